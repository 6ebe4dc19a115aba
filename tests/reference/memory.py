"""Twins of the fills that gather from other pictures, and of what makes the memory forget.

Rays and points through the world, sorting.
"""

from __future__ import annotations

import attrs
import numpy as np
from scipy import ndimage

from hmdwarp.geometry import View, WarpMap
from reference._meeting import DEPTH_FLOOR, Found, Mask, Rays, first_of, guesses, meet
from reference._rays import FLOAT32_UNIT, Array, pixel_error_bound, project, world_directions
from reference.multi import _confidence, _is_better
from reference.picture import ReferencePicture, RenderedPicture, sample_covered

SETTLED = 1e30  # a depth that nothing stands before
LARGEST = 65504.0  # of a half float
TOLERANCE, COLOUR_MARGIN = 0.05, (0.08, 0.25)


@attrs.frozen(eq=False)
class Filled:
    """picture: as a warp's; inverse_depth (h, w), -1 where nothing is known."""

    picture: ReferencePicture
    inverse_depth: Array


def fill_from(
    colour: Array,
    inverse_depth: Array,
    shown: View,
    pictures: tuple[RenderedPicture, ...],
    *,
    newest: bool,
    sampler_pixels: float,
    cell: int = 1,
    halved: bool = False,
) -> Filled:
    """The shown picture, its holes filled from `pictures` in turn.

    newest: the first of them is not overruled by the others. cell: shown pixels on each axis that
    share their guesses. halved: guesses come from the nearest of each 2 x 2 pixels alone.
    """
    high, wide = colour.shape[:2]
    out, depth_out, tolerance = colour.copy(), inverse_depth.copy(), np.zeros((high, wide))
    empty = colour[..., 3] == 0
    depth, confidence, undecided = np.full((high, wide), -1.0), np.zeros((high, wide)), np.zeros((high, wide), bool)
    for number, picture in enumerate(pictures):
        guessed = attrs.evolve(picture, inverse_depth=_nearest_of_blocks(picture.inverse_depth)) if halved else picture
        one = _met_by(picture, guessed, shown, (wide, high), cell, sampler_pixels)
        found, sure = one.meetings, _confidence(one.rays, one.meetings.depth)
        better, unsure = _is_better(found.depth, sure, depth, confidence)
        worth, unsure_worth = _is_better(one.nearest_guess, _confidence(one.rays, one.nearest_guess), depth, confidence)
        shows = empty & found.met & (found.depth <= LARGEST) & better & worth & (one.looked.colour[..., 3] > 0)
        sought = worth | unsure_worth
        doubt = found.undecided | (found.met & (one.looked.undecided | unsure | unsure_worth))
        undecided |= empty & sought & doubt
        out[shows], tolerance[shows], depth_out[shows] = (
            one.looked.colour[shows],
            one.looked.tolerance[shows],
            found.depth[shows],
        )
        depth[shows] = SETTLED if newest and number == 0 else found.depth[shows]
        confidence[shows] = sure[shows]
    return Filled(ReferencePicture(out, tolerance, undecided), depth_out)


def _nearest_of_blocks(depth: Array) -> Array:
    """Half the size, rounded up; a last column or row that is alone counts twice."""
    high, wide = depth.shape
    even = np.pad(depth, ((0, high % 2), (0, wide % 2)), mode="edge")
    return even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2).max(axis=(1, 3))


def _met_by(
    picture: RenderedPicture,
    guessed: RenderedPicture,
    shown: View,
    size: tuple[int, int],
    cell: int,
    sampler_pixels: float,
) -> Found:
    """As _meeting.met_by, with guesses for cells of the shown picture instead of its pixels."""
    cells = (-(-size[0] // cell), -(-size[1] // cell))
    rays = Rays.between(shown, size, picture.view, picture.inverse_depth.shape[1::-1])
    tried, unsure = guesses(guessed, shown, cells)
    column, row = (np.floor((np.arange(n) + 0.5) * c / n).astype(int) for n, c in zip(size, cells, strict=True))
    here = np.ix_(row, column)
    found = first_of([meet(picture, rays, guess[here]) for guess in tried])
    found = attrs.evolve(found, undecided=found.undecided | unsure[here])
    looked = sample_covered(
        picture.colour, np.where(found.met[..., None], found.look, np.nan), found.place_error, sampler_pixels
    )
    return Found(rays, tried[0][here], found, attrs.evolve(looked, undecided=looked.undecided & found.met))


def forgotten(kept: RenderedPicture, rendered: RenderedPicture) -> tuple[Mask, Mask]:
    """Which pixels of a kept picture the newest one disproves, and which are too close to call.

    Each kept pixel is a point in the world; the newest picture's extremes around where it sees that
    point come from rank filters.
    """
    size = rendered.inverse_depth.shape[1::-1]
    known = kept.inverse_depth >= 0
    moved = kept.view.pose.position_m - rendered.view.pose.position_m
    points = np.where(known, kept.inverse_depth, 0)
    pixels, expected, w = project(world_directions(kept.view, size), moved, points, rendered.view, size)
    inside = known & (w > 0) & ((pixels >= 0) & (pixels < np.array(size))).all(axis=-1)
    error = pixel_error_bound(WarpMap.between(kept.view, size, rendered.view, size), size, points)
    x, y = np.floor(np.where(inside[..., None], pixels, 0)).astype(int).transpose(2, 0, 1) // 2
    nearest, farthest, low, high = (field[y, x] for field in _extremes(rendered))
    limit = TOLERANCE * (expected + DEPTH_FLOOR)
    same = (nearest <= expected + limit) & (farthest >= expected - limit)
    margin = COLOUR_MARGIN[0] + COLOUR_MARGIN[1] * high
    own = kept.colour[..., :3]
    recoloured = ((own < low - margin) | (own > high + margin)).any(axis=-1)
    gone = inside & ((nearest < expected - limit) | (same & recoloured))
    # Another cell may be looked at within the pixel's error of an even border; limits within
    # rounding are close calls.
    border = np.abs(pixels / 2 - np.round(pixels / 2)).min(axis=-1) * 2
    unit = 64 * FLOAT32_UNIT * (expected + 1)
    close = np.minimum.reduce(
        [np.abs(nearest - expected - limit), np.abs(farthest - expected + limit), np.abs(nearest - expected + limit)]
    )
    near_margin = np.minimum(np.abs(own - low + margin), np.abs(own - high - margin)).min(axis=-1) <= 2.0**-9 * (
        1 + high.max(axis=-1)
    )
    unsure = (border <= error) | (close <= unit) | near_margin | (np.abs(w) <= unit)
    return gone, known & np.nan_to_num(unsure, nan=1).astype(bool)


def _extremes(rendered: RenderedPicture) -> tuple[Array, Array, Array, Array]:
    """Per cell of 2 x 2 pixels with one more around.

    Nearest (infinite if any is unknown) and farthest depth, lowest and highest colour.
    """
    depth = rendered.inverse_depth
    window = {"size": 4, "mode": "nearest", "origin": -1}  # from one before an even pixel to two after it
    low, high = (
        np.stack([extreme(rendered.colour[..., c], **window)[::2, ::2] for c in range(3)], axis=-1)
        for extreme in (ndimage.minimum_filter, ndimage.maximum_filter)
    )
    nearest = ndimage.maximum_filter(np.where(depth >= 0, depth, np.inf), **window)
    return nearest[::2, ::2], ndimage.minimum_filter(depth, **window)[::2, ::2], low, high
