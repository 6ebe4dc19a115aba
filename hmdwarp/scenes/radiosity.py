"""Converged light between matt surfaces: patch radiosity, solved once for a scene.

Source: Goral, Torrance, Greenberg and Battaile 1984, Modeling the Interaction of Light Between
Diffuse Surfaces; Cohen and Wallace 1993, Radiosity and Realistic Image Synthesis.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..errors import SceneError
from ._cache import cache_folder, read_arrays, write_arrays
from ._lamps import ATLAS, NEAREST_M, stopped

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from ._lamps import Lamp
    from ._mesh import Mesh, Texture
    from ._scene import Background, Scene

Array = NDArray[np.float64]
VERSION = 1  # of stored form factors; counted up with every change of them
RAYS = 512  # of a patch
# Places on a patch where light of lamps is looked up, (x, y) in texels from its middle: a Fibonacci
# lattice, which no straight edge of a shadow runs along.
# Source: Niederreiter 1992, Random Number Generation and Quasi-Monte Carlo Methods, chapter 5.
LOOKED_AT = np.stack([(np.arange(21) + 0.5) / 21, (np.arange(21) * 13 + 0.5) / 21 % 1], axis=1) - 0.5
# A ray starts this far in front of its surface, and a triangle reaches this share beyond its edges,
# so that no ray slips between two.
OFF_M, EDGE = 1e-4, 1e-6
_AT_ONCE = 1 << 21  # rays times triangles


@attrs.define(eq=False, slots=False)
class Blockers:
    """Triangles that stop light, from both sides.

    The rows take a point (x, y, z, 1) to the triangle's own axes: (u, v) along two edges, w along
    the normal in metres. A point is inside where u, v and 1 - u - v are 0 or more, w = 0.
    """

    corners: Array  # (n, 3, 3) metres

    @cached_property
    def rows(self) -> Array:
        """(n, 3, 4) of each triangle."""
        a, b, c = self.corners.transpose(1, 0, 2)
        normal = np.cross(b - a, c - a)
        normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
        turned = np.linalg.inv(np.stack([b - a, c - a, normal], axis=2)) if len(a) else np.empty((0, 3, 3))
        return np.concatenate([turned, -(turned @ a[..., None])], axis=2)

    def hits(self, origins: Array, ways: Array) -> tuple[Array, Array, Array]:
        """Return (r, n) of rays and triangles: how many `ways` to the hit, inf for none; u, v."""
        turned = self.rows.reshape(-1, 4)
        start = (origins @ turned[:, :3].T + turned[:, 3]).reshape(len(origins), -1, 3)
        step = (ways @ turned[:, :3].T).reshape(len(origins), -1, 3)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = -start[..., 2] / step[..., 2]
            u, v = start[..., 0] + t * step[..., 0], start[..., 1] + t * step[..., 1]
            inside = (u >= -EDGE) & (v >= -EDGE) & (u + v <= 1 + EDGE) & (t > 0)
        return np.where(inside, t, np.inf), u, v

    def first(self, origins: Array, ways: Array) -> tuple[NDArray[np.int64], Array, Array]:
        """Return of each ray the number of the first triangle, -1 for none, and u and v on it."""
        which, across, up = np.full(len(origins), -1), np.zeros(len(origins)), np.zeros(len(origins))
        size = max(1, _AT_ONCE // max(1, len(self.corners)))
        for start in range(0, len(origins) if len(self.corners) else 0, size):
            part = slice(start, start + size)
            t, u, v = self.hits(origins[part], ways[part])
            nearest = np.argmin(t, axis=1)
            rows = np.arange(len(t))
            which[part] = np.where(np.isfinite(t[rows, nearest]), nearest, -1)
            across[part], up[part] = u[rows, nearest], v[rows, nearest]
        return which, across, up

    def stop(self, origins: Array, ways: Array, longest: float) -> NDArray[np.bool_]:
        """Return whether something lies on each way, up to `longest` times the way."""
        stopped = np.zeros(len(origins), bool)
        size = max(1, _AT_ONCE // max(1, len(self.corners)))
        for start in range(0, len(origins) if len(self.corners) else 0, size):
            part = slice(start, start + size)
            stopped[part] = (self.hits(origins[part], ways[part])[0] < longest).any(axis=1)
        return stopped


@attrs.frozen(eq=False)
class Patches:
    """Matt pieces of surface, each one texel of the light atlas."""

    texels: NDArray[np.int64]  # (n, 2) column and row
    centres: Array  # (n, 3) metres
    normals: Array  # (n, 3)
    # (n, 3, 2) metres along the surface for each texel to the right and up.
    steps: Array
    albedo: Array  # (n, 3) linear

    def __len__(self) -> int:
        return len(self.texels)

    @property
    def areas(self) -> Array:
        """Square metres of each."""
        return np.linalg.norm(np.cross(self.steps[..., 0], self.steps[..., 1]), axis=1)

    def at(self, across: float | Array, up: float | Array) -> Array:
        """Return a point just before each, by texels from its centre."""
        return self.centres + self.steps[..., 0] * across + self.steps[..., 1] * up + OFF_M * self.normals


def lit_meshes(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the meshes that lamps light: they have places in the light atlas."""
    return [mesh for mesh in meshes if mesh.light_uv is not None]


