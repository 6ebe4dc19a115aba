"""What a twin hands back. The picture, how far a shader may be off, and where rounding alone may
decide otherwise."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from hmdwarp.geometry import View, WarpMap
from reference._rays import FLOAT32_UNIT, Places, pixel_centres, pixel_error_bound, rays_through, world_directions

Array = NDArray[np.float64]

HALF_UNIT = 2.0**-10  # relative error of a stored rgba16f value: GL leaves the rounding open, and llvmpipe truncates
HALF_SMALLEST = 2.0**-24  # the smallest denormal half float
# A GPU's bilinear sampler rounds the place to 1/256 pixel (8 fraction bits); llvmpipe computes it
# in float32.
GPU_SAMPLER_PIXELS = 1 / 256


_ANYWHERE = 1e12  # pixels: as good as not knowing the place, and no Inf to multiply a zero with


def _with_none_as_minus_one(inverse_depth: Array) -> Array:
    """What is negative or no finite number is no depth (docs/conventions.md)."""
    return np.where(np.isfinite(inverse_depth) & (inverse_depth >= 0), inverse_depth, -1.0)


@attrs.frozen(eq=False)
class RenderedPicture:
    """colour (h, w, 4) premultiplied linear with coverage in alpha, inverse_depth (h, w) in 1/m, -1
    for none, and their view."""

    colour: Array
    inverse_depth: Array = attrs.field(converter=_with_none_as_minus_one)
    view: View


@attrs.frozen(eq=False)
class TwinInputs:
    """What a twin is inputs.

    The rendered picture and its view, the shown view and its (w, h), and what else the warp reads.

    colour, inverse_depth as in RenderedPicture. client_inverse_depth: (h, w) of the shown size.
    layers: pictures of the rendered view, nearest first. cube: (3n, 2n, 4) as geometry.cube lays it
    out. others: further rendered pictures. settings: the warp's. sampler_pixels: how far, in
    pixels, the sampler may place a bilinear look beside where it should be. places: where the shown
    view is looked at, if not at its pixel centres; the result then has their shape.
    """

    colour: Array
    inverse_depth: Array = attrs.field(converter=_with_none_as_minus_one)
    rendered: View
    shown: View
    shown_size: tuple[int, int]
    client_inverse_depth: Array | None = None
    layers: tuple[RenderedPicture, ...] = ()
    cube: Array | None = None
    others: tuple[RenderedPicture, ...] = ()
    settings: Any = None
    sampler_pixels: float = GPU_SAMPLER_PIXELS
    places: Places | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """(h, w) of the result."""
        return self.shown_size[::-1] if self.places is None else self.places.pixels.shape[:2]

    def directions(self, view: View) -> Array:
        """(h, w, 3) directions in the world that `view`, of the shown size, looks in."""
        return world_directions(view, self.shown_size, None if self.places is None else self.places.pixels)

    def tangents(self) -> Array:
        """(h, w) complex: the tangents that the shown view looks along."""
        rays = rays_through(
            self.shown, self.shown_size, pixel_centres(self.shown_size) if self.places is None else self.places.pixels
        )
        return rays[..., :2] @ (1, 1j)

    def map_error(self, warp: WarpMap, inverse_depth: Array) -> Array:
        """(h, w): how far a shader's rendered pixels may be off, see pixel_error_bound."""
        return pixel_error_bound(warp, self.shown_size, inverse_depth, self.places)

    def own_depth(self) -> Array:
        """(h, w): the client's own inverse depth at the nearest pixel of each place.

        -1 beside the shown picture.
        """
        if self.places is None:
            return self.client_inverse_depth
        place = np.nan_to_num(self.places.pixels, nan=-1.0, posinf=-1.0, neginf=-1.0)
        nearest = np.floor(np.clip(place, -1, np.array(self.shown_size))).astype(int)
        return np.pad(self.client_inverse_depth, 1, constant_values=-1)[nearest[..., 1] + 1, nearest[..., 0] + 1]

    def at_centres(self) -> TwinInputs:
        """The same for the centres of the shown pixels that its places lie in."""
        if self.places is None:
            return self
        return attrs.evolve(self, places=attrs.evolve(self.places, pixels=np.floor(self.places.pixels) + 0.5))

    def near_another_pixel(self) -> Array:
        """(h, w). Whether a place lies within its error of another pixel, whose depth a shader may
        then take."""
        if self.places is None:
            return np.zeros(self.shape, bool)
        from_border = np.abs(self.places.pixels - np.round(self.places.pixels)).min(axis=-1)
        return from_border <= self.places.error

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) of the rendered picture."""
        return self.colour.shape[1::-1]

    def look(self, pixels: Array, position_error: Array, least: float = 0.5) -> ReferencePicture:
        """The colour at `pixels`, sampled as the settings say; see sample_covered."""
        if getattr(self.settings, "resample", "bilinear") == "catmull-rom":
            return sample_cubic(self.colour, pixels, position_error, least)
        return sample_covered(self.colour, pixels, position_error, self.sampler_pixels, least)


@attrs.frozen(eq=False)
class ReferencePicture:
    """colour (h, w, 4) with coverage in alpha, bottom row first.

    Tolerance (h, w), absolute, for the three colours; undecided (h, w): pixels whose coverage or
    source a rounding error within the bound may change. inverse_depth (h, w): in the shown view,
    where the warp finds one by itself, and how far it may be off; None where it does not.
    """

    colour: Array
    tolerance: Array
    undecided: NDArray[np.bool_]
    inverse_depth: tuple[Array, Array] | None = None


def sample_covered(
    colour: Array, pixels: Array, position_error: Array, sampler_pixels: float = GPU_SAMPLER_PIXELS, least: float = 0.5
) -> ReferencePicture:
    """Bilinear look at `pixels` (h, w, 2) of a premultiplied picture, by SciPy's interpolation,
    averaged over what is covered.

    position_error (h, w): pixels; sampler_pixels: what the sampler adds to it; least: the weight of
    covered texels from which the result counts as covered. The colour may be off by the place's
    error times the steepest change nearby, over the coverage it is normalised with, and by the
    rounding of the stored result.
    """
    outside = ~((pixels >= 0) & (pixels < np.array(colour.shape[1::-1]))).all(axis=-1)
    place = np.where(np.isnan(pixels), 0.0, pixels) - 0.5
    coords = [place[..., 1], place[..., 0]]
    looked = np.stack(
        [ndimage.map_coordinates(colour[..., c], coords, order=1, mode="nearest") for c in range(4)], axis=-1
    )
    alpha = looked[..., 3]
    covered = (alpha >= least) & (alpha > 0) & ~outside
    out = np.zeros_like(looked)
    out[covered] = np.concatenate(
        [looked[covered][:, :3] / alpha[covered][:, None], np.ones((covered.sum(), 1))], axis=1
    )

    error = np.minimum(position_error + sampler_pixels, _ANYWHERE)
    slope = _contrast_near(colour, coords) * 2 * error[..., None]  # both axes
    brightest = np.abs(out[..., :3]).max(axis=-1)
    tolerance = (slope[..., :3].max(axis=-1) + brightest * slope[..., 3]) / np.maximum(alpha - slope[..., 3], 1e-3)
    tolerance += HALF_UNIT * brightest + HALF_SMALLEST
    undecided = (np.abs(alpha - least) <= slope[..., 3]) | near_edge(pixels, colour.shape[1::-1], position_error)
    return ReferencePicture(out, tolerance, undecided)


ON_A_CENTRE = 1 / 1024  # pixels: so near to a texel's centre a cubic look takes that texel


def sample_cubic(colour: Array, pixels: Array, position_error: Array, least: float = 0.5) -> ReferencePicture:
    """As sample_covered, by cubic Hermite curves where twelve texels around, all of 4 x 4 but the
    corners, are covered; between the four outer ones linear.

    A curve has at each texel the slope between its neighbours, and stays between the two texels
    that it joins; first along rows, then across them. It is nowhere steeper than 1.5 times the
    contrast of its four texels, which one across the rows amplifies by the 1.25 that its weights'
    absolute values sum to: so a look `e` beside along both axes differs by less than 1.25 * 1.5 +
    1.5 < 4 e times the contrast, continuously from texel to texel. 64 units of the brightest texel
    nearby cover the rounding of two sums of four products.
    """
    high, wide = colour.shape[:2]
    near = ON_A_CENTRE + 4 * FLOAT32_UNIT * max(high, wide)
    plain = sample_covered(colour, pixels, position_error, near, least)
    known = np.where(np.isnan(pixels), 0.5, pixels)
    given = np.clip(known, 0.5, np.array([wide, high]) - 0.5) - 0.5
    off_centre = np.abs(given - np.round(given))
    place = np.where(off_centre < ON_A_CENTRE, np.round(given), given)
    low = np.floor(place).astype(int)
    x, y = (np.clip(low[..., k, None] + np.arange(-1, 3), 0, n - 1) for k, n in enumerate((wide, high)))
    around = colour[y[..., :, None], x[..., None, :]]  # (.., 4 rows, 4 columns, 4)
    part = place - low
    across = part[..., 0, None]
    inner = _hermite(np.moveaxis(around[..., 1:3, :, :], -2, 0), across[..., None])
    outer = around[..., ::3, 1, :] * (1 - across[..., None]) + around[..., ::3, 2, :] * across[..., None]
    rows = np.stack([outer[..., 0, :], inner[..., 0, :], inner[..., 1, :], outer[..., 1, :]], axis=-2)
    curved = _hermite(np.moveaxis(rows, -2, 0), part[..., 1, None])

    error = np.minimum(position_error + near, _ANYWHERE)
    covered = ndimage.minimum_filter(colour[..., 3], size=5, mode="nearest")
    coords = [place[..., 1], place[..., 0]]
    in_middle = _near(covered, coords) >= 1
    least_covered = np.minimum(around[..., 1:3, :, 3].min(axis=(-1, -2)), around[..., :, 1:3, 3].min(axis=(-1, -2)))
    sharp = (least_covered >= 1) & (plain.colour[..., 3] > 0)
    brightest = _near(ndimage.maximum_filter(np.abs(colour).max(axis=-1), size=5, mode="nearest"), coords)
    tolerance = 4 * error * _contrast_near(colour, coords)[..., :3].max(axis=-1)
    tolerance += (HALF_UNIT + 64 * FLOAT32_UNIT) * brightest + HALF_SMALLEST
    # Beyond a line of texel centres other twelve texels count: with a hole only there, the look
    # turns bilinear at once.
    on_a_line = (np.abs(off_centre - ON_A_CENTRE) <= (error - ON_A_CENTRE)[..., None]).any(axis=-1)
    return ReferencePicture(
        np.where(
            sharp[..., None], np.concatenate([curved[..., :3], np.ones((*sharp.shape, 1))], axis=-1), plain.colour
        ),
        np.where(sharp, tolerance, plain.tolerance),
        plain.undecided | (on_a_line & ~in_middle & (plain.colour[..., 3] > 0)),
    )


def _hermite(four: Array, t: Array) -> Array:
    """The curve from the second to the third of four values, along the first axis."""
    before, start, end, after = four
    slopes = (end - before) / 2, (after - start) / 2
    back = 1 - t
    curve = (1 + 2 * t) * back**2 * start + t * back**2 * slopes[0] + t**2 * (3 - 2 * t) * end - t**2 * back * slopes[1]
    return np.clip(curve, np.minimum(start, end), np.maximum(start, end))


def near_edge(pixels: Array, size: tuple[int, int], error: Array) -> NDArray[np.bool_]:
    """Whether a place lies within its error of the picture's border, or is not known at all."""
    wide, high = size
    distance = np.minimum(np.abs(pixels - 0), np.abs(pixels - np.array([wide, high]))).min(axis=-1)
    return (distance <= error) | ~np.isfinite(error)


def _contrast_near(colour: Array, coords: list[Array]) -> Array:
    """Largest difference within the 4x4 texels around each place, per channel. Bounds the slope a
    moved look can meet."""
    spread = ndimage.maximum_filter(colour, size=(5, 5, 1), mode="nearest") - ndimage.minimum_filter(
        colour, size=(5, 5, 1), mode="nearest"
    )
    return _near(spread, coords)


def _near(field: Array, coords: list[Array]) -> Array:
    """Its value at the texel nearest to each place."""
    y, x = (np.clip(np.round(c).astype(int), 0, n - 1) for c, n in zip(coords, field.shape, strict=False))
    return field[y, x]
