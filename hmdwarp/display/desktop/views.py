"""What a window shows: both eyes' panels of a headset, or one flat view of it."""

from __future__ import annotations

import attrs
import numpy as np

from ...errors import InputError
from ...geometry import Eyes, Fov, Pose, View
from ...headsets import Headset
from .layout import Size, flat_size

BOTH, FLAT = "both", "flat"


@attrs.frozen(eq=False)
class OneEye:
    """A single eye in the middle of the head. name: of the headset whose field of view it has."""

    name: str
    fov: Fov

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return its view, as Eyes.views."""
        return (View(world_from_head, self.fov),)


@attrs.frozen(eq=False)
class Shown:
    """Eyes of a window, and how their pictures look."""

    eyes: Eyes
    count: int  # how many eyes
    size: Size  # (w, h) pixels of one eye's picture
    aspect: float  # width over height of one picture as it should look
    headset: Headset | None  # whose lens lies in front of it, None for a picture viewed without one

    @property
    def whole(self) -> Size:
        """(w, h) of all eyes side by side, in square pixels."""
        return max(1, round(self.count * self.size[1] * self.aspect)), self.size[1]


def shown(view: str, headset: Headset, size: Size | None) -> Shown:
    """Return what the view "both" or "flat" of a headset shows.

    size: of one eye, None for what suits it. The flat view is as wide as the left eye sees to its
    wider side, and as high.
    """
    if view == BOTH:
        width, height = headset.eye_size_m
        return Shown(headset, 2, size or headset.eye_size_px, width / height, headset)
    if view != FLAT:
        raise InputError(f"view '{view}': wanted {BOTH} or {FLAT}")
    left, right, down, up = np.abs(headset.left_fov.tangents)
    wide, high = max(left, right), max(down, up)
    aspect = float(wide / high)
    eye = OneEye(headset.name, Fov.from_tangents((-wide, wide, -high, high)))
    return Shown(eye, 1, size or flat_size(aspect), aspect, None)
