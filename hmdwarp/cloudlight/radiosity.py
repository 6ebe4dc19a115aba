"""Converged light between matt surfaces: patch radiosity, solved once for a scene.

Source: Goral, Torrance, Greenberg and Battaile 1984, Modeling the Interaction of Light Between
Diffuse Surfaces; Cohen and Wallace 1993, Radiosity and Realistic Image Synthesis.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import SceneError, linear_from_srgb
from ..scenes import (
    ATLAS,
    LEAST_AREA,
    NEAREST_M,
    Background,
    IndirectLight,
    Light,
    LitInstant,
    Mesh,
    Scene,
    Texture,
    corners_of,
    lamps_at,
    lights,
    lit_meshes,
    moved_meshes,
    triangle_axes,
)

Array = NDArray[np.float64]
VERSION = 2  # of stored rays; counted up with every change of them
RAYS = 512  # of a patch
# Places on a patch where light of lamps is looked up, (x, y) in texels from its middle: a Fibonacci
# lattice, which no straight edge of a shadow runs along.
# Source: Niederreiter 1992, Random Number Generation and Quasi-Monte Carlo Methods, chapter 5.
LOOKED_AT = np.stack([(np.arange(21) + 0.5) / 21, (np.arange(21) * 13 + 0.5) / 21 % 1], axis=1) - 0.5
# A ray starts this far in front of its surface, and a triangle reaches this share beyond its edges,
# so that no ray slips between two.
OFF_M, EDGE = 1e-4, 1e-6
_AT_ONCE = 1 << 15  # rays times triangles: what a cache holds is three times as quick
# Of what moves, light is solved bounce by bounce until one adds no more than this share of all. The
# atlas rounds to 2^-11.
_ENOUGH, _MOST_BOUNCES = 2.0**-18, 1000


@attrs.define(eq=False, slots=False)
class _Blockers:
    """Triangles that stop light, from both sides."""

    corners: Array  # (n, 3, 3) metres

    @cached_property
    def rows(self) -> Array:
        """(n, 3, 4), see triangle_axes."""
        return triangle_axes(self.corners)

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

    def first(self, origins: Array, ways: Array) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Return of each ray the first triangle's number, -1 for none; u and v; how many `ways`."""
        which, far = np.full(len(origins), -1), np.full(len(origins), np.inf)
        across, up = np.zeros(len(origins)), np.zeros(len(origins))
        size = max(1, _AT_ONCE // max(1, len(self.corners)))
        for start in range(0, len(origins) if len(self.corners) else 0, size):
            part = slice(start, start + size)
            t, u, v = self.hits(origins[part], ways[part])
            nearest = np.argmin(t, axis=1)
            rows = np.arange(len(t))
            which[part] = np.where(np.isfinite(t[rows, nearest]), nearest, -1)
            across[part], up[part], far[part] = u[rows, nearest], v[rows, nearest], t[rows, nearest]
        return which, across, up, far

    def stop(self, origins: Array, ways: Array, longest: float) -> NDArray[np.bool_]:
        """Return whether something lies on each way, up to `longest` times the way."""
        stopped = np.zeros(len(origins), bool)
        size = max(1, _AT_ONCE // max(1, len(self.corners)))
        for start in range(0, len(origins) if len(self.corners) else 0, size):
            part = slice(start, start + size)
            stopped[part] = (self.hits(origins[part], ways[part])[0] < longest).any(axis=1)
        return stopped


@attrs.frozen(eq=False)
class _Patches:
    """Matt pieces of surface, each one texel of the light atlas."""

    texels: NDArray[np.int64]  # (n, 2) column and row
    centres: Array  # (n, 3) metres
    normals: Array  # (n, 3)
    steps: Array  # (n, 3, 2) metres along the surface for each texel to the right and up
    albedo: Array  # (n, 3) linear
    bodies: NDArray[np.int64]  # (n,) that each belongs to, 0 for what stands still

    def __len__(self) -> int:
        return len(self.texels)

    @property
    def areas(self) -> Array:
        """Square metres of each."""
        return np.asarray(np.linalg.norm(np.cross(self.steps[..., 0], self.steps[..., 1]), axis=1))

    def at(self, across: float | Array, up: float | Array) -> Array:
        """Return a point just before each, by texels from its centre."""
        return self.centres + self.steps[..., 0] * across + self.steps[..., 1] * up + OFF_M * self.normals


def _patches_of(meshes: Sequence[Mesh], textures: Sequence[Texture]) -> _Patches:
    """Return a patch for each texel whose centre some triangle covers."""
    kinds: list[list[Array]] = [[] for _ in range(6)]
    for mesh in meshes:
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
            if np.linalg.norm(np.cross(*sides.T)) <= LEAST_AREA:
                raise SceneError(f"mesh '{mesh.name}': a triangle has no area, but a place in the light atlas")
            full = np.concatenate([1 - weights.sum(axis=1, keepdims=True), weights], axis=1)
            normals = full @ mesh.normals[triangle].astype(np.float64)
            found = (
                texels,
                full @ corner,
                normals / np.linalg.norm(normals, axis=1, keepdims=True),
                np.broadcast_to(sides @ inverse, (len(texels), 3, 2)),
                full @ albedo[triangle].astype(np.float64) * texture,
                np.full(len(texels), mesh.body),
            )
            for kind, one in zip(kinds, found, strict=True):
                kind.append(one)
    shapes = ((0, 2), (0, 3), (0, 3), (0, 3, 2), (0, 3), (0,))
    texels, *rest = [np.concatenate([np.empty(s), *kind]) for kind, s in zip(kinds, shapes, strict=True)]
    return _Patches(texels.astype(np.int64), rest[0], rest[1], rest[2], rest[3], rest[4].astype(np.int64))


@lru_cache(maxsize=64)  # what moves has the same textures at each instant
def mean_colour(texture: Texture) -> Array:
    """Return the mean light of a texture, linear RGB."""
    image = texture.image[..., :3]
    linear = linear_from_srgb(image) if texture.srgb else image / 255
    return np.asarray(np.asarray(linear, np.float64).mean(axis=(0, 1)))


@attrs.frozen(eq=False)
class Met:
    """What rays meet."""

    patch: NDArray[np.int64]  # (n,) of a patch; BLACK where light ends: behind a surface, or outside all patches
    places: Array  # (n, 3) metres
    texels: Array  # (n, 2) in the light atlas
    far: Array  # (n,) how many `ways`; inf where they meet nothing


SKY, BLACK = -1, -2


@attrs.define(eq=False, slots=False)
class _Receivers:
    """The surfaces of a scene that get light, and stop it."""

    patches: _Patches
    blockers: _Blockers
    atlas: Array  # (triangles, 3, 2) places of the blockers' corners in the light atlas
    still: _Receivers | None = None  # the first of them, where others follow that move

    def arriving(self, place: Array) -> Array:
        """Return (len(LOOKED_AT), n) the share of a lamp's light that comes there on each patch.

        place: as of lamps_at(). The shadows among what stands still are looked up once.
        """
        if self.still is None:
            return _arriving(self, place.tobytes())
        own, moved = len(self.still.patches), _Blockers(self.blockers.corners[len(self.still.blockers.corners) :])
        first = _shares(moved, self.patches, slice(own), place, self.still.arriving(place) > 0)
        return np.concatenate([first, _shares(self.blockers, self.patches, slice(own, None), place)], axis=1)

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
        which, u, v, far = self.blockers.first(origins, ways)
        hit = np.flatnonzero(which >= 0)
        which, u, v = which[hit], u[hit, None], v[hit, None]
        patch, places, texels = np.full(len(origins), SKY), np.zeros((len(origins), 3)), np.zeros((len(origins), 2))
        for corners, out in ((self.blockers.corners, places), (self.atlas, texels)):
            a, b, c = corners[which].transpose(1, 0, 2)
            out[hit] = a + u * (b - a) + v * (c - a)
        column, row = np.clip(np.floor(texels[hit]).astype(int), 0, np.array(ATLAS) - 1).T
        front = (ways[hit] * self._facing[which]).sum(axis=1) < 0
        patch[hit] = np.where(front, self._number[row, column], BLACK)
        return Met(patch, places, texels, far)


@attrs.frozen(eq=False)
class _Rays:
    """What some patches see along rays spread evenly over cosine and patch: each a like share."""

    starts: Array  # (n, r, 3) metres
    ways: Array  # (n, r, 3) unit vectors
    patch: NDArray[np.int16]  # (n, r) as of Met
    far: NDArray[np.float32]  # (n, r) metres

    def form_factors(self, count: int) -> Array:
        """Return (n, count) what share of what comes to each patch each of all sends."""
        own, rays = self.patch.shape
        met = (np.arange(own)[:, None] * count + self.patch)[self.patch >= 0]
        return np.asarray(np.bincount(met, minlength=own * count).reshape(own, count) / rays)

    def sky(self, background: Background) -> Array:
        """Return (n, 3) what each patch gets from the sky itself."""
        open_, own = self.patch == SKY, np.nonzero(self.patch == SKY)[0]
        light = sky_light(background, self.ways[open_])
        sums = [np.bincount(own, light[:, k], len(self.patch)) for k in range(3)]
        return np.asarray(np.stack(sums, axis=1) / self.patch.shape[1])


@attrs.define(eq=False, slots=False)
class Transport:
    """How light goes from patch to patch of one scene, at one instant if something lit moves."""

    receivers: _Receivers
    form_factors: Array  # (n, n): the share of what leaves patch i that patch j gets
    sky: Array  # (n, 3) what each patch gets from the sky itself
    is_moving: bool = False

    @property
    def patches(self) -> _Patches:
        """Those that get light."""
        return self.receivers.patches

    @property
    def blockers(self) -> _Blockers:
        """The triangles of their surfaces."""
        return self.receivers.blockers

    def direct(self, lamps: Sequence[Light]) -> Array:
        """Return (n, 3) what lamps give each patch, with shadows, as the mean over LOOKED_AT.

        lamps: as lamps_at() returns them.
        """
        total, every = np.zeros((len(self.patches), 3)), [self.receivers.arriving(place) for place, _ in lamps]
        for shares in zip(*every, strict=True):
            total += sum(share[:, None] * np.array(colour) for share, (_, colour) in zip(shares, lamps, strict=True))
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
        if self.is_moving:
            return self._bounced(sent) + self.sky
        over_others = np.stack([self.gathered[k] @ sent[:, k] for k in range(3)], axis=1)
        return over_others + self.sky

    def _bounced(self, sent: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return (n, 3) what each gets of `sent`, for an instant that is used once or twice."""
        factors, albedo = self.form_factors.astype(np.float32), self.patches.albedo.astype(np.float32)
        gets: NDArray[np.float32] = factors @ sent
        for _ in range(_MOST_BOUNCES):
            before, gets = gets, factors @ (sent + albedo * gets)
            if np.abs(gets - before).max(initial=0.0) <= _ENOUGH * np.abs(gets).max(initial=0.0):
                break
        return gets

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


def direct_light(blockers: _Blockers, points: Array, normals: Array, lamps: Sequence[Light]) -> Array:
    """Return (n, 3) what lamps give to points with those normals; 0 in shadow."""
    total = np.zeros((len(points), 3))
    for place, colour in lamps:
        total += _share(blockers, points, normals, place)[:, None] * np.array(colour)
    return total


def _share(
    blockers: _Blockers, points: Array, normals: Array, place: Array, lit: NDArray[np.bool_] | None = None
) -> Array:
    """Return (n,) the share of a lamp's light that points get. lit: False where that is none."""
    ways = place[:3] - points * place[3]
    square = np.maximum((ways**2).sum(axis=1), 1e-12)
    cosine = np.maximum((ways * normals).sum(axis=1) / np.sqrt(square), 0)
    falls = 1 / np.maximum(square, NEAREST_M**2) if place[3] else np.ones(len(points))
    fades = faded(place, -ways / np.sqrt(square)[:, None])
    seen = (cosine > 0) & (fades > 0) & (True if lit is None else lit)
    seen[seen] = ~blockers.stop(points[seen], ways[seen], 1.0 if place[3] else np.inf)
    return np.asarray(cosine * falls * fades * seen)


def _shares(
    blockers: _Blockers, patches: _Patches, which: slice, place: Array, lit: NDArray[np.bool_] | None = None
) -> Array:
    """Return (len(LOOKED_AT), n) of _share on some patches."""
    points = patches.at(*LOOKED_AT.T[..., None, None])[:, which].reshape(-1, 3)
    normals = np.tile(patches.normals[which], (len(LOOKED_AT), 1))
    share = _share(blockers, points, normals, place, None if lit is None else lit.ravel())
    return share.reshape(len(LOOKED_AT), -1)


@lru_cache(maxsize=32)  # 150 kB each; runs of one scene look at the same instants
def _arriving(receivers: _Receivers, place: bytes) -> Array:
    share = _shares(receivers.blockers, receivers.patches, slice(None), np.frombuffer(place))
    share.flags.writeable = False
    return share


def faded(place: Array, ways: Array) -> Array:
    """Return (n,) the share of a lamp's light along (n, 3) unit ways.

    place: as of lamps_at(); of four numbers alone, it shines all round.
    """
    if len(place) == 4:
        return np.ones(len(ways))
    return np.asarray(np.clip(ways @ place[4:7] + place[7], 0, 1) ** 2)


def receivers_of(scene: Scene, time_ns: int = 0) -> _Receivers:
    """Return the surfaces that get light at an instant, those that stand still first.

    The same object for the same surfaces. Errors: SceneError where two triangles have the same
    texel of the atlas, or lie outside it.
    """
    if not scene.lit_moves:
        return _still_receivers(scene.meshes, scene.textures)
    return _receivers_at(scene, LitInstant.of(scene, time_ns))


@lru_cache(maxsize=4)  # each pass of an instant asks
def _receivers_at(scene: Scene, moved: LitInstant) -> _Receivers:
    still = _still_receivers(scene.meshes, scene.textures)
    return _joined(still, _receivers(moved_meshes(scene, moved.time_ns), scene.textures))


@lru_cache(maxsize=4)
def _still_receivers(meshes: tuple[Mesh, ...], textures: tuple[Texture, ...]) -> _Receivers:
    # Of what moves, the places in the atlas alone matter here.
    _receivers([mesh for mesh in meshes if mesh.light_uv is not None], textures)
    return _receivers(lit_meshes(meshes), textures)


def _receivers(meshes: Sequence[Mesh], textures: Sequence[Texture]) -> _Receivers:
    patches = _patches_of(meshes, textures)
    texels = patches.texels
    if len(np.unique(texels, axis=0)) < len(texels):
        raise SceneError("two triangles have the same texel of the light atlas: expected places of their own")
    if len(texels) and (texels.min() < 0 or (texels.max(axis=0) >= ATLAS).any()):
        raise SceneError(f"a mesh lies outside the light atlas of {ATLAS[0]}x{ATLAS[1]} texels: use wider texels")
    places = np.concatenate(
        [np.empty((0, 3, 2)), *(mesh.light_uv[mesh.triangles] for mesh in meshes if mesh.light_uv is not None)]
    )
    return _Receivers(patches, _Blockers(corners_of(meshes)), places)


def _joined(first: _Receivers, other: _Receivers) -> _Receivers:
    names = [field.name for field in attrs.fields(_Patches)]
    patches = _Patches(*(np.concatenate([getattr(scene.patches, name) for scene in (first, other)]) for name in names))
    corners, atlas = (
        np.concatenate(pair) for pair in ((first.blockers.corners, other.blockers.corners), (first.atlas, other.atlas))
    )
    return _Receivers(patches, _Blockers(corners), atlas, first)


def transport_of(scene: Scene, folder: Path | None = None, rays: int = RAYS, *, time_ns: int = 0) -> Transport:
    """Return how light goes through the scene; the same object for the same surfaces and sky.

    folder: where rays between what stands still are kept, the user's cache folder if None. One that
    cannot be read or written is no error. time_ns: matters where something lit moves: then the
    object is of where that is alone. Errors: as receivers_of.
    """
    if not scene.lit_moves:
        return _still_transport(scene.meshes, scene.textures, scene.background, folder, rays)
    return _transport_at(scene, LitInstant.of(scene, time_ns), folder, rays)


@lru_cache(maxsize=4)
def _still_transport(
    meshes: tuple[Mesh, ...], textures: tuple[Texture, ...], background: Background, folder: Path | None, rays: int
) -> Transport:
    receivers, seen = _still_receivers(meshes, textures), _still_rays(meshes, textures, folder, rays)
    return Transport(receivers, seen.form_factors(len(receivers.patches)), seen.sky(background))


@lru_cache(maxsize=4)  # several ask for the instant that is drawn
def _transport_at(scene: Scene, moved: LitInstant, folder: Path | None, rays: int) -> Transport:
    """Return light's ways at an instant: rays of what stands still end where they meet others."""
    every, still = _receivers_at(scene, moved), _still_rays(scene.meshes, scene.textures, folder, rays)
    own, triangles = len(still.patch), len(_still_receivers(scene.meshes, scene.textures).blockers.corners)
    others = _Receivers(every.patches, _Blockers(every.blockers.corners[triangles:]), every.atlas[triangles:])
    patch = still.patch.copy()
    if len(others.blockers.corners):
        near = _near(still, others.blockers.corners.reshape(-1, 3))
        met = others.meet(still.starts[near], still.ways[near])
        stopped = met.far < still.far[near]
        patch[tuple(which[stopped] for which in near)] = met.patch[stopped]
    still = attrs.evolve(still, patch=patch)
    of_moved = _cast(every, slice(own, None), rays)
    parts, count = (still, of_moved), len(every.patches)
    factors = np.concatenate([part.form_factors(count) for part in parts])
    sky = np.concatenate([part.sky(scene.background) for part in parts])
    return Transport(every, factors, sky, is_moving=True)


def _near(rays: _Rays, points: Array) -> tuple[NDArray[np.int64], ...]:
    """Return the numbers (patch, ray) of those that pass through the sphere around some points."""
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    square = float(((points - centre) ** 2).sum(axis=1).max()) * (1 + 1e-9)
    to_centre = centre - rays.starts
    along, apart = (np.einsum("nrk,nrk->nr", to_centre, other) for other in (rays.ways, to_centre))
    return np.nonzero((apart - along**2 <= square) & ((along > 0) | (apart <= square)))


@lru_cache(maxsize=4)
def _still_rays(meshes: tuple[Mesh, ...], textures: tuple[Texture, ...], folder: Path | None, rays: int) -> _Rays:
    """Return the rays from what stands still to what stands still."""
    receivers = _still_receivers(meshes, textures)
    patches, digest = receivers.patches, hashlib.sha256(f"{VERSION} {rays}".encode())
    for array in (patches.texels, patches.centres, patches.normals, patches.steps, receivers.blockers.corners):
        digest.update(np.ascontiguousarray(array).tobytes())
    path = (folder or _cache_folder()) / f"light-{digest.hexdigest()[:40]}.npz"
    stored, shape = _read_arrays(path, ("patch", "far")), (len(patches), rays)
    if stored is not None and [array.shape for array in stored] == [shape, shape]:
        return _Rays(*_begun(patches, slice(None), rays), *stored)
    found = _cast(receivers, slice(None), rays)
    with suppress(OSError):
        _write_arrays(path, {"patch": found.patch, "far": found.far})
    return found


def _begun(patches: _Patches, which: slice, rays: int) -> tuple[Array, Array]:
    """Return (n, r, 3) starts and ways of the rays of some patches.

    All patches use the same rays in their own axes: the error is as smooth as the light.
    """
    # Spread evenly in the unit cube. Source: Roberts 2018, The Unreasonable Effectiveness of
    # Quasirandom Sequences (R4).
    ratio = 1.1673039782614187  # of x^5 = x + 1
    samples = (0.5 + np.arange(1, rays + 1)[:, None] * ratio ** -np.arange(1.0, 5.0)) % 1
    steps, normals = patches.steps[which], patches.normals[which]
    right = steps[..., 0] / np.linalg.norm(steps[..., 0], axis=1, keepdims=True)
    axes = np.stack([right, np.cross(normals, right), normals], axis=1)
    fronts = patches.centres[which] + OFF_M * normals
    return fronts[:, None] + (samples[:, 2:] - 0.5) @ steps.transpose(0, 2, 1), cosine_ways(samples) @ axes


def _cast(receivers: _Receivers, which: slice, rays: int) -> _Rays:
    starts, ways = _begun(receivers.patches, which, rays)
    met = receivers.meet(starts.reshape(-1, 3), ways.reshape(-1, 3))
    shape = starts.shape[:2]
    return _Rays(starts, ways, met.patch.astype(np.int16).reshape(shape), met.far.astype(np.float32).reshape(shape))


def cosine_ways(samples: Array) -> Array:
    """Return (n, 3) ways about +z, as many each way as its cosine. samples: (n, 2) in 0..1."""
    radius, angle = np.sqrt(samples[:, 0]), 2 * np.pi * samples[:, 1]
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - samples[:, 0])], axis=1)


