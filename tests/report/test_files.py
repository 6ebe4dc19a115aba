"""Nothing half-written ever has a final name, and a folder of results is whole or not there."""

import csv
import errno
import json
import math
import os
import signal
import stat
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.base import HmdwarpError, InputError, MachineError
from hmdwarp.report import (
    OutputFolder,
    atomic,
    files,
    raw_text,
    write_bytes,
    write_csv,
    write_json,
    write_png,
    write_text,
)  # fmt: skip


def everything_below(folder: Path) -> set[str]:
    return {str(p.relative_to(folder)) for p in folder.rglob("*")}


WRITES = [
    pytest.param(lambda p: write_bytes(p, b"abc"), id="bytes"),
    pytest.param(lambda p: write_text(p, "ä\n"), id="text"),
    pytest.param(lambda p: write_json(p, {"a": 1}), id="json"),
    pytest.param(lambda p: write_csv(p, [{"a": 1}], ["a"]), id="csv"),
    pytest.param(lambda p: write_png(p, np.zeros((2, 3, 3), np.uint8)), id="png"),
]


@pytest.mark.parametrize("write", WRITES)
def test_writes_and_replaces(write, tmp_path):
    path = tmp_path / "out"
    path.write_bytes(b"old and longer than the new one, by far, so that a mere overwrite would show")
    write(path)
    assert everything_below(tmp_path) == {"out"}
    assert b"old" not in path.read_bytes()
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask  # as any file the user makes


@pytest.mark.parametrize("write", WRITES)
@pytest.mark.parametrize(
    "code, kind", [(errno.ENOSPC, MachineError), (errno.EDQUOT, MachineError), (errno.EROFS, InputError)]
)
def test_a_failed_write_leaves_the_old_file(write, code, kind, tmp_path, monkeypatch):
    path = tmp_path / "out"
    path.write_bytes(b"old")

    def full(_):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(kind) as caught:
        write(path)
    assert str(path) in str(caught.value) and os.strerror(code) in str(caught.value) and "\n" not in str(caught.value)
    assert everything_below(tmp_path) == {"out"} and path.read_bytes() == b"old"


@pytest.mark.parametrize("write", WRITES)
def test_places_that_cannot_be_written(write, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "missing" / "out", tmp_path / "file" / "out", tmp_path / "folder", tmp_path / ("x" * 300)):
        with pytest.raises(InputError, match="cannot write"):
            write(path)
    assert everything_below(tmp_path) == {"file", "folder"}


def interrupted(path: Path) -> None:
    with atomic(path) as temporary:
        temporary.write_bytes(b"half")
        raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("write", "error", "words"),
    [
        (interrupted, KeyboardInterrupt, None),
        (lambda path: write_csv(path, [{"a": 1}, {"surprise": 2}], ["a"]), HmdwarpError, "surprise"),
        (lambda path: write_json(path, {"a": float("nan")}), ValueError, "JSON"),
    ],
)
def test_what_fails_midway_leaves_nothing(write, error, words, tmp_path):
    with pytest.raises(error, match=words):
        write(tmp_path / "out")
    assert everything_below(tmp_path) == set()


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=10))
def test_csv_keeps_every_digit(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("csv") / "out.csv"
    write_csv(path, [{"b": np.float64(v), "a": None} for v in values], ["a", "b"])
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(r["b"]) for r in rows] == values
    assert all(r["a"] == "" for r in rows)
    assert path.read_bytes().startswith(b"a,b\n")


@given(st.text(st.characters(codec="utf-8")) | st.builds("".join, st.lists(st.sampled_from("=+-@\t 'x1"))))
def test_no_cell_of_a_csv_is_one_that_a_spreadsheet_runs(tmp_path_factory, text):
    """It may begin with = + - or @ as a number alone; what it was can be read back."""
    path = tmp_path_factory.mktemp("csv") / "out.csv"
    write_csv(path, [{"a": text}], ["a"])
    with path.open(newline="", encoding="utf-8") as file:
        ((cell,),) = list(csv.reader(file))[1:] or [[""]]
    assert raw_text(cell) == text
    assert cell.strip()[:1] not in ("=", "@", "+", "-") or math.isfinite(float(cell))


