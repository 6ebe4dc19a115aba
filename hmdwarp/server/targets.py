"""Texture pairs to draw into: made when needed, handed back and used again, counted."""

from __future__ import annotations

import attrs
import moderngl

from ..gpu.context import Gpu
from ..gpu.textures import COLOUR, SCALAR, allocate


@attrs.frozen(eq=False)
class Target:
    """What one eye is drawn into: `colour` (rgba16f unless another kind was asked for) and `inverse_depth` r32f of the same size, None
    where colour is all that is kept.
    """

    colour: moderngl.Texture
    inverse_depth: moderngl.Texture | None

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels."""
        return self.colour.size


class TargetPool:
    """Targets of one size and kind, with or without inverse depth; `live` counts those that are out, `made` all that were ever allocated.

    Errors: InputError for a size of 0 or beyond the GL limit.
    """

    def __init__(self, gpu: Gpu, size: tuple[int, int], kind: tuple[int, str] = COLOUR, *, depth: bool = True) -> None:
        self._gl, self.size, self._kind, self._with_depth = gpu.gl, size, kind, depth
        self._free: list[Target] = []
        self._out: dict[moderngl.Texture, Target] = {}

    @property
    def live(self) -> int:
        """Targets that are out."""
        return len(self._out)

    @property
    def made(self) -> int:
        """Targets that exist, out or free: the most that were out at the same time."""
        return len(self._out) + len(self._free)

    def acquire(self) -> Target:
        """A target nobody else has; its contents are whatever was drawn last."""
        target = self._free.pop() if self._free else self._make()
        self._out[target.colour] = target
        return target

    def _make(self) -> Target:
        return Target(
            allocate(self._gl, self.size, self._kind),
            allocate(self._gl, self.size, SCALAR) if self._with_depth else None,
        )

    def lent(self, colour: moderngl.Texture) -> bool:
        """Whether a target with that colour texture is out."""
        return colour in self._out

    def release(self, colour: moderngl.Texture | Target) -> None:
        """Take a target back, named by itself or by its colour texture. Errors: ValueError if it is not out."""
        key = colour.colour if isinstance(colour, Target) else colour
        if key not in self._out:
            raise ValueError("this target is not out: it was released before, or comes from another pool")
        self._free.append(self._out.pop(key))

    def close(self) -> None:
        """Free the textures, those that are out included."""
        for target in [*self._free, *self._out.values()]:
            target.colour.release()
            if target.inverse_depth is not None:
                target.inverse_depth.release()
        self._free.clear()
        self._out.clear()


class Framebuffers:
    """Framebuffers over other people's textures, one per texture, with one depth buffer per size shared by them all."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._depth: dict[tuple[int, int], moderngl.Renderbuffer] = {}
        self._made: dict[tuple[int, ...], tuple[tuple[moderngl.Texture, ...], moderngl.Framebuffer]] = {}

    def over(self, *textures: moderngl.Texture) -> moderngl.Framebuffer:
        """The framebuffer that draws into `textures`, which must have one size; made at the first call."""
        # A GL name is used again after its texture is gone, so the entry holds the textures and is checked against them.
        key = tuple(texture.glo for texture in textures)
        held, framebuffer = self._made.get(key, ((), None))
        if framebuffer is None or any(a is not b for a, b in zip(held, textures, strict=True)):
            size = textures[0].size
            self.reserve(size)
            if framebuffer is not None:
                framebuffer.release()
            framebuffer = self._gl.framebuffer(list(textures), self._depth[size])
            self._made[key] = (textures, framebuffer)
        return framebuffer

    def reserve(self, size: tuple[int, int]) -> None:
        """Make the depth buffer for textures of that size now rather than at the first call of over()."""
        if size not in self._depth:
            self._depth[size] = self._gl.depth_renderbuffer(size)

    def close(self) -> None:
        """Free the framebuffers and depth buffers, not the textures."""
        for _, framebuffer in self._made.values():
            framebuffer.release()
        for depth in self._depth.values():
            depth.release()
        self._made.clear()
        self._depth.clear()
