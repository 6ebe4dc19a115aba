"""Choice of the rendered pictures to keep, drop and use: from views alone, on the CPU."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import View

Mask = NDArray[np.bool_]
SAMPLES = 12  # directions on each axis of a view
REACH_M = 0.3  # an eye farther away may have seen other sides of things
NOVELTY = 0.12  # least share of a view, covered by no kept picture, for it to be kept
INSIDE = 0.15  # weight of a direction inside the newest picture, which lacks only occluded places there
AGAIN = 0.3  # weight of a direction that another picture covers: the place may be occluded there


@attrs.frozen(eq=False)
class Keyframe:
    """A kept picture."""

    slot: int  # Index of the memory's slot that holds it.
    view: View
    drawn_ns: int


def directions(view: View) -> NDArray[np.float64]:
    """Return (n, 3) world directions: an even grid over the view's tangents.

    None lies on the border, where the least motion would lose a whole row.
    """
    left, right, down, up = view.fov.tangents
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    x, y = np.meshgrid(left + share * (right - left), down + share * (up - down))
    rays = np.stack([x.ravel(), y.ravel(), -np.ones(x.size)], axis=-1)
    return rays @ view.pose.rotation_matrix.T


def sees(view: View, towards: NDArray[np.float64]) -> Mask:
    """Return (n,) which of the directions lie in the view's field of view."""
    x, y, z = (towards @ view.pose.rotation_matrix).T
    left, right, down, up = view.fov.tangents
    with np.errstate(divide="ignore", invalid="ignore"):
        across, above = -x / z, -y / z
    return (z < 0) & (across >= left - 1e-9) & (across <= right + 1e-9) & (above >= down - 1e-9) & (above <= up + 1e-9)


def distance_m(a: View, b: View) -> float:
    """Return the distance between the eyes."""
    return float(np.linalg.norm(a.pose.position_m - b.pose.position_m))


def covered(view: View, by: Sequence[Keyframe]) -> Mask:
    """Return (n,) which of the view's directions a nearby keyframe covers."""
    towards = directions(view)
    found = np.zeros(len(towards), bool)
    for one in by:
        if distance_m(view, one.view) <= REACH_M:
            found |= sees(one.view, towards)
    return found


def overlapping(view: View, kept: Sequence[Keyframe]) -> list[Keyframe]:
    """Return the keyframes that overlap the view's directions."""
    towards = directions(view)
    return [one for one in kept if sees(one.view, towards).any()]


def is_new(view: View, kept: Sequence[Keyframe]) -> bool:
    """Return whether the view shows enough that no kept picture shows."""
    return float(1 - covered(view, kept).mean()) >= NOVELTY


def most_redundant(kept: Sequence[Keyframe], newest: View) -> Keyframe:
    """Return the keyframe whose loss costs least, the oldest of equals.

    The others and the newest picture cover most of it.
    """
    beside = Keyframe(-1, newest, 0)
    return max(
        kept, key=lambda one: (covered(one.view, [beside, *(k for k in kept if k is not one)]).mean(), -one.drawn_ns)
    )


def most_useful(kept: Sequence[Keyframe], shown: View, rendered: View, most: int) -> list[Keyframe]:
    """Return up to `most` keyframes that together see most of what `rendered` does not show.

    The newest come first. Directions inside `rendered` count a little: the place may be occluded.
    """
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
