"""Difference images in float64: points in the world instead of a map, sRGB by its formula."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hmdwarp.colour import linear_from_srgb, srgb8_from_linear
from hmdwarp.geometry import View

Array = NDArray[np.float64]


def bytes_of(linear: NDArray) -> Array:
    """(h, w, 3) sRGB bytes of linear light, as numbers."""
    return srgb8_from_linear(np.asarray(linear)[..., :3].astype(np.float64)).astype(np.float64)


def encoded(full: NDArray, simplified: NDArray) -> Array:
    """Linear light of (d + 1) / 2 of two pictures in linear light."""
    return linear_from_srgb((bytes_of(full) - bytes_of(simplified) + 255) / 510)


def warped(
    shown: View,
    now: tuple[NDArray, NDArray],
    rendered: View,
    then: tuple[NDArray, NDArray],
    difference: Array,
    tolerance: float,
    floor: float,
) -> tuple[Array, NDArray[np.bool_]]:
    """(h, w, 3) bytes of the sum, unrounded; and where a test or a border is within float32 of it.

    now, then: linear colour and inverse depth of the simplified scene, bottom row first.
    difference: (h, w, 3) in bytes.
    """
    colour, inverse = np.asarray(now[0], float), np.asarray(now[1], float)
    high, wide = inverse.shape
    held = np.asarray(then[1], float)
    size = held.shape[1], held.shape[0]
    directions = shown.rays((wide, high)) @ shown.pose.rotation_matrix.T
    apart = shown.pose.position_m - rendered.pose.position_m
    # The point at 1 / inverse along the ray, times the inverse depth, so that infinity is no case.
    towards = (directions + apart * inverse[..., None]) @ rendered.pose.rotation_matrix
    total, doubtful = bytes_of(colour), np.zeros((high, wide), bool)
    left, right, down, up = rendered.fov.tangents
    for y in range(high):
        for x in range(wide):
            ahead = -towards[y, x, 2]
            if ahead <= 0:
                continue
            across, above = towards[y, x, 0] / ahead, towards[y, x, 1] / ahead
            column = (across - left) / (right - left) * size[0] - 0.5
            row = (above - down) / (up - down) * size[1] - 0.5
            expected = inverse[y, x] / ahead
            weights, values = [], []
            for i in (int(np.floor(column)), int(np.floor(column)) + 1):
                for j in (int(np.floor(row)), int(np.floor(row)) + 1):
                    if not (0 <= i < size[0] and 0 <= j < size[1]):
                        continue
                    gap, limit = abs(held[j, i] - expected), tolerance * (expected + floor)
                    doubtful[y, x] |= abs(gap - limit) < 1e-5 * (expected + floor)
                    if gap <= limit:
                        weights.append((1 - abs(column - i)) * (1 - abs(row - j)))
                        values.append(difference[j, i])
            doubtful[y, x] |= bool(weights) and sum(weights) < 1e-3
            doubtful[y, x] |= min(abs(column - round(column)), abs(row - round(row))) < 1e-3
            if weights and sum(weights) > 0:
                total[y, x] += np.average(values, axis=0, weights=weights)
    return np.clip(total, 0, 255), doubtful