def test_json_knows_numpy_numbers(tmp_path):
    write_json(tmp_path / "out.json", {"n": np.int64(3), "x": np.float32(0.5), "s": "ü"})
    assert json.loads((tmp_path / "out.json").read_text()) == {"n": 3, "x": 0.5, "s": "ü"}


def test_a_folder_appears_whole(tmp_path):
    out_dir = tmp_path / "a" / "b"
    with OutputFolder(out_dir) as out:
        out.write_json("summary.json", {})
        out.write_png("images/1.png", np.zeros((2, 2, 3), np.uint8))
        out.path("video.mp4").write_bytes(b"v")
        assert not (out_dir / "summary.json").exists() and not (out_dir / "images").exists()
    assert everything_below(out_dir) == {"summary.json", "images", "images/1.png", "video.mp4"}


@pytest.mark.parametrize("former", [True, False])
@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_a_failed_run_leaves_what_was_there(error, former, tmp_path):
    folder = tmp_path / "a" / "b"
    for run in ("one", "two") if former else ("two",):
        with suppress(error), OutputFolder(folder) as out:
            out.write_json("summary.json", {"run": run})
            out.write_text("report.html", run)
            if run == "two":
                raise error
    assert everything_below(tmp_path) == ({"a", "a/b", "a/b/summary.json", "a/b/report.html"} if former else set())
    assert not former or (folder / "report.html").read_text() == "one"


def test_pictures_of_a_former_run_go_and_other_people_s_files_stay(tmp_path):
    for names in (("images/1-left.png", "images/2-left.png"), ("images/2-left.png",)):
        with OutputFolder(tmp_path, owned=("images/*-left.png",)) as out:
            for name in names:
                out.write_bytes(name, b"p")
            out.write_json("summary.json", {})
        (tmp_path / "images" / "mine.png").write_bytes(b"")
    assert everything_below(tmp_path) == {"images", "images/2-left.png", "images/mine.png", "summary.json"}


def test_the_summary_is_never_beside_another_run_s_files(tmp_path, monkeypatch):
    """When giving the names fails half-way, there is no summary.

    Neither the old one nor the new one.
    """
    with OutputFolder(tmp_path) as out:
        out.write_json("summary.json", {"run": 1})
        out.write_text("a.txt", "1")
    real = Path.replace

    def fails_on_b(self, target):
        if Path(target) == tmp_path / "b.txt":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(self, target)

    monkeypatch.setattr(Path, "replace", fails_on_b)
    with pytest.raises(MachineError, match="b.txt"), OutputFolder(tmp_path) as out:
        for name in ("summary.json", "a.txt", "b.txt"):
            out.write_text(name, "2")
    assert everything_below(tmp_path) == {"a.txt"}


OWNED = ("images/*-left.png", "report.html")


@pytest.mark.parametrize("name", ["summary.json", "report.html", "images/1-left.png"])
@pytest.mark.parametrize("summary", [None, "{}", "no JSON", "[]", '{"mine": 1}'])
def test_files_of_others_are_refused_at_once_and_overwritten_by_force(name, summary, tmp_path):
    """A folder is ours by its last file alone; other names in it are nobody's business."""
    (tmp_path / "images").mkdir()
    (tmp_path / "notes.txt").write_text("mine")
    if summary is not None:
        (tmp_path / "summary.json").write_text(summary)
    (tmp_path / name).write_text("precious")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(InputError, match=r"exists, in a folder without results of this command.*--force"):
        OutputFolder(tmp_path, owned=OWNED)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    for force in (True, False):  # then it is ours
        with OutputFolder(tmp_path, owned=OWNED, force=force) as out:
            out.write_text("report.html", "new")
            out.write_json("summary.json", {"run": 1})
        assert everything_below(tmp_path) == {"images", "notes.txt", "report.html", "summary.json"}
        assert (tmp_path / "report.html").read_text() == "new"


def test_a_name_that_nobody_announced_is_refused_at_the_end(tmp_path):
    with pytest.raises(InputError, match=r"table\.csv exists"), OutputFolder(tmp_path) as out:
        out.write_text("table.csv", "new")
        out.write_json("summary.json", {})
        (tmp_path / "table.csv").write_text("precious")
    assert everything_below(tmp_path) == {"table.csv"} and (tmp_path / "table.csv").read_text() == "precious"


