"""Orders of paired comparisons: every pair equally often, or those that tell most."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..scales import FIRST, NEITHER

_BETWEEN = "/"  # no condition's name has it

Pair = tuple[str, str]  # as they are shown
Table = NDArray[np.float64]  # (n, n) counts


def pair_name(first: str, second: str) -> str:
    """Return a pair as an order names it: the first condition is shown first."""
    return f"{first}{_BETWEEN}{second}"


def pair_of(name: str) -> Pair:
    """Return the two conditions of a pair's name."""
    first, second = name.split(_BETWEEN)
    return first, second


def turned(name: str) -> str:
    """Return the name of the same pair the other way round."""
    return pair_name(*reversed(pair_of(name)))


def every_pair(names: Sequence[str]) -> tuple[str, ...]:
    """Return each pair of conditions once; over all of them each condition comes first as often.

    With an even number of conditions the counts differ by one.
    """
    numbered = list(enumerate(names))
    return tuple(
        pair_name(a, b) if (i + j) % 2 else pair_name(b, a) for (i, a), (j, b) in itertools.combinations(numbered, 2)
    )


def tables_of(
    names: Sequence[str], said: Iterable[tuple[Pair, float]], *, allows_ties: bool
) -> tuple[Table, Table | None]:
    """Count answers about pairs, as jod_scores takes them.

    said: pairs as they were shown, with an answer, FIRST, SECOND or NEITHER, each.
    """
    place = {name: number for number, name in enumerate(names)}
    wins, ties = np.zeros((2, len(names), len(names)))
    for (first, second), answer in said:
        a, b = place[first], place[second]
        if answer == NEITHER:
            ties[a, b] += 1
            ties[b, a] += 1
        elif answer == FIRST:
            wins[a, b] += 1
        else:
            wins[b, a] += 1
    return wins, ties if allows_ties else None


def adaptive_order(
    names: Sequence[str],
    wins: Table,
    ties: Table | None,
    shown_first: Table,
    repeats: int,
    draw: Callable[..., int],
) -> tuple[tuple[str, ...], ...]:
    """Return the pairs of the next session: for each repeat those that tell most of the scores.

    They are the spanning tree of the largest expected information about the scores, given all
    answers so far: n - 1 pairs that connect all n conditions. A later repeat counts the trees
    before it as if they had been answered as expected.

    wins, ties: as jod_scores takes them. shown_first: (n, n), how often the row was shown before
    the column. draw: (below, words..) to a number, decides among equals.
    Source: Li, Mantiuk, Wang, Le Callet and Le Callet 2018, Hybrid-MST: A hybrid active sampling
    strategy for pairwise preference aggregation, NeurIPS; here from the first session on.
    """
    from ..statistics import expected_information, with_expected

    wins, shown_first = wins.copy(), shown_first.copy()
    order: list[tuple[str, ...]] = []
    for repeat in range(repeats):
        tree = _widest_tree(expected_information(wins, ties), partial(draw, 2**32, "tree", repeat))
        pairs: list[tuple[int, str]] = []
        for a, b in tree:
            ahead = shown_first[a, b] - shown_first[b, a]
            flip = ahead > 0 or (ahead == 0 and draw(2, "first", repeat, a, b) == 1)
            i, j = (b, a) if flip else (a, b)
            shown_first[i, j] += 1
            pairs.append((draw(2**32, "place", repeat, a, b), pair_name(names[i], names[j])))
        order.append(tuple(name for _, name in sorted(pairs)))
        wins = with_expected(wins, ties, tree)
    return tuple(order)


def _widest_tree(weights: Table, among_equals: Callable[[int, int], int]) -> list[tuple[int, int]]:
    """Return the n - 1 edges of the spanning tree with the largest weights (Kruskal)."""
    n = len(weights)
    edges = sorted(itertools.combinations(range(n), 2), key=lambda e: (-round(float(weights[e]), 9), among_equals(*e)))
    group, tree = list(range(n)), []
    for a, b in edges:
        if group[a] != group[b]:
            tree.append((a, b))
            old, new = group[b], group[a]
            group = [new if one == old else one for one in group]
    return tree
