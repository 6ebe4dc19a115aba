"""Twin of sheets that are blended. Every ray against every triangle, what it meets sorted by
distance, light added up on the way."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@attrs.frozen(eq=False)
class Sheet:
    """Triangles (m, 3, 3) in metres in the world, all of one kind.

    Colour (3,) of its own light, the share that it covers, the tint (3,) of what passes beside it,
    and the share (3,) that passes where it covers.
    """

    corners: Array = attrs.field(converter=lambda value: np.asarray(value, np.float64))
    colour: Array = attrs.field(converter=lambda value: np.asarray(value, np.float64))
    opacity: float
    tint: Array = attrs.field(default=(1.0, 1.0, 1.0), converter=lambda value: np.asarray(value, np.float64))
    coloured: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=lambda value: np.asarray(value, np.float64))


@attrs.frozen(eq=False)
class Seen:
    """Along each of n rays. Veil (n, 3), passing (n, 3), inverse_depth (n,) of the nearest sheet,
    -1 for none; count (n,) of sheets met."""

    veil: Array
    passing: Array
    inverse_depth: Array
    count: NDArray[np.int64]

    def over(self, behind: Array) -> Array:
        """(n, 3): what one sees, given the light behind them all.

        Source: Porter and Duff 1984, Compositing Digital Images.
        """
        return self.veil + self.passing * behind


def look_through(sheets: Sequence[Sheet], eye: ArrayLike, rays: Array, behind: ArrayLike = -1.0) -> Seen:
    """Rays (n, 3) of length 1 along the view axis from `eye`, up to what lies at inverse depth
    `behind` (n,), in 1/m; -1: nothing."""
    met = [[] for _ in rays]
    limit = np.broadcast_to(np.asarray(behind, np.float64), len(rays))
    for sheet in sheets:
        inverse = _meets(sheet.corners, np.asarray(eye, np.float64), rays)
        for ray in np.flatnonzero((inverse > 0) & (inverse >= limit)):
            met[ray].append((inverse[ray], sheet))
    veil, passing = np.zeros((len(rays), 3)), np.ones((len(rays), 3))
    for ray, found in enumerate(met):
        for _, sheet in sorted(
            found, key=lambda one: -one[0]
        ):  # from the eye on: what comes later is dimmed by all before it
            veil[ray] += passing[ray] * sheet.opacity * sheet.colour
            passing[ray] *= (1 - sheet.opacity) * sheet.tint + sheet.opacity * sheet.coloured
    nearest = np.array([max((entry[0] for entry in found), default=-1.0) for found in met])
    return Seen(veil, passing, nearest, np.array([len(found) for found in met]))


def _meets(corners: Array, eye: Array, rays: Array) -> Array:
    """(n,) inverse depth at which each ray meets the sheet, 0 where it does not.

    Source: Moeller and Trumbore 1997.
    """
    best = np.zeros(len(rays))
    for a, b, c in corners:
        edge_1, edge_2, start = b - a, c - a, eye - a
        across = np.cross(rays, edge_2)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / (across @ edge_1)
            u = (across @ start) * scale
            q = np.cross(start, edge_1)
            v = (rays @ q) * scale
            inverse = 1 / ((edge_2 @ q) * scale)
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (inverse > 0)
        best = np.where(hit, np.maximum(best, inverse), best)
    return best
