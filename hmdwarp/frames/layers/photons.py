"""Photons of indirect light for a client that keeps them."""

from __future__ import annotations

import heapq
import struct
from collections.abc import Iterator, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from . import MOST_BUDGET, Delivered, between, layers


@attrs.frozen(order=True)
class PhotonMap:
    """Photons that are delivered bundle by bundle, and replaced as the light changes."""

    # Bytes of each frame, at most, before they are packed.
    budget: int = attrs.field(default=60_000, validator=between(1, MOST_BUDGET))
    # Paths that a lamp sends, rounded up to a power of 2; a sun and the sky send more.
    paths: int = attrs.field(default=1 << 13, validator=between(1, 1 << 16))
    # Metres that a photon lights around it.
    radius: float = attrs.field(default=0.8, validator=between(1e-3, 1e6))

    @property
    def paths_of_bundle(self) -> int:
        """How many paths each bundle has: any bundle fits the budget."""
        return paths_of_bundle(self.budget)

    def bundles(self, *, opened: bool) -> int:
        """Return how many bundles a lamp has. opened: a sun or the sky, not a point."""
        whole = 1 << max(self.paths - 1, 0).bit_length()
        return max(1, whole * (OPEN if opened else 1) // self.paths_of_bundle)

    @property
    def most_photons(self) -> int:
        """How many photons a bundle holds at most."""
        return PHOTONS_A_PATH * self.paths_of_bundle


@layers.register
class Photons(Delivered):
    """A PhotonUpdate for each PhotonMap. The amount is the frozenset of them."""

    name = "photons"
    summary = "indirect light as photons, packed in bundles: only those whose lamp has changed, the oldest first"
    drawn_by = "photons"
    something = frozenset({PhotonMap()})


# A bundle is whole or not there, so bundles may come in any order, and of each the newest stays.

Array = NDArray[np.float64]
# Bytes of a photon: position, normal, power.
PHOTON_BYTES = 12
# Whether every bundle has been sent; lowest corner and edge of the cube that holds all positions.
_CUBE = struct.Struct("<B4f")
# Bundle, its number, its photons.
_HEAD = struct.Struct("<IIH")
CUBE_BYTES, HEAD_BYTES = _CUBE.size, _HEAD.size
_STEPS = 65535
# Of a shared exponent, see shared_exponent().
_MANTISSA, _BIAS, _EXPONENTS = 9, 15, 32
# Paths of a bundle, and the room for photons that each path takes: they leave about one each.
FEWEST_PATHS, MOST_PATHS, PHOTONS_A_PATH = 8, 256, 2

Sent = tuple[int, int]  # bundle, number


def bundle_bytes(paths: int) -> int:
    """Return the bytes of the largest bundle of so many paths."""
    return HEAD_BYTES + PHOTON_BYTES * PHOTONS_A_PATH * paths


# A sun and the sky send so many more photons than a point: most of theirs never come in.
OPEN = 8
# Any bundle of the fewest paths fits.
LEAST_BUDGET = CUBE_BYTES + bundle_bytes(FEWEST_PATHS)


def paths_of_bundle(budget: int) -> int:
    """Return how many paths a bundle has so that any bundle fits a frame of `budget` bytes."""
    paths = MOST_PATHS
    while paths > FEWEST_PATHS and CUBE_BYTES + bundle_bytes(paths) > budget:
        paths //= 2
    return paths


@attrs.frozen(eq=False)
class PhotonUpdate:
    """What one frame brings."""

    # The cube and bundles; the link writes what it has decoded over it.
    content: NDArray[np.uint8]
    # What the sender needs to know again when it hears of the frame.
    bundles: tuple[Sent, ...] = ()


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

    places: (n, 3) in shares of the cube. normals: (n, 2) as scenes.octahedral() returns them.
    """
    steps = np.rint(np.clip(places, 0, 1) * _STEPS).astype(np.uint16)
    return _HEAD.pack(*sent, len(steps)) + steps.tobytes() + normals.tobytes() + shared_exponent(powers).tobytes()


def unpacked(content: NDArray[np.uint8]) -> tuple[bool, Cube, list[tuple[Sent, NDArray[np.uint32]]]]:
    """Return whether every bundle has been sent, the cube, and the bundles that came.

    A photon has three words: x and y; z and normal; power.
    """
    data = content.tobytes()
    whole, *low, edge = _CUBE.unpack_from(data)
    return bool(whole), Cube(np.array(low), edge), list(_bundles(data, CUBE_BYTES))


def _bundles(data: bytes, at: int) -> Iterator[tuple[Sent, NDArray[np.uint32]]]:
    while at < len(data):
        bundle, number, count = _HEAD.unpack_from(data, at)
        at += HEAD_BYTES
        words = np.zeros((count, 3), np.uint32)
        steps = np.frombuffer(data, np.uint16, 3 * count, at).reshape(count, 3).astype(np.uint32)
        normals = np.frombuffer(data, np.uint8, 2 * count, at + 6 * count).reshape(count, 2).astype(np.uint32)
        words[:, 0] = steps[:, 0] | steps[:, 1] << 16
        words[:, 1] = steps[:, 2] | normals[:, 0] << 16 | normals[:, 1] << 24
        words[:, 2] = np.frombuffer(data, np.uint32, count, at + 8 * count)
        at += PHOTON_BYTES * count
        yield (bundle, number), words


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


class BundleSender:
    """The sender's book: the light that each bundle shows, as far as is known to have arrived.

    A bundle that was lost counts as never sent, so it is traced and sent anew. The book holds some
    numbers for each bundle, and what is on its way until its fate is heard; see Link.settled for
    what the news assumes.
    """

    def __init__(self, bundles: int) -> None:
        self._light: list[bytes | None] = [None] * bundles
        self._number = np.zeros(bundles, np.int64)
        # Whether the receiver has nothing of it, unless something is lost.
        self._empty = np.ones(bundles, bool)
        # When each was last sent, by a count.
        self._sent_at = np.full(bundles, -1, np.int64)
        self._count = 0
        self._news: list[tuple[int, int, PhotonUpdate]] = []

    @property
    def whole(self) -> bool:
        """Whether every bundle was sent, and none that is needed is known to be lost."""
        return None not in self._light

    @property
    def remembered(self) -> int:
        """How many things it remembers besides its numbers for each bundle."""
        return sum(len(update.bundles) for *_, update in self._news)

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

    def heard(self, update: PhotonUpdate, arrived: bool, heard_ns: int) -> None:
        """Take note of an update's fate, of which the sender hears at that instant."""
        if not arrived and update.bundles:
            self._count += 1
            heapq.heappush(self._news, (heard_ns, self._count, update))

    def settle(self, now_ns: int) -> None:
        """Act on the news heard by now: what was lost, and not sent anew since, was never sent."""
        while self._news and self._news[0][0] <= now_ns:
            for bundle, number in heapq.heappop(self._news)[2].bundles:
                if number == self._number[bundle]:
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
