"""One pipeline under every driver: what it is built from and exchanges, and what it keeps."""

from __future__ import annotations

import gc
import math
import tracemalloc
from collections.abc import Callable

import moderngl
import numpy as np
import pytest
from replays import CHEAPER, scene_for

from hmdwarp.base import picture_from_linear
from hmdwarp.client import build_plan
from hmdwarp.client.strategies import strategies
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Lap, download
from hmdwarp.headsets import load_headset
from hmdwarp.pipeline import PipelineOptions, PoseRequest, Source, Target, build_plan_for, plans_for, source_of
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.run import Run
from hmdwarp.scenes import load_scene

SIZE = (64, 80)
STEP_NS = 10_000_000
PAIR = ("forward", "pyramid")


class Head:
    """A source of poses that follows a function of time in ns."""

    def __init__(self, pose_at: Callable[[int], Pose]) -> None:
        self._pose_at = pose_at

    def start(self) -> None: ...

    def close(self) -> None: ...

    def head_at(self, time_ns: int) -> PoseSample:
        return PoseSample(time_ns, self._pose_at(time_ns), Origin.MEASURED)


class Eyes:
    """Eyes at places in the head, each with a field of view."""

    def __init__(self, *eyes: tuple[Pose, Fov]) -> None:
        self._eyes = eyes

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        return tuple(View(world_from_head @ eye, fov, eye) for eye, fov in self._eyes)


# Of a headset that is no mirror image of itself: guard bands differ by a few pixels.
UNEQUAL = Eyes(
    (Pose((-0.04, 0.01, 0)), Fov(-0.8, 0.5, -0.7, 0.6)), (Pose((0.02, 0, 0.005)), Fov(-0.45, 0.9, -0.6, 0.75))
)
ONE = Eyes((Pose(), Fov.symmetric(1.4, 1.2)))


def turning(time_ns: int) -> Pose:
    """A head that turns and steps aside."""
    share = time_ns * 1e-9
    return Pose((0.3 * share, 1.6, 1.0), (0, np.sin(share / 2), 0, np.cos(share / 2)))


def pipeline(gpu, eyes, **changes):
    options = PipelineOptions(
        **{"scene": "planes", "latency_ms": 20, "fill": "none", "lens": "none", "size": SIZE, **changes}
    )
    scene = load_scene(options.scene)
    plans = plans_for(options, None, scene)
    needs = plans[0].needs
    requested = PoseRequest(Head(turning), None, SIZE, options.guard_band, needs)
    target = Target(gpu, eyes, 100.0, round(options.latency_ms * 1e6))
    return Run(options, source_of(options), None, plans, needs).build(target, requested)


def shown_at(made, number: int):
    """The refresh of that number; those before it only draw."""
    for k in range(number + 1):
        made.loop.draw(k * STEP_NS)
    return made.loop.show(number * STEP_NS)


@pytest.mark.parametrize(
    "guard", [{}, {"guard": 1.3}, {"guard": (1.1, 1.4)}, {"rendered_size": (SIZE[0] + 17, SIZE[1] + 4)}], ids=str
)
@pytest.mark.parametrize("warp", ["none", "forward", "iterative"])
def test_eyes_that_differ_are_drawn_and_shown_each_with_its_own_view(gpu, guard, warp):
    # Of one sample: a guard band of parts of a pixel makes other mixtures at edges.
    with pipeline(gpu, UNEQUAL, **guard, warp=warp, latency_ms=0, samples=1) as made:
        refresh = shown_at(made, 0)
        for inputs, eye in zip(refresh.inputs, refresh.eyes, strict=True):
            truth = made.server.draw(inputs.shown, SIZE)
            wanted, found = (
                picture_from_linear(download(texture)).astype(int) for texture in (truth.colour, eye.shown.texture)
            )
            made.server.pool(SIZE).release(truth.colour)
            if warp != "none":
                # No latency: every warp gives the rendered picture back. A guard band of an odd
                # number of pixels shifts the 2x2 quads over which the level of detail of textures
                # is taken: a few levels of 255 where they are seen aslant, never another surface
                # (50 and more).
                off = np.abs(found - wanted).max(axis=2)
                assert off.max() <= 25
                assert (off > 4).mean() < 0.03
        assert refresh.inputs[0].rendered.size == refresh.inputs[1].rendered.size == made.sizes.rendered


