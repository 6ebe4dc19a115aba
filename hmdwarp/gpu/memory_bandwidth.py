"""Memory bandwidth of this device, and a check of its clocks.

The bandwidth gives the lower bound of every pass's time.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import attrs
import moderngl

from .context import Gpu
from .timers import both_clocks

_MIB = 1 << 20
LEAST_BYTES = 64 * _MIB  # of one buffer; two are in use
GPU_BYTES = 256 * _MIB  # the largest cache of a GPU is 50 to 96 MB
MOST_BYTES = 512 * _MIB
TIMES_THE_CACHE = 4  # so that at most a quarter of a copy can come from it
ROUNDS = 5
_BLOCK = 16  # bytes of a uvec4
_WIDTH = 8192  # blocks in a row of the dispatch


@attrs.frozen
class Bandwidth:
    """The fastest copy."""

    bytes_per_s: float  # read plus written
    copied: str  # the faster way, "shader" or "driver"
    buffer_bytes: int  # of each buffer


@attrs.frozen
class ClockCheck:
    """One known pass timed by both clocks."""

    clock: str  # the one the stage timer uses
    wall_ms: float
    gpu_ms: float | None  # None where timer queries measure nothing
    note: str  # which clock is used and how far apart the two are, in a sentence


class Copier:
    """Two buffers much larger than the caches, and two ways to copy one to the other.

    Use as a context manager.
    size_bytes: of each buffer; None chooses what suits this device, capped by its limits.
    """

    def __init__(self, gpu: Gpu, size_bytes: int | None = None) -> None:
        self._gpu = gpu
        wanted = suitable_bytes(gpu) if size_bytes is None else size_bytes
        self.size_bytes = min(wanted, gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]) // _BLOCK * _BLOCK
        self._program = gpu.shaders.compute("gpu/copy.comp")
        self._buffers = [gpu.gl.buffer(reserve=self.size_bytes) for _ in range(2)]

    @property
    def ways(self) -> dict[str, Callable[[], None]]:
        """Functions that copy the whole buffer once, by name."""
        return {"shader": self._by_shader, "driver": self._by_driver}

    def _by_shader(self) -> None:
        for binding, buffer in enumerate(self._buffers):
            buffer.bind_to_storage_buffer(binding)
        count = self.size_bytes // _BLOCK
        self._program.uniforms.set(count=count, width=_WIDTH)
        self._program.run(_WIDTH, -(-count // _WIDTH))
        self._gpu.gl.memory_barrier(moderngl.ALL_BARRIER_BITS)

    def _by_driver(self) -> None:
        self._gpu.gl.copy_buffer(self._buffers[1], self._buffers[0])

    def __enter__(self) -> Copier:
        return self

    def __exit__(self, *_: object) -> None:
        for buffer in self._buffers:
            buffer.release()


def copy_bandwidth(gpu: Gpu, *, rounds: int = ROUNDS, size_bytes: int | None = None) -> Bandwidth:
    """Return the best of `rounds` copies in each way, after a warm-up, by the stage timer's clock.

    The best, because other load can only make a copy slower.
    """
    with Copier(gpu, size_bytes) as copier:
        least = dict.fromkeys(copier.ways, float("inf"))
        for number in range(rounds + 1):
            for name, copy in copier.ways.items():
                wall_ms, gpu_ms = both_clocks(gpu.gl, copy)
                if number:
                    least[name] = min(least[name], gpu_ms if gpu.timer.clock == "gpu" else wall_ms)
        best = min(least, key=least.__getitem__)
        return Bandwidth(2 * copier.size_bytes / (least[best] * 1e-3), best, copier.size_bytes)


def check_clocks(gpu: Gpu, *, rounds: int = ROUNDS, size_bytes: int | None = None) -> ClockCheck:
    """Time the copying shader by GPU query and by wall clock after finish, in the same runs.

    Best of each.
    """
    with Copier(gpu, size_bytes) as copier:
        copy = copier.ways["shader"]
        copy()
        times = [both_clocks(gpu.gl, copy) for _ in range(rounds)]
    wall_ms, gpu_ms = (min(column) for column in zip(*times, strict=True))
    if gpu.timer.clock == "wall":
        told = f"{gpu.renderer} answers {gpu_ms:.3g} ms to timer queries: they measure nothing here"
        return ClockCheck("wall", wall_ms, None, f"wall clock after finish; a pass of {wall_ms:.2f} ms, {told}")
    apart = (wall_ms - gpu_ms) / gpu_ms
    note = (
        f"GPU timer queries; a pass of {gpu_ms:.3f} ms takes {wall_ms:.3f} ms by the wall clock, "
        f"{apart:+.1%} (its launch and the wait)"
    )
    return ClockCheck("gpu", wall_ms, gpu_ms, note)


def suitable_bytes(gpu: Gpu) -> int:
    """Return a buffer size large enough to measure the memory, not the caches."""
    if not gpu.is_software:
        return GPU_BYTES
    return min(MOST_BYTES, max(LEAST_BYTES, TIMES_THE_CACHE * last_cache_bytes()))


def last_cache_bytes(root: Path = Path("/sys/devices/system/cpu/cpu0/cache")) -> int:
    """Return the size of the processor's largest cache.

    0 where the system does not say (Linux does).
    """
    sizes = [0]
    for file in root.glob("index*/size"):
        try:
            match = re.fullmatch(r"(\d+)([KMG]?)", file.read_text(encoding="ascii").strip())
        except (OSError, UnicodeDecodeError):
            continue
        if match:
            sizes.append(int(match.group(1)) << {"": 0, "K": 10, "M": 20, "G": 30}[match.group(2)])
    return max(sizes)
