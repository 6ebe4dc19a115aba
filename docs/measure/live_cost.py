"""What a refresh of `hmdwarp live` costs beside OpenGL: `make bench-live`.

The whole live driver runs, on a display without a window (tests/run/offscreen.py) and small
pictures: late pose, drawing, link, newest pose, warp maps, passes, handing over, log. Every call
into OpenGL is timed and taken away; what is left is Python. On llvmpipe the drawing itself takes
the processor and its caches, so the rest is slower than it would be beside a GPU.

Three ways, in runs of their own: the wall's clock; the processor time of this thread, which leaves
out what other programs took but not that they slow the processor down; and the wall's clock with
calls that draw nothing, which is the loop's own cost. A fixed piece of work between the refreshes
tells how slow the machine was: 1.0 is its best. With --gc: what Python's garbage collector does to
the pictures, whenever it likes and between them.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Mapping, Sequence
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
BUDGET_MS = 1e3 / 90
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


def table_of(gpu: Gpu, frames: int) -> tuple[Table, dict[bool, bool]]:
    """Return every case in each way; and by whether it draws, whether those limited keep it."""
    heads = ("case", "clock", "median ms", "p95", "p5", "with GL", "GL calls", "machine")
    table, kept = Table(*heads, title="A refresh outside OpenGL, both eyes"), {True: True, False: True}
    for name, chosen in CASES.items():
        best: dict[bool, list[float]] = {True: [], False: []}
        for label, clock, draws in CLOCKS:
            *parts, total, calls, slow = figures(gpu, frames, clock, draws=draws, **chosen)
            best[draws].append(parts[0])
            numbers = (*(f"{part:.3f}" for part in parts), f"{total:.2f}", f"{calls:.0f}", f"x {slow:.2f}")
            table.add_row(name if label == "wall" else "", label, *numbers)
        for draws, medians in best.items():
            kept[draws] &= name not in LIMITED or min(medians) <= LIMIT_MS
    return table, kept


class Pauses:
    """What each refresh took in ms, what of that was collecting, and (generation, ms) of pauses."""

    def __init__(self) -> None:
        self.refreshes_ms: list[float] = []
        self.collecting_ms: list[float] = []
        self.pauses_ms: list[tuple[int, float]] = []
        self._started_ns = self._began_ns = 0
        self._within_ms = 0.0

    def begin(self) -> None:
        """Begin a refresh."""
        self._within_ms, self._started_ns = 0.0, time.perf_counter_ns()

    def end(self) -> None:
        """End it; what is collected until the next begins is beside the picture."""
        if self._started_ns:
            self.refreshes_ms.append((time.perf_counter_ns() - self._started_ns) * 1e-6)
            self.collecting_ms.append(self._within_ms)

    def notice(self, phase: str, about: Mapping[str, int]) -> None:
        """Count a collection, as one of gc.callbacks."""
        if phase == "start":
            self._began_ns = time.perf_counter_ns()
            return
        took_ms = (time.perf_counter_ns() - self._began_ns) * 1e-6
        self._within_ms += took_ms
        if len(self.refreshes_ms) >= WARM:
            self.pauses_ms.append((about["generation"], took_ms))

    def cells(self) -> list[str]:
        """Return the cells of a row, warm-up left out."""
        took = np.array([ms for _, ms in self.pauses_ms] or [0.0])
        by_generation = " / ".join(str(sum(one == number for one, _ in self.pauses_ms)) for number in range(3))
        refreshes, collecting = (np.array(values[WARM:]) for values in (self.refreshes_ms, self.collecting_ms))
        late = int(((refreshes > BUDGET_MS) & (refreshes - collecting <= BUDGET_MS)).sum())
        numbers = (took.max(), np.percentile(took, 99), took.sum() / len(refreshes))
        numbers += (*np.percentile(refreshes, (50, 99)), refreshes.max())
        return [by_generation, *(f"{value:.3f}" for value in numbers), str(late)]


def collecting(gpu: Gpu, frames: int, chosen: dict[str, Any]) -> Table:
    """Return what collecting whenever Python likes does, and between the pictures."""
    how = f"Garbage collection in {frames} refreshes ({chosen['warp']} + {chosen['fill']})"
    title = f"{how}; late by it: over {BUDGET_MS:.1f} ms (90 Hz) with collecting, not without"
    heads = ("collecting", "pauses by generation", "longest ms", "p99", "ms a refresh")
    table = Table(*heads, "refresh median", "p99", "longest", "late by it", title=title)
    for name, between in {"whenever it likes": False, "between the pictures": True}.items():
        pauses = Pauses()
        gc.collect()
        gc.callbacks.append(pauses.notice)
        try:
            drive(gpu, WARM + frames, pauses.begin, pauses.end, collect=between, **chosen)
        finally:
            gc.callbacks.remove(pauses.notice)
        table.add_row(name, *pauses.cells())
    return table


def main(arguments: Sequence[str] | None = None) -> int:
    """Print; return 1 if the limit is not kept where nothing is drawn."""
    shown = {"frames": (600, "refreshes of each run"), "gc": (False, "what garbage collection does instead")}
    chosen = options(__doc__, arguments, **shown)
    console = Console(width=140)
    with Gpu() as gpu:
        if chosen.gc:
            console.print(collecting(gpu, chosen.frames, CASES[LIMITED[0]]))
            return 0
        table, kept = table_of(gpu, chosen.frames)
        console.print(table)
        told = {draws: "kept" if fine else "NOT kept" for draws, fine in kept.items()}
        limit = f"limit of {LIMIT_MS} ms for the first {len(LIMITED)}"
        console.print(f"{limit}: {told[False]}; beside {gpu.renderer}: {told[True]}")
    return 0 if kept[False] else 1


if __name__ == "__main__":
    raise SystemExit(main())
