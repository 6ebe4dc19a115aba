"""Photons: the light of lamps and of the sky, carried from surface to surface and kept by clients.

The server traces them in bundles and sends those whose lamp has changed; the client splats them.

Source: Jensen 1996, Global Illumination using Photon Maps; Crassin et al. 2013, CloudLight.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..client import ClientScene, PassInputs, ShownPicture, Store, Surfaces, receiver_of, whole_weight
from ..client.strategies import Strategy, strategies
from ..client.warp_kinds import ClientDrawing
from ..client.warps import warps
from ..frames import Needs
from ..frames.layers import MOST_BUDGET, Book, Delivered, Update, between, layers
from ..geometry import View
from ..gpu import Gpu, Uniforms
from ..gpu.textures import COLOUR, SCALAR, Canvas, allocate, drawing_into, release_all
from ..scenes import ATLAS, Background, Light, Scene, lamps_at
from ..sources.server import Lighting
from ..sources.server.parts import Drawing, Sender, Sending, parts
from ..sources.server.passes import Viewport
from .radiosity import (
    OFF_M,
    Transport,
    cosine_ways,
    faded,
    nearest_known,
    of_atlas,
    receivers_of,
    sky_light,
    transport_of,
)

Array = NDArray[np.float64]


# A bundle is whole or not there, so bundles may come in any order, and of each the newest stays.
Sent = tuple[int, int]  # bundle, number
# Bytes of a photon: position, normal, power.
_PHOTON_BYTES = 12
# Whether every bundle has been sent; lowest corner and edge of the cube that holds all positions.
_CUBE = struct.Struct("<B4f")
# Bundle, its number, its photons.
_HEAD = struct.Struct("<IIH")
CUBE_BYTES, HEAD_BYTES = _CUBE.size, _HEAD.size
_STEPS = 65535
# Of a shared exponent, see shared_exponent().
_MANTISSA, _BIAS, _EXPONENTS = 9, 15, 32
# Paths of a bundle, and the room for photons that each path takes: they leave about one each.
_FEWEST_PATHS, _MOST_PATHS, PHOTONS_A_PATH = 8, 256, 2
# A sun and the sky send so many more photons than a point: most of theirs never come in.
OPEN = 8


def _bundle_bytes(paths: int) -> int:
    """Return the bytes of the largest bundle of so many paths."""
    return HEAD_BYTES + _PHOTON_BYTES * PHOTONS_A_PATH * paths


# Any bundle of the fewest paths fits.
LEAST_BUDGET = CUBE_BYTES + _bundle_bytes(_FEWEST_PATHS)


@attrs.frozen(order=True)
class PhotonMap:
    """Photons that are delivered bundle by bundle, and replaced as the light changes."""

    # Bytes of each frame, at most, before they are packed: what the link carries in a frame's time,
    # so that no bundle is late by more than one. Bundles are as large as fits, up to 6 kB.
    budget: int = attrs.field(default=60_000, validator=between(LEAST_BUDGET, MOST_BUDGET))
    # Paths that each lamp sends, rounded up to a power of 2; they leave about one photon each. A
    # sun and the sky send more.
    paths: int = attrs.field(default=1 << 13, validator=between(1, 1 << 16))
    # Metres that a photon lights around it: less is sharper, and uneven where photons are few.
    radius: float = attrs.field(default=0.8, validator=between(1e-3, 1e6))

    @property
    def paths_of_bundle(self) -> int:
        """How many paths each bundle has: any bundle fits the budget."""
        paths = _MOST_PATHS
        while paths > _FEWEST_PATHS and CUBE_BYTES + _bundle_bytes(paths) > self.budget:
            paths //= 2
        return paths

    def bundles(self, *, opened: bool) -> int:
        """Return how many bundles a lamp has. opened: a sun or the sky, not a point."""
        whole = 1 << max(self.paths - 1, 0).bit_length()
        return max(1, whole * (OPEN if opened else 1) // self.paths_of_bundle)

    @property
    def most_photons(self) -> int:
        """How many photons a bundle holds at most."""
        return PHOTONS_A_PATH * self.paths_of_bundle


@layers.register
class PhotonLayer(Delivered):
    """An Update for each PhotonMap. The amount is the frozenset of them."""

    name = "photons"
    summary = "indirect light as photons, packed in bundles: only those whose lamp has changed, the oldest first"
    drawn_by = "photons"
    something = frozenset({PhotonMap()})


@attrs.frozen(eq=False)
class Cube:
    """The cube that holds all positions, in metres from the scene's origin."""

    low: Array
    edge: float

    def packed(self, *, whole: bool) -> bytes:
        """Return the start of an update. whole: whether every bundle has been sent."""
        return _CUBE.pack(whole, *self.low, self.edge)