@pytest.mark.parametrize("warp", ["forward", "mesh", "layered"])
def test_one_eye_is_enough(gpu, warp):
    with pipeline(gpu, ONE, warp=warp) as made:
        refresh = shown_at(made, 4)
        assert len(refresh.eyes) == len(refresh.stage_ms) == 1
        assert download(refresh.eyes[0].shown.texture)[..., 3].mean() > 0.7


def test_exchanged_passes_show_what_they_would_have_shown_alone(gpu):
    other = build_plan((), "iterative:frames=1", "interpolate", "none", client_geometry=True)
    with pipeline(gpu, ONE, warp="iterative:frames=1", fill="interpolate") as made:
        wanted = download(shown_at(made, 5).eyes[0].shown.texture)
    with pipeline(gpu, ONE, warp="forward") as made:
        for k in range(6):
            made.loop.draw(k * STEP_NS)
            if k == 4:
                made.loop.show(k * STEP_NS)
                made.exchange(other)
        found = made.loop.show(5 * STEP_NS)
        assert found.plan is other
        assert np.array_equal(download(found.eyes[0].shown.texture), wanted)


def test_exchanging_again_and_again_leaves_nothing_behind(gpu):
    """Whoever compares warps in a window presses the key a hundred times."""
    plans = [build_plan((), warp, "none", "none", client_geometry=True) for warp in ("forward", "mesh", "backward")]
    with pipeline(gpu, ONE) as made:
        shown_at(made, 3)
        counts = []
        for turn in range(4):
            for plan in plans:
                made.exchange(plan)
                made.loop.show((4 + turn) * STEP_NS)
            counts.append((len(made._made), len(gpu.shaders)))
        assert counts[1:] == counts[:1] * 3
        assert counts[0][0] == 1