KILLED = """
import os, sys
from pathlib import Path
from hmdwarp.report import OutputFolder
out = OutputFolder(sys.argv[1], owned=("report.html",))
out.write_text("report.html", "half")
if sys.argv[2] == "between the names":
    out.write_json("summary.json", {})
    real = Path.replace
    def fails(self, target):
        real(self, target)
        os.kill(os.getpid(), 9)
    Path.replace = fails
    out.commit()
if sys.argv[2] == "alive":
    print("there", flush=True)
    sys.stdin.read()
os.kill(os.getpid(), 9)
"""


def begun(program: str, *arguments: object) -> subprocess.Popen:
    environment = {**os.environ, "PYTHONPATH": str(Path(files.__file__).parents[2])}
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    return subprocess.Popen([sys.executable, "-c", program, *map(str, arguments)], env=environment, **streams)


@pytest.mark.parametrize("when", ["before the end", "between the names"])
def test_the_next_run_deletes_the_remains_of_a_killed_one(when, tmp_path):
    with begun(KILLED, tmp_path, when) as process:
        assert process.wait() == -signal.SIGKILL
    assert list(tmp_path.glob(".partial-*")) and not (tmp_path / "summary.json").exists()
    with OutputFolder(tmp_path, owned=("report.html",)) as out:
        out.write_text("report.html", "whole")
        out.write_json("summary.json", {})
    assert everything_below(tmp_path) == {"report.html", "summary.json"}
    assert (tmp_path / "report.html").read_text() == "whole"


def test_files_of_a_living_run_stay(tmp_path):
    with begun(KILLED, tmp_path, "alive") as other:
        assert other.stdout.readline() == b"there\n"
        (theirs,) = tmp_path.glob(".partial-*")
        with OutputFolder(tmp_path) as out, OutputFolder(tmp_path) as one_more:
            assert (theirs / "report.html").read_text() == "half"
            assert len(list(tmp_path.glob(".partial-*"))) == 3
            out.write_json("summary.json", {"run": 1})
            one_more.write_json("summary.json", {"run": 2})
        assert (theirs / "report.html").exists()
    OutputFolder(tmp_path).discard()
    assert everything_below(tmp_path) == {"summary.json"}


WRITING = """
import os, sys
from hmdwarp.report import atomic
with atomic(sys.argv[1]) as temporary:
    temporary.write_bytes(b"half")
    print("there", flush=True)
    sys.stdin.read()
    os.kill(os.getpid(), 9)
"""


def test_partial_files_of_killed_runs_go_with_the_next_write_of_that_name(tmp_path):
    """Those of a living run stay, as do those of other names and what only looks alike."""
    path = tmp_path / "table.csv"
    others = {".other.csv.0123abcd.part", ".table.csv.mine.part", "table.csv.0123abcd.part"}
    for name in others:
        (tmp_path / name).write_bytes(b"")

    def partial() -> set[str]:
        return {p.name for p in tmp_path.glob(".table.csv.*.part")} - others

    with begun(WRITING, path) as process:
        assert process.stdout.readline() == b"there\n"
        (theirs,) = partial()
        write_bytes(path, b"whole")
        assert partial() == {theirs} and (tmp_path / theirs).read_bytes() == b"half"
        process.stdin.close()
        assert process.wait() == -signal.SIGKILL
    assert partial() == {theirs}
    write_bytes(path, b"again")
    assert everything_below(tmp_path) == {"table.csv", *others} and path.read_bytes() == b"again"


def test_a_folder_that_cannot_be_written_fails_before_the_run_and_errors_name_the_final_file(tmp_path, monkeypatch):
    (tmp_path / "file").write_bytes(b"")
    for path in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / ("x" * 300)):
        with pytest.raises(InputError, match="cannot write"):
            OutputFolder(path)
    with OutputFolder(tmp_path / "out") as out:
        monkeypatch.setattr(os, "fsync", _no_room)
        with pytest.raises(MachineError, match="make room"):
            OutputFolder(tmp_path / "full" / "deeper")
        with pytest.raises(MachineError) as caught:
            out.write_text("images/x.txt", "x")
        assert str(caught.value).startswith(str(tmp_path / "out" / "images" / "x.txt") + ":")
        with pytest.raises(ValueError, match="out of"):
            out.path("../elsewhere")
    assert not (tmp_path / "full").exists()


def _no_room(_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