def packed(sent: Sent, places: Array, normals: NDArray[np.uint8], powers: Array) -> bytes:
    """Return the bytes of a bundle.

    places: (n, 3) in shares of the cube. normals: (n, 2) as octahedral() returns them.
    """
    steps = np.rint(np.clip(places, 0, 1) * _STEPS).astype(np.uint16)
    return _HEAD.pack(*sent, len(steps)) + steps.tobytes() + normals.tobytes() + shared_exponent(powers).tobytes()


def unpacked(content: NDArray[np.uint8]) -> tuple[bool, Cube, list[tuple[Sent, NDArray[np.uint32]]]]:
    """Return whether every bundle has been sent, the cube, and the bundles that came.

    A photon has three words: x and y; z and normal; power.
    """
    data, at = content.tobytes(), CUBE_BYTES
    whole, *low, edge = _CUBE.unpack_from(data)
    bundles = []
    while at < len(data):
        bundle, number, count = _HEAD.unpack_from(data, at)
        at += HEAD_BYTES
        words = np.zeros((count, 3), np.uint32)
        steps = np.frombuffer(data, np.uint16, 3 * count, at).reshape(count, 3).astype(np.uint32)
        normals = np.frombuffer(data, np.uint8, 2 * count, at + 6 * count).reshape(count, 2).astype(np.uint32)
        words[:, 0] = steps[:, 0] | steps[:, 1] << 16
        words[:, 1] = steps[:, 2] | normals[:, 0] << 16 | normals[:, 1] << 24
        words[:, 2] = np.frombuffer(data, np.uint32, count, at + 8 * count)
        at += _PHOTON_BYTES * count
        bundles.append(((bundle, number), words))
    return bool(whole), Cube(np.array(low), edge), bundles


def shared_exponent(colours: Array) -> NDArray[np.uint32]:
    """Return (n, 3) colours of 0 or more as 9 bits each and a common exponent.

    Source: OpenGL 4.3 specification, 8.25 (RGB9_E5).
    """
    top = 2.0 ** (_EXPONENTS - 1 - _BIAS)
    clipped = np.clip(colours, 0, top * (1 - 2.0**-_MANTISSA))
    largest = clipped.max(axis=1, initial=0.0)
    exponent = np.maximum(np.frexp(largest)[1], -_BIAS)
    exponent += np.rint(largest * 2.0 ** (_MANTISSA - exponent)) >= 1 << _MANTISSA
    steps = np.rint(clipped * 2.0 ** (_MANTISSA - exponent)[:, None]).astype(np.uint32)
    shifted = (exponent + _BIAS).astype(np.uint32) << np.uint32(3 * _MANTISSA)
    return np.asarray(steps[:, 0] | steps[:, 1] << _MANTISSA | steps[:, 2] << 2 * _MANTISSA | shifted, np.uint32)


class BundleSender(Book):
    """The sender's book: the light that each bundle shows, as far as is known to have arrived.

    A bundle that was lost counts as never sent, so it is traced and sent anew. The book holds some
    numbers for each bundle, and what is on its way until its fate is heard.
    """

    def __init__(self, bundles: int) -> None:
        super().__init__()
        self._light: list[bytes | None] = [None] * bundles
        self._number = np.zeros(bundles, np.int64)
        # Whether the receiver has nothing of it, unless something is lost.
        self._empty = np.ones(bundles, bool)
        # When each was last sent, by a count.
        self._sent_at = np.full(bundles, -1, np.int64)
        self._count = 0

    @property
    def whole(self) -> bool:
        """Whether every bundle was sent, and none that is needed is known to be lost."""
        return None not in self._light

    @property
    def remembered(self) -> int:
        """How many things it remembers besides its numbers for each bundle."""
        return sum(len(update.pieces) for *_, update, _ in self._news)

    def stale(self, lights: Sequence[bytes]) -> list[int]:
        """Return the bundles that show other light than now; first those sent longest ago.

        lights: what the light of each bundle is told apart by. Of those that were never sent,
        neighbours are far apart.
        """
        found = np.array([k for k, (old, new) in enumerate(zip(self._light, lights, strict=True)) if old != new], int)
        scattered = (found * 0.6180339887498949) % 1
        return found[np.lexsort((scattered, self._sent_at[found]))].tolist() if len(found) else []

    def sent(self, bundle: int, light: bytes, *, empty: bool) -> Sent | None:
        """Enter a bundle as sent; return its number, None if an empty one need not be sent."""
        self._count += 1
        self._light[bundle], self._sent_at[bundle] = light, self._count
        if empty and self._empty[bundle]:
            return None
        self._empty[bundle] = empty
        self._number[bundle] += 1
        return bundle, int(self._number[bundle])

    def _settle(self, piece: Sent, *, arrived: bool) -> None:
        """Forget what was lost, and not sent anew since: it was never sent."""
        bundle, number = piece
        if not arrived and number == self._number[bundle]:
            self._light[bundle], self._sent_at[bundle], self._empty[bundle] = None, -1, False


