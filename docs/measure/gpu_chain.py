"""GPU time of chains for both eyes while the GPU's clock is up: part of `make bench-gpu`.

A GPU that waits most of the time lowers its clock, and shows times that no busy one has. So copies
keep it at work between the refreshes. Prints JSON: one object for each size and chain.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator

import numpy as np
from apparatus import options, sizes_in

from hmdwarp.client import Compensator, PassInputs
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.pipeline import PipelineOptions, build_plan_for
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

# By name: what is asked for beside the defaults.
CHAINS = {
    "default chain": {},
    "iterative + pyramid": {"fill": "pyramid"},
    "iterative": {"fill": "none"},
    "iterative with the lens in one resample": {"fill": "none", "lens": "radial", "fused": True},
    "rotation with the lens in one resample": {"warp": "rotation", "fill": "none", "lens": "radial", "fused": True},
}
LATENCY_NS = 200_000_000
REFRESH_NS = 11_111_111
BUSY_MS = 15.0


class Busy:
    """Copies that keep the GPU's clock up."""

    def __init__(self, gpu: Gpu, data_bytes: int) -> None:
        self._gl = gpu.gl
        self._buffers = [gpu.gl.buffer(reserve=data_bytes) for _ in range(2)]

    def work(self, milliseconds: float) -> None:
        """Copy for that long, and wait for the end."""
        until = time.perf_counter() + milliseconds * 1e-3
        while time.perf_counter() < until:
            self._gl.copy_buffer(*self._buffers)
            self._gl.finish()


def measured(gpu: Gpu, name: str, size: tuple[int, int], refreshes: int, busy: Busy) -> Iterator[dict[str, object]]:
    """Yield the figures of each chain at that size of one eye."""
    scene, headset, track = load_scene(name), load_headset("rift-dk1"), load_trace("look-around").track
    server = Server(gpu, scene)
    for chain, chosen in CHAINS.items():
        wanted = PipelineOptions.of({"scene": name, "lens": "none", "size": f"{size[0]}x{size[1]}", **chosen})
        plan = build_plan_for(wanted, headset, scene)
        frames: list = []
        times: dict[str, list[float]] = {}
        made = None
        for number in range(-1, refreshes):
            now_ns = track.start_ns + 2_000_000_000 + number * 9 * REFRESH_NS
            late = headset.views(track.at(now_ns - LATENCY_NS).pose)
            shown = headset.views(track.at(now_ns).pose)
            frame = server.draw_frame(late, now_ns - LATENCY_NS, size, wanted.guard_band, plan.needs, size)
            if made is None:
                made = Compensator(gpu, plan, headset, frame.eyes[0].size, size)
            frames.append(frame)
            busy.work(BUSY_MS)
            gpu.timer.collect()
            for eye in range(2):
                inputs = PassInputs(frame.eyes[eye], shown[eye], eye, (frame.eyes[1 - eye],), shown_ns=now_ns)
                made.run(inputs)
            stages = gpu.timer.collect()
            if number >= 0:
                for stage in {stage for stage, _ in stages}:
                    times.setdefault(stage, []).append(sum(ms for one, ms in stages if one == stage))
                times.setdefault("total", []).append(sum(ms for _, ms in stages))
            if len(frames) > 2:
                server.recycle(frames.pop(0))
        assert made is not None
        made.close()
        for frame in frames:
            server.recycle(frame)
        yield {
            "chain": chain,
            "size": list(size),
            "time_ms": {
                stage: {"median": float(np.median(each)), "p95": float(np.percentile(each, 95))}
                for stage, each in times.items()
            },
        }


def main() -> None:
    """Print the figures."""
    asked = options(
        __doc__,
        scene=("room", "what is drawn"),
        sizes=("1280x800", "pixels of one eye, with commas"),
        refreshes=(40, "of each chain"),
        busy=(256 << 20, "bytes of each buffer that is copied in between"),
    )
    with Gpu() as gpu:
        busy = Busy(gpu, asked.busy)
        rows = [
            row for size in sizes_in(asked.sizes) for row in measured(gpu, asked.scene, size, asked.refreshes, busy)
        ]
        json.dump(rows, sys.stdout)


if __name__ == "__main__":
    main()
