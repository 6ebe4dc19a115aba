"""Twin of the fill `pyramid`.

Whole levels at once, as windows over arrays, and their completion by recursion from the picture
upwards.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hmdwarp.geometry import View
from reference._behind import Behind, as_stored, known_or_infinite
from reference._rays import Array, pixel_centres, project, world_directions

CRACKS, GAIN, LEAST, DEEP = 2.0**-20, 4.0, 2.0**-10, 2.0**-7
KERNEL = np.outer([1, 3, 3, 1], [1, 3, 3, 1]) / 64


@attrs.frozen
class Chosen:
    """The fill's settings and constants: holes, tolerance and floor in `behind`; both views.

    rendered: with the size (w, h) of its picture. The share a farthest one must have, on levels
    (the first is 0) up to local_levels, from there on, and where the nearest one would lie outside
    the rendered view; what a mere crack counts there.
    """

    least_holes: float
    behind: Behind
    local_levels: int
    least_local: float
    least_border: float
    least_beyond: float
    crack_border: float
    shown: View
    rendered: tuple[View, tuple[int, int]]

    def least_border_on(self, number: int) -> float:
        """On the level of that number."""
        return self.least_border if number >= self.local_levels else self.least_local


@attrs.frozen(eq=False)
class Level:
    """colour (h, w, 3), weight, depth (np.inf: not known), share of holes, and how much borders on
    them (h, w), of one level.
    """

    colour: Array
    weight: Array
    depth: Array
    holes: Array
    border: Array


def pyramid(colour: Array, inverse_depth: Array, chosen: Chosen) -> tuple[Array, Array]:
    """(h, w, 4) with coverage in alpha and (h, w) in 1/m, -1 not known, to the same with every hole
    filled, if anything is covered.
    """
    covered = colour[..., 3] > 0
    picture = Level(colour[..., :3], covered * 1.0, known_or_infinite(inverse_depth), ~covered * 1.0, covered * 1.0)
    guess = _completed(picture, chosen, -1, covered.shape[::-1])
    found = np.concatenate([guess.colour, (guess.weight > 0)[..., None]], axis=-1)
    return np.where(covered[..., None], colour, found), np.where(covered, inverse_depth, as_stored(guess.depth))


def _completed(level: Level, chosen: Chosen, number: int, size: tuple[int, int]) -> Level:
    """The level (-1: the picture, of that size) with what it has not, or should not have, taken
    from the level above it, itself completed.
    """
    is_picture, behind = number < 0, chosen.behind
    if level.weight.size == 1 and not is_picture:
        return level
    pulled = _pulled(level, chosen, number + 1, size)
    if number == 0:
        pulled = attrs.evolve(pulled, border=pulled.border * np.where(pulled.holes >= DEEP, 1.0, chosen.crack_border))
    above = _completed(pulled, chosen, number + 1, size)
    up = _enlarged(above, level.weight.shape, chosen, number + 1, size)
    own = level.weight > 0
    if is_picture:
        return up
    not_nearer, not_farther = behind.share(level.depth, up.depth), behind.share(up.depth, level.depth)
    x = np.clip(up.holes / chosen.least_holes - 0.5, 0, 1) * (number < chosen.local_levels)
    counts = x * x * (3 - 2 * x) * _in_rendered_view(level.depth, chosen, 2 ** (number + 1), size)
    keep = (1 + (level.weight - 1) * not_nearer * not_farther) * (1 + (not_nearer - 1) * counts)
    keep = np.where(own & (up.weight > 0), keep, own)
    mixed = keep[..., None] * level.colour + (1 - keep)[..., None] * up.colour
    with np.errstate(invalid="ignore"):
        known = np.isfinite(level.depth) & np.isfinite(up.depth)
        depth = np.where(keep == 1, level.depth, np.where(known, keep * level.depth + (1 - keep) * up.depth, up.depth))
    border = keep * level.border + (1 - keep) * up.border
    return Level(mixed, (own | (up.weight > 0)) * 1.0, depth, level.holes, border)


def _in_rendered_view(depth: Array, chosen: Chosen, texel: int, size: tuple[int, int]) -> Array:
    """1 where the rendered view contains a point at that depth (np.inf: as if infinitely far) on
    the ray of a texel, `texel` pixels wide; 0 where it does not, in between over one texel.
    """
    rays = world_directions(chosen.shown, size, pixel_centres(depth.shape[::-1]) * texel)
    away = chosen.shown.pose.position_m - chosen.rendered[0].pose.position_m
    place, _, w = project(rays, away, np.where(np.isfinite(depth), depth, 0), *chosen.rendered)
    gap = np.minimum(place, np.array(chosen.rendered[1]) - place).min(axis=-1)
    return np.where(w > 0, np.clip(0.5 + gap / texel, 0, 1), 0.0)


def _least_share(depth: Array, chosen: Chosen, number: int, texel: int, size: tuple[int, int]) -> Array:
    """(h, w): of all borders, what the farthest depth must make up on a level of that number, where
    texels so many pixels wide have `depth`.
    """
    contained = _in_rendered_view(depth, chosen, texel, size)
    return chosen.least_beyond + contained * (chosen.least_border_on(number) - chosen.least_beyond)


def _pulled(level: Level, chosen: Chosen, number: int, size: tuple[int, int]) -> Level:
    """The level of that number: each texel from the 4 x 4 below it, those that are farthest."""
    behind, from_picture = chosen.behind, number == 0
    colour, weight, depth, holes, border, inside = (
        _windows(values, outside)
        for values, outside in (
            (level.colour, 0), (level.weight, 0), (level.depth, np.inf), (level.holes, 0), (level.border, 0),
            (np.ones_like(level.holes), 0),
        )
    )  # fmt: skip
    borders = KERNEL.ravel() * np.where(weight > 0, border, 0)
    if from_picture:
        farthest = np.where(weight > 0, depth, np.inf).min(axis=-1)
    else:
        nearest = np.where((borders > 0) & np.isfinite(depth), depth, 0).max(axis=-1)
        least = _least_share(nearest, chosen, number, 2 ** (number + 1), size)
        farthest = _farthest_of_enough(depth, borders, behind, least)
    holes = (KERNEL.ravel() * holes).sum(axis=-1)
    beside = KERNEL.ravel() * _share(depth, farthest[..., None], behind) * (holes > 0)[..., None]
    counts = beside * weight
    total = counts.sum(axis=-1)
    pulled, mean_depth = _means(counts, colour, depth)
    new_weight = np.where(total > 0, np.clip(GAIN * total, LEAST, 1), 0)
    if from_picture:
        holes = np.where((holes > 0) & (new_weight > 0), CRACKS, holes)
    return Level(
        pulled, new_weight, mean_depth, holes / (KERNEL.ravel() * inside).sum(axis=-1), (beside * border).sum(axis=-1)
    )


def _farthest_of_enough(depth: Array, borders: Array, behind: Behind, least: Array) -> Array:
    """Of (..., n) depths the farthest that, with all that is as far, makes up enough of the
    borders; np.inf where there is none.
    """
    as_far = depth[..., None, :] <= behind.limit(depth)[..., None]
    share = np.einsum("...kn,...n->...k", as_far, borders)
    enough = (borders > 0) & (share > 0) & (share >= (least * borders.sum(axis=-1))[..., None])
    return np.where(enough, depth, np.inf).min(axis=-1)


def _share(depth: Array, farthest: Array, behind: Behind) -> Array:
    """Less the farther off a depth is from the one that counts, either way."""
    return behind.share(depth, farthest) * behind.share(farthest, depth)


def _means(counts: Array, colour: Array, depth: Array) -> tuple[Array, Array]:
    """Means of (..., n) by weights; 0 and np.inf where nothing counts."""
    total = counts.sum(axis=-1)
    over = np.divide(1.0, total, out=np.zeros_like(total), where=total > 0)
    counted = np.where(counts > 0, depth, 0)
    with np.errstate(invalid="ignore"):
        mean_depth = np.where(total > 0, (counts * counted).sum(axis=-1) * over, np.inf)
    unknown = ((counts > 0) & np.isinf(depth)).any(axis=-1)
    return np.einsum("...n,...nc->...c", counts, colour) * over[..., None], np.where(unknown, np.inf, mean_depth)


def _windows(values: Array, outside: float) -> Array:
    """(h / 2, w / 2, 16[, c]): what each texel of the next level reaches over."""
    high, wide = values.shape[:2]
    rest = ((0, 0),) * (values.ndim - 2)
    padded = np.pad(values, ((1, 2 + high % 2), (1, 2 + wide % 2), *rest), constant_values=outside)
    windows = sliding_window_view(padded, (4, 4), axis=(0, 1))[::2, ::2][: -(-high // 2), : -(-wide // 2)]
    return (
        np.moveaxis(windows, 2, -1).reshape(*windows.shape[:2], 16, 3)
        if values.ndim == 3
        else windows.reshape(*windows.shape[:2], 16)
    )


def _enlarged(above: Level, shape: tuple[int, int], chosen: Chosen, number: int, size: tuple[int, int]) -> Level:
    """What the level above, of that number, says at each texel of a level of that shape.

    Bilinear, of the farthest alone.
    """
    rows, columns = (_two_nearest(n, m) for n, m in zip(shape, above.weight.shape, strict=True))
    pairs = [
        (y, x, a * b)
        for y, a in zip(rows, (0.75, 0.25), strict=True)
        for x, b in zip(columns, (0.75, 0.25), strict=True)
    ]
    below = (above.colour, above.weight, above.depth, above.holes, above.border)
    colour, weight, depth, holes, border = (
        np.stack([values[np.ix_(y, x)] for y, x, _ in pairs], axis=2) for values in below
    )
    shares = np.array([share for *_, share in pairs])
    behind, borders = chosen.behind, shares * border
    first = np.where(borders > 0, depth, np.inf).min(axis=-1)
    least = _least_share(first, chosen, number, 2**number, size)
    farthest = _farthest_of_enough(depth, borders, behind, least)
    beside = shares * _share(depth, farthest[..., None], behind)
    counts = beside * weight
    mean, mean_depth = _means(counts, colour, depth)
    found = (counts.sum(axis=-1) > 0) * 1.0
    return Level(mean, found, mean_depth, (shares * holes).sum(axis=-1), (beside * border).sum(axis=-1))


def _two_nearest(count: int, above: int) -> tuple[np.ndarray, np.ndarray]:
    """Of each of `count` texels in a row.

    The texel above it, and the one beside that which it is nearest to.
    """
    place = np.arange(count)
    own = place // 2
    return own, np.clip(own + np.where(place % 2, 1, -1), 0, above - 1)
