"""Tables and charts for a paper: every one of a page, valid in its language, the same each time."""

from __future__ import annotations

import re
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from hmdwarp.base import InputError, PaperOptions
from hmdwarp.report import OutputFolder, write_paper
from hmdwarp.report.bench.page import bench_page

from .bench_samples import a_bench, a_row, some_rows

ALL = PaperOptions(tables=("latex", "markdown"), plots=("svg", "pdf"))


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
    kinds = (".tex", ".md", ".svg", ".pdf", "-figure.tex")
    stems = {kind: {name[: -len(kind)] for name in files if name.endswith(kind)} for kind in kinds}
    assert stems[".svg"] == stems[".pdf"] == stems["-figure.tex"] and len(stems[".pdf"]) >= 2
    tables = stems[".tex"] - {f"{stem}-figure" for stem in stems[".pdf"]}
    assert tables == stems[".md"] == {"table-1"}


def test_latex_has_as_many_cells_in_each_line_as_columns_and_no_letter_with_a_meaning(files):
    for name, content in files.items():
        if not name.endswith(".tex"):
            continue
        text = content.decode()
        kind = "figure" if name.endswith("-figure.tex") else "table"
        assert re.search(r"\\caption\{.*scene .*\d+x\d+", text), name
        assert re.search(rf"\\begin{{{kind}\*?}}\[t\]\n\\centering\n", text) and "\\caption{" in text, name
        assert f"\\label{{{kind[:3]}:{name.removesuffix('.tex').removesuffix('-figure')}}}" in text
        if kind == "figure":
            assert re.search(r"\{(.+\.pdf)\}", text)[1] in files
            continue
        columns = re.search(r"\\begin\{tabular\}\{([lr]+)\}", text)[1]
        lines = [line for line in text.splitlines() if line.endswith(r"\\") and "multicolumn" not in line]
        assert lines and all(len(re.findall(r"(?<!\\)&", line)) == len(columns) - 1 for line in lines), name
        assert not re.search(r"(?<!\\)[%#_~^]", re.sub(r"\$[^$]*\$", "", "\n".join(lines))), name
        assert [text.count(rule) for rule in (r"\toprule", r"\bottomrule")] == [1, 1]
    assert r"50 \% \& \#1\_\{x\}" in files["table-1.tex"].decode()


def test_each_metric_has_its_interval_and_bold_is_the_best_of_a_column():
    """Of two with one error in all instants none is better: both are bold, as the quickest is."""
    rows = [a_row("forward"), a_row("rotation"), a_row("splat")]
    rows[2] |= {name: rows[0][name] for name in ("quality", "at_instants")}
    page = bench_page(a_bench(rows=rows))
    with OutputFolder(Path(tempfile.mkdtemp()) / "out", owned=(), last="bench.json") as out:
        write_paper(out, page, PaperOptions(tables=("latex",)))
        lines = out.path("paper/table-1.tex").read_text().splitlines()
        out.write_json("bench.json", {})
    heads = next(line for line in lines if line.startswith("warp")).removesuffix(r" \\").split(" & ")
    rows_of = [line.removesuffix(r" \\").split(" & ") for line in lines if r"$ 0." in line and " & " in line]
    cells = {own[0].split(" ")[-1]: own for own in rows_of}
    for column, head in enumerate(heads):
        bold = {warp for warp, own in cells.items() if own[column].startswith(r"\textbf")}
        if head.split(" ")[0] in ("FLIP", "PSNR", "SSIM", "flicker"):
            assert bold == {"forward", "splat"}, head
            assert all(re.fullmatch(r"\S+ \$\\pm\$ \S+", own[column]) for own in cells.values()), head
        elif head == "time [ms]":
            assert bold == {min(rows, key=lambda row: row["time_ms"]["total"]["median"])["warp"]}


@pytest.mark.parametrize(("columns", "inches"), [(1, 3.35), (2, 7.0)])
def test_a_plot_is_as_wide_as_its_columns(columns, inches, tmp_path):
    files = written(tmp_path, PaperOptions(plots=("pdf",), columns=columns))
    boxes = {name: re.search(rb"/MediaBox \[ 0 0 ([\d.]+)", content)[1] for name, content in files.items()}
    assert [float(width) / 72 for width in boxes.values()] == pytest.approx([inches] * len(boxes), abs=0.01)


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
    assert written(tmp_path / "nothing is wanted", PaperOptions()) == {}


@pytest.mark.parametrize(("flag", "known"), [("tables", "latex or markdown"), ("plots", "svg or pdf")])
def test_an_unknown_kind_is_refused(flag, known):
    with pytest.raises(InputError, match=f"--{flag} 'word': expected {known}"):
        PaperOptions.of({flag: "word"})
