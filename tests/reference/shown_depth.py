"""Twin of the shown depth. Rendered points put into the world, looked at from the shown eye,
carried along by the warp's own twin."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from reference._rays import project, world_directions
from reference.picture import HALF_UNIT, ReferencePicture, TwinInputs

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
    own, shown = inputs.inverse_depth, inputs.shown
    offset_m = inputs.rendered.pose.position_m - shown.pose.position_m
    rays = world_directions(inputs.rendered, inputs.size)
    _, depth, w = project(rays, offset_m, np.maximum(own, 0), shown, inputs.size)
    known = (own >= 0) & (w > 0) & (np.nan_to_num(depth, nan=np.inf) <= LARGEST_HALF)
    colour = np.zeros((*own.shape, 4))
    colour[known, 0], colour[known, 3] = depth[known], 1
    found = twin(attrs.evolve(inputs, colour=colour))
    stored_once_more = HALF_UNIT * np.abs(found.colour[..., 0])
    return attrs.evolve(found, tolerance=found.tolerance + 2 * stored_once_more)
