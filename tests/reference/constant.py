"""Twin of the fill `constant`: NumPy's mean."""

from __future__ import annotations

import numpy as np

from reference._rays import Array


def constant(colour: Array) -> Array:
    """(h, w, 4) with coverage in alpha to the same with the mean of what is covered in every empty
    pixel, black if nothing is.
    """
    covered = colour[..., 3] > 0
    mean = np.append(colour[covered][:, :3].mean(axis=0) if covered.any() else np.zeros(3), 1.0)
    return np.where(covered[..., None], colour, mean)
