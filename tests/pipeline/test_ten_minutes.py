"""Ten minutes with each strategy: what it keeps has an end."""

from __future__ import annotations

import gc
import math
import tracemalloc

import moderngl
import pytest
from heads import Head
from replays import CHEAPER, scene_for

from hmdwarp.client.strategies import strategies
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset
from hmdwarp.pipeline import PipelineOptions, PoseRequest, Source, Target, build_plan_for
from hmdwarp.run import Run
from hmdwarp.scenes import load_scene

STEP_NS = 7_000_000_000
MIDDLE, LAST = 43, 86  # refreshes: 5 and 10 minutes
# The times of the last thousands of refreshes, which a proxy keeps for its medians, are 43 times
# 0.24 kB here, and caches of 64 matrices that other tests have filled take 64 times 0.5 kB anew. A
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
        loop.draw(number * STEP_NS)
        loop.show(number * STEP_NS)
    gc.collect()
    on_gpu = sum(isinstance(value, moderngl.Texture | moderngl.Buffer) for value in gc.get_objects())
    return tracemalloc.get_traced_memory()[0], on_gpu
