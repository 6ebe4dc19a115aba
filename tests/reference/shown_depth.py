"""Twin of the shown depth. Rendered points put into the world, looked at from the shown eye,
carried along by the warp's own twin."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from hmdwarp.geometry import View
from reference._rays import Array, project, world_directions
from reference.picture import HALF_UNIT, ReferencePicture, RenderedPicture, TwinInputs

LARGEST_HALF = 65504.0


def shown_depth(inputs: TwinInputs, twin: Callable[[TwinInputs], ReferencePicture]) -> ReferencePicture:
    """In red, with coverage in alpha: the depth that the warp finds by itself, if it does.

    Else its answer on pictures that hold in red what inverse depth in 1/m each pixel has for the
    shown eye; coverage 0: not known.
    """
    itself = twin(inputs)
    if itself.inverse_depth is not None:
        depth, tolerance = itself.inverse_depth
        covered = itself.colour[..., 3:]
        return attrs.evolve(itself, colour=covered * np.dstack([depth] * 3 + [covered[..., 0]]), tolerance=tolerance)
    own = RenderedPicture(inputs.colour, inputs.inverse_depth, inputs.rendered)
    swapped = attrs.evolve(
        inputs,
        colour=_as_colour(own, inputs.shown),
        layers=tuple(attrs.evolve(layer, colour=_as_colour(layer, inputs.shown)) for layer in inputs.layers),
        others=tuple(attrs.evolve(other, colour=_as_colour(other, inputs.shown)) for other in inputs.others),
    )
    found = twin(swapped)
    stored_once_more = HALF_UNIT * np.abs(found.colour[..., 0])
    return attrs.evolve(found, tolerance=found.tolerance + 2 * stored_once_more)


def _as_colour(picture: RenderedPicture, shown: View) -> Array:
    size = picture.inverse_depth.shape[::-1]
    offset_m = picture.view.pose.position_m - shown.pose.position_m
    _, depth, w = project(
        world_directions(picture.view, size), offset_m, np.maximum(picture.inverse_depth, 0), shown, size
    )
    known = (picture.inverse_depth >= 0) & (w > 0) & (np.nan_to_num(depth, nan=np.inf) <= LARGEST_HALF)
    out = np.zeros((*picture.inverse_depth.shape, 4))
    out[known, 0], out[known, 3] = depth[known], 1
    return out
