"""Views of a window: both eyes' panels of a headset, or one flat view."""

from __future__ import annotations

import attrs

from ...errors import InputError
from ...geometry import Eyes, Fov, Pose, View
from ...headsets import Headset
from .layout import Size, flat_size

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
