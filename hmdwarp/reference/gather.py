"""Twins of the gather warps: none, rotation, planar, backward."""

from __future__ import annotations

import numpy as np

from ..geometry import Pose, View, WarpMap
from ._rays import Array, pixel_error_bound, project, world_directions
from .picture import GPU_SAMPLER_PIXELS, ReferencePicture, near_edge, sample_covered


def none(colour: Array, inverse_depth: Array, late: View, shown: View, shown_size: tuple[int, int], *, sampler_pixels: float = GPU_SAMPLER_PIXELS, **_: object) -> ReferencePicture:
    """The late picture at the same angles from the view axis."""
    return _through_infinity(colour, late, View(late.pose, shown.fov), shown_size, sampler_pixels)


def rotation(colour: Array, inverse_depth: Array, late: View, shown: View, shown_size: tuple[int, int], *, sampler_pixels: float = GPU_SAMPLER_PIXELS, **_: object) -> ReferencePicture:
    """Each shown pixel's direction, looked up in the late picture."""
    return _through_infinity(colour, late, View(Pose(late.pose.position_m, shown.pose.orientation_xyzw), shown.fov), shown_size, sampler_pixels)


def _through_infinity(colour: Array, late: View, shown: View, shown_size: tuple[int, int], sampler_pixels: float) -> ReferencePicture:
    size = colour.shape[1::-1]
    far = np.zeros(shown_size[::-1])
    pixels, _, _ = project(world_directions(shown, shown_size), np.zeros(3), far, late, size)
    return sample_covered(colour, pixels, pixel_error_bound(WarpMap.between(shown, shown_size, late, size), shown_size, far), sampler_pixels)


def median_inverse_depth(inverse_depth: Array, grid: int = 64) -> float:
    """The lower median over the grid of samples that the shader takes; 0 if none has depth."""
    high, wide = inverse_depth.shape
    x, y = ((2 * np.arange(grid) + 1) * n // (2 * grid) for n in (wide, high))
    samples = np.sort(inverse_depth[np.ix_(y, x)].ravel())
    samples = samples[samples >= 0]
    return float(samples[(len(samples) + 1) // 2 - 1]) if len(samples) else 0.0


def planar(colour: Array, inverse_depth: Array, late: View, shown: View, shown_size: tuple[int, int], *, sampler_pixels: float = GPU_SAMPLER_PIXELS, **_: object) -> ReferencePicture:
    """Each shown ray, met with the plane at the median depth before the late eye."""
    size, r = colour.shape[1::-1], median_inverse_depth(inverse_depth)
    rays = world_directions(shown, shown_size)
    moved = shown.pose.position_m - late.pose.position_m
    # Along the late eye's axis the ray has climbed (axis . ray) per unit length; it meets the plane at depth 1/r after
    # length t with axis . (moved + t ray) = 1/r. As inverse lengths, so that r = 0 needs no case: 1/t = (axis . ray) r / (1 - r axis . moved).
    axis = late.pose.rotation.as_matrix() @ np.array([0.0, 0.0, -1.0])
    past = 1 - r * (axis @ moved)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse_length = (rays @ axis) * r / past
        pixels, _, _ = project(rays, moved, inverse_length, late, size)
        towards = (rays @ axis) / past > 0
    pixels = np.where(towards[..., None], pixels, np.nan)
    bound = pixel_error_bound(WarpMap.between(shown, shown_size, late, size), shown_size, np.abs(np.nan_to_num(inverse_length, posinf=0, neginf=0)))
    # The Sherman-Morrison form cancels by up to 1 + 2 r |moved| before it divides by past.
    return sample_covered(colour, pixels, 4 * bound * (1 + 2 * r * np.linalg.norm(moved)) / max(abs(past), 1e-6), sampler_pixels)


def backward(
    colour: Array,
    inverse_depth: Array,
    late: View,
    shown: View,
    shown_size: tuple[int, int],
    client_inverse_depth: Array,
    tolerance: float,
    floor: float,
    sampler_pixels: float = GPU_SAMPLER_PIXELS,
) -> ReferencePicture:
    """Each shown point, looked up in the late picture where the late depth there agrees with the point's own."""
    size = colour.shape[1::-1]
    known = client_inverse_depth >= 0
    own = np.where(known, client_inverse_depth, 0)
    moved = shown.pose.position_m - late.pose.position_m
    pixels, expected, w = project(world_directions(shown, shown_size), moved, own, late, size)
    pixels = np.where(known[..., None], pixels, np.nan)
    bound = pixel_error_bound(WarpMap.between(shown, shown_size, late, size), shown_size, own)
    at, agree, undecided = _where_depth_agrees(inverse_depth, pixels, expected, bound, tolerance, floor)
    looked = sample_covered(colour, np.where(agree[..., None], at, np.nan), bound, sampler_pixels)
    edge = near_edge(pixels, size, bound) & known
    outside = ~((pixels >= 0) & (pixels < np.array(size))).all(axis=-1)
    looked.colour[outside] = 0
    return ReferencePicture(looked.colour, looked.tolerance, (undecided & known & ~outside) | edge | (looked.undecided & agree))


def _where_depth_agrees(inverse_depth: Array, pixels: Array, expected: Array, error: Array, tolerance: float, floor: float):
    """The looked-up place, or the centre of the heaviest agreeing texel; whether any agrees; where rounding may decide."""
    high, wide = inverse_depth.shape
    place = np.nan_to_num(pixels) - 0.5
    corner = np.floor(place)
    fraction = place - corner
    limit = tolerance * (np.nan_to_num(expected) + floor)
    weights, places, close_call = [], [], np.zeros(error.shape, bool)
    for dy in (0, 1):
        for dx in (0, 1):
            x = np.clip(corner[..., 0] + dx, 0, wide - 1).astype(int)
            y = np.clip(corner[..., 1] + dy, 0, high - 1).astype(int)
            difference = np.abs(inverse_depth[y, x] - expected) - limit
            same = difference <= 0
            weights.append(np.where(same, np.abs(1 - dx - fraction[..., 0]) * np.abs(1 - dy - fraction[..., 1]) + 1e-6, 0))
            places.append(corner + 0.5 + np.array([dx, dy]))
            # 16 u covers the division by w and the products of the comparison, relative to the larger of both depths.
            close_call |= np.abs(difference) <= 16 * 2.0**-24 * (np.abs(inverse_depth[y, x]) + np.nan_to_num(expected) + limit) + 1e-30
    weight = np.stack(weights)
    all_agree, agree = (weight > 0).all(axis=0), (weight > 0).any(axis=0)
    best_at = np.take_along_axis(np.stack(places), weight.argmax(axis=0)[None, ..., None], axis=0)[0]
    second, best = np.sort(weight, axis=0)[-2:]
    # A weight moves by at most the place's error on each axis, and so does the other one.
    rivals = (second > 0) & (best - second <= 4 * error + 1e-6)
    texel_edge = np.minimum(fraction, 1 - fraction).min(axis=-1) <= error
    return np.where(all_agree[..., None], pixels, best_at), agree, close_call | (~all_agree & (rivals | texel_edge))
