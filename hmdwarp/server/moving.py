"""What moves of a scene, on the GPU: each body at its pose, each deforming mesh as it is at an instant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from .projection import eye_from_scene
from .upload import SceneBuffers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..frames.frame import Needs
    from ..geometry import View
    from ..gpu.context import Gpu
    from ..scenes import Mesh, Scene
    from .upload import SceneTextures


@attrs.frozen(eq=False)
class Place:
    """How an eye stands to what positions are relative to. eye_from_here: 4x4. eye: (3,) where it is, in metres."""

    eye_from_here: NDArray[np.float64]
    eye: NDArray[np.float64]


class Moving(ABC):
    """One thing that moves. buffers: its triangles."""

    buffers: SceneBuffers

    @abstractmethod
    def set_time(self, time_ns: int) -> None:
        """Make it what it is at that instant; done once for each."""

    @abstractmethod
    def place(self, view: View) -> Place:
        """Of the view's eye at the instant set last."""

    @abstractmethod
    def moved_by_client(self, needs: Needs) -> bool:
        """Whether frames with these needs tell how it moves."""

    def close(self) -> None:
        """Free its buffers."""
        self.buffers.close()


class MovingBody(Moving):
    """All meshes of body number `number` (1 + its index)."""

    def __init__(self, gpu: Gpu, scene: Scene, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.number = meshes[0].body
        self.buffers = SceneBuffers(gpu, meshes, textures)
        self._motion = scene.bodies[self.number - 1].motion
        self._set_ns: int | None = None

    def set_time(self, time_ns: int) -> None:
        if time_ns != self._set_ns:
            self._pose, self._set_ns = self._motion.state(time_ns).pose, time_ns

    def place(self, view: View) -> Place:
        return Place(self._pose.relative_to(view.pose).matrix(), view.pose.relative_to(self._pose).position_m)

    def moved_by_client(self, needs: Needs) -> bool:
        return needs.ids


class DeformingMesh(Moving):
    """One mesh whose vertices move by themselves: written anew for each instant that is drawn."""

    def __init__(self, gpu: Gpu, scene: Scene, mesh: Mesh, textures: SceneTextures) -> None:
        self.buffers = SceneBuffers(gpu, [mesh], textures)
        self.mesh, self._origin_m = mesh, scene.origin_m
        self._set_ns: int | None = None

    def set_time(self, time_ns: int) -> None:
        if time_ns != self._set_ns:
            self.buffers.move_to(_checked(self.mesh, "positions", self.mesh.deformation.positions(time_ns)))
            self._set_ns = time_ns

    def velocities(self) -> NDArray[np.float32]:
        """(n, 3) m/s in world axes of its vertices at the instant set last."""
        return _checked(self.mesh, "velocities", self.mesh.deformation.velocities(self._set_ns))

    def place(self, view: View) -> Place:
        return Place(eye_from_scene(view, self._origin_m), view.pose.position_m - self._origin_m)

    def moved_by_client(self, needs: Needs) -> bool:
        return needs.velocity


def _checked(mesh: Mesh, what: str, found: NDArray) -> NDArray[np.float32]:
    """Errors: SceneError for another number of vertices than the mesh has, and for values that are not finite."""
    array = np.ascontiguousarray(found, np.float32)
    if array.shape != mesh.positions.shape:
        raise SceneError(
            f"mesh '{mesh.name}': its deformation gives {what} of shape {array.shape}, wanted {mesh.positions.shape}"
        )
    if not np.isfinite(array).all():
        raise SceneError(f"mesh '{mesh.name}': its deformation gives {what} that are not finite numbers")
    return array


def moving_parts(gpu: Gpu, scene: Scene, textures: SceneTextures) -> tuple[Moving, ...]:
    """Of the scene's surfaces all that do not stand still."""
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
    numbers = sorted({mesh.body for mesh in surfaces if mesh.body})
    bodies = [
        MovingBody(gpu, scene, [mesh for mesh in surfaces if mesh.body == number], textures) for number in numbers
    ]
    return (*bodies, *(DeformingMesh(gpu, scene, mesh, textures) for mesh in surfaces if mesh.deformation is not None))


def stands_still(mesh: Mesh) -> bool:
    """Whether it belongs to no body and does not deform."""
    return not mesh.body and mesh.deformation is None
