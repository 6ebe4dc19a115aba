"""Canvas that panels are drawn on: black ground, white ink, y down.

Ink is mixed in linear light (shaders/display/picture.frag): grey looks brighter there than in a
file, and dark letters on white get thin. So a marked item gets a frame on a slightly brighter
ground, never dark letters on white.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..design import open_picture

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont, ImageFont

# 680 pixels are 1 m in a headset (display/present.py). At 300 pixels a metre, the coarsest headset
# here, letters of 28 pixels are 12 high.
WIDTH, PAD = 680, 22
SMALL, TEXT, LARGE, HUGE = 24, 28, 32, 44  # letter heights in pixels
FULL, DIM, GROUND = 255, 120, 36  # as bright on a screen as 255, 182 and 104 of sRGB
LINE = 1.3  # distance between rows of text, in letter heights
PICTURE_HIGH = 420  # most rows of a picture: more would not fit a headset's eye with title and buttons


@functools.cache
def font(px: int) -> FreeTypeFont | ImageFont:
    """Load Pillow's own font, which is always there."""
    from PIL import ImageFont

    return ImageFont.load_default(px)


@functools.lru_cache(4096)
def width_of(text: str, px: int) -> float:
    """Return the width of a line in pixels."""
    return float(font(px).getlength(text))


@functools.lru_cache(1024)
def wrapped(text: str, px: int, width: float) -> tuple[str, ...]:
    """Wrap a text into lines no wider than `width`; a longer word is cut. Line ends stay."""
    rows: list[str] = []
    for line in text.splitlines():
        row = ""
        for word in line.split():
            row = _with(rows, row, word, px, width)
        rows.append(row)
    return tuple(rows)


def _with(rows: list[str], row: str, word: str, px: int, width: float) -> str:
    """Return the row with one more word; a full row goes to `rows`."""
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
    """Return the height of that many rows of text."""
    return round(rows * LINE * px)


@functools.lru_cache(8)
def picture_light(path: str) -> NDArray[np.uint8]:
    """Load a picture as large as a panel takes it: (h, w, 3) linear light, top row first.

    Errors: InputError for a file that is no picture.
    """
    from PIL import Image

    shown = open_picture(path)
    shown.thumbnail((WIDTH - 2 * PAD, PICTURE_HIGH), Image.Resampling.LANCZOS)
    ground = Image.new("RGBA", shown.size, "black")
    srgb = np.asarray(Image.alpha_composite(ground, shown).convert("RGB"), np.float64) / 255
    light = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)  # IEC 61966-2-1
    return np.round(light * 255).astype(np.uint8)


class Canvas:
    """Drawing area of a panel; all are equally wide, so that none jumps when another follows."""

    def __init__(self, height: int) -> None:
        from PIL import Image, ImageDraw

        self._image = Image.new("L", (WIDTH, height))
        self._draw = ImageDraw.Draw(self._image)

    def text(self, x: float, y: float, text: str, px: int, ink: int = FULL, anchor: str = "la") -> None:
        """Draw one line. anchor: as in Pillow; x is at its l(eft), m(iddle) or r(ight)."""
        self._draw.text((x, y), text, ink, font(px), anchor)

    def rows(
        self, y: float, rows: tuple[str, ...], px: int, ink: int = FULL, x: float = PAD, anchor: str = "la"
    ) -> float:
        """Draw line under line. Returns where the next thing may begin."""
        for number, row in enumerate(rows):
            self.text(x, y + height_of(number, px), row, px, ink, anchor)
        return y + height_of(len(rows), px)

    def box(self, left: float, top: float, right: float, bottom: float, *, marked: bool) -> None:
        """Draw a box with round corners."""
        at = (left, top, right, bottom)
        self._draw.rounded_rectangle(
            at, 8, fill=GROUND if marked else None, outline=FULL if marked else DIM, width=4 if marked else 2
        )

    def line(self, x: float, y: float, to_x: float, to_y: float, ink: int = FULL, width: int = 2) -> None:
        """Draw a straight line."""
        self._draw.line((x, y, to_x, to_y), ink, width)

    def pointer(self, x: float, y: float, size: float) -> None:
        """Draw a triangle that stands on its tip."""
        self._draw.polygon(((x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)), FULL)

    def ink(self) -> NDArray[np.uint8]:
        """Return the picture, (h, w), top row first."""
        return np.asarray(self._image)
