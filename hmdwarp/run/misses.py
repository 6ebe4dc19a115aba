"""What missed refreshes cost: pictures that are seen again, and away from their place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..client.inputs import PassInputs
from ..frames import EyeImage
from ..geometry import Pose, View
from ..gpu.context import Gpu
from ..gpu.textures import flip_rows
from ..pipeline.loop import Refresh
from ..poses import quaternions

Array = NDArray[np.float64]
MEASURED = "measured"
TURNED, STANDS = "turned", "stands"  # in summary.json
_POINTS = 17  # a row and a column of the late frame
_MOST_EYES = 2
_MOST_LOOKED_AT = 16  # of the refreshes in a row that show one picture; between them it is interpolated


class MissTally:
    """What the misses of a run cost, in bounded memory."""

    def __init__(self) -> None:
        self._refreshes = self._stale = self._longest = self._run = 0
        self._last_deg, self._squares = 0.0, 0.0

    def add(self, stale: bool, off_deg: float) -> None:
        """Add the next refresh.

        stale: whether it showed a picture again. off_deg: the angle by which things were seen off
        their place.
        """
        if self._refreshes:
            self._squares += (off_deg - self._last_deg) ** 2
        self._last_deg = off_deg
        self._refreshes += 1
        self._stale += stale
        self._run = self._run + 1 if stale else 0
        self._longest = max(self._longest, self._run)

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json, of one refresh at least.

        stale_share: 0..1. longest_stale: refreshes in a row without a new picture. judder_deg: RMS
        of the change of that angle from each refresh to the next; 0 for a single refresh.
        """
        judder = math.sqrt(self._squares / max(1, self._refreshes - 1))
        return {"stale_share": self._stale / self._refreshes, "longest_stale": self._longest, "judder_deg": judder}


class SeenOffset:
    """Angles between where points of the late frame are seen and where they are.

    The points are on a grid over the frame, as far away as its depth says; where it has no depth at
    all, infinitely far. turned: pictures are turned to the newest head, else they stand.
    """

    def __init__(self, *, turned: bool) -> None:
        self._turned = turned

    def between_deg(
        self, made: Refresh, depths: Iterable[Array], then: Refresh, missed: int, periods: int
    ) -> list[float]:
        """Return it for each of the missed refreshes that showed a picture again.

        depths: as of DepthSamples, of the frame of `made`. then: the next picture, so many periods
        later; the head keeps its speed in between.
        """
        every = [_points_of(i.rendered, depth) for i, depth in zip(made.inputs, depths, strict=True)]
        shares = np.arange(1, missed + 1) / periods
        looked_at = np.linspace(shares[0], shares[-1], min(missed, _MOST_LOOKED_AT))
        pairs = [(a.shown, b.shown) for a, b in zip(made.inputs, then.inputs, strict=False)]
        found = []
        for share in looked_at:
            views = zip(every, pairs, strict=False)
            angles = [self._angles(points, a, _between(a, b, float(share))) for points, (a, b) in views]
            found.append(float(np.degrees(np.sqrt(np.mean(np.concatenate(angles) ** 2)))))
        return [float(off) for off in np.interp(shares, looked_at, found)]

    def _angles(self, points: tuple[Array, Array], then: View, now: View) -> Array:
        seen, right = (_ways(points, view) for view in (then, now))
        if not self._turned:
            seen = seen @ then.pose.rotation_matrix @ now.pose.rotation_matrix.T
        apart, together = (np.linalg.norm(ways, axis=1) for ways in (seen - right, seen + right))
        return np.asarray(2 * np.arctan2(apart, together))


class DepthSamples:
    """Inverse depth of late frames at the points of a SeenOffset, without waiting for the GPU.

    take() starts; before() returns those of the refresh before, which are finished long ago.
    """

    def __init__(self, gpu: Gpu) -> None:
        self._gl = gpu.gl
        self._program = gpu.shaders.compute("live/depths.comp")
        size = 4 * _MOST_EYES * _POINTS**2
        self._now, self._before = (gpu.gl.buffer(reserve=size) for _ in range(2))

    def take(self, inputs: Sequence[PassInputs]) -> None:
        """Sample the frame of each eye. Call once for each picture."""
        self._now, self._before = self._before, self._now
        self._now.bind_to_storage_buffer(0)
        for slot, eye in enumerate(inputs):
            depth = eye.rendered.inverse_depth
            depth.bind_to_image(0, read=True, write=False)
            self._program.uniforms.set(inverse_depth=0, size=depth.size, points=_POINTS, slot=slot)
            self._program.run(_POINTS, _POINTS)
        self._gl.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)

    def before(self, eyes: int) -> list[Array]:
        """Return (17, 17) for each eye, the top row first, of the picture before the last one."""
        every = np.frombuffer(self._before.read(), np.float32).reshape(_MOST_EYES, _POINTS, _POINTS)
        return [flip_rows(one.astype(np.float64)) for one in every[:eyes]]

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self._now, self._before):
            buffer.release()


def _points_of(eye: EyeImage, depths: Array) -> tuple[Array, Array]:
    """Return the late frame's points in the world: (n, 3) times inverse depth, and that (n, 1)."""
    found = depths.reshape(-1, 1)
    inverse = np.where((found >= 0).any(), found, 0.0)
    ways = eye.view.rays((_POINTS, _POINTS)).reshape(-1, 3) @ eye.view.pose.rotation_matrix.T
    points, drawn = ways + eye.view.pose.position_m * inverse, inverse[:, 0] >= 0
    return points[drawn], inverse[drawn]


def _between(a: View, b: View, share: float) -> View:
    turned = quaternions.slerp(a.pose.orientation_xyzw.tolist(), b.pose.orientation_xyzw.tolist(), share)
    return View(Pose(a.pose.position_m + share * (b.pose.position_m - a.pose.position_m), turned), a.fov)


def _ways(points: tuple[Array, Array], view: View) -> Array:
    """Return the unit vectors, (n, 3), from an eye to the points."""
    ways = points[0] - view.pose.position_m * points[1]
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))
