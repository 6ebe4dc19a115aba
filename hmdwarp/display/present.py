"""Present finished pictures, and text over them, in the formats of a window or runtime."""

from __future__ import annotations

import math
import textwrap
from collections import OrderedDict
from itertools import product
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..geometry import View
from ..gpu import Canvas, Gpu, Uniforms, allocate, upload
from ._base import Label

FRAMEBUFFER_SRGB = 0x8DB9
Viewport = tuple[int, int, int, int]  # x, y, width, height in pixels, origin bottom left
_Whole = tuple[Uniforms, moderngl.VertexArray]  # draws the whole viewport


class Presenter:
    """Draw finished pictures into framebuffers, one for each Gpu; leaves all GL flags off."""

    def __init__(self, gpu: Gpu) -> None:
        gl = self._gl = gpu.gl
        self._notices: OrderedDict[Label, Notice] = OrderedDict()
        self._shaders = gpu.shaders
        self._nothing = Canvas(gl, (1, 1))
        self._nothing.clear()
        self._pictures: dict[tuple[bool, bool, bool], _Whole] = {}
        self._depth = self._whole("display/depth.frag")

    def _whole(self, fragment: str, **defines: int) -> _Whole:
        draw = self._shaders.draw("display/whole.vert", fragment, **defines)
        return draw.uniforms, self._gl.vertex_array(draw.program, [])

    def notice(self, label: Label) -> Notice | None:
        """Return what show() can lay over the picture; None for "".

        Lines are wrapped; a tab in them makes two columns. Each is drawn once; of too many the
        least recently used one is dropped.
        """
        if not label:
            return None
        if label not in self._notices:
            if len(self._notices) == KEPT:
                self._notices.popitem(last=False)[1].ink.release()
            ink = text_ink(label) if isinstance(label, str) else label.ink()
            is_grey = ink.ndim == 2
            texture = allocate(self._gl, ink.shape[1::-1], (1 if is_grey else 4, "f1"), linear=True)
            if is_grey:
                texture.swizzle = "RRR1"
            upload(texture, ink)
            texture.build_mipmaps()  # a head-locked text panel shows letters at half size
            self._notices[label] = Notice(label, texture)
        self._notices.move_to_end(label)
        return self._notices[label]

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
        if key not in self._pictures:  # all of them now, so that no later picture is held up
            for scaled, noticed in product((False, True), repeat=2):
                defines = {"ENCODES": int(not hardware_srgb), "SCALED": int(scaled), "NOTICED": int(noticed)}
                self._pictures[hardware_srgb, scaled, noticed] = self._whole("display/picture.frag", **defines)
        uniforms, array = self._pictures[key]
        picture.texture.use(0)
        uniforms.set(picture=0, picture_size=picture.size, place=tuple(viewport))
        if notice is not None:
            notice.ink.use(1)
            uniforms.set(ink=1, uv_from_pixel=notice.uv_from_pixel(size, eye))
        # Off for a window too, which may be sRGB without a request for it.
        (self._gl.enable_direct if hardware_srgb else self._gl.disable_direct)(FRAMEBUFFER_SRGB)
        self._draw(array, into, viewport, moderngl.NOTHING)
        self._gl.disable_direct(FRAMEBUFFER_SRGB)

    def depth(self, inverse_depth: moderngl.Texture, into: moderngl.Framebuffer, near_m: float) -> None:
        """Write near_m * inverse_depth, clipped to 0..1, into all of the depth of `into`.

        inverse_depth: r32f, 1/m; -1 (unknown) gives 0. near_m: where depth is 1; 0 is infinitely
        far. A picture of another size is sampled pixel by pixel: depths must not be mixed. Colours
        stay.
        """
        (w, h), (uniforms, array) = into.size, self._depth
        inverse_depth.use(0)
        ratio = (inverse_depth.width / w, inverse_depth.height / h)
        uniforms.set(inverse_depth=0, texel_from_pixel=ratio, near_m=near_m)
        colours, self._gl.depth_func = into.color_mask, "1"
        into.color_mask = _nothing_like(colours)
        self._draw(array, into, (0, 0, w, h), moderngl.DEPTH_TEST)
        into.color_mask, self._gl.depth_func = colours, "<"

    def _draw(self, array: moderngl.VertexArray, into: moderngl.Framebuffer, viewport: Viewport, flags: int) -> None:
        """Draw without moderngl.Scope: it keeps framebuffers, and a runtime has ever new ones."""
        before, into.viewport = into.viewport, viewport
        into.use()
        self._gl.enable_only(flags)
        array.render(moderngl.TRIANGLES, vertices=3)
        self._gl.enable_only(moderngl.NOTHING)
        into.viewport = before

    def close(self) -> None:
        for notice in self._notices.values():
            notice.ink.release()
        self._notices.clear()
        self._nothing.release()
        for _, array in (*self._pictures.values(), self._depth):
            array.release()
        self._pictures.clear()


