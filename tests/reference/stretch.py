"""Twin of the fill `stretch`.

Lines from rays through the world, and whole lines at a time instead of step by step.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import View, WarpMap
from reference._behind import Behind, known_or_infinite
from reference._rays import FLOAT32_UNIT, Array, pixel_centres, project, world_directions

MOST_TAPS = 4
REACH = 3
SLIGHT = 1e-3  # 1/m: a point that far goes where everything nearer on its ray goes
CLOSE = 1e-5  # relative: depths that rounding may take for one another
CLOSE_PIXELS = (
    1e-3  # from the border of a pixel; a line that float32 may move by more, over the whole picture, is left undecided
)


@attrs.frozen(eq=False)
class Stretched:
    """colour (h, w, 4), inverse_depth (h, w); undecided (h, w).

    Where rounding decides which pixels a line passes, or what lies behind.
    """

    colour: Array
    inverse_depth: Array
    undecided: NDArray[np.bool_]


@attrs.frozen
class _Side:
    """What a hole's edge on one side of a line says; away 0 if there is none."""

    away: int = 0
    depth: float = np.inf
    colour: Array | None = None


class _Picture:
    """The picture, and whether anything looked at so far was a close decision."""

    def __init__(self, colour: Array, inverse_depth: Array, behind: Behind) -> None:
        self.colour, self.depth, self.behind = colour, known_or_infinite(inverse_depth), behind
        self.shape, self.close = colour.shape[:2], False

    def pixels(
        self, start: Array, line: Array, steps: Array
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_], NDArray[np.bool_]]:
        """The pixels (n, 2) that a line passes after these steps, whether they are inside, and
        whether rounding decides which they are.
        """
        places = start + line * np.asarray(steps)[:, None]
        close = (np.abs(places - np.round(places)) < CLOSE_PIXELS).any(axis=1)
        found = np.floor(places).astype(int)
        return found, ((found >= 0) & (found < self.shape[::-1])).all(axis=1), close

    def same(self, a: float, b: float) -> tuple[bool, bool]:
        """Whether a is no nearer than b's surface, and b no nearer than a's."""
        return self._within(a, b), self._within(b, a)

    def _within(self, depth: float, farthest: float) -> bool:
        limit = self.behind.limit(farthest)
        self.close |= bool(np.isfinite(limit) and abs(depth - limit) <= CLOSE * limit)
        return bool(depth <= limit)

    def side(self, start: Array, line: Array) -> _Side:
        """The first covered pixel along a line, and the mean from there on."""
        pixels, inside, close = self.pixels(start, line, np.arange(1, max(self.shape) + MOST_TAPS + 1))
        covered = np.zeros(len(pixels), bool)
        covered[inside] = self.colour[pixels[inside, 1], pixels[inside, 0], 3] > 0
        ends = np.flatnonzero(covered | ~inside)
        first = int(ends[0])
        self.close |= bool(close[: first + MOST_TAPS].any())
        if not covered[first]:
            return _Side()
        own = self.depth[pixels[first, 1], pixels[first, 0]]
        total, weight, mean = 0.0, 1.0, np.zeros(3)
        for tap in range(min(first + 1, MOST_TAPS)):
            x, y = pixels[first + tap]
            weight = weight if covered[first + tap] and all(self.same(self.depth[y, x], own)) else 0.0
            if weight:
                mean, total = mean + weight * self.colour[y, x, :3], total + weight
            weight /= 2
        return _Side(first + 1, own, mean / total)

    def farther(self, a: _Side, b: _Side) -> _Side:
        """Of two sides the farther one; of one surface between both."""
        if not (a.away and b.away):
            return a if a.away else b
        a_counts, b_counts = self.same(a.depth, b.depth)
        if a_counts and b_counts and np.isfinite(a.depth):
            part = a.away / (a.away + b.away)
            depth = a.depth + part * (b.depth - a.depth)
            return _Side(min(a.away, b.away), depth, a.colour + part * (b.colour - a.colour))
        return a if a_counts else b


