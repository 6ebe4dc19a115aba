"""Tables and charts for a paper: every one of a page, valid in its language, the same each time."""

from __future__ import annotations

import csv
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from hmdwarp.errors import InputError
from hmdwarp.options import PaperOptions
from hmdwarp.report import OutputFolder, write_paper
from hmdwarp.report.bench.page import bench_page

from .bench_samples import a_bench, some_rows

ALL = PaperOptions(tables=("latex", "csv", "markdown"), plots=("svg", "pdf"))


def written(folder: Path, options: PaperOptions = ALL) -> dict[str, bytes]:
    """What a bench of a warp with a name that every language has to escape gives."""
    rows = some_rows(("none", "mesh:grid=64", "50 % & #1_{x}"), latencies=(200.0,), traces=("look-around",))
    data = a_bench(rows=rows, command="hmdwarp bench")
    with OutputFolder(folder, owned=(), last="bench.json") as out:
        write_paper(out, bench_page(data), options)
        out.write_json("bench.json", {})
    return {path.name: path.read_bytes() for path in sorted((folder / "paper").glob("*"))}


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return written(tmp_path_factory.mktemp("paper"))


def test_each_table_and_chart_is_there_in_each_kind(files):
    stems = {kind: {name[: -len(kind)] for name in files if name.endswith(kind)} for kind in (".tex", ".csv", ".md")}
    assert stems[".tex"] == stems[".csv"] == stems[".md"] and len(stems[".tex"]) >= 3
    assert {name[:-4] for name in files if name.endswith(".svg")} == {
        name[:-4] for name in files if name.endswith(".pdf")
    }


def test_latex_has_as_many_cells_in_each_line_as_columns_and_no_letter_with_a_meaning(files):
    for name, content in files.items():
        if not name.endswith(".tex"):
            continue
        text = content.decode()
        columns = re.search(r"\\begin\{tabular\}\{([lr]+)\}", text)[1]
        lines = [line for line in text.splitlines() if line.endswith(r"\\") and "multicolumn" not in line]
        assert lines and all(len(re.findall(r"(?<!\\)&", line)) == len(columns) - 1 for line in lines), name
        assert not re.search(r"(?<!\\)[%#_~^]", re.sub(r"\$[^$]*\$", "", "\n".join(lines))), name
        assert [text.count(rule) for rule in (r"\toprule", r"\bottomrule")] == [1, 1]
    assert r"50 \% \& \#1\_\{x\}" in files["table-2.tex"].decode()


def test_heads_have_units_and_intervals_are_written(files):
    (head, *rows) = csv.reader(files["table-2.csv"].decode().splitlines())
    assert {"time [ms]", "PSNR [dB]", "FLIP", "FLIP ±"} <= set(head)
    assert len(rows) == 6 and all(len(row) == len(head) for row in rows)


def test_charts_are_whole_and_hold_no_stand_in_of_a_page(files):
    """Colours of a page are stand-ins #010101 .. #07...., which its styles replace."""
    for name, content in files.items():
        if name.endswith(".svg"):
            text = content.decode()
            assert ET.fromstring(text).tag.endswith("svg")
            assert not re.search(r"#0[1-7]0[0-7][0-9a-f]{2}\b", text) and "var(--" not in text, name
        elif name.endswith(".pdf"):
            assert content.startswith(b"%PDF-") and b"CreationDate" not in content


def test_the_same_run_gives_the_same_bytes(files, tmp_path):
    assert written(tmp_path) == files


def test_nothing_is_written_where_nothing_is_wanted(tmp_path):
    assert written(tmp_path, PaperOptions()) == {}


@pytest.mark.parametrize(("flag", "known"), [("tables", "latex, csv or markdown"), ("plots", "svg or pdf")])
def test_an_unknown_kind_is_refused(flag, known):
    with pytest.raises(InputError, match=f"--{flag} 'word': expected {known}"):
        PaperOptions.of({flag: "word"})
