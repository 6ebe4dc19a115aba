"""Which combination to take for a time, and the governor that changes it, without any clock."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.base import HmdwarpError, InputError
from hmdwarp.pipeline import QualityLevel
from hmdwarp.pipeline.governor import BACK_OFF, PATIENCE, SETTLING, WINDOW, Governor, best_within, levels_from


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


OURS, LARGE = {"machine": {"host": "ours"}}, {"size": [1280, 800]}


@pytest.mark.parametrize(
    ("rows", "levels"),
    [
        (  # means over the cases that all have
            [row("a", "none", 4.0, 0.2), row("a", "none", 6.0, 0.4, latency_ms=400.0),
             row("a", "none", 500.0, 0.9, latency_ms=800.0), row("b", "none", 8.0, 0.1),
             row("b", "none", 8.0, 0.2, latency_ms=400.0)],
            [("a", 5.0, 0.3), ("b", 8.0, 0.15)],
        ),
        # Of several sizes the largest.
        ([row("a", "none", 5.0, 0.2), row("a", "none", 20.0, 0.21, **LARGE)], [("a", 20.0, 0.21)]),
        (
            [row("a", "none", 20.0, 0.2, **LARGE), row("a", "none", 30.0, 0.2, **LARGE, scene="planes"),
             row("a", "none", 40.0, 0.2, size=[800, 1280])],
            [("a", 30.0, 0.2)],
        ),
        # Of two machines that with the most rows, however quick the other is.
        (
            [row("b", "none", 0.1, 0.1, machine={"host": "theirs"}), row("a", "none", 10.0, 0.3, **OURS),
             row("b", "none", 20.0, 0.1, **OURS)],
            [("a", 10.0, 0.3), ("b", 20.0, 0.1)],
        ),
        # What was not measured is left out.
        ([row("a", "none", None, 0.1), row("b", "none", 3.0, None), row("c", "none", 3.0, 0.2)], [("c", 3.0, 0.2)]),
    ],
    ids=["means", "sizes", "sides", "machines", "unmeasured"],
)  # fmt: skip
def test_a_level_has_the_figures_that_can_be_compared(rows, levels):
    found = [(level.warp, level.total_ms, level.error) for level in levels_from(rows)]
    assert found == [(name, ms, pytest.approx(error)) for name, ms, error in levels]


def test_the_most_accurate_within_a_budget():
    levels = levels_from(ROWS)
    assert [*map(str, levels)] == ["none", "rotation", "forward + interpolate", "mesh:cut=slope + interpolate"]
    assert levels[2] == QualityLevel("forward", "interpolate", 8.0, 0.05, 35.0)
    # A budget is met by what takes exactly that long.
    assert [best_within(levels, budget_ms) for budget_ms in (1.0, 8.0, 10, 1e6)] == [0, 2, 2, 3]


def test_rows_and_budgets_that_say_nothing_are_refused():
    apart = [row("a", "none", 1.0, 0.1), row("b", "none", 1.0, 0.1, scene="planes")]
    for rows, message in (([row("a", "none", None, 0.1)], "with a time and a FLIP"), (apart, "no common case")):
        with pytest.raises(InputError, match=message):
            levels_from(rows)
    for budget_ms in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="expected a time above 0 ms"):
            best_within(levels_from(ROWS), budget_ms)


BUDGET = 10.0
LADDER = tuple(
    QualityLevel(f"level{n}", "none", time, 1 / (1 + n)) for n, time in enumerate((1.0, 3.0, 6.0, 9.0, 20.0))
)
Machine = Callable[[QualityLevel, int], float]


def run(governor: Governor, machine: Machine, refreshes: int, start: int = 0) -> list:
    """The changes while the governor's level runs on the machine."""
    told = (governor.measured(machine(governor.level, start + k)) for k in range(refreshes))
    return [change for change in told if change is not None]


def steady(drift: float) -> Machine:
    """Everything takes `drift` times what the benchmark says."""
    return lambda level, _: level.total_ms * drift


@st.composite
def ladders(draw: st.DrawFn) -> tuple[QualityLevel, ...]:
    """1 to 6 levels, each 1.02 to 3 times as dear as the one before."""
    steps = draw(st.lists(st.floats(1.02, 3.0), min_size=0, max_size=5))
    times = [draw(st.floats(0.1, 5.0))]
    for step in steps:
        times.append(times[-1] * step)
    return tuple(QualityLevel(f"level{n}", "none", time, 1 / (1 + n)) for n, time in enumerate(times))


DRIFTS = st.floats(0.1, 10.0)
BUDGETS = st.floats(1.0, 40.0)  # times the cheapest level


@given(ladders(), BUDGETS, DRIFTS)
def test_it_settles_under_any_steady_load_within_the_budget_if_a_level_fits(levels, budget, drift):
    """One change is enough where all levels drift alike. Down to what fits, or up to what has room;
    then none. 1/400: a smaller excess does not add up to the evidence wanted."""
    governor = Governor(levels, budget * levels[0].total_ms)
    changes = run(governor, steady(drift), 400)
    assert len(changes) <= 1
    over = governor.level.total_ms * drift > governor.budget_ms * (1 + 1 / 400)
    assert not over or governor.level is levels[0]
    assert run(governor, steady(drift), 3000) == []


@given(ladders(), BUDGETS, DRIFTS, st.floats(1.0, 3.0))
def test_more_budget_never_gives_a_worse_rung(levels, budget, drift, more):
    settled = []
    for ms in (budget * levels[0].total_ms, more * budget * levels[0].total_ms):
        governor = Governor(levels, ms)
        run(governor, steady(drift), 1500)
        settled.append(governor.level.error)
    assert settled[1] <= settled[0]


