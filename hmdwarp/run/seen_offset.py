"""How far from where they belong things are seen, in a picture that is shown again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..client.inputs import PassInputs
from ..geometry import View
from ..gpu.textures import download
from ..pipeline.loop import Refresh

Array = NDArray[np.float64]
_POINTS = 17  # a row and a column of the late frame


class SeenOffset:
    """Angles between where points of the late frame are seen and where they are.

    The points are on a grid over the frame, as far away as its depth says; where it has no depth at
    all, infinitely far. turned: pictures are turned to the newest head, else they stand.
    """

    def __init__(self, *, turned: bool) -> None:
        self._turned = turned
        self._made: Refresh | None = None
        self._points: list[tuple[Array, Array]] = []

    def off_deg(self, made: Refresh, refresh: Refresh) -> float:
        """Return the RMS over the points of all eyes. made: when its picture was made."""
        if made is refresh:
            return 0.0
        if made is not self._made:
            self._made, self._points = made, [_points_of(inputs) for inputs in made.inputs]
        pairs = zip(self._points, made.inputs, refresh.inputs, strict=True)
        angles = [self._angles(points, then.shown, now.shown) for points, then, now in pairs]
        return float(np.degrees(np.sqrt(np.mean(np.concatenate(angles) ** 2))))

    def _angles(self, points: tuple[Array, Array], then: View, now: View) -> Array:
        seen, right = (_ways(points, view) for view in (then, now))
        if not self._turned:
            seen = seen @ then.pose.rotation_matrix @ now.pose.rotation_matrix.T
        apart, together = (np.linalg.norm(ways, axis=1) for ways in (seen - right, seen + right))
        return np.asarray(2 * np.arctan2(apart, together))


def _points_of(inputs: PassInputs) -> tuple[Array, Array]:
    """Return homogeneous points in the world, (n, 3) times the inverse depth, (n, 1).

    All of the late frame that the picture may show.
    """
    eye = inputs.rendered
    inverse = download(eye.inverse_depth)
    rows, columns = ((np.arange(_POINTS) + 0.5) * side / _POINTS for side in inverse.shape[:2])
    found = inverse.reshape(inverse.shape[:2])[np.ix_(rows.astype(int), columns.astype(int))].reshape(-1, 1)
    inverse = np.where((found >= 0).any(), found, 0.0).astype(np.float64)
    ways = eye.view.rays((_POINTS, _POINTS)).reshape(-1, 3) @ eye.view.pose.rotation_matrix.T
    points, drawn = ways + eye.view.pose.position_m * inverse, inverse[:, 0] >= 0
    return points[drawn], inverse[drawn]


def _ways(points: tuple[Array, Array], view: View) -> Array:
    """Return the unit vectors, (n, 3), from an eye to the points."""
    ways = points[0] - view.pose.position_m * points[1]
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))
