"""Where in a window each eye's picture goes, and how large a window should be."""

from __future__ import annotations

import math

Size = tuple[int, int]
Rectangle = tuple[int, int, int, int]

FLAT_AREA_PX = 800 * 600
WHOLE = 8  # pictures of whole work groups, and what video encoders like


def viewports(framebuffer: Size, count: int, aspect: float) -> tuple[Rectangle, ...]:
    """(x, y, w, h) of `count` equally large pictures side by side, the left one first, as large as they fit and in the middle.

    framebuffer: (w, h) in pixels, not in the window's units. aspect: width over height of one picture; kept within a pixel.
    """
    width, height = framebuffer
    each = max(1, min(width // count, round(height * aspect)))
    tall = max(1, min(height, round(each / aspect)))
    left, low = (width - count * each) // 2, (height - tall) // 2
    return tuple((left + k * each, low, each, tall) for k in range(count))


def flat_size(aspect: float) -> Size:
    """A picture of that aspect with as many pixels as one of 800x600, whole eights on each side."""
    width = math.sqrt(FLAT_AREA_PX * aspect)
    return max(WHOLE, round(width / WHOLE) * WHOLE), max(WHOLE, round(width / aspect / WHOLE) * WHOLE)


def window_size(wanted: Size, room: Size, least_height: int = 480, share: float = 0.9) -> Size:
    """What a new window should measure for pictures of `wanted` pixels: so much, but no less than is well seen, and within `share` of
    the room on the screen; the aspect is kept."""
    width, height = wanted
    scale = max(1.0, least_height / height)
    scale = min(scale, share * room[0] / width, share * room[1] / height)
    return max(1, round(width * scale)), max(1, round(height * scale))