@given(st.integers(5, 40), st.floats(1.0, 1000.0), st.floats(0.5, 0.9))
def test_spikes_alone_change_nothing(apart, height, share):
    """Alone. With 4 refreshes between them at 90 % of the budget, which take back 0.4 of evidence
    against 0.25 of a spike."""
    machine = lambda _, k: share * BUDGET * (height if k % apart == apart - 1 else 1)  # noqa: E731
    governor = Governor((LADDER[0], QualityLevel("top", "none", share * BUDGET, 0.1)), BUDGET)
    assert run(governor, machine, 1000) == []


@given(ladders(), BUDGETS, DRIFTS, st.integers(0, 2**32))
def test_noise_of_ten_percent_makes_nothing_flap(levels, budget, drift, seed):
    """Wherever the level is, no level is entered twice. Noise may lead down once at the very edge,
    and never up and down again."""
    noise = random.Random(seed)
    governor = Governor(levels, budget * levels[0].total_ms)
    changes = run(governor, lambda level, _: level.total_ms * drift * noise.uniform(0.9, 1.1), 3000)
    entered = [governor.levels[0] if not changes else changes[0].before, *(change.after for change in changes)]
    assert len(entered) == len(set(entered)), [change.reason for change in changes]


@pytest.mark.parametrize("over, soon", [(1.1, 11), (1.25, 4), (5.0, 4)])
def test_it_goes_down_soon_and_far_enough(over, soon):
    governor = Governor(LADDER, BUDGET)
    run(governor, steady(1.0), 100)
    drift = over * BUDGET / 9.0
    changes = run(governor, steady(drift), soon)
    assert len(changes) == 1
    assert changes[0].before.total_ms == 9.0
    assert changes[0].after == max((r for r in LADDER if r.total_ms * drift <= BUDGET), key=lambda r: r.total_ms)


def test_it_says_why_with_figures():
    governor = Governor(LADDER, BUDGET)
    (down,) = run(governor, steady(2.0), 50)
    assert down.reason == "level3 takes 18.00 ms, over the budget of 10 ms; level1 is expected to take 6.00 ms"
    assert down.refresh == 5  # 2 that tell of the start, 4 of evidence, counted from 0
    (up,) = run(governor, steady(1.0), 200)
    assert up.reason.startswith(
        "level1 takes 3.00 ms, and for 60 refreshes level3 has been expected within 95% of the budget of 10 ms"
    )
    hopeless = Governor(LADDER[:2], 3.5)
    (down,) = run(hopeless, steady(5.0), 50)
    assert down.reason.endswith("level0 is expected to take 5.00 ms, the least there is")


@given(st.floats(1.5, 20.0), st.integers(10, 600))
def test_it_recovers_when_the_load_is_gone(load, lasting):
    governor = Governor(LADDER, BUDGET)
    machine = lambda level, k: level.total_ms * (load if 100 <= k < 100 + lasting else 1)  # noqa: E731
    changes = run(governor, machine, 100 + lasting)
    assert changes and governor.level.total_ms < 9.0
    run(governor, machine, SETTLING + WINDOW + PATIENCE + WINDOW, start=100 + lasting)
    assert governor.level.total_ms == 9.0


def test_the_way_up_waits_until_there_has_been_room_for_long_enough():
    waited = SETTLING + WINDOW - 1 + PATIENCE
    governor = Governor(LADDER, BUDGET)
    (down,) = run(governor, steady(2.0), SETTLING + 4)
    changes = run(governor, steady(1.0), 3 * waited)
    assert [c.after.total_ms for c in changes] == [9.0]
    assert changes[0].refresh - down.refresh == waited
    fresh = run(Governor(LADDER, BUDGET), steady(0.4), 3 * waited)  # nor is the start of a run shorter
    assert fresh[0].refresh == waited - 1 and fresh[0].after.total_ms == 20.0


def test_a_level_that_disappoints_is_tried_ever_more_rarely():
    """The benchmark says 9 ms, it takes 15 here: a machine whose levels do not drift alike."""
    governor = Governor(LADDER, BUDGET)
    changes = run(governor, lambda level, _: 15.0 if level.total_ms == 9.0 else level.total_ms, 30_000)
    tries = [change.refresh for change in changes if change.after.total_ms == 9.0]
    gaps = [b - a for a, b in zip(tries, tries[1:], strict=False)]
    assert len(tries) <= 1 + math.log(30_000 / PATIENCE, BACK_OFF)
    assert all(later >= 3 * earlier for earlier, later in zip(gaps, gaps[1:], strict=False))
    assert governor.level.total_ms == 6.0


def test_where_a_level_disappoints_dearer_ones_wait_as_long():
    levels = tuple(QualityLevel(f"level{ms}", "none", ms, 1 / ms) for ms in (1.0, 2.5, 4.0))
    governor = Governor(levels, 4.5)
    changes = run(governor, lambda level, _: 1.2 if level is levels[0] else 6.0, 190)
    assert [change.after for change in changes][-3:] == [levels[0], levels[1], levels[0]]
    assert run(governor, lambda *_: 0.9, 2 * PATIENCE) == []


def test_it_starts_at_the_most_accurate_level_within_the_budget():
    assert Governor(LADDER, BUDGET).level.total_ms == 9.0
    with pytest.raises(InputError, match=r"level0, takes 1\.00 ms"):
        Governor(LADDER, 0.5)
    for wrong in ((), LADDER[::-1], (LADDER[0], LADDER[0])):
        with pytest.raises(HmdwarpError, match="each take longer and err less"):
            Governor(wrong, BUDGET)
    for bad in (float("nan"), float("inf"), -1.0):
        with pytest.raises(HmdwarpError, match="expected a finite time"):
            Governor(LADDER, BUDGET).measured(bad)
