"""A live run that has warmed up makes nothing new.

No textures, no shaders, no queries, and no objects that stay.
"""

from __future__ import annotations

import gc
import sys
from collections import Counter

import pytest
from made import counting_made

from hmdwarp.display.controls import KEPT
from hmdwarp.run import LiveOptions

from .offscreen import OffscreenDisplay, run_on

# Ten refreshes until the first frame has arrived, then a round of every pool, every older frame
# that is kept (up to half a second), and the counts that come a refresh late.
WARM, THEN = 60, 60
# Not one of anything may be made, so fewer refreshes tell it too; at 25 Hz 13 are half a second.
WARM_ON_GPU, THEN_ON_GPU = 20, 20
# One with several samples a pixel, which take llvmpipe most of the time.
RUNS = {
    **{
        f"{warp} + {fill}": {"scene": "planes", "warp": warp, "fill": fill}
        for warp, fill in (("backward", "interpolate"), ("mesh", "memory"))
    },
    "multi + wide": {"scene": "planes", "warp": "multi", "fill": "wide", "samples": 4},
    "all effects": {"scene": "gallery", "warp": "forward", "fill": "interpolate"},
    "things that move": {"scene": "parade", "warp": "forward", "fill": "pyramid"},
    "mirrors": {"scene": "greenhouse", "warp": "forward", "fill": "none"},
}


@pytest.mark.parametrize("chosen", RUNS.values(), ids=RUNS)
def test_a_refresh_makes_nothing_on_the_gpu(gpu, monkeypatch, chosen):
    display = OffscreenDisplay(gpu=gpu, size=(64, 80), rate_hz=25.0)
    seen: dict[int, tuple[Counter[str], int]] = {}
    with counting_made() as made:
        usual = {"headset": "rift-dk1", "samples": 1, "latency_ms": 100, "pictures": WARM_ON_GPU + THEN_ON_GPU}
        count = lambda number: seen.update({number: (Counter(made), len(gpu.gl.objects))})  # noqa: E731
        run_on(monkeypatch, display, LiveOptions(**{**usual, **chosen}), after=count)
    (before, kept), (after, kept_after) = seen[WARM_ON_GPU], seen[WARM_ON_GPU + THEN_ON_GPU]
    assert after - before == Counter()
    assert kept_after == kept, "moderngl keeps what died until the context is closed"
    assert before["texture"], "or nothing was counted"


@pytest.mark.parametrize("beside", ["nothing", "files"])
def test_a_refresh_leaves_no_objects_behind(gpu, monkeypatch, tmp_path, beside):
    """Containers are counted before anything is collected.

    Garbage that only a full collection finds would stay for the whole run.

    All objects are counted after one, which empties the interpreter's own stocks (up to 2000 tuples
    of each length).
    """
    written = {"record": tmp_path / "walk.csv", "out": tmp_path / "out"} if beside == "files" else {}
    # The plots keep so many refreshes: what comes after them must go as it came.
    begin, end = KEPT + WARM, KEPT + WARM + 2 * THEN
    containers: dict[int, int] = {}
    blocks: dict[int, int] = {}

    def after(number: int) -> None:
        if number in (begin, end):
            containers[number] = len(gc.get_objects())
            gc.collect()
            blocks[number] = sys.getallocatedblocks()

    options = LiveOptions(scene="planes", headset="rift-dk1", latency_ms=50, size=(16, 20), pictures=end, **written)
    run_on(monkeypatch, OffscreenDisplay(gpu=gpu), options, after=after)
    # Numbers at one instant differ by what is just under way, a pose more or less; one object that
    # stays each time would be 2 * THEN.
    assert containers[end] - containers[begin] < THEN
    if beside == "nothing":  # lines wait for up to half a second until they are written
        assert blocks[end] - blocks[begin] < THEN
