"""A study from its first session to its report, by the real command.

Twelve people, some of whom leave or get sick, rate a walk.

The pictures are tiny, nobody looks, and waits that are for people are short; everything else is as
it is in a laboratory: the loop, the store, export, analysis, withdrawal.
"""

from __future__ import annotations

import json
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.study.design import Comparison, Design, load_design
from hmdwarp.study.respondents import Cohort, Model, Population, load_model, person_of
from hmdwarp.study.respondents.simulated import SicknessModel
from hmdwarp.study.store import Contents, Store

from . import tiny
from .made_up import differences

pytestmark = pytest.mark.slow(40)
# These twelve, of the people this model makes up: of them one has enough after two trials and one
# gets sick.
CODES = [f"c{number}" for number in range(1, 13)]
PEOPLE = {"missing": 0.05, "dropout": 0.03, "pause": 0.05, "again": 0.05, "sickening": 0.04, "easily_sick": 1.0}
MANY = 20_000  # whose mean differences are known to sd / sqrt(20,000) = 0.004 grades


@attrs.frozen
class Study:
    """folder: of the file; data: the store; made: what was exported and analysed."""

    file: Path
    data: Path
    made: Path
    design: Design
    model: Model
    contents: Contents

    def cohort(self) -> Cohort:
        """The same people, by their model alone, with the orders that the sessions were given."""
        sessions = self.contents.sessions
        people = [person_of(session.code) for session in sessions]
        return Population(self.model, self.design, "main").of(
            people, self.design.seed, orders=[session.order for session in sessions]
        )


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Study:
    folder = tmp_path_factory.mktemp("study")
    file, model = tiny.write(folder, **PEOPLE)
    data, made = folder / "tiny-simulated-data", folder / "made"
    for code in CODES:
        tiny.ran(*tiny.session(file, model, code))
    tiny.ran("study", "export", file, "--out", made / "export", "--simulated", "--quiet")
    tiny.ran("study", "analyse", file, "--out", made / "analysis", "--simulated", "--quiet")
    with Store(data) as store:
        return Study(file, data, made, load_design(str(file)), load_model(model), store.contents())


def test_the_store_has_what_was_answered_and_nothing_else(study):
    assert [session.code for session in study.contents.sessions] == CODES
    assert [session.status for session in study.contents.sessions] == list(study.cohort().why)
    assert {session.status for session in study.contents.sessions} == {"complete", "stopped", "sick"}
    meant = study.cohort().answers["grade"]
    stored = np.full(meant.shape, np.nan)
    ratings = [answer for answer in study.contents.answers if answer.scale == "grade"]
    rows = {one.id: row for row, one in enumerate(study.contents.sessions)}
    for rating in sorted(ratings, key=lambda one: one.revision):
        stored[rows[rating.session], rating.trial - 1] = np.nan if rating.value is None else rating.value
    np.testing.assert_array_equal(stored, meant)
    assert any(answer.revision > 1 for answer in study.contents.answers)  # somebody wanted a question once more
    assert any(event.kind == "pause" for event in study.contents.events)  # and somebody a pause


def test_the_known_effects_come_back_inside_their_intervals(study):
    (scale,) = json.loads((study.made / "analysis" / "analysis.json").read_text())["scales"]
    assert len(scale["comparisons"]) == 2
    for row in scale["comparisons"]:
        comparison = Comparison("main", row["baseline"], row["condition"])
        rating = attrs.evolve(study.model.ratings["grade"], missing=0.0)
        staying = attrs.evolve(study.model, ratings={"grade": rating}, dropout=0.0, sickness=SicknessModel())
        cohort = Population(staying, study.design, "main").of(range(MANY), seed=1)
        effect = float(differences(cohort, study.design.scales[0], comparison).mean())
        assert effect > 0.5  # a warp helps these people
        assert row["low"] <= effect <= row["high"]
        assert row["shift_low"] <= effect <= row["shift_high"]
        assert row["holm"] < 0.05
        assert row["n"] < len(CODES)  # who left is in none of them, or not in all


def test_dropouts_are_listed(study):
    analysis = json.loads((study.made / "analysis" / "analysis.json").read_text())
    sub = {session.sub: session.status for session in study.contents.sessions if session.status != "complete"}
    assert {entry["participant"]: entry["status"] for entry in analysis["sittings"]["cut"]} == sub
    page = (study.made / "analysis" / "report.html").read_text().replace("<wbr>", "")
    assert all(text in page for text in sub)
