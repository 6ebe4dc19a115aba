"""Photons: the light of lamps and of the sky, carried from surface to surface.

Source: Jensen 1996, Global Illumination using Photon Maps; Crassin et al. 2013, CloudLight.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache

import attrs
import numpy as np
from numpy.typing import NDArray

from ._scene import ATLAS, Background
from .radiosity import OFF_M, Transport, cosine_ways, faded, nearest_known, sky_light

Array = NDArray[np.float64]
Light = tuple[Array, tuple[float, float, float]]  # as lamps_at() returns them
MOST_BOUNCES = 64
_NUMBERS = 5  # that a path takes to start
# Of the factors of kernels: parts of a radius, parts of a texel at most, rounds until they balance.
_PARTS, _MOST_PARTS, _ROUNDS = 4, 4, 50
# Of the kernel: how far a photon may lie off the plane of what it lights, in radii, and the least
# cosine between their normals. As in shaders/lib/receivers.glsl.
OFF_PLANE, LEAST_COSINE = 0.25, 0.8


@attrs.frozen(eq=False)
class Photons:
    """Light as it falls on surfaces, a part of it with each photon."""

    places: Array  # (n, 3) metres, relative to the scene's origin
    normals: Array  # (n, 3) of the surface
    # (n, 3) as Lamp has colours, times square metres: what a white, matt square metre shows
    # when it falls on it.
    powers: Array
    texels: Array  # (n, 2) places in the light atlas

    def __len__(self) -> int:
        return len(self.places)

    def at_most(self, count: int) -> Photons:
        """Return no more than `count`, evenly taken, with the power of all."""
        if len(self) <= count:
            return self
        kept = (np.arange(count) * len(self)) // count
        powers = self.powers[kept]
        powers = powers * (self.powers.sum(axis=0) / np.maximum(powers.sum(axis=0), 1e-300))
        return Photons(self.places[kept], self.normals[kept], powers, self.texels[kept])


class PhotonTracer:
    """Traces the photons of a scene bundle by bundle, each bundle always the same way.

    A lamp sends its photons in `bundles` bundles of `paths` paths; both are powers of 2. A bundle
    of a point is a part of all directions, one of a sun or of the sky (light None) a part of where
    or whence its light comes in. The same paths at another instant start the same way, so that
    light that moves little changes little. What is left of a path ends by Russian roulette, which
    keeps all photons about equally bright.
    """

    def __init__(self, transport: Transport, background: Background, paths: int, bundles: int) -> None:
        # What photons fall on: set anew where something lit has moved.
        self.receivers, self._background = transport.receivers, background
        self.paths, self.bundles = paths, bundles

    @cached_property
    def _starts(self) -> NDArray[np.float32]:
        """(bundles, paths, 5) numbers in 0..1, the first two in the bundle's own part of them."""
        return _nets(self.bundles, self.paths)

    @cached_property
    def _box(self) -> Array:
        """(2, 3) lowest and highest corner."""
        corners = self.receivers.blockers.corners.reshape(-1, 3)
        return np.array([corners.min(axis=0), corners.max(axis=0)]) if len(corners) else np.zeros((2, 3))

    def trace(self, light: Light | None, bundles: Sequence[int], *, direct: bool = False) -> list[Photons]:
        """Return the photons of each bundle: those that have bounced, and those of the sky.

        light: of a lamp, None for the sky. direct: those that come straight from a lamp too.
        """
        numbers = self._starts[list(bundles)].reshape(-1, _NUMBERS).astype(np.float64)
        origins, ways, powers = self._emit(light, numbers)
        # All that are left are as bright as the brightest.
        brightest = self._brightest_of_sky if light is None else powers.max(initial=0.0)
        stays = powers.max(axis=1, initial=0.0) / max(brightest, 1e-300)
        left = np.flatnonzero(numbers[:, _NUMBERS - 1] < stays)
        origins, ways, powers = origins[left], ways[left], powers[left] / stays[left, None]
        chances = [np.random.default_rng(bundle) for bundle in bundles]
        found = [(np.zeros(0, np.int64), *(np.zeros((0, width)) for width in (3, 3, 3, 2)))]
        for bounce in range(MOST_BOUNCES):
            met = self.receivers.meet(origins, ways)
            on = met.patch >= 0
            patch, places, powers, left = met.patch[on], met.places[on], powers[on], left[on]
            normals = self.receivers.patches.normals[patch]
            if bounce or direct or light is None:
                found.append((left, places, normals, powers, met.texels[on]))
            out = powers * self.receivers.patches.albedo[patch]
            stays = out.max(axis=1, initial=0.0) / np.maximum(powers.max(axis=1, initial=0.0), 1e-300)
            # The same for each path, whatever becomes of others.
            drawn = np.concatenate([chance.random((self.paths, 3)) for chance in chances])[left]
            survives = drawn[:, 0] < stays
            if not survives.any():
                break
            normals, left = normals[survives], left[survives]
            powers = out[survives] / stays[survives, None]
            ways = _turned(cosine_ways(drawn[survives, 1:]), normals)
            origins = places[survives] + OFF_M * normals
        of_path, *rest = (np.concatenate(kind) for kind in zip(*found, strict=True))
        order = np.argsort(of_path // self.paths, kind="stable")
        ends = np.searchsorted(of_path[order] // self.paths, np.arange(1, len(bundles)))
        return [Photons(*each) for each in zip(*(np.split(kind[order], ends) for kind in rest), strict=True)]

    @cached_property
    def _brightest_of_sky(self) -> float:
        return float(self._emit(None, self._starts.reshape(-1, _NUMBERS).astype(np.float64))[2].max(initial=0.0))

    def _emit(self, light: Light | None, numbers: Array) -> tuple[Array, Array, Array]:
        """Return origin, way and power of each path's start."""
        count = self.paths * self.bundles
        if light is not None and light[0][3]:
            place, colour = light
            ways = _sphere(numbers)
            powers = faded(place, ways)[:, None] * (4 * np.pi * np.array(colour) / count)
            return np.broadcast_to(place[:3], ways.shape), ways, powers
        if light is not None:
            ways = np.broadcast_to(-light[0][:3] / np.linalg.norm(light[0][:3]), (len(numbers), 3))
            origins, area = _through_box(self._box, ways, numbers)
            return origins, ways, area[:, None] * np.array(light[1]) / count
        ways = _sphere(numbers)
        origins, area = _through_box(self._box, ways, numbers[:, 2:4])
        return origins, ways, 4 * area[:, None] * sky_light(self._background, -ways) / count


def _sphere(numbers: Array) -> Array:
    """Return directions spread evenly."""
    z, angle = 1 - 2 * numbers[:, 0], 2 * np.pi * numbers[:, 1]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    return np.stack([across * np.cos(angle), z, across * np.sin(angle)], axis=1)


def _through_box(box: Array, ways: Array, numbers: Array) -> tuple[Array, Array]:
    """Return where parallel light enters a box, just before it, and the area across each way."""
    size = box[1] - box[0]
    faces = np.abs(ways) * (np.prod(np.maximum(size, 1e-300)) / np.maximum(size, 1e-300))
    area = faces.sum(axis=1)
    ends = np.cumsum(faces, axis=1) / np.maximum(area, 1e-300)[:, None]
    axis = (numbers[:, :1] >= ends[:, :2]).sum(axis=1)
    rows = np.arange(len(axis))
    before = np.where(axis > 0, ends[rows, axis - 1], 0.0)
    along = (numbers[:, 0] - before) / np.maximum(ends[rows, axis] - before, 1e-300)
    share = np.empty((len(axis), 3))
    share[rows, axis] = np.where(ways[rows, axis] > 0, 0.0, 1.0)
    share[rows, (axis + 1) % 3], share[rows, (axis + 2) % 3] = along, numbers[:, 1]
    return box[0] + share * size - ways * (1e-3 * np.linalg.norm(size)), area


def _turned(ways: Array, normals: Array) -> Array:
    """Return ways about +z turned about each normal.

    Source: Duff et al. 2017, Building an Orthonormal Basis, Revisited.
    """
    x, y, z = normals.T
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1 / (sign + z)
    b = x * y * a
    right = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
    up = np.stack([b, sign + y * y * a, -y], axis=1)
    return np.asarray(ways[:, :1] * right + ways[:, 1:2] * up + ways[:, 2:] * normals)


@lru_cache(maxsize=4)
def _nets(bundles: int, paths: int) -> NDArray[np.float32]:
    """Return (bundles, paths, 5) points spread evenly, each bundle in its part of the first two.

    Of a Sobol' sequence any 2^k points lie evenly in all parts of the plane of equal shape that
    halving its sides k times gives.

    Source: Joe and Kuo 2008, Constructing Sobol Sequences with Better Two-Dimensional Projections.
    """
    from scipy.stats import qmc

    steps = 1 << 30
    shift = np.random.default_rng(0).integers(steps, size=_NUMBERS)
    plain = qmc.Sobol(_NUMBERS, scramble=False).random(bundles * paths)  # in steps of 2^-30
    # 24 bits of each are kept, so that none is rounded up to 1.
    points = ((((plain * steps).astype(np.int64) ^ shift) >> 6) / (steps >> 6)).astype(np.float32)
    halvings = bundles.bit_length() - 1
    across, up = 1 << (halvings + 1) // 2, 1 << halvings // 2
    part = (points[:, 0] * across).astype(int) * up + (points[:, 1] * up).astype(int)
    return np.asarray(points[np.argsort(part, kind="stable")].reshape(bundles, paths, _NUMBERS))


def kernel(distance: Array, radius: float) -> Array:
    """Return a photon's share of a square metre at that distance: its integral over a plane is 1.

    Source: Silverman 1986, Density Estimation for Statistics and Data Analysis, 4.2.1.
    """
    return 2 / (np.pi * radius**2) * np.maximum(1 - (distance / radius) ** 2, 0)


@lru_cache(maxsize=4)
def kernel_factors(transport: Transport, radius: float) -> NDArray[np.float16]:
    """Return the factor d that makes up for what a kernel gives outside surfaces, as a finer atlas.

    (h, w, 4), bottom row first, of as many times ATLAS as the kernel asks for. A photon at p lights
    x with d(x) kernel d(p). Then each photon gives away all its power, and evenly lit surfaces are
    even up to their borders.

    Source: Sinkhorn and Knopp 1967, in its symmetric form.
    """
    patches = transport.patches
    widest = float(np.linalg.norm(patches.steps, axis=1).max(initial=0.0))
    finer = int(np.clip(np.ceil(_PARTS * widest / radius), 1, _MOST_PARTS))
    offsets = (np.arange(finer) + 0.5) / finer - 0.5
    parts = [(column, row) for row in range(finer) for column in range(finer)]
    places = np.concatenate([patches.at(offsets[column], offsets[row]) for column, row in parts])
    normals, areas = np.tile(patches.normals, (len(parts), 1)), np.tile(patches.areas, len(parts)) / len(parts)
    factors = _balanced(places, normals, areas, np.tile(patches.bodies, len(parts)), radius)
    width, height = finer * np.array(ATLAS)
    values = np.full((height, width), np.nan)
    for number, (column, row) in enumerate(parts):
        own = finer * patches.texels + (column, row)
        values[own[:, 1], own[:, 0]] = factors[len(patches) * number :][: len(patches)]
    picture = np.ones((height, width, 4), np.float16)
    picture[..., :3] = nearest_known(values)[..., None]
    return picture


def _balanced(places: Array, normals: Array, areas: Array, bodies: NDArray[np.int64], radius: float) -> Array:
    """Return (n,) factors with which each part gives and gets as much as it should."""
    from scipy.sparse import coo_matrix
    from scipy.spatial import cKDTree

    if not len(places):
        return np.zeros(0)
    first, other = cKDTree(places).query_pairs(radius, output_type="ndarray").T
    ways = places[other] - places[first]
    alike = (normals[first] * normals[other]).sum(axis=1) > LEAST_COSINE
    alike &= bodies[first] == bodies[other]  # what moves past something is no part of it
    alike &= np.abs((ways * normals[first]).sum(axis=1)) <= OFF_PLANE * radius
    first, other = first[alike], other[alike]
    given = kernel(np.linalg.norm(ways[alike], axis=1), radius)
    # What a part gives to itself: the kernel over a disc of its area.
    share = np.minimum(areas / (np.pi * radius**2), 1)
    own = np.arange(len(places))
    rows, columns = np.concatenate([first, other, own]), np.concatenate([other, first, own])
    entries = np.concatenate([given * areas[other], given * areas[first], (2 - share) * share])
    spread = coo_matrix((entries, (rows, columns)), shape=(len(places),) * 2).tocsr()
    factors = np.ones(len(places))
    for _ in range(_ROUNDS):
        factors = np.sqrt(factors / np.maximum(spread @ factors, 1e-12))
    return factors


def of_atlas(atlas: NDArray[np.float16], texels: Array) -> Array:
    """Return (n, 3) what an atlas holds at places in ATLAS, blended; it may be finer."""
    from scipy.ndimage import map_coordinates

    at = (texels * (atlas.shape[1] / ATLAS[0]) - 0.5)[:, ::-1].T
    channels = [map_coordinates(atlas[..., k].astype(np.float64), at, order=1, mode="nearest") for k in range(3)]
    return np.stack(channels, axis=1)


def light_keys(lamps: Sequence[Light], background: Background, moved: bytes = b"") -> list[tuple[Light | None, bytes]]:
    """Return the lamps, and None for a sky that shines; each with what tells its light apart.

    moved: what tells apart where all is that moves and is lit.
    """
    found: list[tuple[Light | None, bytes]] = [
        (lamp, np.array([*lamp[0], *lamp[1]]).tobytes() + moved) for lamp in lamps
    ]
    sky = max(*background.zenith, *background.horizon, *background.ground)
    return [*found, (None, b"sky" + moved)] if lamps and sky > 0 else found
