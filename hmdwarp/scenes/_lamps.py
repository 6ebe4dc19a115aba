"""What lamps light and what stops their light; who finds the light between surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..options import NoSettings
from ..registry import Registry
from ._mesh import Mesh
from ._scene import Scene

Array = NDArray[np.float64]
Light = tuple[Array, tuple[float, float, float]]  # place and fading, colour; see lamps_at
LEAST_AREA = 1e-12  # of a triangle, twice, in m2: its axes are divided by this
CONVERGED = "converged"


class IndirectLight:
    """A way to find the light between surfaces under lamps; --indirect names it.

    That called CONVERGED is that of the truth; it has `atlas` in place of a layer.
    """

    name: ClassVar[str]
    Settings: ClassVar[type] = NoSettings
    layer: ClassVar[str] = ""  # whose amount its settings are

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        """Return why it is not for the scene, "" if it is."""
        return ""

    @classmethod
    def atlas(cls, scene: Scene, time_ns: int) -> NDArray[np.float16]:
        """Return what it finds for an instant as the light atlas, (h, w, 4), bottom row first."""
        raise NotImplementedError


lights: Registry[type[IndirectLight]] = Registry("indirect light", "", "lights")


def indirect_atlas(scene: Scene, time_ns: int) -> NDArray[np.float16]:
    """Return the converged light of an instant as the light atlas. Errors: SceneError."""
    if CONVERGED not in lights:
        what = f"scene '{scene.name}' has lamps, and no indirect light '{CONVERGED}' is installed"
        raise SceneError(f"{what}: install the whole of hmdwarp, or use a scene with baked light")
    return lights.get(CONVERGED).atlas(scene, time_ns)


def lit_meshes(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the meshes that stand still and that lamps light: they have places in the atlas."""
    return [mesh for mesh in meshes if mesh.light_uv is not None and not mesh.body]


def moved_meshes(scene: Scene, time_ns: int, meshes: Sequence[Mesh] | None = None) -> list[Mesh]:
    """Return the lit meshes of bodies, or of those given, in the scene's axes at an instant."""
    moved = []
    for mesh in scene.meshes if meshes is None else meshes:
        lit_ns = scene.lit_ns(time_ns)
        if mesh.light_uv is not None and mesh.body:
            pose = scene.bodies[mesh.body - 1].motion.state(lit_ns).pose
            positions = pose.transform(mesh.positions.astype(np.float64)) - scene.origin_m
            moved.append(attrs.evolve(mesh, positions=positions, normals=pose.rotation.apply(mesh.normals)))
    return moved


def with_lamps_stopped(scene: Scene, time_ns: int = 0) -> Scene:
    """Return the scene in the light of that instant, whatever moves: what can be baked."""
    return attrs.evolve(scene, light_ns=time_ns) if scene.lamps else scene


def lamps_at(scene: Scene, time_ns: int) -> list[Light]:
    """Return (place and fading, colour) of lamps, relative to the scene's origin."""
    at, origin = scene.lit_ns(time_ns), np.append(scene.origin_m, 0)
    places = ((lamp, lamp.place(at)) for lamp in scene.lamps)
    return [(np.append(place - place[3] * origin, lamp.fading(at)), lamp.light(at)) for lamp, place in places]


@attrs.frozen
class LitInstant:
    """An instant, which is another one where something lit is elsewhere."""

    where: bytes
    time_ns: int = attrs.field(eq=False)

    @classmethod
    def of(cls, scene: Scene, time_ns: int) -> LitInstant:
        """Return the instant in which the light is at `time_ns`."""
        lit_ns, lit = scene.lit_ns(time_ns), {mesh.body for mesh in scene.meshes if mesh.light_uv is not None} - {0}
        return cls(b"|".join(scene.bodies[number - 1].lit_as(lit_ns) for number in sorted(lit)), lit_ns)


def corners_of(meshes: Sequence[Mesh]) -> Array:
    return np.concatenate([np.empty((0, 3, 3)), *(mesh.positions[mesh.triangles] for mesh in meshes)])


def triangle_axes(corners: Array) -> Array:
    """Return (n, 3, 4) rows that take a point (x, y, z, 1) to each triangle's own axes.

    (u, v) along two edges, w along the normal in metres; inside u, v, 1 - u - v are 0 or more.
    """
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    turned = np.linalg.inv(np.stack([b - a, c - a, normal], axis=2)) if len(a) else np.empty((0, 3, 3))
    return np.concatenate([turned, -(turned @ a[..., None])], axis=2)


def blocking(scene: Scene, time_ns: int = 0, meshes: Sequence[Mesh] | None = None) -> Array:
    """Return the triangle_axes of what stops light at an instant, of the scene or these meshes."""
    if meshes is None:
        return _blocking_at(scene, LitInstant.of(scene, time_ns))
    corners = corners_of([*lit_meshes(meshes), *moved_meshes(scene, time_ns, meshes)])
    a, b, c = corners.transpose(1, 0, 2)
    return triangle_axes(corners[np.linalg.norm(np.cross(b - a, c - a), axis=1) > LEAST_AREA])


@lru_cache(maxsize=4)  # each pass of an instant asks
def _blocking_at(scene: Scene, instant: LitInstant) -> Array:
    return blocking(scene, instant.time_ns, scene.meshes)
