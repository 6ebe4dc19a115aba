"""Views that look straight ahead and hold those of canted eyes."""

from __future__ import annotations

import math
from functools import lru_cache

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .pose import Pose
from .view import Eyes, Fov, Hidden, Polygon, View

Size = tuple[int, int]


@attrs.frozen(eq=False)
class ParallelEyes:
    """The eyes of a headset, each in its place and turned as the head is.

    Their views hold all that the eyes see, and more: what no eye sees of them is hidden.
    Source: the parallel projection of SteamVR and of OpenXR-Toolkit.
    """

    eyes: Eyes

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the view of each eye, the left one first. Errors: InputError beyond 90 degrees."""
        found = []
        for view in self.eyes.views(world_from_head):
            place = Pose(view.head_from_eye.position_m)
            turn = view.head_from_eye.rotation_matrix
            fov, hidden = _held(view.fov, view.hidden, tuple(map(tuple, turn.tolist())))
            found.append(View(world_from_head @ place, fov, place, hidden))
        return tuple(found)

    def size(self, size: Size) -> Size:
        """Return the pixels of views with as many a tangent as those of (w, h) have."""
        wanted = [
            np.array(size) * _spans(held.fov) / _spans(view.fov)
            for view, held in zip(self.eyes.views(Pose()), self.views(Pose()), strict=True)
        ]
        wide, high = np.max(wanted, axis=0).tolist()
        return math.ceil(wide - 1e-6), math.ceil(high - 1e-6)


def _spans(fov: Fov) -> NDArray[np.float64]:
    left, right, down, up = fov.tangents.tolist()
    return np.array([right - left, up - down])


@lru_cache(maxsize=16)
def _held(fov: Fov, hidden: Hidden | None, turn: tuple[tuple[float, ...], ...]) -> tuple[Fov, Hidden | None]:
    left, right, down, up = fov.tangents.tolist()
    corners = _turned(((left, down), (right, down), (right, up), (left, up)), np.array(turn))
    (least_x, least_y), (most_x, most_y) = np.min(corners, axis=0), np.max(corners, axis=0)
    held = Fov.from_tangents((least_x, most_x, least_y, most_y))
    polygons = hidden.polygons if hidden is not None else ()
    ends = ((least_x, least_y), (most_x, least_y), (most_x, most_y), (least_x, most_y))
    # What lies between the border and a side of what the eye sees.
    around = tuple(
        (one, other, there, here)
        for one, other, here, there in zip(ends, _next(ends), corners, _next(corners), strict=True)
    )
    return held, Hidden(tuple(_turned(polygon, np.array(turn)) for polygon in polygons) + around, held)


def _next(places: Polygon) -> Polygon:
    return places[1:] + places[:1]


def _turned(places: Polygon, turn: NDArray[np.float64]) -> Polygon:
    """Return tangents in the head's axes of those in an eye's. Errors: InputError behind it."""
    x, y, z = turn @ np.array([(*place, -1.0) for place in places]).T
    if (z >= 0).any():
        raise InputError("an eye sees more than 90 degrees to a side: no parallel view holds that")
    return tuple(zip((x / -z).tolist(), (y / -z).tolist(), strict=True))
