"""Which cases, which combinations at a time, which refreshes, and which frames those need."""

from __future__ import annotations

import itertools
import sys

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from replays import small

from hmdwarp.base import Choice, InputError, MachineError
from hmdwarp.client import parse_fills
from hmdwarp.client.warps import warps
from hmdwarp.experiments.bench import BenchOptions
from hmdwarp.experiments.bench.cases import (
    WITH_COMPLETE_FILLS,
    cases_of,
    combinations_of,
    common_start_s,
    notes_on_warps,
    pairs_of,
    run_options,
    warps_of,
)
from hmdwarp.frames import Needs, Others
from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.run import Combination, set_up_replay
from hmdwarp.run.measuring import OUTSIDE, batches, frames_used, instants_of, missing, refreshes
from hmdwarp.scenes import load_scene


@given(st.integers(1, 5000), st.integers(1, 40))
def test_instants_are_spread_and_have_a_neighbour(count, wanted):
    found = instants_of(count, wanted)
    assert found == sorted(set(found)) and all(0 <= number < count for number in found)
    assert len(found) == min(wanted, max(1, count // 2))
    if count > 1:
        assert found[0] >= 1
        gaps = [b - a for a, b in zip(found, found[1:], strict=False)]
        assert not gaps or max(gaps) <= count / len(found) + 1


def test_every_combination_of_everything():
    options = BenchOptions(
        latencies_ms=(200, 400), scenes=("room", "planes"), recordings=("walk",), sizes=((64, 48), (32, 24))
    )
    found = cases_of(options)
    assert len(found) == len(set(found)) == 8
    assert [case.size for case in found] == [(64, 48)] * 4 + [(32, 24)] * 4
    alone = BenchOptions(warps="forward", fills="none", scenes="room", recordings="walk")  # each is one name
    assert (*alone.warps, *alone.fills, *alone.scenes, *alone.recordings) == ("forward", "none", "room", "walk")
    asked = attrs.evolve(options, warps=("forward", "rotation", "forward"), fills=("none", "interpolate", "none"))
    pairs = [(c.warp, c.fill) for c in combinations_of(asked, load_scene("planes"))]
    assert pairs == [(warp, fill) for warp in ("forward", "rotation") for fill in ("none", "interpolate")]


DRAWN_ON_THE_CLIENT = ["difference", "irradiance", "model", "photons", "points"]


def test_all_warps_of_late_pictures_by_default():
    found = warps_of(BenchOptions())
    taken = [warp for warp in warps if warp.name not in DRAWN_ON_THE_CLIENT]
    more = {f"{warp.name}:{settings}" for warp in taken for settings in (*warp.variants, *warp.baselines)}
    outside = [name for name in OUTSIDE if not missing(name)]
    assert [text for text in found if ":" not in text] == [*(warp.name for warp in taken), *outside]
    assert set(found) - {warp.name for warp in taken} - set(outside) == more
    # Those that draw on the client are noted, and taken by name.
    (note,) = (note for note in notes_on_warps(BenchOptions()) if "compare" in note)
    assert all(name in note for name in DRAWN_ON_THE_CLIENT)
    assert warps_of(BenchOptions(warps=tuple(DRAWN_ON_THE_CLIENT))) == DRAWN_ON_THE_CLIENT
    assert notes_on_warps(BenchOptions(warps=("model",))) == notes_on_warps(BenchOptions(strategies=("model",))) == []


def test_complete_fills_run_with_few_warps_where_none_was_named():
    pairs = pairs_of(BenchOptions())
    with_complete = {warp for warp, fill in pairs if fill == "pyramid"}
    assert with_complete == set(WITH_COMPLETE_FILLS) == {warp for warp, fill in pairs if fill == "memory+pyramid"}
    assert {warp for warp, fill in pairs if fill == "interpolate"} == set(warps_of(BenchOptions())) - set(OUTSIDE)
    for named in (BenchOptions(warps=("shift",)), BenchOptions(fills=("none", "pyramid"))):
        found = [(warp, fill) for warp, fill in pairs_of(named) if warp not in OUTSIDE]
        assert found == [(warp, fill) for warp in warps_of(named) if warp not in OUTSIDE for fill in named.fills]


def test_another_librarys_warp_has_no_fill_and_is_told_where_it_is_missing(monkeypatch):
    pytest.importorskip("cv2")
    options = BenchOptions(warps=("forward", "cv2.warpFrame"), fills=("pyramid",))
    assert pairs_of(options) == [("forward", "pyramid"), ("cv2.warpFrame", "none")]
    assert notes_on_warps(BenchOptions(lens="radial"))[1:] == ["cv2.warpFrame is left out: it has no lens."]
    monkeypatch.setitem(sys.modules, "cv2", None)  # as if it were not installed
    assert "cv2.warpFrame" not in warps_of(BenchOptions())
    _, note = notes_on_warps(BenchOptions())
    assert "OpenCV is not installed" in note and "pip install '.[bench]'" in note
    with pytest.raises(MachineError, match="cv2.warpFrame: OpenCV is not installed"):
        warps_of(options)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"fills": ()}, "fill"),
        ({"recordings": ()}, "TRACE: expected at least one"),
        ({"latencies_ms": (200, -1)}, "latency -1 ms"),
        ({"latencies_ms": (float("nan"),)}, "latency nan ms"),
        ({"workers": 100_000}, "at most 256"),
        ({"rounds": 10**400}, "rounds inf"),
        ({"sizes": [(0, 0)]}, "width, height"),
        ({"sizes": [(10.5, 5)]}, "width, height"),
        ({"sizes": ["10x5"]}, "width, height"),
    ],
)
def test_impossible_numbers_are_refused(changes, told):
    with pytest.raises(InputError, match=told):
        BenchOptions(**changes)


