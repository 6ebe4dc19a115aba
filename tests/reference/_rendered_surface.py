"""The rendered picture as a surface, and shown rays drawn into it. What the twins of the gathers
that search the rendered depth share."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import View, WarpMap
from reference._rays import FLOAT32_UNIT, Array, pixel_error_bound, project, world_directions

Bools = NDArray[np.bool_]
LEAST_RUN = 0.25  # of 1 - slope . along


@attrs.frozen(eq=False)
class RaysInRendered:
    """Where shown rays appear in the rendered picture.

    At inverse depth r (of the rendered eye) at start + r * along, pixels.

    lead: the rays' component along the rendered eye's axis; ahead_m: how far the shown eye stands
    before the rendered one along that axis. start_error, along_error: how far float32 may be off.
    """

    start: Array
    along: Array
    lead: Array
    ahead_m: float
    start_error: Array
    along_error: Array

    @classmethod
    def of(
        cls,
        rendered: View,
        size: tuple[int, int],
        shown: View,
        shown_size: tuple[int, int],
        directions: Array | None = None,
    ) -> RaysInRendered:
        """Through the pixel centres of the shown view, or along `directions` (..., 3) of length 1
        along its axis."""
        rays = world_directions(shown, shown_size) if directions is None else directions
        moved = shown.pose.position_m - rendered.pose.position_m
        axis = rendered.pose.rotation.as_matrix() @ np.array([0.0, 0.0, -1.0])
        lead, ahead = rays @ axis, float(axis @ moved)
        # A point of rendered inverse depth r lies at the length t = (1/r - ahead) / lead; scaled by
        # r lead: no division, so no case for r = 0.
        start, at_one = (project(rays * (1 - r * ahead), moved, r * lead, rendered, size)[0] for r in (0.0, 1.0))
        warp = WarpMap.between(shown, shown_size, rendered, size)
        along = at_one - start
        error = pixel_error_bound(warp, shown_size, np.zeros(shown_size[::-1]))
        if directions is not None:
            error = np.full(lead.shape, error.max())
        error = np.minimum(error, 1e12)  # as good as not knowing the place, and no Inf to multiply a zero with
        sizes = np.abs(warp.e[:2]).max() + 2 * np.abs(np.nan_to_num(start)).max(axis=-1) * abs(warp.e[2])
        return cls(start, along, lead, ahead, error, abs(warp.e[2]) * error + 4 * FLOAT32_UNIT * sizes)

    def place(self, r: Array) -> Array:
        """(..., 2) pixels."""
        return self.start + r[..., None] * self.along

    def shown_depth(self, r: Array, r_error: Array) -> tuple[Array, Array]:
        """The inverse depth, for the shown eye, of the points at inverse depth r on the rays.

        One over the length to them along the shown axis; and how far a float32 evaluation may be
        off: by r's own error, and by rounding lead, r ahead and their quotient.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            nearer = 1 - r * self.ahead_m
            depth = r * self.lead / nearer
            rounding = 8 * FLOAT32_UNIT * (np.abs(depth) * (1 + np.abs(r * self.ahead_m / nearer)) + np.abs(r / nearer))
            return depth, np.abs(self.lead) / nearer**2 * r_error + rounding

    def place_error(self, r: Array, r_error: Array) -> Array:
        """(...) pixels by which a float32 evaluation of place() may be off."""
        run = np.abs(self.along).max(axis=-1)
        sizes = np.abs(self.start).max(axis=-1) + np.abs(r) * run
        return self.start_error + np.abs(r) * self.along_error + run * r_error + 4 * FLOAT32_UNIT * sizes


@attrs.frozen(eq=False)
class Found:
    """The surface at some places.

    Inverse depth there, its slope (1/m per pixel), the texel's centre, whether it is connected
    along x and y; known; unsure: whether rounding may choose another texel or call neighbours
    connected.
    """

    depth: Array
    slope: Array
    centre: Array
    connected: Bools
    known: Bools
    unsure: Bools


@attrs.frozen(eq=False)
class RenderedSurface:
    """A rendered inverse depth (h, w). Neighbours are connected if they differ by at most tolerance
    * (the farther's + floor)."""

    inverse_depth: Array
    tolerance: float
    floor: float

    def texel(self, place: Array) -> NDArray[np.int64]:
        """(..., 2) x, y of the texel at a place, at the border nearest to it."""
        high, wide = self.inverse_depth.shape
        return np.floor(np.clip(np.nan_to_num(place), 0, [wide - 0.5, high - 0.5])).astype(int)

    def held(self, texel: NDArray[np.int64]) -> Array:
        """Inverse depth of texels; 0 beyond the border."""
        most = np.array(self.inverse_depth.shape[::-1]) - 1
        clipped = np.clip(texel, 0, most)
        return np.where((texel == clipped).all(axis=-1), self.inverse_depth[clipped[..., 1], clipped[..., 0]], 0.0)

    def near_other_texel(self, place: Array, error: Array) -> Bools:
        """Whether a place lies within its error of a border between texels."""
        fraction = np.nan_to_num(place) - np.floor(np.nan_to_num(place))
        return np.minimum(fraction, 1 - fraction).min(axis=-1) <= error

    def at(self, place: Array, error: Array, joined: Array | float = 0.0, joined_error: Array | float = 0.0) -> Found:
        """The plane of the texel at each place (..., 2). joined: 1/m by which neighbours may differ
        in any case and be connected, and its error."""
        texel = self.texel(place)
        centre = texel + 0.5
        off = np.nan_to_num(place) - centre
        own = self.held(texel)
        connected, slope, close = [], [], self.near_other_texel(place, error) | (np.abs(off).min(axis=-1) <= error)
        for axis in (0, 1):
            side = np.where(off[..., axis] < 0, -1, 1)
            step = np.zeros_like(texel)
            step[..., axis] = side
            other = self.held(texel + step)
            limit = np.maximum(self.tolerance * (np.minimum(own, other) + self.floor), joined)
            difference = np.abs(own - other)
            connected.append((other >= 0) & (difference <= limit))
            close |= (other >= 0) & (
                np.abs(difference - limit) <= joined_error + 16 * FLOAT32_UNIT * (own + other + self.floor)
            )
            slope.append(np.where(connected[-1], (other - own) * side, 0.0))
        slopes = np.stack(slope, axis=-1)
        return Found(own + (slopes * off).sum(axis=-1), slopes, centre, np.stack(connected, axis=-1), own >= 0, close)


def run_of(found: Found, rays: RaysInRendered) -> Array:
    """How fast a ray comes nearer to the plane it is at, per inverse depth; at least LEAST_RUN."""
    return np.maximum(1 - (found.slope * rays.along).sum(axis=-1), LEAST_RUN)
