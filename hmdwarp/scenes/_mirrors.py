"""Mirrors of a scene, put together from its meshes: one for all that lies in one plane."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..geometry import Mirror
from ..geometry.mirror import MOST_MIRRORS
from ._mesh import Mesh

SAME_DIRECTION = 1e-3  # rad, between the normals of one plane
SAME_PLANE_M = 1e-3


@attrs.frozen(eq=False)
class SceneMirror:
    """A mirror in world coordinates and the meshes it is made of."""

    shape: Mirror
    meshes: tuple[Mesh, ...]
    # Index of the texture that disturbs the reflection, -1 for none; and by how much.
    normal_map: int
    normal_scale: float


def mirrors_of(scene: str, meshes: Sequence[Mesh], origin_m: NDArray[np.float64]) -> tuple[SceneMirror, ...]:
    """Return all mirrors of the scene called `scene`, plane ones first.

    Each curved mesh is a mirror of its own, the ball around its vertices.
    Errors: SceneError for a plane mirror that is not flat with one unit normal, for a mirror that
    moves, and for more than MOST_MIRRORS.
    """
    groups: dict[tuple, list[Mesh]] = {}
    for index, mesh in enumerate(meshes):
        if not mesh.material.reflectivity:
            continue
        if mesh.body or mesh.deformation is not None:
            raise SceneError(f"mesh '{mesh.name}': a mirror that moves; keep it still or set its reflectivity to 0")
        what = mesh.material.reflectivity, mesh.material.normal_map, mesh.material.normal_scale
        key = (1, index) if mesh.material.curved else (0, *np.round(_plane_of(mesh), 3).tolist())
        groups.setdefault((*key, *what), []).append(mesh)
    if len(groups) > MOST_MIRRORS:
        raise SceneError(
            f"scene '{scene}' has {len(groups)} mirrors: expected at most {MOST_MIRRORS}; one plane counts once"
        )
    ordered = sorted(groups.values(), key=lambda group: group[0].material.curved)
    materials = [group[0].material for group in ordered]
    return tuple(
        SceneMirror(_shape(group, origin_m), tuple(group), material.normal_map, material.normal_scale)
        for group, material in zip(ordered, materials, strict=True)
    )


def _plane_of(mesh: Mesh) -> NDArray[np.float64]:
    """Return (4,) unit normal and distance from the scene's origin."""
    normals, positions = mesh.normals.astype(np.float64), mesh.positions.astype(np.float64)
    fault = f"mesh '{mesh.name}': a mirror without a normal"
    remedy = "a plane mirror is flat with one unit normal at all vertices; mark others as curved (curved=True)"
    if not len(mesh.triangles) or np.abs(np.linalg.norm(normals, axis=1) - 1).max() > SAME_DIRECTION:
        raise SceneError(f"{fault}: it lacks triangles, or its normals are not of length 1; {remedy}")
    mean = normals.mean(axis=0)
    mean /= max(float(np.linalg.norm(mean)), 1e-30)
    apart = np.linalg.norm(normals - mean, axis=1).max()
    if apart > SAME_DIRECTION:
        degrees = np.degrees(2 * np.arcsin(min(apart / 2, 1)))
        raise SceneError(f"{fault}: its normals differ by up to {degrees:.3g} degrees; {remedy}")
    distances = positions @ mean
    if np.ptp(distances) > SAME_PLANE_M:
        raise SceneError(
            f"{fault}: its vertices leave a plane by {np.ptp(distances) * 1e3:.3g} mm along its normals; {remedy}"
        )
    a, b, c = (positions[mesh.triangles[:, i]] for i in range(3))
    if (np.cross(b - a, c - a) @ mean < 0).any():
        raise SceneError(f"{fault}: some triangles face away from their normals; {remedy}")
    return np.array([*mean, distances.mean()])


def _shape(meshes: list[Mesh], origin_m: NDArray[np.float64]) -> Mirror:
    positions = np.concatenate([mesh.positions for mesh in meshes]).astype(np.float64)
    reflectivity = meshes[0].material.reflectivity
    if meshes[0].material.curved:
        centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
        radius = float(np.linalg.norm(positions - centre, axis=1).max())
        if not radius:
            raise SceneError(f"mesh '{meshes[0].name}': a curved mirror of no size; expected a ball or similar")
        return Mirror(centre + origin_m, radius_m=radius, reflectivity=reflectivity)
    normal = _plane_of(meshes[0])[:3]
    right = _along_u(meshes[0], normal)
    up = np.cross(normal, right)
    low, high = (np.array([extreme(positions @ axis) for axis in (right, up)]) for extreme in (np.min, np.max))
    across, along = (high - low) / 2
    middle = (low + high) / 2
    centre = right * middle[0] + up * middle[1] + normal * float((positions @ normal).mean())
    return Mirror(centre + origin_m, right * max(across, 1e-6), up * max(along, 1e-6), reflectivity=reflectivity)


def _along_u(mesh: Mesh, normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit vector in the plane along which u grows; any in the plane if u is constant.

    A normal map has its x there.
    """
    places = np.column_stack([mesh.uv, np.ones(len(mesh.uv))]).astype(np.float64)
    along = np.linalg.lstsq(places, mesh.positions.astype(np.float64), rcond=None)[0][0]
    along -= normal * (along @ normal)
    if np.linalg.norm(along) < 1e-9:
        along = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    return along / np.linalg.norm(along)
