"""Orders are balanced, the same every time, and allotted so that none falls behind; pairs too."""

from __future__ import annotations

import random
from collections import Counter
from itertools import combinations, pairwise, permutations, product

import pytest
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.base import InputError
from hmdwarp.study.design import Condition, Design, Part, allot, design_from_text, pair_of, rows_for, tables_of
from hmdwarp.study.design.definitions import FIXED, RANDOM, WILLIAMS
from hmdwarp.study.design.orders import RANDOM_ROWS, every_pair, presented, williams
from hmdwarp.study.design.plan_text import balance
from hmdwarp.study.scales import FIRST, NEITHER, SECOND

from ..plans import text_of


def design(count: int, *, order: str = WILLIAMS, repeats: int = 1, seed: int = 0, part: str = "p") -> Design:
    conditions = tuple(Condition(f"c{number}") for number in range(count))
    return Design("s", "s", (Part(part, conditions),), (), order=order, repeats=repeats, seed=seed)


@together("n", range(1, 31))
def test_every_place_and_every_neighbour_equally_often(n):
    rows = williams(n)
    assert len(rows) == (1 if n == 1 else 2 * n if n % 2 else n)
    times = len(rows) // n
    assert all(sorted(row) == list(range(n)) for row in rows)
    places = Counter((place, number) for row in rows for place, number in enumerate(row))
    assert set(places.values()) == {times} and len(places) == n * n
    pairs = Counter(pair for row in rows for pair in pairwise(row))
    assert len(pairs) == n * (n - 1) and set(pairs.values()) <= {times}


def test_the_square_of_six_as_published():
    published = "1 2 6 3 5 4 / 2 3 1 4 6 5 / 3 4 2 5 1 6 / 4 5 3 6 2 1 / 5 6 4 1 3 2 / 6 1 5 2 4 3"
    assert " / ".join(" ".join(str(number + 1) for number in row) for row in williams(6)) == published


@together("n, repeats", product(range(1, 13), [1, 2, 3, 7, 13]))
def test_each_repeat_is_balanced_by_itself_and_seams_are_spread(n, repeats):
    rows = rows_for(design(n, repeats=repeats), "p")
    assert len(rows) == len(williams(n)) and all(len(order) == repeats for order in rows)
    for repeat in range(repeats):  # all rows of the square, each once
        assert len({order[repeat] for order in rows}) == len(rows)
        pairs = Counter(pair for order in rows for pair in pairwise(order[repeat]))
        assert len(set(pairs.values())) <= 1
    seams = Counter((one[-1], other[0]) for order in rows for one, other in pairwise(order))
    if n > 1 and repeats > 1:
        names = [f"c{number}" for number in range(n)]
        counts = [seams[a, b] for a in names for b in names if a != b]
        assert max(counts) - min(counts) <= 1  # as even as (repeats - 1) seams of each order allow
        assert not any(seams[name, name] for name in names)


def test_the_seed_and_the_part_decide_and_nothing_else():
    assert rows_for(design(6, seed=1), "p") == rows_for(design(6, seed=1), "p")
    assert rows_for(design(6, seed=1), "p") != rows_for(design(6, seed=2), "p")
    assert rows_for(design(6, part="p"), "p") != rows_for(design(6, part="q"), "q")
    # Written down once: the same plan on another machine, or with a later Python, is the same plan.
    assert rows_for(design(4, seed=7), "p")[0] == KNOWN_WILLIAMS
    assert rows_for(design(4, seed=7, order=RANDOM, repeats=2), "p")[:2] == KNOWN_RANDOM


KNOWN_WILLIAMS = (("c2", "c3", "c0", "c1"),)
KNOWN_RANDOM = (
    (("c3", "c0", "c2", "c1"), ("c2", "c1", "c3", "c0")),
    (("c3", "c0", "c1", "c2"), ("c3", "c1", "c2", "c0")),
)


@together("n", [2, 3, 5])
def test_random_orders_are_uniform_and_do_not_repeat_at_a_seam(n):
    rows = rows_for(design(n, order=RANDOM, repeats=3), "p")
    assert len(rows) == RANDOM_ROWS
    assert all(sorted(names) == [f"c{number}" for number in range(n)] for order in rows for names in order)
    assert not any(one[-1] == other[0] for order in rows for one, other in pairwise(order))
    # Each condition comes first 1000 / n times; four standard deviations of the binomial about
    # that.
    first = Counter(order[0][0] for order in rows)
    spread = 4 * (RANDOM_ROWS * (1 / n) * (1 - 1 / n)) ** 0.5
    assert all(abs(first[f"c{number}"] - RANDOM_ROWS / n) < spread for number in range(n))


def test_fixed_is_as_in_the_file_and_one_condition_has_one_order():
    assert rows_for(design(3, order=FIXED, repeats=2), "p") == ((("c0", "c1", "c2"), ("c0", "c1", "c2")),)
    assert rows_for(design(1, order=FIXED), "p") == ((("c0",),),)
    assert rows_for(design(1, order=RANDOM, repeats=2), "p")[0] == (("c0",), ("c0",))


# --- allotting ----------------------------------------------------------------------------------


@given(st.lists(st.integers(0, 9), min_size=1, max_size=30), st.integers(0, 2**63))
def test_one_of_the_least_filled_is_taken(filled, seed):
    row = allot(filled, seed)
    assert filled[row] == min(filled)
    assert allot(filled, seed) == row


@given(st.integers(1, 14), st.integers(0, 9), st.integers(0, 2**32), st.floats(0, 0.9))
def test_rows_stay_level_after_dropouts(rows, seed, chance, dropping):
    """Counts differ by more than one only where people dropped out of one row. Those who come next
    fill just these gaps.
    """
    rng = random.Random(chance)
    filled = [0] * rows
    for _ in range(60):
        before = max(filled) - min(filled)
        row = allot(filled, seed)
        filled[row] += 1
        assert max(filled) - min(filled) <= max(before, 1)
        if rng.random() < dropping:
            filled[rng.choice([number for number, count in enumerate(filled) if count])] -= 1
    gaps = sum(max(filled) - count for count in filled)
    for _ in range(gaps):
        filled[allot(filled, seed)] += 1
    assert len(set(filled)) == 1


def test_nothing_to_order_is_refused():
    with pytest.raises(InputError, match="0 conditions: expected 1 or more"):
        williams(0)
    with pytest.raises(InputError, match="no order to allot"):
        allot([], 0)


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


def test_answers_become_tables():
    said = [(("a", "b"), FIRST), (("a", "b"), SECOND), (("c", "a"), SECOND), (("b", "c"), NEITHER)]
    wins, ties = tables_of("abc", said, allows_ties=True)
    assert wins.tolist() == [[0, 1, 1], [1, 0, 0], [0, 0, 0]]
    assert ties.tolist() == [[0, 0, 0], [0, 0, 1], [0, 1, 0]]