def patches_of(meshes: Sequence[Mesh], textures: Sequence[Texture]) -> Patches:
    """Return a patch for each texel whose centre some lit triangle covers.

    Errors: SceneError where two triangles cover the same texel.
    """
    kinds: list[list[Array]] = [[] for _ in range(5)]
    for mesh in lit_meshes(meshes):
        texture = mean_colour(textures[mesh.texture]) if mesh.texture >= 0 else np.ones(3)
        albedo = mesh.albedo if mesh.albedo is not None else np.full_like(mesh.positions, 0.5)
        assert mesh.light_uv is not None
        for triangle in mesh.triangles:
            places = mesh.light_uv[triangle].astype(np.float64)
            low = np.floor(places.min(axis=0)).astype(int)
            high = np.ceil(places.max(axis=0)).astype(int)
            texels = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="xy"), axis=-1).reshape(-1, 2)
            edges = np.stack([places[1] - places[0], places[2] - places[0]], axis=1)
            if abs(np.linalg.det(edges)) < 1e-9:
                raise SceneError(f"mesh '{mesh.name}': a triangle has no area in the light atlas")
            inverse = np.linalg.inv(edges)
            # A texel on the common edge of two triangles is that of one: the offset breaks the tie.
            weights = (texels + 0.5 + (1e-6, -2e-6) - places[0]) @ inverse.T
            inside = (weights >= 0).all(axis=1) & (weights.sum(axis=1) < 1)
            weights, texels = (texels[inside] + 0.5 - places[0]) @ inverse.T, texels[inside]
            corner = mesh.positions[triangle].astype(np.float64)
            sides = np.stack([corner[1] - corner[0], corner[2] - corner[0]], axis=1)
            full = np.concatenate([1 - weights.sum(axis=1, keepdims=True), weights], axis=1)
            normals = full @ mesh.normals[triangle].astype(np.float64)
            found = (
                texels,
                full @ corner,
                normals / np.linalg.norm(normals, axis=1, keepdims=True),
                np.broadcast_to(sides @ inverse, (len(texels), 3, 2)),
                full @ albedo[triangle].astype(np.float64) * texture,
            )
            for kind, one in zip(kinds, found, strict=True):
                kind.append(one)
    shapes = ((0, 2), (0, 3), (0, 3), (0, 3, 2), (0, 3))
    texels, *rest = (np.concatenate([np.empty(s), *kind]) for kind, s in zip(kinds, shapes, strict=True))
    texels = texels.astype(np.int64)
    if len(np.unique(texels, axis=0)) < len(texels):
        raise SceneError("two triangles have the same texel of the light atlas: expected places of their own")
    if len(texels) and (texels.min() < 0 or (texels.max(axis=0) >= ATLAS).any()):
        raise SceneError(f"a mesh lies outside the light atlas of {ATLAS[0]}x{ATLAS[1]} texels: use wider texels")
    return Patches(texels, *rest)


def mean_colour(texture: Texture) -> Array:
    """Return the mean light of a texture, linear RGB."""
    image = texture.image[..., :3]
    linear = linear_from_srgb(image) if texture.srgb else image / 255
    return np.asarray(linear, np.float64).mean(axis=(0, 1))


@attrs.frozen(eq=False)
class Met:
    """What rays meet."""

    # (n,) of a patch; BLACK where light ends: behind a surface, or beside all patches.
    patch: NDArray[np.int64]
    places: Array  # (n, 3) metres
    texels: Array  # (n, 2) in the light atlas


SKY, BLACK = -1, -2