class BundleRoom:
    """The receiver's book: the newest of each bundle."""

    def __init__(self) -> None:
        self._held: dict[int, tuple[int, NDArray[np.uint32]]] = {}

    def take(self, sent: Sent, words: NDArray[np.uint32]) -> bool:
        """Take a bundle unless what is there is as new; return whether it was taken."""
        bundle, number = sent
        if bundle in self._held and self._held[bundle][0] >= number:
            return False
        self._held[bundle] = number, words
        return True

    def words(self) -> NDArray[np.uint32]:
        """Return (n, 3) of all photons, in the order of their bundles."""
        held = [self._held[bundle][1] for bundle in sorted(self._held)]
        return np.concatenate([np.zeros((0, 3), np.uint32), *held])


MOST_BOUNCES = 64
_NUMBERS = 5  # that a path takes to start
# Of the factors of kernels: parts of a radius, parts of a texel at most, rounds until they balance.
_PARTS, _MOST_PARTS, _ROUNDS = 4, 4, 50
# Of the kernel: how far a photon may lie off the plane of what it lights, in radii, and the least
# cosine between their normals. As in shaders/lib/receivers.glsl.
OFF_PLANE, LEAST_COSINE = 0.25, 0.8


@attrs.frozen(eq=False)
class TracedPhotons:
    """Light as it falls on surfaces, a part of it with each photon."""

    places: Array  # (n, 3) metres, relative to the scene's origin
    normals: Array  # (n, 3) of the surface
    # (n, 3) as Lamp has colours, times square metres: what a white, matt square metre shows
    # when it falls on it.
    powers: Array
    texels: Array  # (n, 2) places in the light atlas

    def __len__(self) -> int:
        return len(self.places)

    def at_most(self, count: int) -> TracedPhotons:
        """Return no more than `count`, evenly taken, with the power of all."""
        if len(self) <= count:
            return self
        kept = (np.arange(count) * len(self)) // count
        powers = self.powers[kept]
        powers = powers * (self.powers.sum(axis=0) / np.maximum(powers.sum(axis=0), 1e-300))
        return TracedPhotons(self.places[kept], self.normals[kept], powers, self.texels[kept])


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
        self._starts = _nets(bundles, paths)

    @cached_property
    def _box(self) -> Array:
        """(2, 3) lowest and highest corner."""
        corners = self.receivers.blockers.corners.reshape(-1, 3)
        return np.array([corners.min(axis=0), corners.max(axis=0)]) if len(corners) else np.zeros((2, 3))

    def trace(self, light: Light | None, bundles: Sequence[int], *, direct: bool = False) -> list[TracedPhotons]:
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
        return [TracedPhotons(*each) for each in zip(*(np.split(kind[order], ends) for kind in rest), strict=True)]

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


def octahedral(normals: Array) -> NDArray[np.uint8]:
    """Return unit vectors as (n, 2) bytes: off by at most 0.7 degrees.

    Source: Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors.
    """
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    signs = np.where(flat[:, :2] >= 0, 1.0, -1.0)
    folded = np.where(flat[:, 2:] < 0, (1 - np.abs(flat[:, 1::-1])) * signs, flat[:, :2])
    return np.asarray(np.rint((folded * 0.5 + 0.5) * 254).astype(np.uint8))


