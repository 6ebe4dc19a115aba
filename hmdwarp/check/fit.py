"""Numbers of a reading, fitted so that frames agree, each with its standard error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from .frame_reading import Reading
from .overlap import Overlap, Residuals
from .stated_frames import Array

FACTOR, OFFSET, ALONG, PIXEL_X, PIXEL_Y, LATE = "factor", "offset", "along", "pixel_x", "pixel_y", "late_s"
_ROUNDS = 5
_CUT = 6.0  # standard deviations: what disagrees more is no evidence of how much
_CHANCE = 0.8  # of the worst disagreement: what points have that meet by chance, and those out of view
_SMALL = 1e-9


@attrs.frozen(eq=False)
class Fitted:
    """A reading, and how well each fitted number is known."""

    reading: Reading
    names: tuple[str, ...]
    change: Array  # of each number against the reading at the start; of FACTOR its logarithm
    error: Array  # standard error of each, inf where the frames say nothing


@attrs.frozen
class Noise:
    """Deviations of what agrees."""

    depth: float
    colour: float

    @classmethod
    def of(cls, found: Residuals) -> Noise:
        """Return those of residuals: from their medians, which outliers do not move."""
        return cls(*(max(1.48 * _median(np.abs(one)), 1e-4) for one in (found.depth, found.colour)))


def _median(values: Array) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) else math.inf


def cost(found: Residuals, noise: Noise) -> Array:
    """Return the disagreement of each point, NaN where nothing can be said."""
    with np.errstate(invalid="ignore"):
        each = [
            np.log1p(np.minimum(one / deviation, _CUT) ** 2)
            for one, deviation in ((np.abs(found.depth), noise.depth), (np.abs(found.colour), noise.colour))
        ]
    worst = math.log1p(_CUT**2)
    return np.where(found.seen, np.where(np.isnan(each[0]), worst, each[0]) + each[1], 2 * _CHANCE * worst)


def changed(reading: Reading, names: Sequence[str], change: Sequence[float]) -> Reading:
    """Return the reading with other numbers."""
    values: dict[str, Any] = {
        name: reading.factor * math.exp(one) if name == FACTOR else getattr(reading, name) + one
        for name, one in zip(names, change, strict=True)
    }
    return attrs.evolve(reading, **values)


def fit(overlap: Overlap, start: Reading, steps: dict[str, float]) -> Fitted:
    """Return the reading for which points agree best.

    steps: of each number that is fitted, a small difference, by which slopes are taken.
    Source: iteratively reweighted least squares; its error by the sandwich formula over blocks,
    whose points err together (White 1980; Liang and Zeger 1986).
    """
    names, change = tuple(steps), np.zeros(len(steps))
    small = np.array(list(steps.values()))
    limit = 60 * small
    hessian, spread = np.eye(len(names)), np.eye(len(names))
    for _ in range(_ROUNDS):
        reading = changed(start, names, change.tolist())
        found = overlap.residuals(reading)
        noise = Noise.of(found)
        hessian, spread = np.zeros((len(names),) * 2), np.zeros((overlap.blocks, len(names)))
        down = np.zeros(len(names))
        slopes = [overlap.residuals(changed(reading, [name], [steps[name]])) for name in names]
        for kind in ("depth", "colour"):
            deviation = getattr(noise, kind)
            values = getattr(found, kind) / deviation
            slope = np.stack([(getattr(one, kind) / deviation - values) for one in slopes], -1) / small
            with np.errstate(invalid="ignore"):
                usable = np.isfinite(values) & np.isfinite(slope).all(axis=-1) & (np.abs(values) < _CUT)
            value, slope, block = values[usable], slope[usable], overlap.block[usable]
            weighted = slope / (1 + value**2)[:, None]
            hessian += weighted.T @ slope
            pull = weighted * value[:, None]
            down += pull.sum(axis=0)
            for column in range(len(names)):
                spread[:, column] += np.bincount(block, pull[:, column], overlap.blocks)
        scale = np.sqrt(np.diag(hessian)) + _SMALL
        step = -np.linalg.solve(hessian / np.outer(scale, scale) + 1e-6 * np.eye(len(names)), down / scale) / scale
        change += np.clip(step, -limit, limit)
        if (np.abs(step) < 0.05 * small).all():
            break
    inverse = np.linalg.pinv(hessian)
    error = np.sqrt(np.diag(inverse @ (spread.T @ spread) @ inverse))
    error = np.where(np.diag(hessian) * small**2 > _SMALL, error, math.inf)
    return Fitted(changed(start, names, change.tolist()), names, change, error)