@attrs.define(eq=False, slots=False)
class Receivers:
    """The surfaces of a scene that get light, and stop it."""

    patches: Patches
    blockers: Blockers
    atlas: Array  # (triangles, 3, 2) places of the blockers' corners in the light atlas

    @cached_property
    def _number(self) -> NDArray[np.int64]:
        """(h, w) the patch of each texel, BLACK where there is none."""
        number = np.full(ATLAS[::-1], BLACK)
        number[self.patches.texels[:, 1], self.patches.texels[:, 0]] = np.arange(len(self.patches))
        return number

    @cached_property
    def _facing(self) -> Array:
        corners = self.blockers.corners
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    def meet(self, origins: Array, ways: Array) -> Met:
        """Return what each ray meets first; SKY as its patch where it meets nothing."""
        which, u, v = self.blockers.first(origins, ways)
        hit = np.flatnonzero(which >= 0)
        which, u, v = which[hit], u[hit, None], v[hit, None]
        patch, places, texels = np.full(len(origins), SKY), np.zeros((len(origins), 3)), np.zeros((len(origins), 2))
        for corners, out in ((self.blockers.corners, places), (self.atlas, texels)):
            a, b, c = corners[which].transpose(1, 0, 2)
            out[hit] = a + u * (b - a) + v * (c - a)
        column, row = np.clip(np.floor(texels[hit]).astype(int), 0, np.array(ATLAS) - 1).T
        front = (ways[hit] * self._facing[which]).sum(axis=1) < 0
        patch[hit] = np.where(front, self._number[row, column], BLACK)
        return Met(patch, places, texels)


@attrs.define(eq=False, slots=False)
class Transport:
    """How light goes from patch to patch of one scene."""

    receivers: Receivers
    form_factors: Array  # (n, n): the share of what leaves patch i that patch j gets
    sky: Array  # (n, 3) what each patch gets from the sky itself

    @property
    def patches(self) -> Patches:
        """Those that get light."""
        return self.receivers.patches

    @property
    def blockers(self) -> Blockers:
        """The triangles of their surfaces."""
        return self.receivers.blockers

    def direct(self, lamps: Sequence[tuple[Array, tuple[float, float, float]]]) -> Array:
        """Return (n, 3) what lamps give each patch, with shadows, as the mean over LOOKED_AT.

        lamps: (place, colour) of each, relative to the scene's origin, as of Lamp.
        """
        total = np.zeros((len(self.patches), 3))
        for across, up in LOOKED_AT:
            total += direct_light(self.blockers, self.patches.at(across, up), self.patches.normals, lamps)
        return total / len(LOOKED_AT)

    @cached_property
    def gathered(self) -> NDArray[np.float32]:
        """(3, n, n) F (I - rho F)^-1: from what each patch sends of first light to all indirect."""
        # In float32: light between surfaces of albedo 0.9 errs by 10 times its rounding.
        back, albedo = self.form_factors.T.astype(np.float32), self.patches.albedo.astype(np.float32)
        one = np.eye(len(back), dtype=np.float32)
        return np.array([np.linalg.solve(one - back * albedo[:, k], back).T for k in range(3)])

    def indirect(self, direct: Array) -> Array:
        """Return (n, 3) what each patch gets over any number of others, and from the sky."""
        sent = (self.patches.albedo * (direct + self.sky)).astype(np.float32)
        over_others = np.stack([self.gathered[k] @ sent[:, k] for k in range(3)], axis=1)
        return over_others + self.sky

    @cached_property
    def _nearest(self) -> NDArray[np.int64]:
        """(h, w) the patch whose light each texel of the atlas has: its own, or the nearest."""
        number = np.full(ATLAS[::-1], np.nan)
        number[self.patches.texels[:, 1], self.patches.texels[:, 0]] = np.arange(len(self.patches))
        return nearest_known(number).astype(np.int64)

    def atlas(self, values: Array) -> NDArray[np.float16]:
        """Return (h, w, 4) of (n, 3) values, bottom row first; borders repeat, coverage is 1."""
        picture = np.ones((*ATLAS[::-1], 4), np.float16)
        picture[..., :3] = values[self._nearest] if len(self.patches) else 0
        return picture


def nearest_known(values: Array) -> Array:
    """Return an atlas (h, w) with the nearest known value in place of nan; 0 without any."""
    from scipy.ndimage import distance_transform_edt

    if np.isnan(values).all():
        return np.zeros_like(values)
    rows, columns = distance_transform_edt(np.isnan(values), return_distances=False, return_indices=True)
    return np.asarray(values[rows, columns])


def direct_light(
    blockers: Blockers, points: Array, normals: Array, lamps: Sequence[tuple[Array, tuple[float, float, float]]]
) -> Array:
    """Return (n, 3) what lamps give to points with those normals; 0 in shadow."""
    total = np.zeros((len(points), 3))
    for place, colour in lamps:
        ways = place[:3] - points * place[3]
        square = np.maximum((ways**2).sum(axis=1), 1e-12)
        cosine = np.maximum((ways * normals).sum(axis=1) / np.sqrt(square), 0)
        falls = 1 / np.maximum(square, NEAREST_M**2) if place[3] else np.ones(len(points))
        seen = cosine > 0
        seen[seen] = ~blockers.stop(points[seen], ways[seen], 1.0 if place[3] else np.inf)
        total += (cosine * falls * seen)[:, None] * np.array(colour)
    return total


