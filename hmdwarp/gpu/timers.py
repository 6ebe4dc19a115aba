"""Stage times: by GPU timer queries where they work, else by wall clock after finish()."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import attrs
import moderngl

from .shaders import Compute
from .textures import release_all


def is_software(gl: moderngl.Context) -> bool:
    """Return whether the context renders on the CPU."""
    return any(name in gl.info["GL_RENDERER"].lower() for name in ("llvmpipe", "softpipe", "swiftshader"))


# Of the wall-clock time that a real timer reports at least: launching may be nearly all of it. A
# copy by a CPU takes milliseconds, and a timer that misses it still counts what surrounds it.
_LEAST_SHARE, _LEAST_SHARE_ON_A_CPU = 1e-3, 0.1
_BYTES, _WIDTH = 4 << 20, 512


@attrs.frozen
class ClockCheck:
    """One known pass timed by both clocks."""

    clock: str  # the one that stages are timed by: "gpu" where the two agree, else "wall"
    wall_ms: float
    gpu_ms: float | None  # None where timer queries measure nothing
    note: str  # which clock is used and how far apart the two are, in a sentence


def check_clocks(gl: moderngl.Context) -> ClockCheck:
    """Time a copy by a compute shader by GPU query and by wall clock after finish, in the same run.

    llvmpipe answers about 1 ns for any work; Zink, which runs on the same llvmpipe, measures it.
    """
    copy, blocks, query = Compute(gl, "gpu/copy.comp", {}), _BYTES // 16, gl.query(time=True)
    buffers = [gl.buffer(reserve=_BYTES) for _ in range(2)]
    for binding, buffer in enumerate(buffers):
        buffer.bind_to_storage_buffer(binding)
    copy.uniforms.set(count=blocks, width=_WIDTH)
    copy.run(_WIDTH, blocks // _WIDTH)  # keeps one-time work of the driver out of the comparison
    gl.finish()
    started_ns = time.perf_counter_ns()
    with query:
        copy.run(_WIDTH, blocks // _WIDTH)
    gl.finish()
    wall_ms, gpu_ms = (time.perf_counter_ns() - started_ns) * 1e-6, query.elapsed * 1e-6
    release_all(copy.program, *buffers)
    if not wall_ms * (_LEAST_SHARE_ON_A_CPU if is_software(gl) else _LEAST_SHARE) < gpu_ms <= wall_ms * 1.5:
        told = f"({gpu_ms:.3g} ms for a pass of {wall_ms:.2f} ms)"
        return ClockCheck("wall", wall_ms, None, f"wall clock: this driver's GPU timers are unusable {told}")
    apart = f"({(wall_ms - gpu_ms) / gpu_ms:+.1%}: launching and waiting)"
    note = f"GPU timers; a pass of {gpu_ms:.3f} ms takes {wall_ms:.3f} ms by wall clock {apart}"
    return ClockCheck("gpu", wall_ms, gpu_ms, note)


Stages = tuple[tuple[str, float], ...]  # (name, milliseconds) of each stage, in order


@attrs.define(eq=False)
class Lap:
    """Some stages of a frame. Read their times later, when the GPU has long finished them."""

    _free: list[moderngl.Query]  # to be used again
    _pending: list[tuple[str, moderngl.Query]] = attrs.field(factory=list)
    _done: list[tuple[str, float]] = attrs.field(factory=list)

    def read(self) -> Stages:
        """Return the times of all stages; waits for the GPU. May be called again."""
        for name, query in self._pending:
            self._done.append((name, query.elapsed * 1e-6))
            self._free.append(query)
        self._pending = []
        return tuple(self._done)


class Laps(Lap):
    """Several laps, read as one."""

    def __init__(self, *laps: Lap) -> None:
        super().__init__([])
        self._laps = laps

    def read(self) -> Stages:
        return tuple(stage for lap in self._laps for stage in lap.read())


class StageTimer:
    """Times of the stages of one frame: only Lap.read() reads queries, so no stage waits."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self.check = check_clocks(gl)
        self.clock = self.check.clock
        self._now, self._lap_started_ns = Lap([]), time.perf_counter_ns()

    @property
    def lap_ms(self) -> float:
        """Wall-clock milliseconds since the last lap, in stages and between them."""
        return (time.perf_counter_ns() - self._lap_started_ns) * 1e-6

    @contextmanager
    def aside(self, name: str) -> Iterator[None]:
        """Time all that runs inside as one stage of this lap, whatever laps it makes of its own."""
        lap_started_ns, lap, started_ns = self._lap_started_ns, self.lap(), time.perf_counter_ns()
        try:
            yield
        finally:
            self._now, self._lap_started_ns = lap, lap_started_ns
            lap._done.append((name, (time.perf_counter_ns() - started_ns) * 1e-6))

    def stage(self, name: str, *, barrier: bool = False) -> Stage:
        """Time the GL calls inside `with timer.stage(name):`; blocks that raise do not count.

        It can be entered again. barrier: make what is stored inside visible to all that follows.
        """
        return Stage(self, name, barrier, by_query=self.clock == "gpu")

    def cpu_stage(self, name: str) -> Stage:
        """Time work of the CPU inside `with timer.cpu_stage(name):`, in milliseconds."""
        return Stage(self, name, barrier=False, by_query=False)

    def lap(self) -> Lap:
        """Return every stage since the last lap; one that is never read costs its queries."""
        lap, self._now, self._lap_started_ns = self._now, Lap(self._now._free), time.perf_counter_ns()
        return lap

    def collect(self) -> list[tuple[str, float]]:
        """Return (stage, ms) of every stage since the last lap; waits for the GPU."""
        return list(self.lap().read())


class Stage:
    """A stage timed by a query, or by the wall clock between two instants of an idle GPU."""

    # A class, because contextlib's generators cost 3 us each and a refresh has ten.

    __slots__ = ("_barrier", "_by_query", "_name", "_query", "_started_ns", "_timer")

    def __init__(self, timer: StageTimer, name: str, barrier: bool, by_query: bool) -> None:
        self._timer, self._name, self._barrier, self._by_query = timer, name, barrier, by_query

    def __enter__(self) -> None:
        gl, free = self._timer._gl, self._timer._now._free
        if self._by_query:
            self._query = free.pop() if free else gl.query(time=True)
            self._query.__enter__()
        else:
            gl.finish()
            self._started_ns = time.perf_counter_ns()

    def __exit__(self, error: type[BaseException] | None, *rest: object) -> None:
        gl, lap = self._timer._gl, self._timer._now
        if self._barrier and error is None:
            gl.memory_barrier(moderngl.ALL_BARRIER_BITS)
        if self._by_query:
            self._query.__exit__(error, *rest)  # type: ignore[arg-type]  # moderngl types each argument as a tuple
            if error is None:
                lap._pending.append((self._name, self._query))
            else:
                lap._free.append(self._query)
        elif error is None:
            gl.finish()
            lap._done.append((self._name, (time.perf_counter_ns() - self._started_ns) * 1e-6))
