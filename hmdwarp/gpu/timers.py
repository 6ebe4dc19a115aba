"""How long a stage took: GPU timer queries where they are real, else wall clock after finish()."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import moderngl

from .context import is_software


def has_real_gpu_timer(gl: moderngl.Context) -> bool:
    """Whether GL_TIME_ELAPSED measures anything: llvmpipe answers about 1 ns for any work, or leaves compute out."""
    if is_software(gl):
        return False
    texture = gl.texture((512, 512), 4, dtype="f4")
    framebuffer = gl.framebuffer([texture])
    framebuffer.clear()  # what a driver does once, at first use, is no part of the comparison
    gl.finish()
    query = gl.query(time=True)
    started = time.perf_counter_ns()
    with query:
        for _ in range(4):
            framebuffer.clear(0.5, 0.5, 0.5, 0.5)
    gl.finish()
    wall_ns = time.perf_counter_ns() - started
    elapsed_ns = query.elapsed
    framebuffer.release()
    texture.release()
    # A real timer sees at least a thousandth of what the wall clock saw, and no more than it saw.
    return wall_ns * 1e-3 < elapsed_ns <= wall_ns * 1.5


Stages = tuple[tuple[str, float], ...]  # (name, milliseconds) of each stage, in order


class Lap:
    """Some stages of a frame. Their times may be asked for later, when the GPU has long finished them."""

    def __init__(self, pending: list[tuple[str, moderngl.Query]], done: list[tuple[str, float]], free: list[moderngl.Query]) -> None:
        self._pending, self._done, self._free = pending, done, free

    def read(self) -> Stages:
        """Times of all stages; waits for the GPU if it has not finished. May be called again."""
        for name, query in self._pending:
            self._done.append((name, query.elapsed * 1e-6))
            self._free.append(query)
        self._pending = []
        return tuple(self._done)


class StageTimer:
    """Times the stages of one frame; `clock` says "gpu" or "wall".

    GPU queries are read by Lap.read() alone, so that a stage never waits for the one before it.
    """

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self.clock = "gpu" if has_real_gpu_timer(gl) else "wall"
        self._free: list[moderngl.Query] = []
        self._pending: list[tuple[str, moderngl.Query]] = []
        self._done: list[tuple[str, float]] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what is issued inside under `name`, in milliseconds."""
        if self.clock == "gpu":
            query = self._free.pop() if self._free else self._gl.query(time=True)
            with query:
                yield
            self._pending.append((name, query))
            return
        self._gl.finish()
        started = time.perf_counter_ns()
        yield
        self._gl.finish()
        self._done.append((name, (time.perf_counter_ns() - started) * 1e-6))

    def lap(self) -> Lap:
        """Every stage since the last lap, in order. One that is never read costs its queries."""
        lap = Lap(self._pending, self._done, self._free)
        self._pending, self._done = [], []
        return lap

    def collect(self) -> list[tuple[str, float]]:
        """(stage, ms) of every stage since the last lap, in order; waits for the GPU if it has not finished."""
        return list(self.lap().read())


def both_clocks(gl: moderngl.Context, run: Callable[[], object]) -> tuple[float, float]:
    """(wall_ms, gpu_ms) of one run: by the wall clock until the GPU has finished, and by a timer query, real or not."""
    query = gl.query(time=True)
    gl.finish()
    started = time.perf_counter_ns()
    with query:
        run()
    gl.finish()
    wall_ms = (time.perf_counter_ns() - started) * 1e-6
    return wall_ms, query.elapsed * 1e-6
