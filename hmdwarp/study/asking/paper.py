"""What plates are drawn on: black paper, white ink, y down; what is grey there is dim over the picture.

Ink is mixed in linear light (shaders/display/picture.frag), where grey looks brighter than in a file, and dark letters on white get thin:
what is marked is framed, on a ground that is a little brighter, and never dark on white.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

# 680 pixels are 1 m in a headset (display/notice.py): at 300 pixels a metre, the coarsest headset here, 28 of them are 12.
WIDTH, PAD = 680, 22
SMALL, TEXT, LARGE, HUGE = 24, 28, 32, 44  # letters, in pixels
FULL, DIM, GROUND = 255, 120, 36  # as bright on a screen as 255, 182 and 104 of sRGB
LINE = 1.3  # rows of letters apart, in letters


@functools.cache
def font(px: int) -> FreeTypeFont:
    """Pillow's own, which is always there."""
    from PIL import ImageFont

    return ImageFont.load_default(px)


@functools.lru_cache(4096)
def width_of(text: str, px: int) -> float:
    """In pixels."""
    return float(font(px).getlength(text))


@functools.lru_cache(1024)
def wrapped(text: str, px: int, width: float) -> tuple[str, ...]:
    """Its lines, none wider than `width`: a word that is by itself is cut. Line ends in the text stay."""
    rows: list[str] = []
    for line in text.splitlines():
        row = ""
        for word in line.split():
            row = _with(rows, row, word, px, width)
        rows.append(row)
    return tuple(rows)


def _with(rows: list[str], row: str, word: str, px: int, width: float) -> str:
    """The row with one word more; what is full goes to `rows`."""
    longer = f"{row} {word}" if row else word
    if width_of(longer, px) <= width:
        return longer
    if row:
        rows.append(row)
    while width_of(word, px) > width and len(word) > 1:
        fits = next(n for n in range(len(word) - 1, 0, -1) if n == 1 or width_of(word[:n], px) <= width)
        rows.append(word[:fits])
        word = word[fits:]
    return word


def height_of(rows: int, px: int) -> int:
    """Of so many rows of text."""
    return round(rows * LINE * px)


class Paper:
    """height: in pixels; all plates are equally wide, so that none jumps when another follows."""

    def __init__(self, height: int) -> None:
        from PIL import Image, ImageDraw

        self._image = Image.new("L", (WIDTH, height))
        self._draw = ImageDraw.Draw(self._image)

    def text(self, x: float, y: float, text: str, px: int, ink: int = FULL, anchor: str = "la") -> None:
        """One line. anchor: as Pillow has them; its first letter says where x is: l(eft), m(iddle), r(ight)."""
        self._draw.text((x, y), text, ink, font(px), anchor)

    def rows(
        self, y: float, rows: tuple[str, ...], px: int, ink: int = FULL, x: float = PAD, anchor: str = "la"
    ) -> float:
        """Line under line; where the next thing may begin."""
        for number, row in enumerate(rows):
            self.text(x, y + height_of(number, px), row, px, ink, anchor)
        return y + height_of(len(rows), px)

    def box(self, left: float, top: float, right: float, bottom: float, *, marked: bool) -> None:
        """With round corners."""
        at = (left, top, right, bottom)
        self._draw.rounded_rectangle(
            at, 8, fill=GROUND if marked else None, outline=FULL if marked else DIM, width=4 if marked else 2
        )

    def line(self, x: float, y: float, to_x: float, to_y: float, ink: int = FULL, width: int = 2) -> None:
        """Straight."""
        self._draw.line((x, y, to_x, to_y), ink, width)

    def pointer(self, x: float, y: float, size: float) -> None:
        """A triangle that stands on its tip."""
        self._draw.polygon(((x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)), FULL)

    def ink(self) -> NDArray[np.uint8]:
        """(h, w), top row first."""
        return np.asarray(self._image)
