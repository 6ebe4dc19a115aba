"""The moving parts of a scene on the GPU: bodies at their poses, meshes as they deform."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ...geometry import View
from ...gpu.context import Gpu
from ...scenes import Mesh, Scene
from .projection import eye_from_scene
from .upload import SceneBuffers, SceneTextures

STAYS = np.eye(4)
STAYS.flags.writeable = False


@attrs.frozen(eq=False)
class Place:
    """An eye in the space that positions are relative to."""

    # 4x4.
    eye_from_here: NDArray[np.float64]
    # (3,) metres.
    eye: NDArray[np.float64]


class Moving(ABC):
    """One thing that moves."""

    # The layer that describes its motion: the client of a frame with that layer moves it.
    layer: ClassVar[str]
    # Its triangles.
    buffers: SceneBuffers

    @abstractmethod
    def set_time(self, time_ns: int) -> None:
        """Move it to its place at that instant; do nothing for the same instant again."""

    @abstractmethod
    def place(self, view: View) -> Place:
        """Return the place of the view's eye at the instant set last."""

    def scene_from_here(self, time_ns: int) -> NDArray[np.float64]:
        """Return the 4x4 that takes its positions to the scene's axes at an instant."""
        return STAYS

    def close(self) -> None:
        """Free its buffers."""
        self.buffers.close()


class MovingBody(Moving):
    """All meshes of body number `number` (1 + its index)."""

    layer = "ids"

    def __init__(self, gpu: Gpu, scene: Scene, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.number = meshes[0].body
        self.buffers = SceneBuffers(gpu, meshes, textures)
        self._motion, self._origin_m = scene.bodies[self.number - 1].motion, scene.origin_m
        self._set_ns: int | None = None

    def set_time(self, time_ns: int) -> None:
        if time_ns != self._set_ns:
            self._pose, self._set_ns = self._motion.state(time_ns).pose, time_ns

    def place(self, view: View) -> Place:
        return Place(self._pose.relative_to(view.pose).matrix(), view.pose.relative_to(self._pose).position_m)

    def scene_from_here(self, time_ns: int) -> NDArray[np.float64]:
        matrix = self._motion.state(time_ns).pose.matrix()
        matrix[:3, 3] -= self._origin_m
        return matrix


class DeformingMesh(Moving):
    """One mesh whose vertices move by themselves: uploaded again for each instant that is drawn."""

    layer = "velocity"

    def __init__(self, gpu: Gpu, scene: Scene, mesh: Mesh, textures: SceneTextures) -> None:
        self.buffers = SceneBuffers(gpu, [mesh], textures)
        assert mesh.deformation is not None
        self.mesh, self._deformation, self._origin_m = mesh, mesh.deformation, scene.origin_m
        self._set_ns: int | None = None
        # The arrays that were moved, which may be replaced.
        self._moved = mesh

    def set_time(self, time_ns: int) -> None:
        if time_ns != self._set_ns or self.buffers.meshes[0] is not self._moved:
            self.buffers.move_to(self.positions(time_ns))
            self._set_ns, self._moved = time_ns, self.buffers.meshes[0]

    def positions(self, time_ns: int) -> NDArray[np.float32]:
        """Return its vertices, (n, 3) metres relative to the scene's origin, at any instant."""
        return _checked(self.mesh, "positions", self._deformation.positions(time_ns))

    def velocities(self) -> NDArray[np.float32]:
        """Return its vertices' velocities, (n, 3) m/s in world axes, at the last set instant."""
        assert self._set_ns is not None
        return _checked(self.mesh, "velocities", self._deformation.velocities(self._set_ns))

    def place(self, view: View) -> Place:
        return Place(eye_from_scene(view, self._origin_m), view.pose.position_m - self._origin_m)


def _checked(mesh: Mesh, what: str, values: NDArray[Any]) -> NDArray[np.float32]:
    """Return the values as float32.

    Errors: SceneError for another number of vertices than the mesh has, and for values that are not
    finite.
    """
    array = np.ascontiguousarray(values, np.float32)
    if array.shape != mesh.positions.shape:
        raise SceneError(
            f"mesh '{mesh.name}': its deformation gives {what} of shape {array.shape}, expected {mesh.positions.shape}"
        )
    if not np.isfinite(array).all():
        raise SceneError(f"mesh '{mesh.name}': its deformation gives {what} that are not finite numbers")
    return array


def moving_parts(gpu: Gpu, scene: Scene, textures: SceneTextures) -> tuple[Moving, ...]:
    """Return all moving surfaces of the scene."""
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
    numbers = sorted({mesh.body for mesh in surfaces if mesh.body})
    bodies = [
        MovingBody(gpu, scene, [mesh for mesh in surfaces if mesh.body == number], textures) for number in numbers
    ]
    return (*bodies, *(DeformingMesh(gpu, scene, mesh, textures) for mesh in surfaces if mesh.deformation is not None))
