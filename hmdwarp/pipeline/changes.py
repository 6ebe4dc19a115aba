"""How much a new frame would differ from the last one that was sent, in pixels."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from itertools import product

import attrs
import numpy as np
from numpy.typing import NDArray

from ..frames import EyeImage, Frame
from ..geometry import View, WarpMap
from ..gpu.textures import download
from ..scenes import Body, Mesh, Scene

# A frame is sent if something may have moved by more than this.
SEEN_PX = 0.5
# A row and a column of the picture where the head's motion is looked at, its sides among them.
_LINES = 17
# A body that comes closer to an eye than this counts as near without bound.
_NEAREST_M = 0.01

Points = NDArray[np.float64]


@attrs.frozen(eq=False)
class _Sent:
    # One for each eye, and the largest inverse depth in its layers.
    eyes: tuple[tuple[EyeImage, float], ...]
    drawn_ns: int


class Changes:
    """Bound how far anything has moved on the screen since the last frame that was sent.

    The head's motion is that of the warp map, for points infinitely far and as near as the nearest
    in the frame. To it comes the largest motion of a body or of a deforming mesh, wherever it is.
    Whatever else changes the picture counts without bound: light of lamps that have moved, the
    light that a body stops, another recorded frame.

    content: tells what a renderer without a scene shows at an instant from what it shows at others.
    """

    def __init__(self, scene: Scene, content: Callable[[int], object] = lambda time_ns: None) -> None:
        self._scene, self._content = scene, content
        self._stops_light = sorted({mesh.body for mesh in scene.meshes if mesh.light_uv is not None} - {0})
        moving = [mesh for mesh in scene.meshes if not mesh.material.head_locked]
        bodies = {mesh.body: [other for other in moving if other.body == mesh.body] for mesh in moving if mesh.body}
        self._movers: list[_Mover] = [_MovedBody(scene.bodies[n - 1], meshes) for n, meshes in bodies.items()]
        self._movers += [_DeformedMesh(mesh, scene.origin_m) for mesh in moving if mesh.deformation is not None]
        self._sent: _Sent | None = None

    def sent(self, frame: Frame) -> None:
        """Compare with this frame from now on; waits until it has been drawn."""
        self._sent = _Sent(tuple((eye, _nearest(eye)) for eye in frame.eyes), frame.drawn_ns)

    def moved_px(self, views: Sequence[View], now_ns: int) -> float:
        """Return a bound for a frame drawn now for these views; infinite before the first.

        In pixels of the frame that was sent.
        """
        if self._sent is None or len(views) != len(self._sent.eyes):
            return math.inf
        then_ns = self._sent.drawn_ns
        if self._content(then_ns) != self._content(now_ns) or self.light_at(then_ns) != self.light_at(now_ns):
            return math.inf
        return max(
            _by_head(eye, view, nearest) + self._by_movers(eye, view, then_ns, now_ns)
            for (eye, nearest), view in zip(self._sent.eyes, views, strict=True)
        )

    def light_at(self, time_ns: int) -> object:
        """Return what tells the light of an instant from that of others; None where it is baked."""
        if not self._scene.lamps:
            return None
        lit_ns = self._scene.lit_ns(time_ns)
        poses = (self._scene.bodies[number - 1].motion.state(lit_ns).pose for number in self._stops_light)
        return (
            tuple(tuple(lamp.place(lit_ns).tolist()) for lamp in self._scene.lamps),
            tuple(pose.matrix().tobytes() for pose in poses),
        )

    def _by_movers(self, eye: EyeImage, view: View, then_ns: int, now_ns: int) -> float:
        places = (eye.view.pose.position_m, view.pose.position_m)
        angles = (mover.moved_rad(places, then_ns, now_ns) for mover in self._movers)
        return max(angles, default=0.0) * _pixels_per_rad(eye)


class _Mover(ABC):
    """Something that moves by itself."""

    @abstractmethod
    def points(self, time_ns: int) -> Points:
        """Return (n, 3) points in the world.

        No other of its points moves farther or lies outside the box around them.
        """

    def moved_rad(self, places: Sequence[Points], then_ns: int, now_ns: int) -> float:
        """Return a bound on the angle by which a point has moved, seen from any of the places."""
        then, now = self.points(then_ns), self.points(now_ns)
        far_m = float(np.linalg.norm(now - then, axis=1).max(initial=0.0))
        if not far_m:
            return 0.0
        near_m = min(_distance(place, points) for place in places for points in (then, now))
        return far_m / near_m if near_m > _NEAREST_M else math.inf


class _MovedBody(_Mover):
    def __init__(self, body: Body, meshes: Sequence[Mesh]) -> None:
        positions = np.concatenate([mesh.positions for mesh in meshes]).astype(np.float64)
        ends = zip(positions.min(axis=0), positions.max(axis=0), strict=True)
        self._corners = np.array([(*corner, 1.0) for corner in product(*ends)])
        self._motion = body.motion

    def points(self, time_ns: int) -> Points:
        # A rigid motion moves no point of a box farther than one of its corners.
        return (self._corners @ self._motion.state(time_ns).pose.matrix().T)[:, :3]


class _DeformedMesh(_Mover):
    def __init__(self, mesh: Mesh, origin_m: Points) -> None:
        assert mesh.deformation is not None
        self._deformation, self._origin_m = mesh.deformation, origin_m

    def points(self, time_ns: int) -> Points:
        return np.asarray(self._deformation.positions(time_ns), np.float64) + self._origin_m


def _distance(place: Points, points: Points) -> float:
    """Return the distance to the sphere around the box around the points."""
    low, high = points.min(axis=0), points.max(axis=0)
    return float(np.linalg.norm(place - (low + high) / 2) - np.linalg.norm(high - low) / 2)


def _pixels_per_rad(eye: EyeImage) -> float:
    """Return the most pixels that an angle covers: in a corner of the picture, to its middle."""
    left, right, down, up = eye.view.fov.tangents
    per_tangent = max(eye.size[0] / (right - left), eye.size[1] / (up - down))
    return float(per_tangent * (1 + max(left * left, right * right) + max(down * down, up * up)))


def _by_head(eye: EyeImage, view: View, nearest: float) -> float:
    moved = WarpMap.between(eye.view, eye.size, View(view.pose, eye.view.fov), eye.size)
    x, y = (np.linspace(0.0, side, _LINES) for side in eye.size)
    pixels = np.stack(np.meshgrid(x, y), axis=-1)
    ends = [moved.apply(pixels, np.full(pixels.shape[:2], depth))[0] for depth in (0.0, nearest)]
    far = max(float(np.linalg.norm(end - pixels, axis=-1).max()) for end in ends)
    return far if math.isfinite(far) else math.inf


def _nearest(eye: EyeImage) -> float:
    """Return the largest inverse depth of any layer, 0 where all is infinitely far."""
    depths = (texture for texture in eye.textures() if (texture.components, texture.dtype) == (1, "f4"))
    return max(0.0, *(float(np.nanmax(download(texture))) for texture in depths))
