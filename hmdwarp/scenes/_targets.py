"""Targets to find: small bright balls at seeded places of a scene, all seen from its viewpoint."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ._scene import Scene
from ._viewpoint import Triangles
from .shapes import Ball

Array = NDArray[np.float64]
COLOUR = (1.0, 0.1, 0.8)  # linear; few scenes have it
_YAW_DEG, _PITCH_DEG = 90.0, 30.0  # from the viewpoint's own direction, either way
_NEAREST_M, _FARTHEST_M = 0.6, 5.0
_SHARE = (0.5, 0.9)  # of the way to what is behind
_APART = 3.0  # centres, in sizes of a target
_AT_ONCE, _TRIES = 32, 40
_RINGS = 12
_RIM = np.array([(0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])


def with_targets(scene: Scene, count: int, size_deg: float, seed: tuple[int, ...]) -> tuple[Scene, Array]:
    """Return the scene with `count` balls that shine evenly, and their (count, 3) places in metres.

    size_deg: of each, seen from the viewpoint. Nothing that stands still is before one of them or
    within it. Errors: InputError where the scene has no room for so many.
    """
    solid = [mesh for mesh in scene.meshes if mesh.is_surface and not mesh.body]
    triangles = Triangles.of([(mesh.positions + scene.origin_m, mesh.triangles) for mesh in solid])
    eye, turn = np.array(scene.viewpoint.position_m), np.array(scene.viewpoint.rotation_matrix)
    rng, half = np.random.default_rng(seed), np.radians(size_deg) / 2
    found: list[tuple[Array, float]] = []  # (direction, distance)
    for _ in range(_TRIES):
        angles = np.radians(rng.uniform((-_YAW_DEG, -_PITCH_DEG), (_YAW_DEG, _PITCH_DEG), (_AT_ONCE, 2)))
        share = rng.uniform(*_SHARE, _AT_ONCE)
        ways = _directions(angles) @ turn.T
        tried = _apart(ways, [way for way, _ in found], np.cos(_APART * 2 * half), count - len(found))
        if not tried:
            continue
        rim = _directions(angles[tried, None] + _RIM * half) @ turn.T
        free = triangles.first_hits(eye, rim.reshape(-1, 3))[0].reshape(rim.shape[:2]).min(axis=1)
        away = np.minimum(free, _FARTHEST_M) * share[tried]
        clear = (away * (1 + np.tan(half)) < free) & (away >= _NEAREST_M)
        found += [(ways[k], float(m)) for k, m, is_clear in zip(tried, away, clear, strict=True) if is_clear]
        if len(found) == count:
            return _placed(scene, eye, half, found)
    raise InputError(
        f"scene '{scene.name}' has room for {len(found)} of {count} targets of {size_deg:g} degrees: expected fewer, "
        "or smaller ones"
    )


def _apart(ways: Array, others: list[Array], cosine: float, most: int) -> list[int]:
    """Return up to `most` numbers of ways that are apart from the others and from each other."""
    chosen: list[int] = []
    for number, way in enumerate(ways):
        if len(chosen) < most and all(way @ other < cosine for other in (*others, *(ways[k] for k in chosen))):
            chosen.append(number)
    return chosen


def _placed(scene: Scene, eye: Array, half: float, found: list[tuple[Array, float]]) -> tuple[Scene, Array]:
    places = np.array([eye + direction * distance for direction, distance in found])
    meshes = []
    for number, (place, (_, distance)) in enumerate(zip(places - scene.origin_m, found, strict=True)):
        x, y, z = map(float, place)
        mesh = Ball((x, y, z), distance * float(np.sin(half)), -1, COLOUR).mesh(f"target-{number}", _RINGS)
        meshes.append(attrs.evolve(mesh, light=np.tile(COLOUR, (len(mesh.positions), 1))))
    return attrs.evolve(scene, meshes=(*scene.meshes, *meshes)), places


def _directions(angles: Array) -> Array:
    """Return unit vectors for (.., 2) yaw (left) and pitch (up) in radians, from -z."""
    yaw, pitch = angles[..., 0], angles[..., 1]
    return np.stack([-np.sin(yaw) * np.cos(pitch), np.sin(pitch), -np.cos(yaw) * np.cos(pitch)], axis=-1)
