"""Twins of the gather warps: none, shift, rotation, similarity, planar, backward."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp.geometry import Pose, View, WarpMap
from reference._rays import FLOAT32_UNIT, Array, Places, pixel_centres, pixel_error_bound, project
from reference.picture import ReferencePicture, TwinInputs, near_edge


def none(inputs: TwinInputs) -> ReferencePicture:
    """The rendered picture at the same angles from the view axis."""
    return _through_infinity(inputs, View(inputs.rendered.pose, inputs.shown.fov))


def shift(inputs: TwinInputs) -> ReferencePicture:
    """The same tangents from the middle of the view, which is where its direction was drawn."""
    return _from_the_middle(inputs, 0.0, lambda ring, seen: 1.0 + 0j)


def similarity(inputs: TwinInputs) -> ReferencePicture:
    """A turn and scale about the middle of the view, fitted to rays close around it that meet the
    plane at the median depth."""
    r = median_inverse_depth(inputs.inverse_depth)
    return _from_the_middle(inputs, r, lambda ring, seen: (ring.conj() @ seen) / (ring.conj() @ ring))


RING = 1e-4 * np.exp(2j * np.pi * np.arange(12) / 12)  # tangents; third derivatives enter by its square


def _from_the_middle(inputs: TwinInputs, r: float, fitted) -> ReferencePicture:
    """fitted: the complex factor, from tangents around the middle and what they become."""
    shown, rendered = inputs.shown, inputs.rendered
    left, right, down, up = shown.fov.tangents
    middle = complex(left + right, down + up) / 2
    moved = (shown.pose.position_m - rendered.pose.position_m) * (r > 0)
    tangents = middle + np.array([0, *RING])
    rays = np.stack([tangents.real, tangents.imag, -np.ones(len(tangents))], axis=-1)
    rays = rays @ shown.pose.rotation.as_matrix().T
    axis = rendered.pose.rotation.as_matrix() @ np.array([0.0, 0.0, -1.0])
    past = 1 - r * (axis @ moved)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse_length = (rays @ axis) * r / past
        pixels, _, _ = project(rays, moved, inverse_length, rendered, inputs.size)
        ahead = ((rays @ axis) / past > 0)[0]
    left, right, down, up = rendered.fov.tangents
    per_tangent = np.array(inputs.size) / (right - left, up - down)
    seen = (pixels - pixels[0]) / per_tangent @ (1, 1j)
    factor = fitted(RING, seen[1:])
    own = inputs.tangents() - middle
    places = pixels[0] + np.stack([(factor * own).real, (factor * own).imag], axis=-1) * per_tangent
    places = np.where(ahead, places, np.nan)
    bound = _middle_bound(inputs, r, moved, past)
    return inputs.look(places, bound)


def _middle_bound(inputs: TwinInputs, r: float, moved: Array, past: float) -> Array:
    """That of the planar map at the middle, with its derivative off by 32 units in each pixel from
    there."""
    given = inputs.places or Places(pixel_centres(inputs.shown_size))
    middle = np.array(inputs.shown_size) / 2
    from_middle = np.linalg.norm(np.nan_to_num(given.pixels) - middle, axis=-1)
    error = np.asarray(given.error) + 32 * FLOAT32_UNIT * from_middle
    at = Places(np.broadcast_to(middle, given.pixels.shape), error, given.rounding)
    warp = WarpMap.between(inputs.shown, inputs.shown_size, inputs.rendered, inputs.size)
    bound = pixel_error_bound(warp, inputs.shown_size, np.full(inputs.shape, r), at)
    return 4 * bound * (1 + 2 * r * np.linalg.norm(moved)) / max(abs(past), 1e-6)


def rotation(inputs: TwinInputs) -> ReferencePicture:
    """Each shown pixel's direction, looked up in the rendered picture."""
    shown = inputs.shown
    clamped = inputs.settings is not None and inputs.settings.edge == "clamp"
    return _through_infinity(
        inputs, View(Pose(inputs.rendered.pose.position_m, shown.pose.orientation_xyzw), shown.fov), clamped
    )


def _through_infinity(inputs: TwinInputs, shown: View, clamped: bool = False) -> ReferencePicture:
    size, rendered = inputs.size, inputs.rendered
    far = np.zeros(inputs.shape)
    pixels, _, _ = project(inputs.directions(shown), np.zeros(3), far, rendered, size)
    bound = inputs.map_error(WarpMap.between(shown, inputs.shown_size, rendered, size), far)
    if not clamped:
        return inputs.look(pixels, bound)
    # In a picture that repeats its border the place is the same one, moved inwards; moving two
    # places to the nearest of a box never takes them apart, so the bound holds.
    return inputs.look(np.clip(pixels, 0.5, np.array(size) - 0.5), bound)


