"""From a real store: places, conditions before, reasons for what is missing, who counts with whom.

And the same by way of the export.
"""

from __future__ import annotations

import json
import re

import attrs
import numpy as np
import pytest

from hmdwarp.errors import InputError
from hmdwarp.report.study import render_study_report
from hmdwarp.study.analysis.full_analysis import analyse
from hmdwarp.study.analysis.long_table import from_contents
from hmdwarp.study.design import design_from_text
from hmdwarp.study.export.export_rows import declined
from hmdwarp.study.export.write import ExportOptions, export
from hmdwarp.study.scales import FOLDER as SCALES
from hmdwarp.study.scales import load_scale, scored
from hmdwarp.study.store import DECLINED, PERSON, PILOT, SIMULATED, Store

from ..made_up import LATE_OR_WARPED
from ..store.sessions import go_through

pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")

TEXT = (
    LATE_OR_WARPED.replace("[practice]\nseconds = 1\n", "").replace("guard = 1.5\n", "")
    + '[[family]]\nname = "the warp"\npairs = [["late", "warped"]]\n'
)
MEANS = {"late": 5.0, "warped": 3.0, "reference": 1.5}


def sit(store, design, code, origin=PERSON, until=99, seed=0, status="complete", reference=1.5):
    """A session whose grades are known: the condition's own and a quarter for each seed."""
    session, means = store.begin(design, None, code, origin), MEANS | {"reference": reference}

    def values(step):
        if step.scale.name != "grade":
            return float({"fms": step.trial, "ipq": seed}.get(step.scale.name, step.phase == "after"))
        condition = session.order[0][step.trial - 1]
        grade = None if (seed, condition) == (2, "late") else means[condition] + 0.25 * (seed % 3)
        return 6.0, grade  # corrected at once

    def actual(step):
        return {"hole_share_mean": 0.1 * MEANS.get(step.condition.name, 0)}

    go_through(store, session, values, of=design, until=until, actual=actual)
    return store.end(session, status)


@pytest.fixture(scope="module")
def design():
    """With a reference, a sickness scale and a questionnaire."""
    return design_from_text(TEXT, "late.toml")


@pytest.fixture(scope="module")
def contents(tmp_path_factory, design):
    """Nine people: one could not say once, one stopped, one got sick.

    And a pilot, in another place.
    """
    with Store(tmp_path_factory.mktemp("study") / "data", create=True) as store:
        for seed in range(7):
            sit(store, design, f"p{seed}", seed=seed, reference=5.5 if seed == 4 else 1.5)
        sit(store, design, "stopped", until=1, status="stopped")
        sit(store, design, "sick", until=2, status="sick")
        sit(store, design, "rehearsal", PILOT)
        yield store.contents()


def test_programs_and_pilots_never_count_with_people(contents, design):
    first, *rest = contents.sessions  # a store refuses to hold both; a table of several stores may
    mixed = attrs.evolve(contents, sessions=(attrs.evolve(first, origin=SIMULATED), *rest))
    people = from_contents(mixed, design)
    assert first.sub not in set(people.rows["participant"])
    assert people.origin == PERSON and any("simulated" in note and "left out" in note for note in people.notes)
    programs = from_contents(mixed, design, SIMULATED)
    assert set(programs.rows["participant"]) == {first.sub} and any("not of people" in note for note in programs.notes)


@pytest.mark.parametrize(
    ("held", "origin", "says"),
    [
        (PERSON, PILOT, "no session of a pilot to {}: it holds sessions of people: leave out --pilot"),
        (SIMULATED, PERSON, "no session of a person to {}: it holds simulated ones: use --simulated"),
        (SIMULATED, PILOT, "no session of a pilot to {}: it holds simulated ones: use --simulated"),
        ("", PERSON, "no session of a person to {}: run one first"),
        ("", PILOT, "no session of a pilot to {}: run one with --pilot first"),
    ],
)
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
    (part,) = analyse(found)["scales"][0]["parts"]
    assert [row["condition"] for row in part["conditions"]] == ["late", "warped", "reference"]
    turned = attrs.evolve(found, planned={"": ("reference", "warped")})
    assert turned.conditions("") == ["reference", "warped", "late"]  # what the plan does not have (any more) comes last
    assert attrs.evolve(found, planned={}).conditions("") == ["reference", "late", "warped"]


def test_one_person_is_one_person(contents, design):
    """In the words of the page too.

    And of one difference no interval is printed, neither of ratings nor of questionnaires.
    """
    sub = next(session.sub for session in contents.sessions if session.code == "p0")
    alone = attrs.evolve(contents, sessions=tuple(session for session in contents.sessions if session.sub == sub))
    data = analyse(from_contents(alone, design))
    page = render_study_report(data, "")
    assert not re.search(r"\b1 (people|participants|sessions|ratings|conditions|pairs)\b", page + json.dumps(data))
    assert "1 participant" in page and "The only participant who rated the hidden reference" in page
    assert all(row["low"] is row["high"] is row["level"] is None for row in data["questionnaires"])