def stretch(
    colour: Array,
    inverse_depth: Array,
    rendered: tuple[View, tuple[int, int]],
    shown: View,
    settings,
    least_parallax: float,
) -> Stretched:
    """(h, w, 4) with coverage in alpha and (h, w) in 1/m, -1 not known, to the same with holes
    filled from what lies behind.

    rendered: the view that was rendered and its (w, h). settings: tolerance, floor, spread, as the
    fill's.
    """
    size = colour.shape[1::-1]
    lines, shaky = _lines(rendered, shown, size, least_parallax)
    picture = _Picture(colour, inverse_depth, Behind(settings.tolerance, settings.floor))
    out = Stretched(colour.copy(), inverse_depth.copy(), np.zeros(colour.shape[:2], bool))
    away = np.zeros(colour.shape[:2])
    for y, x in np.argwhere(colour[..., 3] == 0):
        picture.close = bool(shaky[y, x])
        start, line = np.array([x + 0.5, y + 0.5]), lines[y, x]
        found = _Side()
        if line.any():
            hidden, near = picture.side(start, -line), picture.side(start, line)
            found = picture.farther(hidden, near)
            inside, close = _in_view(
                start, [found.depth] if near.away else [found.depth, np.inf], rendered, shown, size
            )
            picture.close |= close
            found = found if hidden.away and inside else _Side()
        out.undecided[y, x] = picture.close
        if found.away:
            away[y, x], out.inverse_depth[y, x] = found.away, found.depth if np.isfinite(found.depth) else -1
            out.colour[y, x] = [*found.colour, 1]
    return _smoothed(out, colour[..., 3] == 0, away, lines, picture, settings.spread)


def _lines(
    rendered: tuple[View, tuple[int, int]], shown: View, size: tuple[int, int], least_parallax: float
) -> tuple[Array, NDArray[np.bool_]]:
    """(h, w, 2).

    Where a slightly nearer point of the rendered eye's parallel ray appears, as a step of a pixel
    on its longer axis.
    """
    towards_rendered = shown.pose.position_m - rendered[0].pose.position_m
    rays = world_directions(shown, size)
    moved, _, _ = project(rays, -towards_rendered, np.full(rays.shape[:2], SLIGHT), shown, size)
    way = (moved - pixel_centres(size)) / SLIGHT
    _, _, w = project(rays, -towards_rendered, np.full(rays.shape[:2], SLIGHT), shown, size)
    longer = np.abs(way * w[..., None]).max(axis=-1, keepdims=True)
    lines = np.where(longer >= least_parallax, way / np.maximum(np.abs(way).max(axis=-1, keepdims=True), 1e-300), 0.0)
    forward = WarpMap.between(*rendered, shown, size)
    terms = (np.abs(forward.e[:2]) + pixel_centres(size) * abs(forward.e[2])).max(axis=-1)
    error = 4 * FLOAT32_UNIT * terms / np.maximum(longer[..., 0], 1e-300)
    return lines, (error * max(size) > CLOSE_PIXELS) | (np.abs(longer[..., 0] - least_parallax) < 1e-4)


def _in_view(
    start: Array, depths: list[float], rendered: tuple[View, tuple[int, int]], shown: View, size: tuple[int, int]
) -> tuple[bool, bool]:
    """Whether the rendered picture looked at these points of a pixel's ray.

    Whether rounding decides.
    """
    inside, close = True, False
    x, y = start - 0.5
    ray = world_directions(shown, size)[int(y), int(x)]
    for depth in depths:
        known = np.array(depth if np.isfinite(depth) else 0.0)
        place, _, w = project(ray, shown.pose.position_m - rendered[0].pose.position_m, known, *rendered)
        inside &= bool(w > 0 and (place >= 0).all() and (place < rendered[1]).all())
        close |= bool(w > 0 and (np.minimum(np.abs(place), np.abs(place - rendered[1])) < CLOSE_PIXELS).any())
    return inside, close


def _smoothed(
    drawn: Stretched, holes: NDArray[np.bool_], away: Array, lines: Array, picture: _Picture, spread: float
) -> Stretched:
    """Averages over streaks beside each other, of the same surface, in holes alone."""
    out = Stretched(drawn.colour.copy(), drawn.inverse_depth, drawn.undecided.copy())
    depths = known_or_infinite(drawn.inverse_depth)
    for y, x in np.argwhere(away > 0):
        across = np.array([-lines[y, x, 1], lines[y, x, 0]])
        apart = away[y, x] * spread
        if apart <= 1:
            out.undecided[y, x] |= abs(apart - 1) < CLOSE
            continue
        steps = apart * np.array([tap for tap in range(-REACH, REACH + 1) if tap])
        pixels, inside, close = picture.pixels(np.array([x + 0.5, y + 0.5]), across, steps)
        picture.close = bool(close.any()) or apart - 1 < CLOSE
        total, mean = 1.0, drawn.colour[y, x, :3].copy()
        for (i, j), tap in zip(pixels[inside], (np.abs(steps) / apart)[inside], strict=True):
            picture.close |= bool(holes[j, i] and drawn.undecided[j, i])
            if holes[j, i] and away[j, i] and all(picture.same(depths[j, i], depths[y, x])):
                mean, total = mean + drawn.colour[j, i, :3] / (1 + tap), total + 1 / (1 + tap)
        out.colour[y, x, :3] = mean / total
        out.undecided[y, x] |= picture.close
    return out