@attrs.frozen
class _Pass:
    is_pass: bool = False


@attrs.frozen
class _Plan:
    needs: Needs
    fills: tuple[Choice, ...] = ()
    effect_passes: tuple[str, ...] = ()
    lens: _Pass = _Pass()


def some(*needs: Needs) -> list[Combination]:
    each = itertools.product(enumerate(needs), ("none", "interpolate"))
    return [Combination(f"w{n}", fill, _Plan(need, parse_fills(fill))) for (n, need), fill in each]


def test_combinations_with_other_older_frames_are_batches_of_their_own():
    near, far = Needs(others=Others(1, 50)), Needs(others=Others(2, 100))
    found = batches(some(Needs(), near, Needs(), far, near), (8, 8), (8, 8), 1e9)
    assert [" ".join(c.warp for c in batch) for batch in found] == ["w0 w0 w1 w1 w2 w2 w4 w4", "w3 w3"]
    assert len(batches(some(Needs(), Needs()), (8, 8), (8, 8), 1e9)) == 1


@given(st.integers(1, 8), st.floats(0, 1e5))
def test_memory_bounds_what_exists_at_a_time(count, most):
    combinations = some(*[Needs()] * count)
    found = batches(combinations, (8, 8), (8, 8), most)
    assert [c for batch in found for c in batch] == combinations
    # Both fills of a warp together.
    assert all(len({c.warp for c in batch}) == len(batch) / 2 for batch in found)
    pair = 32 * 64 * 2 + 16 * 64 * 3
    assert all(len(batch) == 2 or len(batch) / 2 * pair <= most for batch in found)


@pytest.mark.parametrize("needs", [Needs(), Needs(others=Others(1, 40_000_000)), Needs(others=Others(3, 100_000_000))])
@pytest.mark.parametrize("latency_ms", [0.0, 60.0, 200.0])
def test_looking_at_a_few_refreshes_is_looking_at_a_whole_run(needs, latency_ms):
    """The frames, the older frames and the heads are those of the run in which every frame was
    drawn.
    """
    looked_at = {0, 7, 8, 23, 29}

    def seen(refresh, setup):
        older = [frame.drawn_ns for frame in (*setup.loop.history.frames, *setup.loop.history.recent)]
        return refresh.frame.drawn_ns, older, refresh.head.pose.position_m.tolist()

    with set_up_replay(small(latency_ms=latency_ms), needs) as setup:
        whole = {}
        for number, instant_ns in setup.schedule.numbered():
            setup.loop.draw(instant_ns)
            if number >= 0:
                whole[number] = seen(setup.loop.show(instant_ns), setup)
    with set_up_replay(small(latency_ms=latency_ms), needs) as setup:
        few = {number: seen(refresh, setup) for number, refresh in refreshes(setup, needs, looked_at)}
        used = frames_used(setup.schedule, setup.channel.latency_ns, needs, looked_at)
    assert few == {number: whole[number] for number in sorted(looked_at)}
    assert sum(map(len, used.values())) <= len(looked_at) * (1 + needs.others.past)


def test_runs_read_their_recording_as_asked_and_start_at_the_same_refresh():
    options = BenchOptions(trace_options=TraceOptions(scale=0.5))
    assert {run_options(options, case).trace_options for case in cases_of(options)} == {options.trace_options}
    options = BenchOptions(latencies_ms=(0, 100, 500), recordings=("walk",))
    walk = load_trace("walk").track
    assert common_start_s(options, walk, 60.0) == 0.5
    assert common_start_s(attrs.evolve(options, start_s=2.0), walk, 60.0) == 2.0
    with pytest.raises(InputError, match="latency 90000 ms"):
        common_start_s(attrs.evolve(options, latencies_ms=(100, 90000)), walk, 60.0)
