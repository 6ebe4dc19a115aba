"""Recorded studies, and tables of ratings, give what they gave.

A folder of golden/ holds a study's file, its store as SQL, files that are put in place of its
traces (by their number) or beside them, and the commands; expected.txt is what they said and wrote.
After an intended change look at the difference that

    HMDWARP_GOLDEN=write python -m pytest tests/study/test_golden.py

makes of it.
"""

from __future__ import annotations

import json
import re
import shlex
import shutil
import sqlite3
import tomllib
from contextlib import closing
from pathlib import Path

import pytest
from commands import hmdwarp
from golden_texts import assert_text, words_of

from hmdwarp.base import InputError
from hmdwarp.scenes import inputs_beside
from hmdwarp.study.analysis.full_analysis import analyse
from hmdwarp.study.analysis.long_table import SourceOptions, from_csv

TABLES = Path(__file__).with_name("tables")
GOLDEN, ROOT = Path(__file__).parent / "golden", str(Path(__file__).resolve().parents[2])
# Versions differ from machine to machine.
VARIES = re.compile(r'("(?:commit|options|python|numpy|moderngl|hmdwarp|Version|SoftwareVersion)": )"[^"]*"')
MADE = re.compile(r'(?:commit [^"\n]*?, )?python \d[^"\n]*?moderngl [\w.]+|hmdwarp\s\d[\w.+]*')
# Of times nanoseconds stay, the ninth decimal; a float with more is rounded.
NUMBER = re.compile(r"-?\d+\.\d{10,}(?:e-?\d+)?|-?\d+(?:\.\d+)?e-\d+")
COLUMNS = ["participant", "part", "condition", "scale", "value", "why_missing", "place", "previous"]
TELLING = re.compile(r"(?!made_with|schema|hmdwarp|title|resamples|seed|scales.\d.measure)").match
TURNS = ("0,0,1", "0.6,0,0.8", "0.28,0,0.96")
PROGRESS = re.compile(r"^recordings: .*\n", re.M)  # of a slow machine
HEAD = "# recorded on 2031-07-23 by Maria\ntime_ns,x_m,y_m,z_m,qx,qy,qz,qw\n"


def restored(folder: Path, data: Path) -> Path:
    """The store of a study, with a short trace for each showing, or what is in place of it."""
    (data / "traces").mkdir(parents=True)
    with closing(sqlite3.connect(data / "study.sqlite3")) as db:
        db.executescript((folder / "store.sql").read_text(encoding="utf-8"))
        for number, (trace,) in enumerate(db.execute("SELECT trace FROM showing WHERE trace <> ''")):
            poses = (f"{number + k * 11_000_000},{k / 8},1.5,{number / 4},0,{TURNS[k]}" for k in range(3))
            path = data / "traces" / trace
            path.write_text(HEAD + "\n".join(poses) + "\n")
            for other in (folder / "traces").glob(f"{number}.*"):
                shutil.copy(other, inputs_beside(path) if other.suffix == ".inputs" else path)
                if other.suffix == ".gone":
                    path.unlink()
    return data


def written(folder: Path) -> list[str]:
    """Every file, of a page its words; of equal ones the first."""
    first: dict[str, str] = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        text, name = path.read_bytes().decode(), path.relative_to(folder).as_posix()
        if path.suffix == ".html":
            text = words_of(text)
        first[f"== {name}"] = f"as {known}" if (known := next((k for k, v in first.items() if v == text), "")) else text
    return [f"{name}\n{text}" for name, text in first.items()]


@pytest.mark.parametrize("folder", sorted(GOLDEN.glob("*/")), ids=lambda folder: folder.name)
def test_a_recorded_study_gives_what_it_gave(folder, tmp_path):
    pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")
    for path in folder.glob("*.toml"):
        shutil.copy(path, tmp_path)
    restored(folder, tmp_path / "data")
    said = []
    for line in (folder / "commands.txt").read_text(encoding="utf-8").splitlines():
        done = hmdwarp("study", *shlex.split(line), folder=tmp_path)
        assert "analyse" not in line or max(map(len, done.stdout.splitlines()), default=0) <= 80, done.stdout
        said.append(f"$ {line}\n{done.returncode}\n{done.stdout}{done.stderr}")
    with closing(sqlite3.connect(tmp_path / "data" / "study.sqlite3")) as db:
        left = [f"{table}: {db.execute(f'SELECT * FROM {table}').fetchall()}" for table in ("withdrawn", "participant")]
        left += [f"{table}: {db.execute(f'SELECT count(*) FROM {table}').fetchone()}" for table in ("answer", "event")]
    text = (
        "\n".join([*said, *written(tmp_path / "out"), *left])
        .replace("\r\n", "\n")
        .replace(str(tmp_path), "")
        .replace(ROOT, "")
    )
    text = PROGRESS.sub("", text)
    compare(MADE.sub("hmdwarp", VARIES.sub(r'\1""', text)), folder / "expected.txt")


def compare(text: str, expected: Path) -> None:
    assert_text(NUMBER.sub(lambda found: f"{float(found[0]):.8g}", text), expected)


def test_tables_of_ratings_give_what_they_gave(tmp_path):
    """tables/tables.toml: tables of others, right and wrong, and ratings whose truth is known."""
    pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")
    said = []
    for name, table in tomllib.loads((TABLES / "tables.toml").read_text(encoding="utf-8")).items():
        path = tmp_path / f"{name}.csv"
        path.write_text(table["text"], encoding="utf-8")
        options = {key: tuple(v) if isinstance(v, list) else v for key, v in table.get("options", {}).items()}
        try:
            ratings = from_csv(path, SourceOptions(**options))
            data = json.loads(json.dumps(analyse(ratings, families=table.get("compare", ())), allow_nan=False))
            lines = [f"{where}: {value}" for where, value in leaves(data) if value not in (None, "", [], {})]
            lines = [*ratings.rows[COLUMNS].to_csv(index=False).splitlines(), *filter(TELLING, lines)]
        except InputError as error:
            lines = [str(error).replace(f"{tmp_path}/", "")]
        assert not any("\n" in line for line in lines)
        said.append("\n".join([f"== {name}", *lines]))
    compare("\n".join(said), TABLES / "expected.txt")


def leaves(data: object, where: str = "") -> list[tuple[str, object]]:
    """All values, with the place of each; of short lists at once."""
    if isinstance(data, list) and not any(isinstance(value, dict | list) for value in data):
        return [(where, data)]
    if isinstance(data, dict | list):
        items = data.items() if isinstance(data, dict) else enumerate(data)
        return [leaf for key, value in items for leaf in leaves(value, f"{where}.{key}".lstrip("."))]
    return [(where, data)]