def light_keys(lamps: Sequence[Light], background: Background, moved: bytes = b"") -> list[tuple[Light | None, bytes]]:
    """Return the lamps, and None for a sky that shines; each with what tells its light apart.

    moved: what tells apart where all is that moves and is lit.
    """
    found: list[tuple[Light | None, bytes]] = [
        (lamp, np.array([*lamp[0], *lamp[1]]).tobytes() + moved) for lamp in lamps
    ]
    sky = max(*background.zenith, *background.horizon, *background.ground)
    return [*found, (None, b"sky" + moved)] if lamps and sky > 0 else found


# Paths traced for one frame, at most: many of a sun's and of the sky's bring nothing in.
_MOST_TRACED = 1 << 16


@parts.register
class PhotonPart(Sending[PhotonMap, "PhotonSource"]):
    """One sender for each PhotonMap that frames need. Without lamps there are no photons."""

    name = "photons"
    order = 131

    def make_sender(self, wanted: PhotonMap) -> PhotonSource:
        return PhotonSource(self.context.scene, wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        updates = {wanted: self.sender(wanted).update(drawing.time_ns) for wanted in self.needed(drawing)}
        return {"photons": updates} if updates else {}


class PhotonSource(Sender):
    """The bundles of one PhotonMap: those of each lamp, then those of the sky."""

    def __init__(self, scene: Scene, wanted: PhotonMap) -> None:
        self._scene, self._wanted = scene, wanted
        self._tracers: list[PhotonTracer] = []
        self._cube = Cube(np.zeros(3), 1.0)
        if scene.lamps:
            transport = transport_of(scene)
            self._factors = kernel_factors(transport, wanted.radius)
            for light, _ in light_keys(lamps_at(scene, 0), scene.background):
                bundles = wanted.bundles(opened=light is None or not light[0][3])
                self._tracers.append(PhotonTracer(transport, scene.background, wanted.paths_of_bundle, bundles))
            # Around all lit surfaces, rounded as it is sent.
            corners = transport.blockers.corners.reshape(-1, 3)
            low = corners.min(axis=0).astype(np.float32).astype(np.float64)
            self._cube = Cube(low, float(np.float32(max((corners - low).max(), 1e-6))))
        # The tracer of each bundle, and the bundle's number there.
        self._bundles = [(k, bundle) for k, tracer in enumerate(self._tracers) for bundle in range(tracer.bundles)]
        self.book = BundleSender(len(self._bundles))

    def update(self, now_ns: int) -> Update:
        """Return what a frame drawn now brings."""
        self.book.settle(now_ns)
        out, sent = bytearray(), []
        left, traced = self._wanted.budget - CUBE_BYTES, 0
        lights: list[tuple[Light | None, bytes]] = []
        if self._tracers:
            receivers = receivers_of(self._scene, now_ns)
            for tracer in self._tracers:
                tracer.receivers = receivers
            moved = receivers.blockers.corners.tobytes() if self._scene.lit_moves else b""
            lights = light_keys(lamps_at(self._scene, now_ns), self._scene.background, moved)
        state_of = [lights[k][1] for k, _ in self._bundles]
        stale = self.book.stale(state_of)
        largest = _bundle_bytes(self._wanted.paths_of_bundle)
        while stale and left >= largest and traced < _MOST_TRACED:
            # Of one lamp, as many as surely fit.
            of = self._bundles[stale[0]][0]
            batch = [bundle for bundle in stale[: left // largest] if self._bundles[bundle][0] == of]
            traced += len(batch) * self._wanted.paths_of_bundle
            every = self._tracers[of].trace(lights[of][0], [self._bundles[bundle][1] for bundle in batch])
            for bundle, whole in zip(batch, every, strict=True):
                found = whole.at_most(self._wanted.most_photons)
                entered = self.book.sent(bundle, state_of[bundle], empty=not len(found))
                if entered is not None:
                    places, powers = found.places - self._cube.low, of_atlas(self._factors, found.texels)
                    normals = octahedral(found.normals)
                    out += packed(entered, places / self._cube.edge, normals, found.powers * powers)
                    sent.append(entered)
            left = self._wanted.budget - CUBE_BYTES - len(out)
            stale = [bundle for bundle in stale if bundle not in batch]
        self.complete = not stale  # of the light as it is now
        start = self._cube.packed(whole=self.book.whole)
        return Update(np.frombuffer(start + bytes(out), np.uint8).copy(), tuple(sent))


_LIGHT = (4, "f4")  # rgba32f: sums of thousands of photons


@attrs.frozen
class _PhotonSettings(PhotonMap):
    # Shown pixels of one pixel of the splatted light, on each axis.
    scale: int = attrs.field(default=4, validator=attrs.validators.ge(1))

    @property
    def wanted(self) -> PhotonMap:
        return PhotonMap(self.budget, self.paths, self.radius)


_SPLATS_UNIT = 8


class _SplatLight(Lighting):
    """Its indirect light is a picture that its owner sets, see Splats."""

    defines = ("LAMPS", "SPLATTED")
    splats: Any

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        self.use_lamps(uniforms, time_ns)
        self.splats.use(uniforms, _SPLATS_UNIT)


class _ReceiverLight(Lighting):
    """In place of colour, drawn are the normal and what the atlas of its owner holds."""

    defines = ("RECEIVERS",)
    coloured = False
    indirect: moderngl.Texture

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        self.use_atlas(uniforms, self.indirect)


@receiver_of("photons")
class KeptPhotons(Store):
    """The newest photons of each bundle of one PhotonMap, and the whole scene, that they light.

    The buffer for all, see cloudlight/photons.vert, is allocated at once.
    """

    def __init__(self, client: ClientScene, wanted: PhotonMap) -> None:
        super().__init__(client, wanted)
        gpu, scene = client.gpu, client.scene
        self.surfaces = Surfaces(gpu, scene, _SplatLight, _ReceiverLight, samples=client.server.samples)
        self._factors: moderngl.Texture | None = None
        if lighting := self.surfaces.lighting(_ReceiverLight):
            factors = kernel_factors(transport_of(scene), wanted.radius)
            self._factors = lighting.indirect = allocate(gpu.gl, factors.shape[1::-1], COLOUR)
            self._factors.write(factors.tobytes())
        self.photons = gpu.gl.buffer(reserve=_PHOTON_BYTES * max(1, most_photons(scene, wanted)))
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget all photons; passes draw from the same buffer still."""
        self._room, self.cube, self.count = BundleRoom(), Cube(np.zeros(3), 1.0), 0
        self.bytes = 0
        self.first_picture_bytes: int | None = None

    def receive(self, content: NDArray[np.uint8]) -> None:
        if not len(content):
            return
        whole, self.cube, bundles = unpacked(content)
        self.bytes += len(content)
        if whole and self.first_picture_bytes is None:
            self.first_picture_bytes = self.bytes
        if sum(self._room.take(sent, words) for sent, words in bundles):
            words = self._room.words()
            self.count = len(words)
            self.photons.write(words.tobytes())

    def weights(self) -> list[dict[str, Any]]:
        """Return that of the scene; and what has crossed before packing, and what is held."""
        weight = {
            "budget": self.wanted.budget,
            "geometry_bytes": self.photons.size,
            "texture_bytes": 0,
            "start_up_bytes": 0,
            "first_picture_bytes": self.first_picture_bytes,
            "arrived_bytes": self.bytes,
            "photons": self.count,
        }
        return [whole_weight(self.client.scene), weight]

    def close(self) -> None:
        self.photons.release()
        self.surfaces.close()
        if self._factors is not None:
            self._factors.release()


def most_photons(scene: Scene, wanted: PhotonMap) -> int:
    """Return how many photons there can be at most."""
    lights = [light for light, _ in light_keys(lamps_at(scene, 0), scene.background)]
    bundles = sum(wanted.bundles(opened=light is None or not light[0][3]) for light in lights)
    return bundles * wanted.most_photons


class Splats:
    """Photons splatted at a part of the shown resolution, by deferred shading.

    Each pixel gets the light of all photons within `radius` metres of what it shows, on about the
    same plane; see shaders/cloudlight/photons.frag.
    """

    def __init__(self, gpu: Gpu, photons: KeptPhotons, size: tuple[int, int], scale: int, radius: float) -> None:
        """Compile the programs and allocate the buffers. size: of the shown picture."""
        gl = self._gl = gpu.gl
        self._photons, self._radius, self._size = photons, radius, size
        low = (-(-size[0] // scale), -(-size[1] // scale))
        self._receivers = ShownPicture(Canvas(gl, low), allocate(gl, low, SCALAR))
        self.light = allocate(gl, low, _LIGHT)
        self._framebuffer = gl.framebuffer([self.light])
        self._program = gpu.shaders.draw("cloudlight/photons.vert", "cloudlight/photons.frag")
        self._vertices = gl.vertex_array(self._program.program, [(photons.photons, "3u4/i", "in_photon")])
        self._view: dict[str, object] = {}

    def draw(self, view: View, time_ns: int) -> None:
        """Splat all photons for a view."""
        photons = self._photons
        left, right, down, up = view.fov.tangents
        self._view = {
            "eye": tuple((view.pose.position_m - photons.client.scene.origin_m).tolist()),
            "scene_from_eye": view.pose.rotation_matrix,
            "low_tangents": (left, down, right, up),
            "radius": self._radius,
        }
        self._framebuffer.clear()
        if not photons.count:
            return
        # The normal, and the factor for photons; 0 for what lamps do not light.
        photons.surfaces.draw(view, self._receivers, time_ns, _ReceiverLight)
        self._bind(self._program.uniforms, 0)
        self._program.uniforms.set(low=tuple(photons.cube.low.tolist()), edge=photons.cube.edge)
        with drawing_into(self._framebuffer, moderngl.BLEND):
            self._gl.blend_func = (moderngl.ONE, moderngl.ONE)
            self._vertices.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=photons.count)
            self._gl.blend_func = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA)

    def use(self, uniforms: Uniforms, unit: int) -> None:
        """Bind what shaders/lib/splatted.glsl reads, from that texture unit on."""
        self._bind(uniforms, unit)
        self.light.use(unit + 2)
        shares = tuple((np.array(self.light.size) / self._size).tolist())
        uniforms.set(splatted=unit + 2, low_per_pixel=shares)

    def _bind(self, uniforms: Uniforms, unit: int) -> None:
        self._receivers.colour.texture.use(unit)
        self._receivers.depth.use(unit + 1)
        uniforms.set(receivers=unit, receiver_depth=unit + 1, **self._view)

    def close(self) -> None:
        """Free the buffers; the shader library owns the programs."""
        self._receivers.colour.release()
        release_all(self._receivers.depth, self._vertices, self._framebuffer, self.light)


@warps.register
class PhotonWarp(ClientDrawing):
    """Splat the photons at low resolution, and draw for the shown view and instant with that light.

    Lamps and their shadows are where they are at that instant: the client knows how they move.
    """

    name = "photons"
    summary = "the client draws the scene with direct light at the newest pose, and splats photons as indirect light"
    reads = ("client.model", "rendered.photons")
    exact_when = "never: indirect light is spread over the photons' radius; direct light is exact, and never late"
    gets_wrong = (
        "indirect light is late by the link and by the frames that its bundles take, smooth within the radius, and "
        "uneven where photons are few; takes the whole scene on the client"
    )
    source = "Crassin et al. 2013, CloudLight (photons); Jensen 1996 (photon maps)"
    Settings = _PhotonSettings
    variants = ("scale=8",)
    for_moving_light = True

    @classmethod
    def needs(cls, settings: _PhotonSettings) -> Needs:
        return Needs(photons=frozenset({settings.wanted}))

    def prepare_scene(self, geometry: ClientScene) -> None:
        chosen = self.settings
        self._photons = geometry.store(KeptPhotons, chosen.wanted)
        self._splats = Splats(self.gpu, self._photons, self.shown_size, chosen.scale, chosen.radius)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        self._splats.draw(inputs.middle, inputs.shown_ns)
        surfaces = self._photons.surfaces
        if lighting := surfaces.lighting(_SplatLight):
            lighting.splats = self._splats
        surfaces.draw(inputs.middle, ShownPicture(into, depth), inputs.shown_ns, _SplatLight)

    def close(self) -> None:
        super().close()
        self._splats.close()


@strategies.register
class PhotonStrategy(Strategy):
    """For scenes whose light moves, and clients that are fast: surfaces need no atlas for it."""

    name = "photons"
    summary = "the server sends indirect light as photons; the client draws the scene with direct light, splats them"
    crosses = "the scene once; photons, of what has changed"
    client = "draws the scene with direct light at the newest pose, splats photons as indirect light"
    late = "indirect light"
    classes = (3,)
    source = "Crassin et al. 2013, CloudLight"
    warp, fill = "photons", "none"
