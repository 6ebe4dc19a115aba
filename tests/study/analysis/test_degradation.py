"""Degradation ratings (DCR) of simulated people: plan, store, analysis, page."""

from __future__ import annotations

from together import together

from hmdwarp.study.design import Ask, Show, design_from_text, steps_of
from hmdwarp.study.design.plan_text import session_phases

from ..refusals import check_refused, table

STUDY = """schema = 1
name = "impaired"
title = "How much is it impaired?"
seed = 4
[common]
scene = "planes"
[trial]
shows = "reference first"
seconds = 2
scales = ["dcr"]
[[condition]]
name = "late"
latency = 400
warp = "none"
fill = "none"
[[condition]]
name = "warped"
latency = 400
warp = "forward"
[[condition]]
name = "reference"
latency = 0
warp = "none"
fill = "none"
reference = true
"""
MODEL = """schema = 1
title = "people who notice"
[rating.dcr]
people_sd = 0.4
condition_sd = 0.3
noise_sd = 0.6
[rating.dcr.means]
late = 2.0
warped = 3.4
reference = 4.8
"""


def test_a_trial_shows_the_reference_and_then_the_condition():
    design = design_from_text(STUDY, "impaired.toml", checked=False)
    steps = steps_of(design, (("late", "reference", "warped"),), "main")
    shows = [step for step in steps if isinstance(step, Show)]
    assert [show.condition.name for show in shows] == ["reference", "late"] + ["reference"] * 3 + ["warped"]
    assert [show.after for show in shows[1::2]] == [show.key for show in shows[::2]]
    asks = [step for step in steps if isinstance(step, Ask)]
    assert [ask.about for ask in asks] == [show.key for show in shows[1::2]]
    trials = next(phase for phase in session_phases(design, "main") if phase.name == "trials")
    assert trials.content == "3 of the reference and a condition, each 2 s, each rated: dcr"
    assert trials.seconds == 3 * (2 * 2 + 6)


WRONG = r"""
reference = true ->  => trial.shows is "reference first", and no [[condition]] has reference = true @ shows
"dcr" -> "acr" => has 'acr', which asks nothing about the reference: expected dcr
shows = "reference first" ->  => shown right before: it needs shows = "reference first" @ scales
"dcr" -> "preference" => has 'preference', a preference
"""


@together("entry", table(WRONG))
def test_incompatible_settings_are_refused(entry):
    check_refused(entry, STUDY, lambda wrong: design_from_text(wrong, "impaired.toml", checked=False), "impaired.toml")
