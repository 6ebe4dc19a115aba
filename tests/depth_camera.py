"""A depth camera in a rendered scene: frames as a real one gives them, and the truth beside them.
Its faults are those of the devices: noise that grows with the distance squared, no depth at edges
and beyond the range, depth that does not line up with colour, rows that are read one after the
other. Each can be switched off."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.base import srgb8_from_linear
from hmdwarp.geometry import Fov, Pose, View, metres_from_inverse_depth
from hmdwarp.gpu import download
from hmdwarp.sources.server import Server

EDGE = 0.05  # second difference of the inverse depth, over it: more is an edge


@attrs.frozen(eq=False)
class CameraFrame:
    """One picture with depth; top row first."""

    colour: NDArray[np.uint8]  # (h, w, 3) sRGB
    depth_m: NDArray[np.float64]  # (h, w) metres along -z as measured, 0 where there is none
    view: View  # of the colour, at time_ns
    time_ns: int
    truth_m: NDArray[np.float64]  # (h, w) metres along -z in the colour's view, inf for the sky


@attrs.frozen
class DepthCamera:
    """The camera and its faults."""

    size: tuple[int, int] = (96, 72)
    fov: Fov = Fov.symmetric(np.deg2rad(74), np.deg2rad(59))
    noise: float = 0.0  # Standard deviation of the depth over the depth squared, 1/m: 0.0025 is a Kinect
    # Nearest and farthest distance that is measured, metres.
    near_m: float = 0.0
    far_m: float = np.inf
    edge_gaps: float = 0.0  # share of the pixels beside an edge that have no depth
    shift: tuple[float, float] = (0.0, 0.0)  # Pixels that depth lies to the right of and below the colour
    # From the first row to the last; frames are stamped when the middle row is read.
    readout_ns: int = 0
    bands: int = 6  # of rows that are drawn for one instant each, where rows are read one by one

    def record(
        self,
        server: Server,
        world_from_eye_at: Callable[[int], Pose],
        times_ns: Iterable[int],
        rng: np.random.Generator,
    ) -> list[CameraFrame]:
        """Return a frame for each instant."""
        return [self._frame(server, world_from_eye_at, int(time_ns), rng) for time_ns in times_ns]

    def _frame(
        self, server: Server, world_from_eye_at: Callable[[int], Pose], time_ns: int, rng: np.random.Generator
    ) -> CameraFrame:
        colour = np.empty((*self.size[::-1], 3), np.float16)
        inverse, truth = np.empty(self.size[::-1]), np.empty(self.size[::-1])
        bands = self.bands if self.readout_ns else 1
        for band, rows in enumerate(np.array_split(np.arange(self.size[1]), bands)):
            instant = time_ns + round(((band + 0.5) / bands - 0.5) * self.readout_ns)
            pose = world_from_eye_at(instant)
            for fov, depth in ((self._depth_fov(), inverse), (self.fov, truth)):
                eye = server.draw(View(pose, fov), self.size, time_ns=instant)
                depth[rows] = download(eye.inverse_depth)[rows]
                if depth is truth:
                    colour[rows] = download(eye.colour)[rows, :, :3]
                server.pool(eye.size).release(eye.colour)
        return CameraFrame(
            srgb8_from_linear(colour), self.measured(inverse, rng), View(world_from_eye_at(time_ns), self.fov), time_ns,
            metres_from_inverse_depth(truth),
        )  # fmt: skip

    def _depth_fov(self) -> Fov:
        """Return the field of view whose picture is that of the colour, shifted."""
        left, right, down, up = self.fov.tangents
        x, y = self.shift[0] * (right - left) / self.size[0], self.shift[1] * (up - down) / self.size[1]
        return Fov.from_tangents((left - x, right - x, down + y, up + y))

    def measured(self, inverse: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Return the depth in metres that the camera measures of an inverse depth, 0 for none."""
        # Noise of the depth that grows with its square is the same everywhere in inverse depth.
        noisy = inverse + self.noise * rng.standard_normal(inverse.shape)
        with np.errstate(divide="ignore"):
            depth = np.where((inverse > 0) & (noisy > 0), 1 / noisy, 0)
        unseen = (depth < self.near_m) | (depth > self.far_m)
        unseen |= _beside_edges(inverse) & (rng.random(inverse.shape) < self.edge_gaps)
        return np.where(unseen, 0, depth)


def _beside_edges(inverse: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which pixels lie at an edge: inverse depth, linear on a plane, bends there."""
    found = np.zeros(inverse.shape, bool)
    for axis in (0, 1):
        rows = np.moveaxis(inverse, axis, 0)
        bend = np.abs(rows[:-2] - 2 * rows[1:-1] + rows[2:])
        np.moveaxis(found, axis, 0)[1:-1] |= bend > EDGE * rows[1:-1]
    return found
