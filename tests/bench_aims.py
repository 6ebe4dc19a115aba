"""How near the warps' aims of speed are: a table for docs/performance.md.

Processor time of all threads, OpenCV's on one, which a machine with other work changes less than it
does the clock on the wall. All methods take turns in one process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping

import cv2
import numpy as np
from bench_quick import Case

from hmdwarp.client.warps import warps
from hmdwarp.gpu import SCALAR, Gpu, allocate
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

SIZE = (1280, 800)
# (what, over what, at most, what it is over)
AIMS = (("backward with its depth", "forward", 1.0, "`backward` with the client's depth over `forward`"),)
PARTS = (
    ("forward", "warpFrame", "`forward` over cv2.warpFrame"),
    ("none", "forward", "copying a picture (`none`) over `forward`"),
    ("depth", "forward", "drawing the client's depth alone over `forward`"),
    ("depth, 2x2 pixels", "depth", "the same without pixels: its triangles"),
    ("backward", "forward", "`backward` without the client's depth over `forward`"),
    ("unseeded", "iterative", "`iterative` without its seed (`seed=rotation`) over `iterative`"),
    ("iterative", "warpFrame", "`iterative` over cv2.warpFrame"),
)


def methods_of(case: Case, gpu: Gpu) -> dict[str, Callable[[], object]]:
    """Return what the aims and their parts need, by name."""
    iterative = warps.get("iterative")
    unseeded = iterative(gpu, case.size, case.size, iterative.Settings(seed="rotation"))
    few = allocate(gpu.gl, (2, 2), SCALAR)
    every = case.methods()
    wanted = {name for aim in (*AIMS, *PARTS) for name in aim[:2]}
    return {name: run for name, run in every.items() if name in wanted} | {
        "unseeded": lambda: unseeded.run(case.inputs, case.canvas),
        "depth": lambda: case.server.draw_depth(case.shown, case.size, case.client_depth),
        "depth, 2x2 pixels": lambda: case.server.draw_depth(case.shown, (2, 2), few),
    }


def measured(gpu: Gpu, methods: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the median milliseconds of processor time, after one round to warm up."""
    times: dict[str, list[float]] = {name: [] for name in methods}
    for _ in range(rounds + 1):
        for name, run in methods.items():
            gpu.gl.finish()
            started = time.process_time_ns()
            run()
            gpu.gl.finish()
            times[name].append((time.process_time_ns() - started) * 1e-6)
    return {name: float(np.median(values[1:])) for name, values in times.items()}


def table(took: Mapping[str, float]) -> str:
    """Return the ratios as a Markdown table: aims first, then what they are made of."""
    lines = ["| ratio of processor times, 1280x800 | measured | aim | |", "| --- | ---: | ---: | --- |"]
    for what, other, most, told in AIMS:
        ratio = took[what] / took[other]
        lines.append(f"| {told} | {ratio:.2f} | {most:g} | {'met' if ratio <= most else 'not met'} |")
    lines += [f"| {told} | {took[what] / took[other]:.2f} | | |" for what, other, told in PARTS]
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=25)
    parser.add_argument("--time", type=float, default=3.0, help="seconds into look-around")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"))
        print(table(measured(gpu, methods_of(Case(gpu, server, SIZE, arguments.time), gpu), arguments.rounds)))
        server.close()


if __name__ == "__main__":
    main()