def median_inverse_depth(inverse_depth: Array, grid: int = 64) -> float:
    """The lower median over the grid of samples that the shader takes; 0 if none has depth."""
    high, wide = inverse_depth.shape
    x, y = ((2 * np.arange(grid) + 1) * n // (2 * grid) for n in (wide, high))
    samples = np.sort(inverse_depth[np.ix_(y, x)].ravel())
    samples = samples[samples >= 0]
    return float(samples[(len(samples) + 1) // 2 - 1]) if len(samples) else 0.0


def planar(inputs: TwinInputs) -> ReferencePicture:
    """Each shown ray, met with the plane at the median depth before the rendered eye."""
    rendered, shown, shown_size, size = inputs.rendered, inputs.shown, inputs.shown_size, inputs.size
    r = median_inverse_depth(inputs.inverse_depth)
    rays = inputs.directions(shown)
    moved = shown.pose.position_m - rendered.pose.position_m
    # Along the rendered eye's axis the ray has climbed (axis . ray) per unit length; it meets the
    # plane at depth 1/r after length t with axis . (moved + t ray) = 1/r. As inverse lengths, so
    # that r = 0 needs no case: 1/t = (axis . ray) r / (1 - r axis . moved).
    axis = rendered.pose.rotation.as_matrix() @ np.array([0.0, 0.0, -1.0])
    past = 1 - r * (axis @ moved)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse_length = (rays @ axis) * r / past
        pixels, _, _ = project(rays, moved, inverse_length, rendered, size)
        towards = (rays @ axis) / past > 0
    pixels = np.where(towards[..., None], pixels, np.nan)
    bound = inputs.map_error(
        WarpMap.between(shown, shown_size, rendered, size), np.abs(np.nan_to_num(inverse_length, posinf=0, neginf=0))
    )
    # The shader's form cancels by up to 1 + 2 r |moved| before it divides by past.
    grown = 4 * bound * (1 + 2 * r * np.linalg.norm(moved)) / max(abs(past), 1e-6)
    return inputs.look(pixels, grown)


def backward(inputs: TwinInputs) -> ReferencePicture:
    """Each shown point, looked up in the rendered picture where the rendered depth there agrees
    with the point's own; without the test, wherever it is in the picture.

    Depth is known at the centres of the shown pixels, so it is compared where they appear, wherever
    the colour is looked for.
    """
    rendered, shown, shown_size, size, settings = (
        inputs.rendered, inputs.shown, inputs.shown_size, inputs.size, inputs.settings,
    )  # fmt: skip
    own = inputs.own_depth()
    known = own >= 0
    own = np.where(known, own, 0)
    moved = shown.pose.position_m - rendered.pose.position_m
    pixels, _, _ = project(inputs.directions(shown), moved, own, rendered, size)
    centres, expected, _ = project(inputs.at_centres().directions(shown), moved, own, rendered, size)
    both_ahead = known & ~np.isnan(pixels).any(axis=-1) & ~np.isnan(centres).any(axis=-1)
    pixels = np.where(both_ahead[..., None], pixels, np.nan)
    bound = inputs.map_error(WarpMap.between(shown, shown_size, rendered, size), own)
    if settings.test == "off":
        looked = inputs.look(pixels, bound)
        unsure = (looked.undecided & known) | inputs.near_another_pixel()
        return attrs.evolve(looked, undecided=unsure, inverse_depth=(own, np.zeros(own.shape)))
    at, agree, undecided = _where_depth_agrees(
        inputs.inverse_depth, pixels, centres, expected, bound, settings.tolerance, settings.floor
    )
    looked = inputs.look(np.where(agree[..., None], at, np.nan), bound, least=0.0)
    outside = ~((pixels >= 0) & (pixels < np.array(size))).all(axis=-1)
    looked.colour[outside] = 0
    edge = near_edge(pixels, size, bound) & known
    undecided = (undecided & known & ~outside) | edge | inputs.near_another_pixel()
    return ReferencePicture(looked.colour, looked.tolerance, undecided, (own, np.zeros(own.shape)))


def _where_depth_agrees(
    inverse_depth: Array, pixels: Array, centres: Array, expected: Array, error: Array, tolerance: float, floor: float
):
    """The place, or the centre of the one of two texels that agrees; whether any agrees.

    Where rounding may decide.

    The two texels: the one that the centre of the shown pixel falls into, and of the other three of
    the place's bilinear footprint the one not beside it.
    """
    corner = np.floor(np.nan_to_num(pixels) - 0.5).astype(int)
    texel = np.floor(np.nan_to_num(centres)).astype(int)
    across = 2 * corner + 1 - texel
    near, near_close = _agrees(inverse_depth, texel, expected, tolerance, floor)
    far, far_close = _agrees(inverse_depth, across, expected, tolerance, floor)
    at = np.where((near & far)[..., None], pixels, np.where(near[..., None], texel, across) + 0.5)
    # The centre may fall into the next texel, or the place into the other half of its own, where
    # the other three texels are others.
    within = np.nan_to_num(centres) - texel
    from_border = np.minimum(within, 1 - within).min(axis=-1) <= error
    middle = np.nan_to_num(pixels) - np.round(np.nan_to_num(pixels) - 0.5) - 0.5
    from_middle = np.abs(middle).min(axis=-1) <= error
    return at, near | far, near_close | far_close | from_border | from_middle


def _agrees(inverse_depth: Array, texel: Array, expected: Array, tolerance: float, floor: float):
    """Whether the texel lies inside the picture and holds the expected depth. And whether that is a
    close call."""
    most = np.array(inverse_depth.shape[1::-1]) - 1
    clipped = np.clip(texel, 0, most)
    inside = (texel == clipped).all(axis=-1)
    held = inverse_depth[clipped[..., 1], clipped[..., 0]]
    limit = tolerance * (np.nan_to_num(expected) + floor)
    difference = np.abs(held - expected)
    # 16 u covers the division by w and the products of the comparison, relative to the larger of
    # both depths.
    close = np.abs(difference - limit) <= 16 * FLOAT32_UNIT * (np.abs(held) + np.nan_to_num(expected) + limit) + 1e-30
    return inside & (difference <= limit), inside & close
