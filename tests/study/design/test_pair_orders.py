"""Orders of paired comparisons: balanced over all sessions, or chosen by what they tell."""

from __future__ import annotations

from collections import Counter
from itertools import combinations, permutations

import pytest
from together import together

from hmdwarp.study.design import Ask, Show, design_from_text, notes, pair_of, rows_for, steps_of, tables_of, trials_of
from hmdwarp.study.design.orders import every_pair, presented
from hmdwarp.study.design.plan_text import balance, session_phases
from hmdwarp.study.scales import FIRST, NEITHER, SECOND

from ..refusals import check_refused, table

TEXT = """schema = 1
name = "pairs"
title = "Which is better?"
seed = 4
[trial]
shows = "pair"
seconds = 2
repeats = {repeats}
order = "{order}"
scales = ["preference"]
[sickness]
scale = "fms"
every = 2
[[condition]]
latency = {latencies}
"""


def study(conditions: int = 4, order: str = "williams", repeats: int = 1):
    latencies = [100 * (k + 1) for k in range(conditions)]
    return design_from_text(TEXT.format(order=order, repeats=repeats, latencies=latencies), "pairs.toml", checked=False)


@pytest.mark.parametrize("conditions", [2, 3, 4, 5])
@pytest.mark.parametrize("repeats", [1, 2])
def test_full_balance(conditions, repeats):
    """Over all orders each pair stands in each place, and each way round, equally often."""
    design = study(conditions, repeats=repeats)
    rows = rows_for(design, "main")
    names = [condition.name for condition in design.parts[0].conditions]
    shown = Counter(name for order in rows for repeat in order for name in repeat)
    assert {pair_of(name) for name in shown} == set(permutations(names, 2))
    assert len(set(shown.values())) == 1
    found = balance(rows, presented(design, "main"))
    assert found.places[0] == found.places[1]
    for order in rows:
        for repeat in order:
            assert {frozenset(pair_of(name)) for name in repeat} == set(map(frozenset, combinations(names, 2)))
            assert len(repeat) == len(names) * (len(names) - 1) / 2
    if repeats == 2:  # a person sees a pair both ways
        assert all({pair_of(n) for n in first} == {pair_of(n)[::-1] for n in second} for first, second in rows)


def test_each_condition_is_first_as_often():
    """Within one repeat too: with an odd number exactly, else to one."""
    for n in range(2, 9):
        firsts = Counter(pair_of(name)[0] for name in every_pair([f"c{k}" for k in range(n)]))
        counts = [firsts[f"c{k}"] for k in range(n)]
        assert max(counts) - min(counts) <= (n % 2 == 0)


def test_a_trial_shows_both_before_it_asks():
    design = study(3)
    order = rows_for(design, "main")[0]
    steps = steps_of(design, order, "main")
    assert trials_of(design, "main") == 3
    first, second, question = steps[:3]
    assert isinstance(first, Show)
    assert isinstance(second, Show)
    assert (first.condition.name, second.condition.name) == pair_of(order[0][0])
    assert (first.turn, first.after, second.turn, second.after) == ("first", "", "second", first.key)
    assert isinstance(question, Ask)
    assert question.about == second.key
    sick = [step for step in steps if isinstance(step, Ask) and step.scale.name == "fms"]
    assert [(question.trial, question.about) for question in sick] == [(2, "trial/2/second")]
    assert len({step.key for step in steps}) == len(steps)
    trials = next(phase for phase in session_phases(design, "main") if phase.name == "trials")
    assert trials.content.startswith("3 pairs")
    assert trials.seconds == 3 * 2 * 2 + 4 * 6.0  # each shown for 2 s, and 4 answers
    assert not any("odd number" in note for note in notes(design))


WRONG = r"""
scales = ["preference"] -> scales = ["acr"] => after a pair: expected one scale of kind preference
scales = ["preference"] -> scales = ["preference", "preference_or_tie"] => expected one scale of kind
shows = "pair" -> shows = "one" => needs shows = "pair" @ scales
latency = [100, 200, 300] -> latency = [100] => expected two at least @ shows
scale = "fms" -> scale = "preference" => would stand among those of the trials
[sickness] -> [questionnaires]⏎»after = ["preference"]⏎[sickness] => it belongs in [trial]
repeats = 1 -> repeats = 400 => makes 3 x 400 trials
"""


@together("entry", table(WRONG))
def test_incompatible_settings_are_refused(entry):
    text = TEXT.format(order="williams", repeats=1, latencies=[100, 200, 300])
    check_refused(entry, text, lambda wrong: design_from_text(wrong, "pairs.toml", checked=False), "pairs.toml")


def test_answers_become_tables():
    wins, ties = tables_of(
        "abc",
        [(("a", "b"), FIRST), (("a", "b"), SECOND), (("c", "a"), SECOND), (("b", "c"), NEITHER)],
        allows_ties=True,
    )
    assert wins.tolist() == [[0, 1, 1], [1, 0, 0], [0, 0, 0]]
    assert ties.tolist() == [[0, 0, 0], [0, 0, 1], [0, 1, 0]]
