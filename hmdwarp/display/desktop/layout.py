"""Layout of the eyes' pictures in a window, and the size of a new window."""

from __future__ import annotations

import math

Size = tuple[int, int]
Rectangle = tuple[int, int, int, int]

FLAT_AREA_PX = 800 * 600
_LEAST_HEIGHT, _SHARE = 480, 0.9  # of a new window: readable pixels, and its share of the free area
WHOLE = 8  # pictures of whole work groups, which also suit video encoders


def viewports(framebuffer: Size, count: int, aspect: float) -> tuple[Rectangle, ...]:
    """Return (x, y, w, h) of `count` equal pictures side by side, as large as fits, centred.

    The left eye comes first.
    framebuffer: (w, h) in pixels, not in the window's units. aspect: width over height of one
    picture; kept within a pixel.
    """
    width, height = framebuffer
    each = max(1, min(width // count, round(height * aspect)))
    tall = max(1, min(height, round(each / aspect)))
    left, low = (width - count * each) // 2, (height - tall) // 2
    return tuple((left + k * each, low, each, tall) for k in range(count))


def flat_size(aspect: float) -> Size:
    """Return a size of that aspect with as many pixels as 800x600, in multiples of eight."""
    width = math.sqrt(FLAT_AREA_PX * aspect)
    return max(WHOLE, round(width / WHOLE) * WHOLE), max(WHOLE, round(width / aspect / WHOLE) * WHOLE)


def beside(framebuffer: Size, column: int) -> Size:
    """Return the size that a panel of that many columns at the right leaves for pictures.

    If that is less than half, the panel covers the pictures instead.
    """
    width, height = framebuffer
    return (width - column, height) if 2 * column <= width else framebuffer


def window_size(wanted: Size, room: Size, column: int = 0) -> Size:
    """Return the size of a new window for pictures of `wanted` pixels and a panel beside them.

    It is large enough to read, and within most of the free area of the screen; the pictures'
    aspect is kept.
    """
    width, height = wanted
    most = _SHARE * room[0], _SHARE * room[1]
    column = column if 2 * column <= most[0] else 0
    scale = max(1.0, _LEAST_HEIGHT / height)
    scale = min(scale, (most[0] - column) / width, most[1] / height)
    return max(1, round(width * scale)) + column, max(1, round(height * scale))
