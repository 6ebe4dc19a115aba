"""The page of an analysis: it holds everything, and names are text and nothing else.

What the command prints and writes: golden/.
"""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import attrs
import pytest

from hmdwarp.errors import InputError, MachineError
from hmdwarp.report.study import render_study_report
from hmdwarp.resources import import_extra
from hmdwarp.study.analysis.findings import claims_for
from hmdwarp.study.analysis.full_analysis import analyse, analysis_folder, write_analysis
from hmdwarp.study.analysis.long_table import Ratings, SourceOptions, from_csv
from hmdwarp.study.design import Comparison, Family

from .tables import GRADE, PUBLISHED, in_order, ratings_of

pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")

NASTY = "<script>alert('x')</script> $\\frac{1}{2}$ & \"q\""


class Page(HTMLParser):
    """Text, and what a browser would fetch."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.text, self.fetched, self.tags = "", [], []
        self.feed(html)
        self.text = " ".join(self.text.split())

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        links = [value for name, value in attributes if name in ("src", "href", "xlink:href")]
        self.fetched += [value for value in links if not value.startswith("#")]

    def handle_data(self, data):
        self.text += data


def page_of(folder: Path, ratings: Ratings, typed: str = "", **more) -> str:
    with analysis_folder(folder) as out:
        page = write_analysis(out, analyse(ratings, **more), typed)
    return page.read_text(encoding="utf-8")


def test_the_page_holds_everything_and_asks_the_network_for_nothing(tmp_path):
    ratings = from_csv(PUBLISHED)
    page = Page(page_of(tmp_path / "out", ratings, claims=claims_for(None, ratings, SourceOptions())[0]))
    assert page.fetched == [] and "script" not in page.tags and page.tags.count("svg") == 3
    for text in (
        "In 5 of 9 rows of run 2", "does not follow", "nothing was rated at 600 ms", "+1.00 .. +2.05",
        "participant 9: none, 400 ms",
    ):  # fmt: skip
        assert text in page.text


def test_names_are_text_and_nothing_else(tmp_path):
    ratings = ratings_of({f"late {NASTY}": [5, 4, 3.5], f"warped {NASTY}": [3, None, 3]}, part=NASTY)
    rows = ratings.rows.assign(participant=ratings.rows["participant"] + NASTY).to_dict("records")
    html = page_of(tmp_path / "out", attrs.evolve(ratings, title=NASTY, notes=(NASTY,), rows=rows), NASTY)
    assert "<script" not in html and NASTY in Page(html).text


def test_a_page_of_hardly_anything_can_be_made(tmp_path):
    for number, values in enumerate(({"late": [None]}, {"late": [3.0]}, {"late": [3, 4], "warped": [3, 4]})):
        html = page_of(tmp_path / str(number), ratings_of(values))
        assert not re.search(r"\bnan\b", Page(html).text, re.IGNORECASE)


def test_the_order_has_its_chart_where_it_is_known(tmp_path):
    rows = in_order(people=8).to_dict("records")
    text = Page(page_of(tmp_path / "out", Ratings(rows, {"grade": GRADE}))).text
    assert "The place of a trial: F(1, " in text and "Ratings less the person" in text


def test_charts_break_names_between_words_and_have_axes_without_factors():
    """Text of an axis that reaches a billionth either way, as of equal pairs, has a factor."""
    name = "forward + interpolate+composite, 800 ms"
    pair = (Family("one", (Comparison("", "late", name),)),)
    page = render_study_report(
        analyse(attrs.evolve(ratings_of({"late": [3.0] * 5, name: [3.0] * 5}), families=pair)), ""
    )
    assert ">interpolate+<" in page and ">composite<" in page
    words = re.findall(r">([^<>]*)</text>", page)
    assert "1.0" in "".join(words) and not any(word.startswith("1e") for word in words)


def test_a_page_of_others_is_not_overwritten(tmp_path):
    (tmp_path / "report.html").write_text("theirs")
    with pytest.raises(InputError, match="report.html exists"), analysis_folder(tmp_path):
        pass


def test_a_missing_package_is_named_with_its_installation():
    told = r"this needs statsmodels, which is not installed: pip install '\.\[study\]'"
    with pytest.raises(MachineError, match=told):
        import_extra("statsmodels_that_is_not_there", "statsmodels", "study")