def _nothing_like(mask: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the colour mask that blocks everything, for none, one or several attachments."""
    return tuple(_nothing_like(part) if isinstance(part, tuple) else False for part in mask)


_FONT_PX, _LINE_PX, _PAD_PX, COLUMN_PX = 28, 38, 18, 28
_LETTERS_A_LINE = 44
KEPT = 16  # textures; notices are few, and a help text is the same each time

# Head-locked, at 1 m. At 300 pixels a metre (640x800 an eye, 100 degrees) letters still have 13
# pixels, and the text is so small and central that both eyes of every headset here see all of it.
_AT_M = 1.0
_LINE_M = 0.056
MAX_WIDTH_M, MAX_HEIGHT_M = 1.1, 1.2
_MIDDLE_M, LOWEST_M = -0.35, -0.62
# A text panel is read straight ahead, and no turn of the head brings it nearer: it lies only a
# little below.
_TEXT_PANEL_MIDDLE_M = -0.1

# In a window without an eye: full size, but no more than this share of the viewport, above this
# margin.
_MAX_SHARE, MARGIN = 0.94, 0.03


@attrs.frozen(eq=False)
class Notice:
    """A drawn text or text panel. (u, v) on it has its origin at the bottom left."""

    label: Label
    # with mipmaps, 1 where a letter is, or the light of a picture; the Presenter's
    ink: moderngl.Texture

    def uv_from_pixel(self, size: tuple[int, int], eye: View | None) -> NDArray[np.float64]:
        """Return 3x3: (x, y, 1) in pixels of a (w, h) viewport, origin bottom left, to uv.

        The third row is positive in front of the eye. eye: the eye that sees it 1 m in front of the
        head, text below the middle; None for a viewport without an eye, text at its bottom. A text
        panel is centred in either case.
        """
        (w, h), is_text = self.ink.size, isinstance(self.label, str)
        if eye is None:
            scale = min(1.0, _MAX_SHARE * size[0] / w, _MAX_SHARE * size[1] / h)
            # At whole pixels, letters of full size stay sharp.
            middle = (size[1] - scale * h) / 2
            left, bottom = (size[0] - scale * w) / 2, min(MARGIN * size[1], middle) if is_text else middle
            pixel_from_uv = np.array([[scale * w, 0, round(left)], [0, scale * h, round(bottom)], [0, 0, 1.0]])
        else:
            w_m, h_m = (pixels * _LINE_M / _LINE_PX for pixels in (w, h))
            scale = min(1.0, MAX_WIDTH_M / w_m, MAX_HEIGHT_M / h_m)
            w_m, h_m = scale * w_m, scale * h_m
            bottom = max((_MIDDLE_M if is_text else _TEXT_PANEL_MIDDLE_M) - h_m / 2, LOWEST_M)
            in_head = np.array([[w_m, 0, -w_m / 2], [0, h_m, bottom], [0, 0, -_AT_M]])
            from_eye = in_head - np.outer(eye.head_from_eye.position_m, (0, 0, 1))
            in_eye = eye.head_from_eye.rotation.as_matrix().T @ from_eye
            pixel_from_uv = eye.fov.pixel_from_tangent(size) @ np.diag([1.0, 1.0, -1.0]) @ in_eye
        return np.asarray(np.linalg.inv(pixel_from_uv), np.float64)


def text_ink(text: str) -> NDArray[np.uint8]:
    """Return (h, w), top row first: 255 inside letters of the text, with a margin."""
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.load_default(_FONT_PX)
    rows: list[tuple[str, ...]] = []  # of one part, or of two columns
    for line in text.splitlines():
        before, tab, after = line.partition("\t")
        rows += [(before, after)] if tab else [(part,) for part in textwrap.wrap(line, _LETTERS_A_LINE) or [""]]

    def widest(parts: list[str], from_px: int = 0) -> int:
        return max((from_px + math.ceil(font.getlength(part)) for part in parts), default=0)

    second_px = widest([row[0] for row in rows if len(row) == 2]) + COLUMN_PX
    wide = max(widest([row[0] for row in rows]), widest([row[1] for row in rows if len(row) == 2], second_px))
    size = (wide + 2 * _PAD_PX, _LINE_PX * len(rows) + _PAD_PX)
    image = Image.new("L", size)
    draw = ImageDraw.Draw(image)
    for number, row in enumerate(rows):
        for column, part in enumerate(row):
            draw.text((_PAD_PX + column * second_px, _PAD_PX / 2 + number * _LINE_PX), part, 255, font)
    return np.asarray(image)
