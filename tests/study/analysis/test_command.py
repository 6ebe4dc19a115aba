"""hmdwarp study analyse.

What it writes and prints, the same every time, and what it says where it cannot.
"""

from __future__ import annotations

import csv
import json
import re
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import attrs
import pytest
from commands import hmdwarp

from hmdwarp.errors import MachineError
from hmdwarp.resources import import_extra
from hmdwarp.study.analysis.full_analysis import analyse, analysis_folder, write_analysis

from .tables import GRADE, PUBLISHED, in_order, ratings_of

pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")

NASTY = "<script>alert('x')</script> $\\frac{1}{2}$ & \"q\""


def command(*arguments: object, folder) -> subprocess.CompletedProcess[str]:
    return hmdwarp("study", "analyse", *arguments, folder=folder)


def page_of(folder: Path, data: dict, typed: str = "") -> str:
    with analysis_folder(folder) as out:
        page = write_analysis(out, data, typed)
    return page.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The shipped study, analysed where it has no store."""
    folder = tmp_path_factory.mktemp("run")
    return command("thesis", "--out", "out", folder=folder), folder / "out"


def test_it_prints_what_it_found_in_80_columns(done):
    run, _ = done
    assert run.returncode == 0, run.stderr
    assert max(map(len, run.stdout.splitlines())) <= 80
    said = " ".join(run.stdout.split())
    assert "9 of 11 rated 'forward + interpolate, 400 ms' better than 'none, 400 ms', 2 worse" in said
    assert "(95 % +0.70 to +1.86). After Holm over 3 comparisons p = .0098" in said
    assert "drawn with seed 0" in said and said.endswith("report: out/report.html")


def test_it_writes_the_page_the_numbers_and_the_tables(done):
    _, out = done
    assert sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()) == [
        "analysis.json", "report.html", "tables/comparisons.csv", "tables/conditions.csv", "tables/differences.csv",
        "tables/missing.csv", "tables/ratings.csv",
    ]  # fmt: skip
    data = json.loads((out / "analysis.json").read_text())
    assert {"commit", "numpy", "moderngl"} <= data["made_with"].keys()
    with (out / "tables" / "comparisons.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["p"]) for row in rows] == [row["p"] for row in data["scales"][0]["comparisons"]]
    with (out / "tables" / "ratings.csv").open() as file:
        assert len(list(csv.DictReader(file))) == data["ratings"] == 117


class Page(HTMLParser):
    """Text, and what a browser would fetch."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.text, self.fetched, self.tags = "", [], []
        self.feed(html)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.fetched += [
            value for name, value in attributes if name in ("src", "href", "xlink:href") and not value.startswith("#")
        ]

    def handle_data(self, data):
        self.text += data


def test_the_page_holds_everything_and_asks_the_network_for_nothing(done):
    _, out = done
    page = Page((out / "report.html").read_text())
    assert page.fetched == [] and "script" not in page.tags and page.tags.count("svg") == 3
    for text in (
        "In 5 of 9 rows of run 2", "does not follow", "nothing was rated at 600 ms", "+1.00 .. +2.05",
        "participant 9: none, 400 ms",
    ):  # fmt: skip
        assert text in " ".join(page.text.split())


def test_a_place_that_cannot_be_written_is_refused_before_the_work(tmp_path):
    """Nothing is read: the table that is named is not there."""
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "report.html").write_text("theirs")
    for out, told in (("file", "file: cannot write"), ("theirs", "report.html exists")):
        run = command("absent.csv", "--out", out, folder=tmp_path)
        assert run.returncode == 2 and told in run.stderr, run.stderr
    run = command("absent.csv", "--out", "new", folder=tmp_path)
    assert run.returncode == 2 and "absent.csv" in run.stderr and not (tmp_path / "new").exists()


def test_names_are_text_and_nothing_else(tmp_path):
    ratings = ratings_of({f"late {NASTY}": [5, 4, 3.5], f"warped {NASTY}": [3, None, 3]}, part=NASTY)
    rows = ratings.rows.assign(participant=ratings.rows["participant"] + NASTY).to_dict("records")
    ratings = attrs.evolve(ratings, title=NASTY, notes=(NASTY,), rows=rows)
    html = page_of(tmp_path / "out", analyse(ratings), NASTY)
    assert "<script" not in html and NASTY in " ".join(Page(html).text.split())


def test_a_page_of_hardly_anything_can_be_made(tmp_path):
    for number, values in enumerate(({"late": [None]}, {"late": [3.0]}, {"late": [3, 4], "warped": [3, 4]})):
        html = page_of(tmp_path / str(number), analyse(ratings_of(values)))
        assert not re.search(r"\bnan\b", Page(html).text, re.IGNORECASE)


def test_the_order_has_its_chart_where_it_is_known(tmp_path):
    ratings = attrs.evolve(
        ratings_of({"late": [3.0]}), rows=in_order(people=8).to_dict("records"), scale_info={"grade": GRADE}
    )
    text = Page(page_of(tmp_path / "out", analyse(ratings))).text
    assert "The place of a trial: F(1, " in text and "Ratings less the person" in text


WRONG = [
    (("none.csv",), "no such file"),
    (("thezis",), "thesis"),
    (("quick",), "there are no data of 'quick' yet"),
    ((PUBLISHED, "--family", "a:b"), "no part has both 'a' and 'b'"),
    ((PUBLISHED, "--columns", "grade"), "expected ROLE=NAME,.."),
    ((PUBLISHED, "--scale", "acr"), "thesis_ratings.csv:46: rating 6"),
    ((PUBLISHED, "--pilot", "--simulated"), "never mixed"),
    ((PUBLISHED, "--claims", "none.toml"), "none.toml: no such file"),
]


@pytest.mark.parametrize(("arguments", "told"), WRONG, ids=lambda value: value if isinstance(value, str) else "")
def test_wrong_input_is_one_line_and_leaves_nothing(tmp_path, arguments, told):
    run = hmdwarp("study", "analyse", *arguments, "--out", "out", folder=tmp_path)
    assert run.returncode == 2 and run.stderr.count("\n") == 1 and told in run.stderr, run.stderr
    assert not (tmp_path / "out").exists()


def test_a_missing_package_is_named_with_its_installation():
    with pytest.raises(
        MachineError, match=r"this needs statsmodels, which is not installed: pip install '\.\[study\]'"
    ):
        import_extra("statsmodels_that_is_not_there", "statsmodels", "study")
