"""Which combination to take for a time, from rows as in bench.json."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.pipeline import QualityLevel
from hmdwarp.pipeline.governor import choose, levels_from


def row(warp: str, fill: str, total: float | None, flip: float | None, **case) -> dict:
    """What the choice reads of a row of bench.json."""
    figures = {
        "psnr_db": {"mean": None if flip is None else 40 - 100 * flip, "p95": None},
        "flip": {"mean": flip, "p95": flip},
    }
    return {
        "warp": warp, "fill": fill, "trace": "walk", "scene": "room", "latency_ms": 200.0, "size": [640, 400],
        "time_ms": {"total": {"median": total, "p95": total}}, "quality": figures, **case,
    }  # fmt: skip


ROWS = [
    row("none", "none", 1.0, 0.3), row("rotation", "none", 2.0, 0.15), row("forward", "interpolate", 8.0, 0.05),
    row("forward", "none", 7.0, 0.16), row("mesh:cut=slope", "interpolate", 40.0, 0.02),
    row("mesh", "interpolate", 90.0, 0.021),
]  # fmt: skip


@given(st.lists(st.tuples(st.floats(0.01, 1e3), st.floats(0, 1)), min_size=1, max_size=40), st.randoms())
def test_the_ladder_is_the_pareto_front(points, shuffler):
    rows = [row(f"w{n}", "none", *point) for n, point in enumerate(points)]
    front = levels_from(rows)
    assert all(a.total_ms < b.total_ms and a.error > b.error for a, b in zip(front, front[1:], strict=False))
    for time, error in points:  # nothing beats the front, and whatever is off it is beaten by it
        assert any(level.total_ms <= time and level.error <= error for level in front)
    assert {(level.total_ms, level.error) for level in front} <= set(points)
    shuffler.shuffle(rows)
    assert levels_from(rows) == front


def test_figures_are_means_over_the_cases_all_have():
    rows = [
        *(
            row("a", "none", time, flip, latency_ms=at)
            for time, flip, at in ((4.0, 0.2, 200.0), (6.0, 0.4, 400.0), (500.0, 0.9, 800.0))
        ),
        *(row("b", "none", time, flip, latency_ms=at) for time, flip, at in ((8.0, 0.1, 200.0), (8.0, 0.2, 400.0))),
    ]
    first, second = levels_from(rows)
    assert (first.warp, first.total_ms, first.error) == ("a", 5.0, pytest.approx(0.3))
    assert (second.warp, second.total_ms, second.error) == ("b", 8.0, pytest.approx(0.15))


def test_the_largest_of_several_sizes_counts():
    rows = [row("a", "none", 5.0, 0.2), row("a", "none", 20.0, 0.21, size=[1280, 800])]
    assert [level.total_ms for level in levels_from(rows)] == [20.0]
    more = [
        row("a", "none", 30.0, 0.2, size=[1280, 800], scene="planes"),
        row("a", "none", 40.0, 0.2, size=[800, 1280]),
    ]
    chosen = choose([*rows, *more], 100.0)
    assert (chosen["total_ms"], chosen["sizes"], chosen["cases"]) == (30.0, [(800, 1280), (1280, 800)], 3)


def test_the_choice_and_the_next_step_up():
    names = [str(level) for level in levels_from(ROWS)]
    assert names == ["none", "rotation", "forward + interpolate", "mesh:cut=slope + interpolate"]
    assert levels_from(ROWS)[2] == QualityLevel("forward", "interpolate", 8.0, 0.05, 35.0)
    chosen = choose(ROWS, 10)
    assert chosen == {
        "budget_ms": 10.0, "warp": "forward", "fill": "interpolate", "settings": {}, "total_ms": 8.0, "flip": 0.05,
        "psnr_db": 35.0, "sizes": [(640, 400)], "cases": 1,
        "next": {"warp": "mesh:cut=slope", "fill": "interpolate", "total_ms": 40.0, "flip": 0.02, "psnr_db": 38.0},
    }  # fmt: skip
    best = choose(ROWS, 1e6)
    assert best["next"] is None
    assert best["settings"] == {"cut": "slope"}
    assert choose(ROWS, 8.0)["warp"] == "forward"  # a budget is met by what takes exactly that long


def test_times_of_two_machines_are_not_mixed():
    """The machine with the most rows counts, however quick the other is."""
    slow = [row("none", "none", 10.0, 0.3), row("rotation", "none", 20.0, 0.1)]
    ours = [{**row, "latency_ms": latency, "machine": {"host": "ours"}} for row in slow for latency in (100.0, 200.0)]
    theirs = [{**row("rotation", "none", 0.1, 0.1), "latency_ms": 300.0, "machine": {"host": "theirs"}}]
    assert levels_from([*theirs, *ours]) == levels_from(ours)


def test_rows_that_measured_nothing_are_left_out():
    rows = [row("a", "none", None, 0.1), row("b", "none", 3.0, None), row("c", "none", 3.0, 0.2)]
    assert [found.warp for found in levels_from(rows)] == ["c"]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: levels_from([row("a", "none", None, 0.1)]), "with a time and a FLIP"),
        (
            lambda: levels_from([row("a", "none", 1.0, 0.1), row("b", "none", 1.0, 0.1, scene="planes")]),
            "no common case",
        ),
        *((lambda bad=bad: choose(ROWS, bad), "expected a time above 0 ms") for bad in (0.0, -1.0, math.nan, math.inf)),
    ],
)
def test_rows_and_budgets_that_say_nothing_are_refused(call, message):
    with pytest.raises(InputError, match=message):
        call()
