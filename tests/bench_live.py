"""What a refresh of `hmdwarp live` costs beside OpenGL: `make bench-live`.

With --gc: what Python's garbage collector costs it.

The whole live driver runs, on a display without a window (tests/run/offscreen.py) and small
pictures: late pose, drawing, link, newest pose, warp maps, passes, handing over, log. Every call
into OpenGL is timed and taken away; what is left is Python. On llvmpipe the drawing itself takes
the processor and its caches, so the rest is slower than it would be beside a GPU.

Three ways, in runs of their own: the wall's clock; the processor time of this thread, which leaves
out what other programs took but not that they slow the processor down; and the wall's clock with
calls that draw nothing, which is the loop's own cost. A fixed piece of work between the refreshes
tells how slow the machine was: 1.0 is its best.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from cProfile import Profile
from pstats import Stats
from statistics import median
from typing import Any

import gc_pauses
import numpy as np
from gl_clock import GlClock, nothing_drawn
from rich.console import Console
from rich.table import Table
from run.offscreen import OffscreenDisplay

from hmdwarp.display import Closed, Tick
from hmdwarp.gpu import Gpu
from hmdwarp.run import LiveOptions
from hmdwarp.run import live_run as run

LIMIT_MS = 0.5  # median, both eyes
CASES: dict[str, dict[str, Any]] = {
    "forward + interpolate, radial lens": {"warp": "forward", "fill": "interpolate", "lens": "radial"},
    "backward + none, no lens": {"warp": "backward", "fill": "none", "lens": "none"},
    "rotation + none, fused with the lens": {"warp": "rotation", "fill": "none", "lens": "radial", "fused": True},
    "mesh + pyramid, radial lens": {"warp": "mesh", "fill": "pyramid", "lens": "radial"},
}
# The last one is what is left where the pixels are made elsewhere: on one machine a software driver
# takes caches and clock rate away.
CLOCKS = (
    ("wall", time.perf_counter_ns, True),
    ("thread", time.thread_time_ns, True),
    ("wall, nothing drawn", time.perf_counter_ns, False),
)
LIMITED = tuple(CASES)[:2]  # those that the limit is for
SIZE, WARM, LATENCY_MS = (64, 80), 60, 50.0
GL_CLASSES = ("moderngl", "_moderngl")


class TimedDisplay(OffscreenDisplay):
    """Calls begin() and end() around all that happens between one wait() and the next.

    `frames` refreshes, then it closes.
    """

    def __init__(self, gpu: Gpu, frames: int, begin: Callable[[], None], end: Callable[[], None]) -> None:
        super().__init__(gpu=gpu, size=SIZE, rate_hz=90.0)
        self._left, self._begin, self._end = frames, begin, end

    def wait(self) -> Tick | None:
        self._end()
        self._left -= 1
        if self._left < 0:
            raise Closed("done")
        tick = super().wait()
        self._begin()
        return tick

    def show_status(self, status: object) -> None:
        """Nobody looks, and what one test keeps would be garbage here."""


def drive(gpu: Gpu, frames: int, begin: Callable[[], None], end: Callable[[], None], **chosen: Any) -> None:
    """A live run of that many refreshes."""
    display = TimedDisplay(gpu, frames, begin, end)
    run.open_display = lambda *_: display
    run.live(LiveOptions(latency_ms=LATENCY_MS, **chosen))


def probe_ns() -> int:
    """A fixed piece of Python and NumPy, like what is measured."""
    started = time.perf_counter_ns()
    matrix, total = np.eye(3), 0.0
    for number in range(40):
        matrix = matrix @ matrix
        total += float(matrix[number % 3, 0])
    return time.perf_counter_ns() - started


class Outside:
    """Times of all refreshes: outside GL and in all, in ms, and calls into GL."""

    def __init__(self, gl: GlClock) -> None:
        self._gl, self._started = gl, 0
        self.outside_ms: list[float] = []
        self.total_ms: list[float] = []
        self.calls: list[int] = []
        self.probes_ns: list[int] = []

    def begin(self) -> None:
        self.probes_ns.append(probe_ns())
        self._gl.reset()
        self._started = self._gl.clock()

    def end(self) -> None:
        if self._started:
            total = self._gl.clock() - self._started
            self.outside_ms.append(self._gl.outside(total) * 1e-6)
            self.total_ms.append(total * 1e-6)
            self.calls.append(self._gl.calls)

    def figures(self) -> tuple[float, float, float, float, float]:
        """(median, p95, p5 outside GL in ms, median in all, how slow the machine was), warm-up left
        out.
        """
        outside = np.array(self.outside_ms[WARM:])
        slow = median(self.probes_ns[WARM:]) / min(self.probes_ns)
        low, middle, high = np.percentile(outside, (5, 50, 95))
        return float(middle), float(high), float(low), median(self.total_ms[WARM:]), slow


def measure(gpu: Gpu, frames: int, clock: Callable[[], int], *, draws: bool = True, **chosen: Any) -> Outside:
    """Calls of OpenGL timed away by `clock`; without `draws` they draw nothing."""
    gl = GlClock(clock)
    gl.calibrate()
    times = Outside(gl)
    with gl.watching(), nullcontext() if draws else nothing_drawn():
        drive(gpu, WARM + frames, times.begin, times.end, **chosen)
    return times


def shares(gpu: Gpu, frames: int, **chosen: Any) -> list[tuple[str, float]]:
    """(part of the program, share of the time outside GL), the largest first.

    By cProfile, which makes small functions look large.

    What NumPy and attrs do counts for the module that called them.
    """
    profile, left = Profile(), [WARM]

    def begin() -> None:
        left[0] -= 1
        if left[0] < 0:
            profile.enable()

    drive(gpu, WARM + frames, begin, profile.disable, **chosen)
    own: dict[str, float] = defaultdict(float)
    stats = Stats(profile).stats
    for function, (*_, inside, _cumulative, callers) in stats.items():
        _share_out(stats, function, inside, callers, own, depth=0)
    total = sum(own.values())
    return sorted(((name, spent / total) for name, spent in own.items()), key=lambda one: -one[1])


def _share_out(stats: dict, function: tuple, inside: float, callers: dict, own: dict[str, float], depth: int) -> None:
    file, _, name = function
    if "hmdwarp/" in file:
        own[file.rpartition("hmdwarp/")[2].removesuffix(".py")] += inside
    elif "mgl." in name or any(f"/{part}" in file for part in GL_CLASSES):
        return
    elif callers and depth < 8:
        weights = {caller: numbers[2] for caller, numbers in callers.items()}
        whole = sum(weights.values()) or 1.0
        for caller, weight in weights.items():
            if caller in stats:
                _share_out(stats, caller, inside * weight / whole, stats[caller][4], own, depth + 1)


def table_of(gpu: Gpu, frames: int) -> tuple[Table, dict[bool, bool]]:
    """Every case in each way.

    Whether those that have a limit keep it, beside a driver that draws and beside one that does
    not.
    """
    table = Table(
        "case",
        "clock",
        "median ms",
        "p95",
        "p5",
        "with GL",
        "GL calls",
        "machine",
        title="A refresh outside OpenGL, both eyes",
    )
    kept = {True: True, False: True}
    for name, chosen in CASES.items():
        best: dict[bool, list[float]] = {True: [], False: []}
        for label, clock, draws in CLOCKS:
            times = measure(gpu, frames, clock, draws=draws, **chosen)
            middle, high, low, total, slow = times.figures()
            best[draws].append(middle)
            numbers = (
                f"{middle:.3f}",
                f"{high:.3f}",
                f"{low:.3f}",
                f"{total:.2f}",
                f"{median(times.calls):.0f}",
                f"x {slow:.2f}",
            )
            table.add_row(name if label == "wall" else "", label, *numbers)
        for draws, medians in best.items():
            kept[draws] &= name not in LIMITED or min(medians) <= LIMIT_MS
    return table, kept


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status 1 if the limit is not kept where nothing is drawn."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=600, help="refreshes of each run")
    parser.add_argument("--gc", action="store_true", help="what the garbage collector does to the pictures instead")
    parser.add_argument("--shares", action="store_true", help="also by module")
    asked = parser.parse_args(arguments)
    console = Console(width=140)
    with Gpu() as gpu:
        if asked.gc:
            console.print(
                gc_pauses.table_of(lambda *ends, **chosen: drive(gpu, *ends, **chosen), asked.frames, CASES[LIMITED[0]])
            )
            return 0
        table, kept = table_of(gpu, asked.frames)
        console.print(table)
        told = {draws: "kept" if fine else "NOT kept" for draws, fine in kept.items()}
        console.print(
            f"limit of {LIMIT_MS} ms for the first {len(LIMITED)}: {told[False]}; beside {gpu.renderer}: {told[True]}"
        )
        for name in LIMITED if asked.shares else ():
            parts = [f"{part} {share:.0%}" for part, share in shares(gpu, asked.frames, **CASES[name])[:14]]
            console.print(f"{name}: {', '.join(parts)}")
    return 0 if kept[False] else 1


if __name__ == "__main__":
    raise SystemExit(main())
