"""Twin of the multi warp: every ray against every rendered picture. Depth, then confidence, then
the newer decides."""

from __future__ import annotations

import numpy as np

from hmdwarp.geometry import WarpMap
from reference._meeting import DEPTH_FLOOR, DEPTH_TOLERANCE, Mask, Meetings, Rays, is_depth, met_by
from reference._rays import FLOAT32_UNIT, Array, project, world_directions
from reference.picture import ReferencePicture, RenderedPicture, TwinInputs

GAIN = 1.25
CLOSE = 64 * FLOAT32_UNIT  # Depths and ratios are some ten float32 operations from exact


def multi(inputs: TwinInputs) -> ReferencePicture:
    """The newest picture, then the others in turn. An eye that has not moved and sees no more than
    before gets the newest alone."""
    newest = RenderedPicture(inputs.colour, inputs.inverse_depth, inputs.rendered)
    shape = inputs.shown_size[::-1]
    colour, tolerance = np.zeros((*shape, 4)), np.zeros(shape)
    depth, confidence, undecided = np.full(shape, -1.0), np.full(shape, -1.0), np.zeros(shape, bool)
    for number, picture in enumerate((newest, *(() if _is_unmoved(inputs) else inputs.others))):
        one = met_by(picture, inputs.shown, inputs.shown_size, inputs.sampler_pixels)
        found, looked, sure = one.meetings, one.looked, _confidence(one.rays, one.meetings.depth)
        better, unsure = _is_better(found.depth, sure, depth, confidence)
        # Where even the nearest guess would not be better than what is there, no surface is looked
        # for.
        worth, unsure_worth = _is_better(one.nearest_guess, _confidence(one.rays, one.nearest_guess), depth, confidence)
        if number > 0:
            gone, unsure_gone = _is_contradicted(inputs, newest, found)
            better, unsure = better & ~gone, unsure | unsure_gone
        shows = found.met & better & worth & (looked.colour[..., 3] > 0)
        sought = worth | unsure_worth
        undecided |= sought & (found.undecided | (found.met & (looked.undecided | unsure | unsure_worth)))
        colour[shows], tolerance[shows] = looked.colour[shows], looked.tolerance[shows]
        depth[shows], confidence[shows] = found.depth[shows], sure[shows]
    return ReferencePicture(colour, tolerance, undecided)


def _is_unmoved(inputs: TwinInputs) -> bool:
    back = WarpMap.between(inputs.shown, inputs.shown_size, inputs.rendered, inputs.size)
    low = np.round(back.H[:2, 2])
    return back.moves_whole_pixels() and bool((low >= 0).all() and (low + inputs.shown_size <= inputs.size).all())


def _confidence(rays: Rays, depth: Array) -> Array:
    """How densely the picture sampled a place on the ray. By how much nearer it is to its eye than
    to the shown one."""
    moved = rays.shown.pose.position_m - rays.view.pose.position_m
    points = np.maximum(depth, 0)
    ratio = project(world_directions(rays.shown, rays.shown_size), moved, points, rays.view, rays.size)[2]
    with np.errstate(divide="ignore"):
        return 1 / np.where(depth >= 0, ratio, 1)


def _is_better(depth: Array, sure: Array, depth_before: Array, sure_before: Array) -> tuple[Mask, Mask]:
    """Whether one stands before another, and whether that is a close call."""
    apart, larger = np.abs(depth - depth_before), np.maximum(depth, depth_before)
    limit = DEPTH_TOLERANCE * (larger + DEPTH_FLOOR)
    alike = apart <= limit
    better = np.where(alike, sure > GAIN * sure_before, depth > depth_before)
    close = (np.abs(apart - limit) <= CLOSE * larger) | (alike & (np.abs(sure - GAIN * sure_before) <= CLOSE * sure))
    nothing = depth_before < 0
    return nothing | better, ~nothing & close


def _is_contradicted(inputs: TwinInputs, newest: RenderedPicture, found: Meetings) -> tuple[Mask, Mask]:
    """Whether the newest picture, at the pixel in which the found point appears there, holds
    something farther; and close calls."""
    moved, size = inputs.shown.pose.position_m - newest.view.pose.position_m, inputs.size
    points = np.where(found.met, found.depth, 0)
    pixels, expected, w = project(world_directions(inputs.shown, inputs.shown_size), moved, points, newest.view, size)
    error = Rays.between(inputs.shown, inputs.shown_size, newest.view, size).error(points) + found.place_error
    inside = (w > 0) & ((pixels >= 0) & (pixels < np.array(size))).all(axis=-1)
    x, y = np.floor(np.where(inside[..., None], pixels, 0)).astype(int).transpose(2, 0, 1)
    held = newest.inverse_depth[y, x]
    nearer, limit = expected - held, DEPTH_TOLERANCE * (expected + DEPTH_FLOOR)
    close = np.abs(nearer - limit) <= CLOSE * (np.abs(held) + expected)
    close |= (np.abs(pixels - np.round(pixels)).min(axis=-1) <= error) | (np.abs(w) <= CLOSE)
    return inside & is_depth(held) & (nearer > limit), np.nan_to_num(close, nan=1).astype(bool)
