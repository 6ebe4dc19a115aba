"""One stream of pictures with coverage: to packets, and packets to what the client sees."""

from __future__ import annotations

import math
import struct

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .codecs import Codec, codecs
from .coding import check_quality
from .stream import (
    ColourDecoder,
    ColourEncoder,
    Packet,
    Undecodable,
    bytes_from_light,
    covered,
    from_two_parts,
    light_from_bytes,
    pack,
    stops_of,
    two_parts,
    unpack,
)

# See two_parts. The fields: powers of 2 beyond 1, the light of uncovered pixels as half floats; the
# parts: coverage (after a key frame XORed with the one before) and video.
_HEADER = struct.Struct("<IB6sI")
# A byte of coverage: 0 is nothing at all, 1 to 255 a coverage of 0 to 1.
_STEPS = 254
_COVERED = np.float16(1).view(np.uint16)


class Encoder:
    """Encode the pictures of one stream into packets.

    size: (w, h). crf: constant quality, 0 (best) to 51; or bitrate_mbit: Mbit/s of the video;
    neither: the codec's own crf. key_every_s: a key frame at least that often; None: the first, and
    those requested. keeps_beyond_1: whether light above 1 is kept; a display clips it, but what is
    multiplied by less than 1 before it is shown needs it. Coverage is packed without loss; after a
    key frame what changed of it is, so that a headset's hidden area costs little.
    Errors: InputError for numbers out of range, or codec "none", which encodes nothing;
    MachineError as ColourEncoder.
    """

    def __init__(
        self,
        codec: str | Codec,
        size: tuple[int, int],
        rate_hz: float,
        *,
        crf: int | None = None,
        bitrate_mbit: float | None = None,
        key_every_s: float | None = None,
        keeps_beyond_1: bool = False,
    ) -> None:
        check_quality(crf, bitrate_mbit)
        if key_every_s is not None and not 0 < key_every_s < math.inf:
            raise InputError(f"key frames every {key_every_s:g} s: expected a time above 0")
        self.size = size
        self._colour = ColourEncoder(_coding(codec), size, rate_hz, crf, bitrate_mbit)
        self._key_every = max(1, round(key_every_s * rate_hz)) if key_every_s is not None else None
        self._number, self._last_key = 0, 0
        self._key_wanted = True
        self._keeps_beyond_1, self._stops = keeps_beyond_1, 0
        self._before = np.zeros(size[::-1], np.uint8)

    def request_key(self) -> None:
        """Make the next picture a key frame, because an earlier one is missing."""
        self._key_wanted = True

    def encode(self, picture: NDArray[np.float16]) -> Packet:
        """Encode the next picture: (h, w, 4) linear light with coverage in alpha.

        Rows in either order. A pixel without coverage comes back exactly if all such pixels are the
        same, as where nothing was drawn; else within the codec's error, like any other. Errors:
        ValueError.
        """
        width, height = self.size
        if picture.shape != (height, width, 4) or picture.dtype != np.float16:
            found = f"{picture.dtype} of shape {picture.shape}"
            raise ValueError(f"{found}: expected float16 of shape {(height, width, 4)}")
        number = self._number
        is_due = self._key_every is not None and number - self._last_key >= self._key_every
        wants_key = self._key_wanted or is_due
        light = np.ascontiguousarray(picture[..., :3])
        empty, coverage = _coverage(picture)
        if self._keeps_beyond_1:
            # It falls with a key frame only: another scale changes every block of the video.
            self._stops = max(stops_of(light), 0 if wants_key else self._stops)
        colour, key = self._colour.encode(covered(bytes_from_light(light, self._stops), coverage == 0), wants_key)
        packed = pack(coverage if key else coverage ^ self._before)
        data = two_parts(_HEADER, (self._stops, empty.tobytes()), packed, colour)
        self._before = coverage
        self._number, self._key_wanted = number + 1, False
        self._last_key = number if key else self._last_key
        return Packet(number, key, data)


class Decoder:
    """Decode the packets of one stream into pictures.

    They must come in the order of encoding; some may be missing.
    """

    def __init__(self, codec: str | Codec, size: tuple[int, int]) -> None:
        self.size = size
        self._colour = ColourDecoder(_coding(codec), size)
        self._before = np.zeros(size[::-1], np.uint8)

    def decode(self, packet: Packet) -> NDArray[np.float16]:
        """Return the picture as the client sees it: as encoded, coverage within 1/508.

        Errors: Undecodable for damaged bytes, and for every picture from a missing one to the next
        key frame.
        """
        self._colour.begin(packet.number, packet.key)
        stops, empty, packed, video = _parts(packet.data)
        colour = self._colour.decode(video, packet.number)
        coverage = unpack(packed)
        if coverage.shape != self._before.shape or coverage.dtype != np.uint8:
            raise Undecodable("damaged picture (coverage of another size)")
        self._before = coverage = coverage if packet.key else coverage ^ self._before
        out = np.empty((*coverage.shape, 4), np.float16)
        out[..., :3] = light_from_bytes(colour, stops)
        out[..., 3] = np.maximum(coverage.astype(np.float32) - 1, 0) / _STEPS
        out[coverage == 0] = (*empty, 0)
        return out


def _coverage(picture: NDArray[np.float16]) -> tuple[NDArray[np.float16], NDArray[np.uint8]]:
    """Return the light of what is not covered, (3,), and the byte of each pixel's coverage."""
    alpha = picture[..., 3]
    empty = np.zeros(3, np.float16)
    if (alpha.view(np.uint16) == _COVERED).all():
        return empty, np.full(alpha.shape, 1 + _STEPS, np.uint8)
    codes = (1.5 + _STEPS * np.clip(alpha.astype(np.float32), 0, 1)).astype(np.uint8)
    hole = alpha == 0
    if hole.any():
        empty = picture[hole][0, :3].copy()
        codes[hole & (picture[..., :3] == empty).all(axis=-1)] = 0
    return empty, codes


def _parts(data: bytes) -> tuple[int, NDArray[np.float16], bytes, bytes]:
    """Return a packet's powers of 2, light of uncovered pixels, coverage and video.

    Errors: Undecodable.
    """
    (stops, empty), packed, video = from_two_parts(_HEADER, data, "picture")
    return stops, np.frombuffer(empty, np.float16), packed, video


def _coding(codec: str | Codec) -> Codec:
    codec = codecs.get(codec) if isinstance(codec, str) else codec
    if codec.is_none:
        raise InputError(
            f"codec '{codec.name}' encodes nothing: "
            f"expected one of {', '.join(codec.name for codec in codecs if not codec.is_none)}"
        )
    return codec
