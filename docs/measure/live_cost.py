"""What a refresh of `hmdwarp live` costs beside OpenGL: `make bench-live`.

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

import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from statistics import median
from typing import Any

import numpy as np
from apparatus import options
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
LIMITED = tuple(CASES)[:2]  # those that the limit is for
# The last one is what is left where the pixels are made elsewhere: on one machine a software driver
# takes caches and clock rate away.
CLOCKS = (
    ("wall", time.perf_counter_ns, True),
    ("thread", time.thread_time_ns, True),
    ("wall, nothing drawn", time.perf_counter_ns, False),
)
SIZE, LATENCY_MS = (64, 80), 50.0
WARM = 60  # refreshes before those that count, and never more than those


class TimedDisplay(OffscreenDisplay):
    """Calls begin() and end() around what happens between two waits, and closes after `frames`."""

    def __init__(self, gpu: Gpu, frames: int, begin: Callable[[], None], end: Callable[[], None]) -> None:
        super().__init__(gpu=gpu, size=SIZE)
        self._left, self._begin, self._end = frames, begin, end

    def wait(self) -> Tick | None:
        """Return the next refresh. Raises: Closed."""
        self._end()
        self._left -= 1
        if self._left < 0:
            raise Closed("done")
        tick = super().wait()
        self._begin()
        return tick

    def show_status(self, status: object) -> None:
        """Keep nothing: what a test would look at is garbage here."""


def drive(gpu: Gpu, frames: int, begin: Callable[[], None], end: Callable[[], None], **chosen: Any) -> None:
    """Run live for that many refreshes."""
    display = TimedDisplay(gpu, frames, begin, end)
    run.open_display = lambda *_: display
    run.live(LiveOptions(headset="rift-dk1", latency_ms=LATENCY_MS, **chosen))


def probe_ns() -> int:
    """Return what a fixed piece of Python and NumPy takes, like what is measured."""
    started = time.perf_counter_ns()
    matrix, total = np.eye(3), 0.0
    for number in range(40):
        matrix = matrix @ matrix
        total += float(matrix[number % 3, 0])
    return time.perf_counter_ns() - started


def figures(gpu: Gpu, frames: int, clock: Callable[[], int], *, draws: bool, **chosen: Any) -> tuple[float, ...]:
    """Return median, p95 and p5 of a refresh outside GL in ms, median in all, calls, slowness."""
    gl, rows, probes, started = GlClock(clock), list[tuple[float, float, int]](), list[int](), list[int]()
    gl.calibrate()
    warm = min(WARM, frames)

    def begin() -> None:
        probes.append(probe_ns())
        gl.reset()
        started.append(clock())

    def end() -> None:
        if started:
            total = clock() - started[-1]
            rows.append((gl.outside(total) * 1e-6, total * 1e-6, gl.calls))

    with gl.watching(), nullcontext() if draws else nothing_drawn():
        drive(gpu, warm + frames, begin, end, **chosen)
    outside, total, _ = np.array(rows[warm:]).T
    low, middle, high = np.percentile(outside, (5, 50, 95))
    slow = median(probes[warm:]) / min(probes)
    return middle, high, low, median(total), median(calls for *_, calls in rows), slow


def table_of(gpu: Gpu, frames: int, scene: str) -> tuple[Table, dict[bool, bool]]:
    """Return every case in each way; and by whether it draws, whether those limited keep it."""
    heads = ("case", "clock", "median ms", "p95", "p5", "with GL", "GL calls", "machine")
    table, kept = Table(*heads, title="A refresh outside OpenGL, both eyes"), {True: True, False: True}
    for name, chosen in CASES.items():
        best: dict[bool, list[float]] = {True: [], False: []}
        for label, clock, draws in CLOCKS:
            *parts, total, calls, slow = figures(gpu, frames, clock, draws=draws, scene=scene, **chosen)
            best[draws].append(parts[0])
            numbers = (*(f"{part:.3f}" for part in parts), f"{total:.2f}", f"{calls:.0f}", f"x {slow:.2f}")
            table.add_row(name if label == "wall" else "", label, *numbers)
        for draws, medians in best.items():
            kept[draws] &= name not in LIMITED or min(medians) <= LIMIT_MS
    return table, kept


def main(arguments: Sequence[str] | None = None) -> int:
    """Print; return 1 if the limit is not kept where nothing is drawn."""
    chosen = options(__doc__, arguments, frames=(600, "refreshes of each run"), scene=("room", "what is drawn"))
    console = Console(width=140)
    with Gpu() as gpu:
        table, kept = table_of(gpu, chosen.frames, chosen.scene)
        console.print(table)
        told = {draws: "kept" if fine else "NOT kept" for draws, fine in kept.items()}
        limit = f"limit of {LIMIT_MS} ms for the first {len(LIMITED)}"
        console.print(f"{limit}: {told[False]}; beside {gpu.renderer}: {told[True]}")
    return 0 if kept[False] else 1


if __name__ == "__main__":
    raise SystemExit(main())
