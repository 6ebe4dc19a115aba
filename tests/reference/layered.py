"""Twin of the layered warp. Every ray against every layer, the nearest meeting that was uncovered
stays."""

from __future__ import annotations

import numpy as np

from reference._meeting import Mask, Meetings, Rays, is_depth, is_nearer, met_by
from reference.picture import ReferencePicture, RenderedPicture, TwinInputs

BORDER = 1.0  # pixels


def layered(inputs: TwinInputs) -> ReferencePicture:
    """The layers one after the other; of equals the earlier stays."""
    front = RenderedPicture(inputs.colour, inputs.inverse_depth, inputs.rendered)
    shape = inputs.shown_size[::-1]
    colour, tolerance, depth = np.zeros((*shape, 4)), np.zeros(shape), np.full(shape, -1.0)
    undecided = np.zeros(shape, bool)
    for number, layer in enumerate((front, *inputs.layers[: inputs.settings.layers - 1])):
        one = met_by(layer, inputs.shown, inputs.shown_size, inputs.sampler_pixels)
        found, looked = one.meetings, one.looked
        free, unsure = (
            (np.ones(shape, bool), np.zeros(shape, bool)) if number == 0 else _uncovered(front, one.rays, found)
        )
        nearer, close = is_nearer(found.depth, depth)
        # Where even the nearest guess lies behind what is there, no surface is looked for.
        worth, close_guess = is_nearer(one.nearest_guess, depth)
        shows = found.met & free & nearer & worth & (looked.colour[..., 3] > 0)
        # Whatever was uncertain of a layer counts where it might have shown.
        sought = worth | close_guess
        undecided |= sought & (found.undecided | (found.met & (unsure | looked.undecided | close | close_guess)))
        colour[shows], tolerance[shows], depth[shows] = (
            looked.colour[shows],
            looked.tolerance[shows],
            found.depth[shows],
        )
    return ReferencePicture(colour, tolerance, undecided)


def _uncovered(front: RenderedPicture, rays: Rays, found: Meetings) -> tuple[Mask, Mask]:
    """Whether what covers the found place in the visible layer lies on the shown ray within the
    picture, a pixel from its border or more; and where that is uncertain."""
    place = np.where(found.met[..., None], np.nan_to_num(found.place), 0)
    x, y = np.clip(np.floor(place).astype(int), 0, np.array(rays.size) - 1).transpose(2, 0, 1)
    depth = front.inverse_depth[y, x]
    at = rays.start + np.where(is_depth(depth), depth, 0)[..., None] * rays.along
    first, last = np.full(2, BORDER), np.array(rays.size) - BORDER
    inside = ((at >= first) & (at < last)).all(axis=-1)
    error = 2 * found.place_error + rays.error(depth)
    close = np.minimum(np.abs(at - first), np.abs(at - last)).min(axis=-1) <= error
    close |= (np.abs(place - np.round(place)) <= found.place_error[..., None]).any(axis=-1)
    return ~is_depth(depth) | inside, close
