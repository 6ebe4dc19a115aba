"""Twins of the forward warps: sort all drawn pixels and paint them one over the other."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import WarpMap
from reference._rays import FLOAT32_UNIT, Array, pixel_error_bound, project, world_directions
from reference.picture import ReferencePicture, TwinInputs

FARTHEST, NEAREST = 2.0**-20, 2.0**11  # 1/m
EPIPOLE_FARTHEST = 2.0**20  # pixels from the picture's middle: the shader's epipole is a whole number


def forward(inputs: TwinInputs) -> ReferencePicture:
    """Each drawn pixel to the shown pixel it lands in; of several the nearest. Colours are copied.

    Depths that float32 may take for equal are undecided here; tests/client/test_forward.py decides
    exact ties. As for the shader, all that is farther than 1000 km is equally far (the lowest index
    wins), and all that is nearer than 0.5 mm equally near.
    """
    landed = _Landings.of(inputs)
    depth = _as_ordered(landed.depth)
    picture = _painted(inputs, landed, np.lexsort((-landed.source, depth)))
    order = np.lexsort((landed.source, -depth, landed.slot))
    picture.undecided.ravel()[:] |= _near_ties(landed.slot[order], depth[order], picture.undecided.size)
    return picture


def forward_raster(inputs: TwinInputs) -> ReferencePicture:
    """Each drawn pixel painted in turn, from the top row of the picture to the bottom one, each
    from left to right."""
    landed = _Landings.of(inputs)
    up, right = np.divmod(landed.source, inputs.size[0])
    return _painted(inputs, landed, np.lexsort((right, -up)))


def forward_ordered(inputs: TwinInputs) -> ReferencePicture:
    """Each drawn pixel painted in turn, in McMillan's order around the shown eye's place in the
    rendered picture."""
    landed = _Landings.of(inputs)
    x0, y0, towards = _epipole(inputs)
    up, right = np.divmod(landed.source, inputs.size[0])
    dx, dy = np.abs(right - x0), np.abs(up - y0)
    last_is_least = -1 if towards else 1
    if inputs.settings.sheets == "rows":
        quadrant = 2 * (up < y0) + (right < x0)
        return _painted(inputs, landed, np.lexsort((quadrant, last_is_least * dx, last_is_least * dy)))
    beside = dx >= dy
    triangle = np.where(beside, right < x0, 2 + (up < y0))
    return _painted(
        inputs, landed, np.lexsort((np.where(beside, up, right), triangle, last_is_least * np.maximum(dx, dy)))
    )


def _epipole(inputs: TwinInputs) -> tuple[int, int, bool]:
    """The rendered pixel that the shown eye appears in, and whether it lies ahead. As angles from
    the rendered eye, not by the warp map."""
    rendered = inputs.rendered
    x, y, z = rendered.pose.rotation.inv().apply(inputs.shown.pose.position_m - rendered.pose.position_m)
    left, right, down, up = rendered.fov.tangents
    middle = np.array([left + right, down + up]) / 2
    per_tangent = inputs.size / np.array([right - left, up - down])
    towards = z <= 0
    # From the picture's middle, in pixels, times the depth: where that is 0 the epipole is at
    # infinity.
    offset = (np.array([x, y]) + z * middle) * per_tangent * (1 if towards else -1)
    scale = max(abs(z), np.hypot(*offset) / EPIPOLE_FARTHEST)
    offset = offset / scale if scale > 0 else offset
    pixel = np.floor(np.array(inputs.size) / 2 + offset + 1e-6)
    return int(pixel[0]), int(pixel[1]), bool(towards)


@attrs.frozen(eq=False)
class _Landings:
    """What lands inside the shown picture. Index of the drawn pixel, index of the shown one,
    inverse depth there; and the shown pixels (flat) that rounding alone may give to others."""

    source: NDArray[np.int64]
    slot: NDArray[np.int64]
    depth: Array
    undecided: NDArray[np.bool_]

    @classmethod
    def of(cls, inputs: TwinInputs) -> _Landings:
        rendered, shown, size, shown_size = inputs.rendered, inputs.shown, inputs.size, inputs.shown_size
        drawn = (inputs.inverse_depth >= 0) & np.isfinite(inputs.inverse_depth)
        own = np.where(drawn, inputs.inverse_depth, 0).astype(np.float64)
        moved = rendered.pose.position_m - shown.pose.position_m
        pixels, depth, w = project(world_directions(rendered, size), moved, own, shown, shown_size)
        bound = pixel_error_bound(WarpMap.between(rendered, size, shown, shown_size), size, own)
        flat = pixels.reshape(-1, 2)
        lands = drawn.ravel() & (w.ravel() > 0) & ((flat >= 0) & (flat < np.array(shown_size))).all(axis=1)
        source = np.flatnonzero(lands)
        slot = flat[source, 1].astype(int) * shown_size[0] + flat[source, 0].astype(int)
        undecided = np.zeros(shown_size[0] * shown_size[1], bool)
        _mark_near_borders(undecided, flat[drawn.ravel()], bound.ravel()[drawn.ravel()], shown_size)
        return cls(source, slot, depth.ravel()[source], undecided)


def _painted(inputs: TwinInputs, landed: _Landings, order: NDArray[np.int64]) -> ReferencePicture:
    """The picture when what lands is painted in that order, later over earlier."""
    wide, high = inputs.shown_size
    out = np.zeros((wide * high, 4))
    out[landed.slot[order]] = inputs.colour.reshape(-1, 4)[
        landed.source[order]
    ]  # NumPy: of repeated indices the last stays
    return ReferencePicture(out.reshape(high, wide, 4), np.zeros((high, wide)), landed.undecided.reshape(high, wide))


def _as_ordered(inverse_depth: Array) -> Array:
    """Inverse depths as far as the order of landings tells them apart."""
    return np.where(inverse_depth < FARTHEST, 0, np.minimum(inverse_depth, NEAREST))


def _near_ties(slot: Array, depth: Array, pixels: int) -> np.ndarray:
    """Shown pixels whose two nearest landings are closer in depth than float32 tells apart, but not
    infinitely far."""
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
