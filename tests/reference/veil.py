"""Twin of the pass that lays a veil over the shown picture.

The twin of the warp `iterative` twice, then the sum of the light.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from reference.iterative import iterative
from reference.picture import HALF_UNIT, ReferencePicture, TwinInputs

Array = NDArray[np.float64]


def lay_over(inputs: TwinInputs, passing: Array, behind: Array) -> ReferencePicture:
    """What is shown where nothing that is known stands before the veil.

    Its surface has no stretched sheets and keeps its fringes. inputs: the veil as a rendered
    picture, premultiplied by coverage. passing: (h, w, 3) of the rendered size, 1 where no sheet
    is. behind: (h, w, 4) of the shown size, what the veil is laid over; its holes stay holes.
    """
    inputs = attrs.evolve(inputs, settings=attrs.evolve(inputs.settings, sheet=0.0, fringe="own"))
    covered = inputs.colour[..., 3:]
    stopped = np.concatenate([(1 - passing) * covered, covered], axis=2)
    veil, stops = iterative(inputs), iterative(attrs.evolve(inputs, colour=stopped))
    out = behind.copy()
    shows = (veil.colour[..., 3] > 0) & (behind[..., 3] > 0)
    out[shows, :3] = veil.colour[shows][:, :3] + (1 - stops.colour[shows][:, :3]) * behind[shows][:, :3]
    bright = np.abs(behind[..., :3]).max(axis=-1)
    tolerance = veil.tolerance + bright * stops.tolerance + HALF_UNIT * np.abs(out[..., :3]).max(axis=-1)
    return ReferencePicture(
        out, np.where(shows, tolerance, 0), (veil.undecided | stops.undecided) & (behind[..., 3] > 0)
    )
