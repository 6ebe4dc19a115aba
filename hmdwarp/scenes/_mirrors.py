"""Which of a scene's meshes mirror, put together to mirrors: one for all that lies in one plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..geometry import Mirror
from ..geometry.mirror import MOST_MIRRORS

if TYPE_CHECKING:
    from ._model import Mesh, Scene

SAME_DIRECTION = 1e-3  # rad, between the normals of one plane
SAME_PLANE_M = 1e-3


@attrs.frozen(eq=False)
class SceneMirror:
    """A mirror in world coordinates, the meshes it is made of, and the scene's texture that disturbs it (-1: none), by how much."""

    shape: Mirror
    meshes: tuple[Mesh, ...]
    normal_map: int
    normal_scale: float


def mirrors_of(scene: Scene) -> tuple[SceneMirror, ...]:
    """All mirrors of a scene, plane ones first; every curved mesh is one of its own, the ball around its vertices.

    Errors: SceneError for a mirror that is neither flat with one unit normal nor said to be curved, for one that moves, and for too many.
    """
    groups: dict[tuple, list[Mesh]] = {}
    for index, mesh in enumerate(scene.meshes):
        if not mesh.material.reflectivity:
            continue
        if mesh.body or mesh.deformation is not None:
            raise SceneError(
                f"mesh '{mesh.name}': a mirror that moves; wanted one that stands still, or no reflectivity"
            )
        what = mesh.material.reflectivity, mesh.material.normal_map, mesh.material.normal_scale
        key = (1, index) if mesh.material.curved else (0, *np.round(_plane_of(mesh), 3).tolist())
        groups.setdefault((*key, *what), []).append(mesh)
    if len(groups) > MOST_MIRRORS:
        raise SceneError(
            f"scene '{scene.name}' has {len(groups)} mirrors: wanted at most {MOST_MIRRORS}; what lies in one plane counts once"
        )
    ordered = sorted(groups.values(), key=lambda meshes: meshes[0].material.curved)
    materials = [meshes[0].material for meshes in ordered]
    return tuple(
        SceneMirror(_shape(meshes, scene.origin_m), tuple(meshes), material.normal_map, material.normal_scale)
        for meshes, material in zip(ordered, materials, strict=True)
    )


def _plane_of(mesh: Mesh) -> NDArray[np.float64]:
    """(4,) unit normal and distance from the scene's origin. Errors: SceneError if the mesh has not one normal, or is not flat."""
    normals, positions = mesh.normals.astype(np.float64), mesh.positions.astype(np.float64)
    told = f"mesh '{mesh.name}': a mirror without a normal"
    wanted = "a plane mirror is flat and has one unit normal at all its vertices; a curved one says so (curved=True)"
    if not len(mesh.triangles) or np.abs(np.linalg.norm(normals, axis=1) - 1).max() > SAME_DIRECTION:
        raise SceneError(f"{told}: it has no triangles, or normals that are not of length 1; {wanted}")
    mean = normals.mean(axis=0)
    mean /= max(np.linalg.norm(mean), 1e-30)
    apart = np.linalg.norm(normals - mean, axis=1).max()
    if apart > SAME_DIRECTION:
        raise SceneError(
            f"{told}: its normals differ by up to {np.degrees(2 * np.arcsin(min(apart / 2, 1))):.3g} degrees; {wanted}"
        )
    distances = positions @ mean
    if np.ptp(distances) > SAME_PLANE_M:
        raise SceneError(
            f"{told}: its vertices leave a plane by {np.ptp(distances) * 1e3:.3g} mm along its normals; {wanted}"
        )
    a, b, c = (positions[mesh.triangles[:, i]] for i in range(3))
    if (np.cross(b - a, c - a) @ mean < 0).any():
        raise SceneError(f"{told}: some triangles face the other way than their normals; {wanted}")
    return np.array([*mean, distances.mean()])


def _shape(meshes: list[Mesh], origin_m: NDArray) -> Mirror:
    positions = np.concatenate([mesh.positions for mesh in meshes]).astype(np.float64)
    reflectivity = meshes[0].material.reflectivity
    if meshes[0].material.curved:
        centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
        radius = float(np.linalg.norm(positions - centre, axis=1).max())
        if not radius:
            raise SceneError(
                f"mesh '{meshes[0].name}': a curved mirror of no size; wanted a ball or something like one"
            )
        return Mirror(centre + origin_m, radius_m=radius, reflectivity=reflectivity)
    normal = _plane_of(meshes[0])[:3]
    right = _along_u(meshes[0], normal)
    up = np.cross(normal, right)
    low, high = (np.array([extreme(positions @ axis) for axis in (right, up)]) for extreme in (np.min, np.max))
    across, along = (high - low) / 2
    middle = (low + high) / 2
    centre = right * middle[0] + up * middle[1] + normal * float((positions @ normal).mean())
    return Mirror(centre + origin_m, right * max(across, 1e-6), up * max(along, 1e-6), reflectivity=reflectivity)


def _along_u(mesh: Mesh, normal: NDArray) -> NDArray[np.float64]:
    """Unit vector in the plane along which u grows, where a normal map has its x; any in the plane if u does not grow."""
    places = np.column_stack([mesh.uv, np.ones(len(mesh.uv))]).astype(np.float64)
    along = np.linalg.lstsq(places, mesh.positions.astype(np.float64), rcond=None)[0][0]
    along -= normal * (along @ normal)
    if np.linalg.norm(along) < 1e-9:
        along = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    return along / np.linalg.norm(along)