def test_a_change_of_latency_keeps_what_is_under_way(gpu):
    options = PipelineOptions()
    with pipeline(gpu, ONE, latency_ms=30) as made:
        ages = []
        for k in range(12):
            if k == 6:
                made.channel.retime(options.network, 60_000_000)
            made.loop.draw(k * STEP_NS)
            refresh = made.loop.show(k * STEP_NS)
            ages.append(None if refresh is None else refresh.age_ns // STEP_NS)
    # Three refreshes late; those sent before the change still arrive, then the last one stays until
    # the first that took six has come.
    assert ages == [None, None, None, 3, 3, 3, 3, 3, 3, 4, 5, 6]


def test_times_are_read_when_they_are_asked_for(gpu, monkeypatch):
    """A live driver asks a refresh later, so that the GPU never has to be waited for."""
    read, unread = [], Lap.read
    monkeypatch.setattr(Lap, "read", lambda self: (read.append(self), unread(self))[1])
    with pipeline(gpu, ONE) as made:
        refresh = shown_at(made, 4)
        assert not read
        assert {name for name, _ in refresh.stage_ms[0]} == {"warp"}
        assert refresh.response.warp_ms == sum(ms for _, ms in refresh.stage_ms[0])
        assert refresh.response.render_ms > 0
        assert len(read) >= 3


def test_frames_carry_what_the_plan_needs_and_older_ones_are_of_the_same_eye(gpu):
    with pipeline(gpu, ONE, warp="layered") as made:
        assert made.requested.needs == Needs(peeled=made.plans[0].needs["peeled"]) == made.plans[0].needs
    with pipeline(gpu, UNEQUAL, warp="multi:frames=1,spacing=0,eye=own") as made:
        for one in shown_at(made, 4).inputs:
            assert [older.view.fov for older in one.others] == [one.rendered.view.fov]
    with pipeline(gpu, UNEQUAL, warp="multi:frames=0") as made:
        left, right = shown_at(made, 4).inputs
        for one, other in ((left, right), (right, left)):
            assert [beside.view.fov for beside in one.others] == [other.rendered.view.fov]


def test_a_plan_beside_others_gets_only_what_it_needs(gpu):
    """Frames carry what all plans need; a fill that reads the shown depth failed on the rest."""
    options = PipelineOptions(scene="planes", warp="layered", fill="none", lens="none", size=SIZE)
    plans = [build_plan((), warp, fill, "none", client_geometry=True) for warp, fill in (("layered", "none"), PAIR)]
    needs = plans[0].needs | plans[1].needs
    requested = PoseRequest(Head(turning), None, SIZE, 1.0, needs)
    target = Target(gpu, UNEQUAL, 100.0, 0)
    with Run(options, Source(options), None, plans[:1], needs).build(target, requested) as made:
        made.loop.draw(0)
        refresh = made.loop.show(0)
        beside = made.loop.inputs(refresh, plans[1].needs)
        assert "peeled" in refresh.inputs[0].rendered
        assert "peeled" not in beside[0].rendered
        shown = made.compensator(plans[1]).run(beside[0]).shown
        other = Run(options.with_pair(*PAIR), Source(options), None, plans[1:], plans[1].needs)
        with other.build(target, PoseRequest(Head(turning), None, SIZE, 1.0, plans[1].needs)) as alone:
            alone.loop.draw(0)
            expected = alone.loop.show(0).eyes[0].shown
            assert np.array_equal(download(shown.texture), download(expected.texture))


APART_NS = 7_000_000_000
MIDDLE, LAST = 43, 86  # refreshes: 5 and 10 minutes
# The times of the last thousands of refreshes, which a proxy keeps for its medians, are 43 times
# 0.24 kB here; caches of 64 matrices that other tests have filled take 64 times 0.5 kB anew. A
# picture of 32x24 kept at each refresh would be 43 times 6 kB.
GROWTH_BYTES = 40_000


def wandering(time_ns: int) -> Pose:
    """A head that walks and turns through the scene and comes by again."""
    angle = time_ns * 1e-9 * 0.31
    turn = (0.1 * math.sin(angle / 2), math.sin(angle / 3), 0.0, math.cos(angle / 3))
    return Pose((math.sin(angle), 1.6 + 0.1 * math.cos(angle), math.cos(angle / 5)), turn)


@pytest.mark.slow(15)
@pytest.mark.parametrize(
    "name", [*(CHEAPER.get(name, name) for name in strategies.names()), "model:arrives=progressive"]
)
def test_memory_stops_growing_once_the_head_has_been_everywhere(gpu, name):
    headset = load_headset("flat-90")
    said = {"strategy": name, "scene": scene_for(name), "size": "32x24", "lens": "none", "latency": 20.0}
    options = PipelineOptions.of({**said, "predict": "none", "samples": 1, "loss": "0.1", "link_seed": 3})
    scene = load_scene(options.scene)
    plan = build_plan_for(options, headset, scene)
    request = PoseRequest(Head(wandering), None, (32, 24), options.guard_band, plan.needs)
    run = Run(options, Source(options, scene), None, [plan], plan.needs)
    with run.build(Target(gpu, headset, 100.0, 20_000_000), request) as made:
        tracemalloc.start()
        try:
            kept = [_kept_after(made.loop, first, last) for first, last in ((0, MIDDLE), (MIDDLE, LAST))]
        finally:
            tracemalloc.stop()
    (bytes_then, on_gpu_then), (bytes_now, on_gpu_now) = kept
    assert on_gpu_now <= on_gpu_then
    assert bytes_now - bytes_then < GROWTH_BYTES


def _kept_after(loop, first: int, last: int) -> tuple[int, int]:
    """Bytes on the CPU and textures and buffers on the GPU, after these refreshes."""
    for number in range(first, last):
        loop.draw(number * APART_NS)
        loop.show(number * APART_NS)
    gc.collect()
    on_gpu = sum(isinstance(value, moderngl.Texture | moderngl.Buffer) for value in gc.get_objects())
    return tracemalloc.get_traced_memory()[0], on_gpu
