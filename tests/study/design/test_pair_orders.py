"""Trials of two: orders of pairs, balanced over all sessions; the reference and a condition."""

from __future__ import annotations

from collections import Counter
from itertools import combinations, permutations, product

from together import together

from hmdwarp.study.design import Ask, Show, design_from_text, notes, pair_of, rows_for, steps_of, tables_of, trials_of
from hmdwarp.study.design.orders import every_pair, presented
from hmdwarp.study.design.plan_text import balance, session_phases
from hmdwarp.study.scales import FIRST, NEITHER, SECOND

from ..plans import text_of


def study(conditions: int, repeats: int = 1):
    latencies = [100 * (k + 1) for k in range(conditions)]
    changes = ("[100, 200, 300]", str(latencies)), ("repeats = 1", f"repeats = {repeats}")
    return design_from_text(text_of("pairs", *changes), "pairs.toml", checked=False)


@together("conditions, repeats", product([2, 3, 4, 5], [1, 2]))
def test_full_balance(conditions, repeats):
    """Over all orders each pair stands in each place, and each way round, equally often."""
    design = study(conditions, repeats)
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
    assert [type(step) for step in steps[:3]] == [Show, Show, Ask]
    assert (first.condition.name, second.condition.name) == pair_of(order[0][0])
    assert (first.turn, first.after, second.turn, second.after) == ("first", "", "second", first.key)
    assert question.about == second.key
    sick = [step for step in steps if isinstance(step, Ask) and step.scale.name == "fms"]
    assert [(question.trial, question.about) for question in sick] == [(2, "trial/2/second")]
    assert len({step.key for step in steps}) == len(steps)
    trials = next(phase for phase in session_phases(design, "main") if phase.name == "trials")
    assert trials.content.startswith("3 pairs")
    assert trials.seconds == 3 * 2 * 2 + 4 * 6.0  # each shown for 2 s, and 4 answers
    assert not any("odd number" in note for note in notes(design))


def test_a_trial_shows_the_reference_and_then_the_condition():
    design = design_from_text(text_of("impaired"), "impaired.toml", checked=False)
    steps = steps_of(design, (("late", "reference", "warped"),), "main")
    shows = [step for step in steps if isinstance(step, Show)]
    assert [show.condition.name for show in shows] == ["reference", "late"] + ["reference"] * 3 + ["warped"]
    assert [show.after for show in shows[1::2]] == [show.key for show in shows[::2]]
    assert [ask.about for ask in steps if isinstance(ask, Ask)] == [show.key for show in shows[1::2]]
    trials = next(phase for phase in session_phases(design, "main") if phase.name == "trials")
    assert trials.content == "3 of the reference and a condition, each 2 s, each rated: dcr"
    assert trials.seconds == 3 * (2 * 2 + 6)


def test_answers_become_tables():
    said = [(("a", "b"), FIRST), (("a", "b"), SECOND), (("c", "a"), SECOND), (("b", "c"), NEITHER)]
    wins, ties = tables_of("abc", said, allows_ties=True)
    assert wins.tolist() == [[0, 1, 1], [1, 0, 0], [0, 0, 0]]
    assert ties.tolist() == [[0, 0, 0], [0, 0, 1], [0, 1, 0]]
