"""Twin of the forward warp: sorts all drawn pixels by where they land and how near they are."""

from __future__ import annotations

import numpy as np

from ..geometry import WarpMap
from ._rays import FLOAT32_UNIT, Array, pixel_error_bound, project, world_directions
from .picture import Asked, ReferencePicture

FARTHEST, NEAREST = 2.0**-20, 2.0**11  # 1/m


def forward(asked: Asked) -> ReferencePicture:
    """Each drawn pixel to the shown pixel it lands in; of several the nearest. Colours are copied.

    Depths that float32 may take for equal are undecided here; tests/client/test_forward.py decides exact ties. As for the shader,
    all that is farther than 1000 km is equally far (the lowest index wins), and all that is nearer than 0.5 mm equally near.
    """
    colour, inverse_depth, size = asked.colour, asked.inverse_depth, asked.size
    late, shown, shown_size = asked.late, asked.shown, asked.shown_size
    drawn = np.isfinite(inverse_depth) & (inverse_depth >= 0)
    own = np.where(drawn, inverse_depth, 0).astype(np.float64)
    moved = late.pose.position_m - shown.pose.position_m
    pixels, shown_depth, w = project(world_directions(late, size), moved, own, shown, shown_size)
    bound = pixel_error_bound(WarpMap.between(late, size, shown, shown_size), size, own)

    flat, depth, error = pixels.reshape(-1, 2), _as_ordered(shown_depth.ravel()), bound.ravel()
    lands = drawn.ravel() & (w.ravel() > 0) & ((flat >= 0) & (flat < np.array(shown_size))).all(axis=1)
    source = np.flatnonzero(lands)
    slot = flat[source, 1].astype(int) * shown_size[0] + flat[source, 0].astype(int)
    order = np.lexsort((source, -depth[source], slot))
    slot, source = slot[order], source[order]
    first = np.r_[True, slot[1:] != slot[:-1]] if len(slot) else np.zeros(0, bool)

    out = np.zeros((shown_size[0] * shown_size[1], 4))
    out[slot[first]] = colour.reshape(-1, 4)[source[first]]
    undecided = _near_ties(slot, depth[source], len(out))
    _mark_near_borders(undecided, flat[drawn.ravel()], error[drawn.ravel()], shown_size)
    shape = shown_size[::-1]
    return ReferencePicture(out.reshape(*shape, 4), np.zeros(shape), undecided.reshape(shape))


def _as_ordered(inverse_depth: Array) -> Array:
    """Inverse depths as far as the order of landings tells them apart."""
    return np.where(inverse_depth < FARTHEST, 0, np.minimum(inverse_depth, NEAREST))


def _near_ties(slot: Array, depth: Array, pixels: int) -> np.ndarray:
    """Shown pixels whose two nearest landings are closer in depth than float32 tells apart, but not infinitely far."""
    marked = np.zeros(pixels, bool)
    if len(slot) > 1:
        same = slot[1:] == slot[:-1]
        difference = depth[:-1] - depth[1:]
        # q and the division each carry their error: 16 u relative, twice.
        close = same & (difference <= 32 * FLOAT32_UNIT * depth[:-1]) & (depth[:-1] > 0)
        marked[slot[1:][close]] = True
    return marked


def _mark_near_borders(marked: np.ndarray, flat: Array, error: Array, shown_size: tuple[int, int]) -> None:
    """Mark both pixels of every landing that lies within its error of a border between pixels."""
    sure = np.isfinite(flat).all(axis=1)
    flat, error = flat[sure], np.minimum(error[sure], 0.5)
    fraction = flat - np.floor(flat)
    close = np.minimum(fraction, 1 - fraction).min(axis=1) <= error
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            reached = np.floor(flat[close] + np.array([dx, dy]) * error[close][:, None]).astype(int)
            within = ((reached >= 0) & (reached < np.array(shown_size))).all(axis=1)
            marked[reached[within, 1] * shown_size[0] + reached[within, 0]] = True
