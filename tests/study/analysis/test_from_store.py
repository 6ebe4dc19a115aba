"""From recorded stores: who counts with whom; and pages, which hold everything as text.

All that an analysis says of a store, what the command prints and writes: golden/.
"""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import attrs
import pytest
from together import together

from hmdwarp.base import InputError
from hmdwarp.report import study_page
from hmdwarp.study.analysis.findings import claims_for
from hmdwarp.study.analysis.full_analysis import analyse, analysis_folder, write_analysis
from hmdwarp.study.analysis.long_table import Ratings, SourceOptions, from_contents, from_csv
from hmdwarp.study.design import design_from_text
from hmdwarp.study.export.write import ExportOptions, export, without_consent
from hmdwarp.study.scales import FOLDER as SCALES
from hmdwarp.study.scales import load_scale
from hmdwarp.study.store import COMPLETE, PERSON, PILOT, SIMULATED, Store

from ..store.sessions import go_through
from ..test_golden import GOLDEN, restored
from .tables import PUBLISHED, ratings_of

pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")
TEXT = (GOLDEN / "ratings" / "study.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def design():
    return design_from_text(TEXT, "late.toml")


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    """Of nine people, eight of whom came to the end."""
    with Store(restored(GOLDEN / "ratings", tmp_path_factory.mktemp("study") / "data")) as store:
        yield store.contents()


def test_programs_and_pilots_never_count_with_people(contents, design):
    first, *rest = contents.sessions  # a store refuses to hold both; a table of several stores may
    mixed = attrs.evolve(contents, sessions=(attrs.evolve(first, origin=SIMULATED), *rest))
    people = from_contents(mixed, design)
    assert first.sub not in set(people.rows["participant"])
    assert people.origin == PERSON and any("simulated" in note and "left out" in note for note in people.notes)
    programs = from_contents(mixed, design, SIMULATED)
    assert set(programs.rows["participant"]) == {first.sub} and any("not of people" in note for note in programs.notes)


ASKED_FOR = [  # whose sessions there are, whose are asked for, what is said
    (PERSON, PILOT, "no session of a pilot to {}: it holds sessions of people: leave out --pilot"),
    (SIMULATED, PERSON, "no session of a person to {}: it holds simulated ones: use --simulated"),
    (SIMULATED, PILOT, "no session of a pilot to {}: it holds simulated ones: use --simulated"),
    ("", PERSON, "no session of a person to {}: run one first"),
    ("", PILOT, "no session of a pilot to {}: run one with --pilot first"),
]


@together("held, origin, says", ASKED_FOR)
def test_sessions_of_others_count_only_on_request(contents, design, tmp_path, held, origin, says):
    """Nobody reads numbers made up by a program for those of people."""
    sessions = tuple(attrs.evolve(session, origin=held) for session in contents.sessions if held)
    others = attrs.evolve(contents, sessions=sessions)
    with pytest.raises(InputError, match=says.format("analyse")):
        from_contents(others, design, origin)
    with pytest.raises(InputError, match=says.format("export")):
        export(others, design, tmp_path / "out", ExportOptions(origin=origin))
    assert not held or from_contents(others, design, held).origin == held


def test_conditions_stand_in_the_order_of_the_plan(contents, design):
    """Not in that of the latencies, and not in that in which somebody saw them first."""
    found = from_contents(contents, design)
    assert found.conditions("") == ["late", "warped", "reference"]
    turned = attrs.evolve(found, planned={"": ("reference", "warped")})
    assert turned.conditions("") == ["reference", "warped", "late"]  # what the plan does not have (any more) comes last
    assert attrs.evolve(found, planned={}).conditions("") == ["reference", "late", "warped"]


def test_one_person_is_one_person(contents, design):
    """In the words of the page too. And of one difference no interval is printed, neither of
    ratings nor of questionnaires.
    """
    sub = next(session.sub for session in contents.sessions if session.status == COMPLETE)
    alone = attrs.evolve(contents, sessions=tuple(session for session in contents.sessions if session.sub == sub))
    data = analyse(from_contents(alone, design))
    page = study_page(data, "").html()
    assert not re.search(r"\b1 (people|participants|sessions|ratings|conditions|pairs)\b", page + json.dumps(data))
    assert "1 participant" in page and "The only participant who rated the hidden reference" in page
    assert all(row["low"] is row["high"] is row["level"] is None for row in data["questionnaires"])


def test_a_declined_session_counts_nowhere(contents, design, tmp_path):
    """Nor in the export: tables, counts and missing ratings are those of the others."""
    (refused,) = [session for session in contents.sessions if not session.consented]
    others = attrs.evolve(contents, sessions=tuple(one for one in contents.sessions if one is not refused))
    assert (without_consent(contents)[0], without_consent(others)[0]) == (1, 0)
    kept, data = export(others, design, tmp_path / "others").folder, analyse(from_contents(others, design))
    made, with_refusal = export(contents, design, tmp_path / "all").folder, analyse(from_contents(contents, design))
    note = "Declined to take part, and counted nowhere else: 1."
    assert with_refusal.pop("notes") == [*data.pop("notes"), note]
    assert with_refusal == data
    for path in kept.rglob("*"):
        assert path.is_dir() or path.read_bytes() == (made / path.relative_to(kept)).read_bytes(), path


def test_custom_scales_are_reported_like_shipped_ones(tmp_path):
    """A translated questionnaire, a sickness scale of one's own, and a shipped one asked as a scale
    of each trial.
    """
    for name in ("fms", "vrsq"):
        (tmp_path / f"my-{name}.toml").write_text((SCALES / f"{name}.toml").read_text())
    text = TEXT.replace('"fms"', '"my-fms.toml"').replace('["vrsq"]', '["my-vrsq.toml"]')
    design = design_from_text(text.replace('["grade"]', '["grade", "misc"]'), str(tmp_path / "late.toml"))
    with Store(tmp_path / "data", create=True) as store:
        for code in ("one", "two"):
            session = store.begin(design, None, code, PERSON)
            go_through(store, session, 2.0, of=design)
            store.end(session, COMPLETE)
        data = analyse(from_contents(store.contents(), design))
    assert {entry["scale"] for entry in data["sickness"]} == {"my-fms", "misc"}
    assert {questionnaire["scale"] for questionnaire in data["questionnaires"]} == {"my-vrsq"}
    assert [scale["measure"]["name"] for scale in data["scales"]] == ["grade"]


def test_a_change_counts_each_person_once_however_many_sessions_they_had(contents, design):
    """Five people with one change in each of two sessions are five, and their p is 2 / 2^5."""
    vrsq = {"scale": "vrsq"}
    survey = [
        {"participant": f"p{who}", "session": session, "phase": phase, "item": item.key, "value": value} | vrsq
        for who in range(5)
        for session in (1, 2)
        for phase, value in (("before", 0.0), ("after", float(session)))
        for item in load_scale("vrsq").items
    ]
    rows = analyse(attrs.evolve(from_contents(contents, design), survey=survey))["questionnaires"]
    assert [(row["n"], row["p"]) for row in rows] == [(5, 2 / 2**5)] * 3
    assert [row["change"] for row in rows] == pytest.approx([50.0] * 3)


def test_a_session_is_read_by_the_plan_it_was_run_by(contents):
    changed = design_from_text(TEXT.replace('warp = "forward"', 'warp = "backward"'), "late.toml")
    found = from_contents(contents, changed)
    assert any("changed after" in note for note in found.notes)
    assert (found.rows.loc[found.rows["condition"] == "warped", "warp"] == "forward").all()


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
        "does not follow", "nothing was rated at 600 ms", "+1.00 .. +2.05",
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