def test_a_declined_session_counts_nowhere(tmp_path, design):
    """Nor in the export: tables, counts and missing ratings are those of the others."""
    with Store(tmp_path / "data", create=True) as store:
        for code in ("p1", "p2"):
            sit(store, design, code)
        before = store.contents()
        session = store.begin(design, None, "p3", PERSON)
        store.record(session, "refused", "consent", by="participant")
        store.end(session, DECLINED)
        after = store.contents()
        (kept, data), (_, with_refusal) = (
            (export(one, design, tmp_path / name), analyse(from_contents(one, design)))
            for one, name in ((before, "before"), (after, "after"))
        )
    note = "Declined to take part, and counted nowhere else: 1."
    assert with_refusal.pop("notes") == [*data.pop("notes"), note]
    assert with_refusal == data and data["participants"] == 2 and data["missing"] == 0
    files = {path.relative_to(kept.folder) for path in kept.folder.rglob("*") if path.is_file()}
    for name in files:
        assert (kept.folder / name).read_bytes() == (tmp_path / "after" / name).read_bytes(), name
    assert declined(after) == 1 and declined(before) == 0


def test_custom_scales_are_reported_like_shipped_ones(tmp_path):
    """A translated questionnaire, a sickness scale of one's own, and a shipped one asked as a scale
    of each trial.
    """
    for name in ("fms", "vrsq"):
        (tmp_path / f"my-{name}.toml").write_text((SCALES / f"{name}.toml").read_text())
    text = (
        TEXT.replace('"fms"', '"my-fms.toml"')
        .replace('["vrsq"]', '["my-vrsq.toml"]')
        .replace('["grade"]', '["grade", "misc"]')
    )
    design = design_from_text(text, str(tmp_path / "late.toml"))
    with Store(tmp_path / "data", create=True) as store:
        sit(store, design, "one")
        sit(store, design, "two", seed=1)
        data = analyse(from_contents(store.contents(), design))
    assert {entry["scale"] for entry in data["sickness"]} == {"my-fms", "misc"}
    assert {questionnaire["scale"] for questionnaire in data["questionnaires"]} == {"my-vrsq"}
    assert [scale["measure"]["name"] for scale in data["scales"]] == ["grade"]


def test_a_change_counts_each_person_once_however_many_sessions_they_had(contents, design):
    """Five people with one change in each of two sessions are five, and their p is 2 / 2^5."""
    ratings = from_contents(contents, design)
    survey = [
        {
            "participant": f"p{who}",
            "session": session,
            "phase": phase,
            "item": item.key,
            "value": value,
            "scale": "vrsq",
        }
        for who in range(5)
        for session in (1, 2)
        for phase, value in (("before", 0.0), ("after", float(session)))
        for item in load_scale("vrsq").items
    ]
    rows = analyse(attrs.evolve(ratings, survey=survey))["questionnaires"]
    assert [(row["n"], row["p"]) for row in rows] == [(5, 2 / 2**5)] * 3
    assert [row["change"] for row in rows] == pytest.approx([50.0] * 3)


def test_a_questionnaire_asked_once_has_quartiles_by_part_of_its_scale(tmp_path):
    design = design_from_text(TEXT.replace('after = ["vrsq"]', 'after = ["vrsq", "ipq"]'), "late.toml")
    with Store(tmp_path / "data", create=True) as store:
        for seed in range(5):
            sit(store, design, f"p{seed}", seed=seed)
        stored = store.contents()
    data = analyse(from_contents(stored, design))
    assert {row["scale"] for row in data["questionnaires"]} == {"vrsq"}
    ipq = load_scale("ipq")
    assert [row["score"] for row in data["asked_once"]] == [score.name for score in ipq.scores]
    answers: dict[int, dict[str, float | None]] = {}
    for answer in stored.answers:
        if answer.scale == "ipq":
            answers.setdefault(answer.session, {})[answer.item] = answer.value
    sheets = [scored(ipq, sheet) for sheet in answers.values()]
    for row in data["asked_once"]:
        found = [row[name] for name in ("low_quartile", "median", "high_quartile")]
        assert found == pytest.approx(np.percentile([sheet[row["score"]] for sheet in sheets], (25, 50, 75)))
        assert (row["when"], row["n"], row["least"], row["most"]) == ("after", 5, 0, 6)
    page = render_study_report(data, "").replace("<wbr>", "")
    assert "Questionnaires, answered once" in page and "ipq after: " in page and "0 to 6" in page
    assert "Questionnaires, answered once" not in render_study_report({**data, "asked_once": []}, "")


def test_a_session_is_read_by_the_plan_it_was_run_by(contents):
    changed = design_from_text(TEXT.replace('warp = "forward"', 'warp = "backward"'), "late.toml")
    found = from_contents(contents, changed)
    assert any("changed after 9 of 9" in note for note in found.notes)
    assert (found.rows.loc[found.rows["condition"] == "warped", "warp"] == "forward").all()
