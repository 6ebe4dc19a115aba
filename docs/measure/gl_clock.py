"""How long a frame spends inside OpenGL: moderngl's own methods, watched."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from statistics import median
from typing import Any

import _moderngl
import moderngl

# Every method and property of moderngl that reaches the driver, of the classes that are used here.
# What only looks at Python is left out.
CALLS: dict[type, tuple[str, ...]] = {
    moderngl.Buffer: (
        "write",
        "read",
        "read_into",
        "clear",
        "bind_to_uniform_block",
        "bind_to_storage_buffer",
        "orphan",
        "release",
    ),
    moderngl.ComputeShader: ("run", "run_indirect", "release"),
    moderngl.Framebuffer: (
        "clear",
        "use",
        "read",
        "read_into",
        "release",
        "viewport",
        "scissor",
        "color_mask",
        "depth_mask",
    ),
    moderngl.Program: ("release",),
    moderngl.Query: ("__enter__", "__exit__", "elapsed", "samples"),
    moderngl.Renderbuffer: ("release",),
    moderngl.Sampler: ("use", "clear", "release"),
    moderngl.Scope: ("__enter__", "__exit__", "release"),
    moderngl.Texture: (
        "read", "read_into", "write", "build_mipmaps", "use", "bind_to_image", "release", "filter", "repeat_x",
        "repeat_y",
    ),
    moderngl.VertexArray: ("render", "render_indirect", "transform", "release"),
    moderngl.Context: (
        *(
            "clear",
            "enable",
            "disable",
            "enable_only",
            "enable_direct",
            "disable_direct",
            "finish",
            "copy_buffer",
            "copy_framebuffer",
        ),
        *(
            "depth_func",
            "blend_func",
            "blend_equation",
            "viewport",
            "cull_face",
            "front_face",
            "memory_barrier",
            "clear_samplers",
        ),
        *("detect_framebuffer", "error", "__enter__", "__exit__"),
    ),
    _moderngl.Uniform: ("write", "read"),
}  # fmt: skip


class GlClock:
    """`inside`: ns by `clock` in GL calls since reset(), of which there were `calls`.

    Each watched call costs `beside_ns` that is not inside, and `within_ns` that is: what an empty
    one costs.
    """

    def __init__(self, clock: Callable[[], int] = time.perf_counter_ns) -> None:
        self.clock, self.within_ns, self.beside_ns = clock, 0.0, 0.0
        self.reset()

    def reset(self) -> None:
        """Count from here."""
        self.inside, self.calls, self.busy = 0, 0, False

    def watched(self, call: Callable[..., Any]) -> Callable[..., Any]:
        """Return the same call, its time added to `inside`.

        One that is made within another belongs to that.
        """
        clock = self.clock

        def timed(*given: Any, **named: Any) -> Any:
            if self.busy:
                return call(*given, **named)
            self.busy = True
            started = clock()
            try:
                return call(*given, **named)
            finally:
                self.inside += clock() - started
                self.calls += 1
                self.busy = False

        return timed

    def outside(self, total_ns: int) -> float:
        """Return what of `total_ns` since reset() was outside GL, less what watching costs."""
        return total_ns - self.inside - self.calls * self.beside_ns

    def calibrate(self, calls: int = 20_000, rounds: int = 7) -> None:
        """Measure what watching an empty call of three arguments costs."""
        empty = self.watched(lambda a, b, c: None)
        bare = lambda a, b, c: None  # noqa: E731
        within, beside = [], []
        for _ in range(rounds):
            plain = _timed(self.clock, bare, calls)
            self.reset()
            total = _timed(self.clock, empty, calls)
            within.append(self.inside / calls)
            beside.append((total - plain - self.inside) / calls)
        self.within_ns, self.beside_ns = median(within), median(beside)
        self.reset()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Every GL call of this process goes through `watched` inside the block."""
        with _replaced(
            {(kind, name): self._watched_member(getattr(kind, name)) for kind, names in CALLS.items() for name in names}
        ):
            yield

    def _watched_member(self, member: Any) -> Any:
        if not isinstance(member, property):
            return self.watched(member)
        return property(self.watched(member.fget), self.watched(member.fset) if member.fset else None)


# What sets a driver to work; everything else only tells it what it will need then.
DRAWS = {
    moderngl.ComputeShader: ("run", "run_indirect"),
    moderngl.VertexArray: ("render", "render_indirect"),
    moderngl.Framebuffer: ("clear",),
    moderngl.Context: ("memory_barrier", "finish", "copy_framebuffer"),
}


@contextmanager
def nothing_drawn() -> Iterator[None]:
    """Let calls that set the driver to work return at once inside the block.

    Python has the processor for itself, as beside a GPU.
    """
    with _replaced({(kind, name): lambda *_, **__: None for kind, names in DRAWS.items() for name in names}):
        yield


def _timed(clock: Callable[[], int], call: Callable[..., Any], calls: int) -> int:
    started = clock()
    for _ in range(calls):
        call(1, 2, 3)
    return clock() - started


@contextmanager
def _replaced(members: dict[tuple[type, str], Any]) -> Iterator[None]:
    before = {(kind, name): kind.__dict__[name] for kind, name in members}
    try:
        for (kind, name), member in members.items():
            setattr(kind, name, member)
        yield
    finally:
        for (kind, name), member in before.items():
            setattr(kind, name, member)
