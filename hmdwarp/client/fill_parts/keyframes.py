"""Which late pictures are worth remembering, which make room for them, and which are looked into: decided from views alone, on the CPU."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import View

Mask = NDArray[np.bool_]
SAMPLES = 12  # directions on each axis of a view
REACH_M = 0.3  # an eye so far away may have seen other sides of things
NOVELTY = 0.12  # share of a view that no kept one covers, from which it is kept
INSIDE = 0.15  # what a direction inside the newest picture counts: only what is hidden there is missing
AGAIN = 0.3  # what a direction counts that another picture covers already: it may have been hidden there


@attrs.frozen(eq=False)
class Keyframe:
    """slot: which of the memory's textures holds it."""

    slot: int
    view: View
    drawn_ns: int


def directions(view: View) -> NDArray[np.float64]:
    """(n, 3) in the world: an even grid over the view's tangents. None lies on its border: the least motion would lose a whole row."""
    left, right, down, up = view.fov.tangents
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    x, y = np.meshgrid(left + share * (right - left), down + share * (up - down))
    rays = np.stack([x.ravel(), y.ravel(), -np.ones(x.size)], axis=-1)
    return rays @ view.pose.rotation_matrix.T


def sees(view: View, towards: NDArray[np.float64]) -> Mask:
    """(n,) which of the directions lie in the view's field of view."""
    x, y, z = (towards @ view.pose.rotation_matrix).T
    left, right, down, up = view.fov.tangents
    with np.errstate(divide="ignore", invalid="ignore"):
        across, above = -x / z, -y / z
    return (z < 0) & (across >= left - 1e-9) & (across <= right + 1e-9) & (above >= down - 1e-9) & (above <= up + 1e-9)


def distance_m(a: View, b: View) -> float:
    """Between the eyes."""
    return float(np.linalg.norm(a.pose.position_m - b.pose.position_m))


def covered(view: View, by: Sequence[Keyframe]) -> Mask:
    """(n,) which of the view's directions another one covers from near by."""
    towards = directions(view)
    found = np.zeros(len(towards), bool)
    for one in by:
        if distance_m(view, one.view) <= REACH_M:
            found |= sees(one.view, towards)
    return found


def overlapping(view: View, kept: Sequence[Keyframe]) -> list[Keyframe]:
    """Those that look in some of the view's directions."""
    towards = directions(view)
    return [one for one in kept if sees(one.view, towards).any()]


def is_new(view: View, kept: Sequence[Keyframe]) -> bool:
    """Whether the view shows enough that none of the kept pictures does."""
    return float(1 - covered(view, kept).mean()) >= NOVELTY


def most_redundant(kept: Sequence[Keyframe], newest: View) -> Keyframe:
    """The one whose loss costs least: the others, and the newest, cover most of it; of equals the oldest."""
    beside = Keyframe(-1, newest, 0)
    return max(
        kept, key=lambda one: (covered(one.view, [beside, *(k for k in kept if k is not one)]).mean(), -one.drawn_ns)
    )


def most_useful(kept: Sequence[Keyframe], shown: View, rendered: View, most: int) -> list[Keyframe]:
    """Up to `most` that together see most of what the late view does not show, the newest first; what lies inside it counts a little."""
    towards = directions(shown)
    worth = np.where(sees(rendered, towards), INSIDE, 1.0)
    seen = {one.slot: sees(one.view, towards) * np.exp(-distance_m(shown, one.view) / REACH_M / 3) for one in kept}
    chosen: list[Keyframe] = []
    while len(chosen) < most:
        rest = [one for one in kept if one not in chosen and seen[one.slot].any()]
        if not rest:
            break
        best = max(rest, key=lambda one: (float(worth @ seen[one.slot]), one.drawn_ns))
        chosen.append(best)
        worth = np.where(seen[best.slot] > 0, AGAIN * worth, worth)
    return sorted(chosen, key=lambda one: (-one.drawn_ns, one.slot))