def sky_light(background: Background, ways: Array) -> Array:
    """Return (n, 3) the background in those directions, see Background."""
    share = np.sqrt(np.abs(ways[:, 1:2] / np.linalg.norm(ways, axis=1, keepdims=True)))
    end = np.where(ways[:, 1:2] > 0, background.zenith, background.ground)
    return np.asarray((1 - share) * np.array(background.horizon) + share * end)


def of_atlas(atlas: NDArray[np.float16], texels: Array) -> Array:
    """Return (n, 3) what an atlas holds at places in ATLAS, blended; it may be finer."""
    from scipy.ndimage import map_coordinates

    at = (texels * (atlas.shape[1] / ATLAS[0]) - 0.5)[:, ::-1].T
    channels = [map_coordinates(atlas[..., k].astype(np.float64), at, order=1, mode="nearest") for k in range(3)]
    return np.stack(channels, axis=1)


@lights.register
class Converged(IndirectLight):
    """Light after any number of bounces, as the truth has it."""

    name = "converged"

    @classmethod
    def atlas(cls, scene: Scene, time_ns: int) -> NDArray[np.float16]:
        transport = transport_of(scene, time_ns=time_ns)
        return transport.atlas(transport.indirect(transport.direct(lamps_at(scene, time_ns))))


def _cache_folder() -> Path:
    """Return the folder where programs of this user keep what they can make again."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(os.path.expanduser(base)) / "hmdwarp" / "models"  # noqa: PTH111 (a user without a home is no error)


def _read_arrays(path: Path, names: Collection[str]) -> list[NDArray[Any]] | None:
    """Return the named arrays of what _write_arrays stored; None for a file that lacks them.

    One that is missing, damaged or cut off is no error.
    """
    try:
        # Given a path, np.load forgets to close a file that is no archive.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            return [stored[name] for name in names]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None


def _write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write a file that gets its name only when whole: another run may read at the same time.

    Errors: OSError for a folder that cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.stem, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
