"""A study from its first session to its report, by the real command.

Twelve people, some of whom leave or get sick, rate a walk.

The pictures are tiny, nobody looks, and waits that are for people are short; everything else is as
it is in a laboratory: the loop, the store, export, analysis, withdrawal.
"""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.study.analysis.long_table import SourceOptions, from_contents, from_csv
from hmdwarp.study.design import Comparison, Design, load_design
from hmdwarp.study.respondents import Cohort, Model, Population, load_model, person_of
from hmdwarp.study.respondents.response_model import SicknessModel
from hmdwarp.study.store import SIMULATED, Contents, Store

from . import tiny
from .made_up import differences

pytestmark = pytest.mark.slow(40)
# These twelve, of the people this model makes up: of them one has enough after two trials and one
# gets sick.
CODES = [f"c{number}" for number in range(1, 13)]
PEOPLE = {"missing": 0.05, "dropout": 0.03, "pause": 0.05, "again": 0.05, "sickening": 0.04, "easily_sick": 1.0}
PILOT, WITHDRAWN = "trying-out", "c3"
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
    tiny.ran(*tiny.session(file, model, PILOT, "--pilot", "--store", str(data)))
    tiny.ran("study", "export", file, "--out", made / "export", "--simulated", "--quiet")
    tiny.ran("study", "analyse", file, "--out", made / "analysis", "--simulated", "--quiet")
    with Store(data) as store:
        return Study(file, data, made, load_design(str(file)), load_model(model), store.contents())


def test_every_session_ends_as_its_person_does(study):
    assert [session.code for session in study.contents.sessions] == CODES
    assert [session.status for session in study.contents.sessions] == list(study.cohort().why)
    assert {session.status for session in study.contents.sessions} == {"complete", "stopped", "sick"}
    assert "Fast motion sickness" in next(
        session.why for session in study.contents.sessions if session.status == "sick"
    )


def test_a_dropout_frees_the_order(study):
    """Twelve begin four orders; each is held by as many who stay as any other, but for one."""
    held = [
        sum(session.row == row and session.status == "complete" for session in study.contents.sessions)
        for row in range(4)
    ]
    assert max(held) - min(held) <= 1


def test_the_store_has_what_was_answered_and_nothing_else(study):
    meant = study.cohort().answers["grade"]
    stored = np.full(meant.shape, np.nan)
    ratings = [answer for answer in study.contents.answers if answer.scale == "grade"]
    rows = {one.id: row for row, one in enumerate(study.contents.sessions)}
    for rating in sorted(ratings, key=lambda one: one.revision):
        stored[rows[rating.session], rating.trial - 1] = np.nan if rating.value is None else rating.value
    np.testing.assert_array_equal(stored, meant)
    assert any(answer.revision > 1 for answer in study.contents.answers)  # somebody wanted a question once more
    assert any(event.kind == "pause" for event in study.contents.events)  # and somebody a pause


def test_trials_show_their_planned_condition(study):
    shown = [showing for showing in study.contents.showings if showing.complete and showing.trial]
    assert len({(showing.session, showing.trial) for showing in shown}) == sum(study.cohort().trials)
    for showing in shown:
        wanted = study.design.part("main").condition(showing.condition).settings["latency"]
        # A frame that comes at once is still drawn two refreshes of 50 ms before it is seen.
        assert showing.actual["latency_ms_median"] == pytest.approx(max(wanted, 100.0), abs=1e-6)
        assert showing.actual["pictures"] * 50 == pytest.approx(
            1000 * study.design.seconds, abs=51
        )  # at 20 Hz; both ends count


def known_effect(study: Study, comparison: Comparison) -> float:
    """The mean difference of very many such people who all stay and can always say."""
    rating = attrs.evolve(study.model.ratings["grade"], missing=0.0)
    staying = attrs.evolve(study.model, ratings={"grade": rating}, dropout=0.0, sickness=SicknessModel())
    cohort = Population(staying, study.design, "main").of(range(MANY), seed=1)
    return float(differences(cohort, study.design.scales[0], comparison).mean())


def test_the_known_effects_come_back_inside_their_intervals(study):
    (scale,) = json.loads((study.made / "analysis" / "analysis.json").read_text())["scales"]
    assert len(scale["comparisons"]) == 2
    for row in scale["comparisons"]:
        effect = known_effect(study, Comparison("main", row["baseline"], row["condition"]))
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
    with (study.made / "export" / "bids" / "participants.tsv").open(newline="") as file:
        listed = {
            row["participant_id"].removeprefix("sub-"): row["status"] for row in csv.DictReader(file, delimiter="\t")
        }
    assert {one: status for one, status in listed.items() if status != "complete"} == sub


def test_the_export_reads_back(study):
    own, exported = (
        from_contents(study.contents, study.design, SIMULATED),
        from_csv(study.made / "export" / "ratings.csv", SourceOptions()),
    )
    assert len(exported.rows)
    values = [
        {
            (row.participant, row.place, row.condition, row.previous): row.value
            for row in table.rows.dropna(subset="value").itertuples()
        }
        for table in (own, exported)
    ]
    assert values[0] == values[1]


def test_a_pilot_stays_apart(study):
    with Store(study.data) as store:
        (pilot,) = store.contents(pilot=True).sessions
    assert pilot.code == PILOT
    assert PILOT not in [session.code for session in study.contents.sessions]
    assert not holding(study.made, pilot.code) and not holding(study.made, pilot.sub)


def test_codes_are_in_nothing_that_is_passed_on(study):
    """They are what people have written down somewhere.

    C1 would be found in any picture's bytes, so the longest one is looked for.
    """
    assert holding(study.data, PILOT)  # the search finds what is there
    for table in (study.made / "export").glob("*.?sv"):
        assert not set(re.split(r"[,\t\n]", table.read_text())) & set(CODES)


def test_a_withdrawal_leaves_nothing(study, tmp_path):
    """Neither in the store nor in a new export.

    The code stays, as a mark that it is not used again.
    """
    data = tmp_path / "tiny-data"
    shutil.copytree(study.data, data)
    sub = next(session.sub for session in study.contents.sessions if session.code == WITHDRAWN)
    assert holding(data, sub)
    tiny.ran("study", "withdraw", study.file, WITHDRAWN, "--store", data, "--yes")
    assert not holding(data, sub)
    out = tmp_path / "export"
    tiny.ran("study", "export", study.file, "--store", data, "--out", out, "--simulated", "--quiet")
    assert not holding(out, sub)
    assert len(list((out / "bids").glob("sub-*"))) == len(CODES) - 1
    again = tiny.program(*tiny.session(study.file, study.file.with_name("people.toml"), WITHDRAWN, "--store", data))
    assert again.returncode == 2 and "withdrawn" in again.stderr


def holding(folder: Path, text: str) -> list[Path]:
    """Files with that in their bytes or their names."""
    found = [path for path in folder.rglob("*") if text in path.name]
    return found + [path for path in folder.rglob("*") if path.is_file() and text.encode() in path.read_bytes()]