def with_lamps_stopped(scene: Scene, time_ns: int = 0) -> Scene:
    """Return the scene with its lamps where they are at that instant: what can be baked."""
    return attrs.evolve(scene, lamps=[stopped(lamp, time_ns) for lamp in scene.lamps]) if scene.lamps else scene


def lamps_at(scene: Scene, time_ns: int) -> list[tuple[Array, tuple[float, float, float]]]:
    """Return place and colour of the scene's lamps at an instant, relative to its origin."""
    return [(_seen_from(lamp, scene.origin_m, time_ns), lamp.colour) for lamp in scene.lamps]


def _seen_from(lamp: Lamp, origin: Array, time_ns: int) -> Array:
    place = lamp.place(time_ns)
    place[:3] -= place[3] * origin
    return place


def transport_of(scene: Scene, folder: Path | None = None, rays: int = RAYS) -> Transport:
    """Return how light goes through the scene; the same object for the same surfaces and sky.

    folder: where form factors are kept, the user's cache folder if None. One that cannot be read or
    written is no error.
    """
    return _transport(scene.meshes, scene.textures, scene.background, folder, rays)


@lru_cache(maxsize=4)
def _transport(
    every: tuple[Mesh, ...], textures: tuple[Texture, ...], background: Background, folder: Path | None, rays: int
) -> Transport:
    meshes, patches = lit_meshes(every), patches_of(every, textures)
    corners = np.concatenate([np.empty((0, 3, 3)), *(mesh.positions[mesh.triangles] for mesh in meshes)])
    places = np.concatenate(
        [np.empty((0, 3, 2)), *(mesh.light_uv[mesh.triangles] for mesh in meshes if mesh.light_uv is not None)]
    )
    receivers = Receivers(patches, Blockers(corners), places)
    path = (folder or cache_folder()) / f"light-{_key(background, patches, corners, rays)}.npz"
    count = len(patches)
    stored = read_arrays(path, ("form_factors", "sky"))
    if stored is not None and [one.shape for one in stored] == [(count, count), (count, 3)]:
        return Transport(receivers, *stored)
    factors, sky = _cast(receivers, background, rays)
    with suppress(OSError):
        write_arrays(path, {"form_factors": factors, "sky": sky})
    return Transport(receivers, factors, sky)


def _key(background: Background, patches: Patches, corners: Array, rays: int) -> str:
    digest = hashlib.sha256(f"{VERSION} {rays} {background}".encode())
    for array in (patches.texels, patches.centres, patches.normals, patches.steps, corners):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:40]


def _cast(receivers: Receivers, background: Background, rays: int) -> tuple[Array, Array]:
    """Return the form factors and the sky's light by rays spread evenly over cosine and patch.

    All patches use the same rays in their own axes: the error is as smooth as the light.
    """
    patches = receivers.patches
    count = len(patches)
    samples = _spread(rays)
    local = cosine_ways(samples)
    factors, sky = np.zeros((count, count)), np.zeros((count, 3))
    for i in range(count):
        right = patches.steps[i, :, 0] / np.linalg.norm(patches.steps[i, :, 0])
        axes = np.stack([right, np.cross(patches.normals[i], right), patches.normals[i]])
        ways = local @ axes
        starts = patches.centres[i] + (samples[:, 2:] - 0.5) @ patches.steps[i].T + OFF_M * patches.normals[i]
        found = receivers.meet(starts, ways).patch
        sky[i] = sky_light(background, ways[found == SKY]).sum(axis=0) / rays
        factors[i] = np.bincount(found[found >= 0], minlength=count) / rays
    return factors, sky


def cosine_ways(samples: Array) -> Array:
    """Return (n, 3) ways about +z, as many each way as its cosine. samples: (n, 2) in 0..1."""
    radius, angle = np.sqrt(samples[:, 0]), 2 * np.pi * samples[:, 1]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - samples[:, 0])], axis=1)


def _spread(count: int) -> Array:
    """Return (count, 4) points spread evenly in the unit cube.

    Source: Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences (R4).
    """
    ratio = 1.1673039782614187  # of x^5 = x + 1
    return (0.5 + np.arange(1, count + 1)[:, None] * ratio ** -np.arange(1.0, 5.0)) % 1


def sky_light(background: Background, ways: Array) -> Array:
    """Return (n, 3) the background in those directions, see Background."""
    share = np.sqrt(np.abs(ways[:, 1:2] / np.linalg.norm(ways, axis=1, keepdims=True)))
    end = np.where(ways[:, 1:2] > 0, background.zenith, background.ground)
    return (1 - share) * np.array(background.horizon) + share * end
