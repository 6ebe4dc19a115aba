"""Views of a window, the places of their pictures in it, and the size of a new one."""

from __future__ import annotations

import math

import attrs

from ...errors import InputError
from ...geometry import Eyes, Fov, Pose, View
from ...headsets import Headset

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


def picture_area(framebuffer: Size, column: int) -> Size:
    """Return the size that a panel of that many columns at the right leaves for pictures.

    If that is less than half, the panel covers the pictures instead.
    """
    width, height = framebuffer
    return (width - column, height) if 2 * column <= width else framebuffer


def window_size(wanted: Size, room: Size, column: int = 0) -> Size:
    """Return the size of a new window for pictures of `wanted` pixels and a panel next to them.

    It is large enough to read, and within most of the free area of the screen; the pictures'
    aspect is kept.
    """
    width, height = wanted
    most = _SHARE * room[0], _SHARE * room[1]
    column = column if 2 * column <= most[0] else 0
    scale = max(1.0, _LEAST_HEIGHT / height)
    scale = min(scale, (most[0] - column) / width, most[1] / height)
    return max(1, round(width * scale)) + column, max(1, round(height * scale))


BOTH, FLAT = "both", "flat"


@attrs.frozen(eq=False)
class OneEye:
    """A single eye in the middle of the head."""

    name: str  # the headset whose field of view it has
    fov: Fov

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return its view, as Eyes.views."""
        return (View(world_from_head, self.fov),)


@attrs.frozen(eq=False)
class WindowView:
    """Eyes of a window, and the format of their pictures."""

    eyes: Eyes
    count: int  # how many eyes
    size: Size  # (w, h) pixels of one eye's picture
    aspect: float  # width over height of one picture as displayed
    headset: Headset | None  # the headset whose lens is in front of it, None for a picture viewed without one

    @property
    def total_size(self) -> Size:
        """(w, h) of all eyes side by side, in square pixels."""
        return max(1, round(self.count * self.size[1] * self.aspect)), self.size[1]


def window_view(view: str, headset: Headset, size: Size | None) -> WindowView:
    """Return the view "both" or "flat" of a headset.

    size: of one eye, None for the default. The flat view has the shape of both eyes side by side,
    and so fills the same window.
    """
    width, height = headset.eye_size_m
    if view == BOTH:
        count = len(headset.views(Pose()))
        return WindowView(headset, count, size or headset.eye_size_px, width / height, headset)
    if view != FLAT:
        raise InputError(f"--view '{view}': expected {BOTH} or {FLAT}")
    fov, aspect = headset.flat_view
    return WindowView(OneEye(headset.name, fov), 1, size or flat_size(aspect), aspect, None)


class SwitchableView:
    """The members of a Display that follow from a view which may be switched.

    hmdwarp corrects the lens. size: (w, h) of one eye's picture; None for what suits the view.
    """

    distorts = takes_depth = ""

    def __init__(self, headset: Headset, size: Size | None, view: str) -> None:
        self._emulated, self._wanted_size = headset, size
        self._view = window_view(view, headset, size)

    def set_view(self, view: str) -> None:
        """Switch to "both" or "flat". Errors: InputError for another name."""
        self._view = window_view(view, self._emulated, self._wanted_size)

    @property
    def eyes(self) -> Eyes:
        """Eyes of the current view."""
        return self._view.eyes

    @property
    def size(self) -> Size:
        """(w, h) of one eye's picture in the current view."""
        return self._view.size

    @property
    def headset(self) -> Headset | None:
        """The headset whose lens the plan corrects; None for the flat view."""
        return self._view.headset
