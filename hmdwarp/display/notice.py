"""Text over the picture: drawn once into a texture, placed where the eye sees it."""

from __future__ import annotations

import math
import textwrap
from collections import OrderedDict
from typing import TYPE_CHECKING

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..geometry import View
from ..gpu.textures import allocate, upload
from ._base import Label

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont, ImageFont

FONT_PX, LINE_PX, PAD_PX, COLUMN_PX = 28, 38, 18, 28
LETTERS_A_LINE = 44
KEPT = 16  # textures; notices are few, and a help text is the same each time

# Head-locked, at 1 m. At 300 pixels a metre (640x800 an eye, 100 degrees) letters still have 13
# pixels, and the text is so small and central that both eyes of every headset here see all of it.
AT_M = 1.0
LINE_M = 0.056
MAX_WIDTH_M, MAX_HEIGHT_M = 1.1, 1.2
MIDDLE_M, LOWEST_M = -0.35, -0.62
# A text panel is read straight ahead, and no turn of the head brings it nearer: it lies only a
# little below.
TEXT_PANEL_MIDDLE_M = -0.1

# In a window without an eye: full size, but no more than this share of the viewport, above this
# margin.
MAX_SHARE, MARGIN = 0.94, 0.03


@attrs.frozen(eq=False)
class Notice:
    """A drawn text or text panel. (u, v) on it has its origin at the bottom left."""

    label: Label
    # with mipmaps, 1 where a letter is, or the light of a picture; it belongs to the Notices that
    # made it
    ink: moderngl.Texture

    def uv_from_pixel(self, size: tuple[int, int], eye: View | None) -> NDArray[np.float64]:
        """Return 3x3: (x, y, 1) in pixels of a (w, h) viewport, origin bottom left, to uv.

        The third row is positive in front of the eye. eye: the eye that sees it 1 m in front of the
        head, text below the middle; None for a viewport without an eye, text at its bottom. A text
        panel is centred in either case.
        """
        pixel_from_uv = self._in_viewport(size) if eye is None else _seen(self._in_head(), eye, size)
        return np.asarray(np.linalg.inv(pixel_from_uv), np.float64)

    @property
    def _is_text(self) -> bool:
        return isinstance(self.label, str)

    def _in_viewport(self, size: tuple[int, int]) -> NDArray[np.float64]:
        """Return pixels of the viewport from uv."""
        w, h = self.ink.size
        scale = min(1.0, MAX_SHARE * size[0] / w, MAX_SHARE * size[1] / h)
        # At whole pixels, letters of full size stay sharp.
        middle = (size[1] - scale * h) / 2
        left, bottom = (
            round((size[0] - scale * w) / 2),
            round(min(MARGIN * size[1], middle) if self._is_text else middle),
        )
        return np.array([[scale * w, 0, left], [0, scale * h, bottom], [0, 0, 1.0]])

    def _in_head(self) -> NDArray[np.float64]:
        """Return 3x3: (u, v, 1) to metres in the head's axes."""
        w, h = (pixels * LINE_M / LINE_PX for pixels in self.ink.size)
        scale = min(1.0, MAX_WIDTH_M / w, MAX_HEIGHT_M / h)
        w, h = scale * w, scale * h
        bottom = max((MIDDLE_M if self._is_text else TEXT_PANEL_MIDDLE_M) - h / 2, LOWEST_M)
        return np.array([[w, 0, -w / 2], [0, h, bottom], [0, 0, -AT_M]])


def _seen(in_head: NDArray[np.float64], eye: View, size: tuple[int, int]) -> NDArray[np.float64]:
    """Return homogeneous pixels of the eye's picture from uv."""
    head_from_eye = eye.head_from_eye
    from_eye = in_head - np.outer(head_from_eye.position_m, (0, 0, 1))
    in_eye = head_from_eye.rotation.as_matrix().T @ from_eye
    seen: NDArray[np.float64] = eye.fov.pixel_from_tangent(size) @ np.diag([1.0, 1.0, -1.0]) @ in_eye
    return seen


class Notices:
    """Textures of texts, each drawn once.

    The least recently used one is dropped when there are too many.
    """

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._kept: OrderedDict[Label, Notice] = OrderedDict()

    def of(self, label: Label) -> Notice | None:
        """Return the notice of a text or text panel, None for an empty text.

        Lines are wrapped; a tab in them makes two columns.
        """
        if not label:
            return None
        if label not in self._kept:
            if len(self._kept) == KEPT:
                self._kept.popitem(last=False)[1].ink.release()
            self._kept[label] = self._draw(label)
        self._kept.move_to_end(label)
        return self._kept[label]

    def _draw(self, label: Label) -> Notice:
        ink = text_ink(label) if isinstance(label, str) else label.ink()
        is_grey = ink.ndim == 2
        texture = allocate(self._gl, ink.shape[1::-1], (1 if is_grey else 4, "f1"), linear=True)
        if is_grey:
            texture.swizzle = "RRR1"
        upload(texture, ink)
        texture.build_mipmaps()  # a head-locked text panel shows letters at half size
        return Notice(label, texture)

    def close(self) -> None:
        """Free the textures."""
        for notice in self._kept.values():
            notice.ink.release()
        self._kept.clear()


def text_ink(text: str) -> NDArray[np.uint8]:
    """Return (h, w), top row first: 255 inside letters of the text, with a margin."""
    from PIL import Image, ImageDraw, ImageFont

    font = ImageFont.load_default(FONT_PX)
    rows = [row for line in text.splitlines() for row in _wrapped(line)]
    second_px = _widest(font, [row[0] for row in rows if len(row) == 2]) + COLUMN_PX
    wide = max(
        _widest(font, [row[0] for row in rows]), _widest(font, [row[1] for row in rows if len(row) == 2], second_px)
    )
    size = (wide + 2 * PAD_PX, LINE_PX * len(rows) + PAD_PX)
    image = Image.new("L", size)
    draw = ImageDraw.Draw(image)
    for number, row in enumerate(rows):
        for column, part in enumerate(row):
            draw.text((PAD_PX + column * second_px, PAD_PX / 2 + number * LINE_PX), part, 255, font)
    return np.asarray(image)


def _widest(font: FreeTypeFont | ImageFont, parts: list[str], from_px: int = 0) -> int:
    return max((from_px + math.ceil(font.getlength(part)) for part in parts), default=0)


def _wrapped(line: str) -> list[tuple[str, ...]]:
    """Return the rows of one part, or of two columns."""
    if "\t" in line:
        before, _, after = line.partition("\t")
        return [(before, after)]
    return [(part,) for part in textwrap.wrap(line, LETTERS_A_LINE) or [""]]
