"""Present finished pictures in the colour and depth formats of a window or runtime."""

from __future__ import annotations

from itertools import product
from typing import Any

import moderngl

from ..geometry import View
from ..gpu.context import Gpu
from ..gpu.shaders import Draw
from ..gpu.textures import Canvas
from ._base import Label
from .notice import Notice, Notices

FRAMEBUFFER_SRGB = 0x8DB9
Viewport = tuple[int, int, int, int]  # x, y, width, height in pixels, origin bottom left


class Presenter:
    """Draw finished pictures into framebuffers, one presenter for each Gpu.

    Leaves all GL flags off, as passes expect.
    """

    def __init__(self, gpu: Gpu) -> None:
        gl = self._gl = gpu.gl
        self._notices = Notices(gl)
        self._shaders = gpu.shaders
        self._nothing = Canvas(gl, (1, 1))
        self._nothing.clear()
        self._pictures: dict[tuple[bool, bool, bool], _Whole] = {}
        self._depth = _Whole(gl, gpu.shaders.draw("display/whole.vert", "display/depth.frag"))

    def prepare(self, *, hardware_srgb: bool) -> None:
        """Compile what show() uses; otherwise its first call does."""
        for scaled, noticed in product((False, True), repeat=2):
            defines = {"ENCODES": int(not hardware_srgb), "SCALED": int(scaled), "NOTICED": int(noticed)}
            draw = self._shaders.draw("display/whole.vert", "display/picture.frag", **defines)
            self._pictures[hardware_srgb, scaled, noticed] = _Whole(self._gl, draw)

    def notice(self, label: Label) -> Notice | None:
        """Return the notice that show() can lay over the picture; None for "". Cached."""
        return self._notices.of(label)

    def show(
        self,
        panel: Canvas | None,
        into: moderngl.Framebuffer,
        viewport: Viewport,
        *,
        hardware_srgb: bool,
        notice: Notice | None = None,
        eye: View | None = None,
    ) -> None:
        """Draw the picture, black for None, scaled bilinearly into the viewport of `into`.

        Alpha is 1 there.

        hardware_srgb: whether `into` is sRGB and encodes by itself; else it gets the bytes of a
        window. Holes are black, light beyond 0..1 is clipped, NaN is black. notice: over it, as
        `eye` sees head-locked content; eye None: at the bottom of the viewport.
        """
        picture, size = panel or self._nothing, (viewport[2], viewport[3])
        key = (hardware_srgb, picture.size != size, notice is not None)
        if key not in self._pictures:
            self.prepare(hardware_srgb=hardware_srgb)
        whole = self._pictures[key]
        picture.texture.use(0)
        whole.uniforms.set(picture=0, picture_size=picture.size, place=tuple(viewport))
        if notice is not None:
            notice.ink.use(1)
            whole.uniforms.set(ink=1, uv_from_pixel=notice.uv_from_pixel(size, eye))
        # Off for a window too, which may be sRGB without a request for it.
        (self._gl.enable_direct if hardware_srgb else self._gl.disable_direct)(FRAMEBUFFER_SRGB)
        self._draw(whole, into, viewport, moderngl.NOTHING)
        self._gl.disable_direct(FRAMEBUFFER_SRGB)

    def depth(self, inverse_depth: moderngl.Texture, into: moderngl.Framebuffer, near_m: float) -> None:
        """Write near_m * inverse_depth, clipped to 0..1, into all of the depth of `into`.

        inverse_depth: r32f, 1/m; -1 (unknown) gives 0. near_m: where depth is 1; 0 is infinitely
        far. A picture of another size is sampled pixel by pixel: depths must not be mixed. Colours
        stay.
        """
        w, h = into.size
        inverse_depth.use(0)
        ratio = (inverse_depth.width / w, inverse_depth.height / h)
        self._depth.uniforms.set(inverse_depth=0, texel_from_pixel=ratio, near_m=near_m)
        colours, self._gl.depth_func = into.color_mask, "1"
        into.color_mask = _nothing_like(colours)
        self._draw(self._depth, into, (0, 0, w, h), moderngl.DEPTH_TEST)
        into.color_mask, self._gl.depth_func = colours, "<"

    def _draw(self, whole: _Whole, into: moderngl.Framebuffer, viewport: Viewport, flags: int) -> None:
        """Draw without moderngl.Scope.

        A Scope keeps its framebuffer until the context goes, and a runtime's framebuffers come and
        go.
        """
        before, into.viewport = into.viewport, viewport
        into.use()
        self._gl.enable_only(flags)
        whole.array.render(moderngl.TRIANGLES, vertices=3)
        self._gl.enable_only(moderngl.NOTHING)
        into.viewport = before

    def close(self) -> None:
        """Free its own objects; the programs belong to the shader library."""
        self._notices.close()
        self._nothing.release()
        for whole in (*self._pictures.values(), self._depth):
            whole.array.release()
        self._pictures.clear()


class _Whole:
    """A program that draws the whole viewport."""

    def __init__(self, gl: moderngl.Context, draw: Draw) -> None:
        self.uniforms, self.array = draw.uniforms, gl.vertex_array(draw.program, [])


def fitted(picture: tuple[int, int], place: Viewport) -> Viewport:
    """Return the largest part of `place`, centred, with the shape of a (w, h) picture.

    The rest is for bars.
    """
    x, y, w, h = place
    scale = min(w / picture[0], h / picture[1])
    inside = (max(round(scale * picture[0]), 1), max(round(scale * picture[1]), 1))
    return (x + (w - inside[0]) // 2, y + (h - inside[1]) // 2, *inside)


def _nothing_like(mask: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the colour mask that blocks everything, for none, one or several attachments."""
    return tuple(_nothing_like(part) if isinstance(part, tuple) else False for part in mask)
