"""One eye's stream of frames: colour and depth to packets, packets to what the client sees."""

from __future__ import annotations

import functools
import math

import attrs
import numpy as np
from numpy.typing import NDArray

from ...colour import linear_from_srgb
from ...errors import InputError
from .codecs import Codec, codecs
from .coding import check_quality
from .depth_codec import DepthDecoder, DepthEncoder
from .holes import covered
from .stream import ColourDecoder, ColourEncoder
from .undecodable import Undecodable


@attrs.frozen
class Packet:
    """One eye's frame on the network."""

    # 0 for the first of its stream.
    number: int
    # Whether it can be decoded without those before it.
    key: bool
    colour: bytes = attrs.field(repr=lambda data: f"<{len(data)} bytes>")
    depth: bytes = attrs.field(repr=lambda data: f"<{len(data)} bytes>")

    @property
    def size_bytes(self) -> int:
        """The size of colour and depth."""
        return len(self.colour) + len(self.depth)


@attrs.frozen(eq=False)
class Picture:
    """One eye's frame as it arrived; a hole is (0, 0, 0) and -1."""

    # (h, w, 3) sRGB.
    colour: NDArray[np.uint8]
    # (h, w) in 1/m.
    inverse_depth: NDArray[np.float32]

    def rgba(self) -> NDArray[np.float16]:
        """Return (h, w, 4) linear light with coverage in alpha; a hole is (0, 0, 0, 0)."""
        out = np.empty((*self.colour.shape[:2], 4), np.float16)
        out[..., :3] = _half_of_byte()[self.colour]
        out[..., 3] = self.inverse_depth >= 0
        return out


class Encoder:
    """Encode the frames of one eye into packets.

    size: (w, h) of its frames. crf: constant quality, 0 (best) to 51; or bitrate_mbit: Mbit/s of
    its colour; neither: the codec's own crf. key_every_s: a key frame at least that often; None:
    the first, and those requested. Depth takes no part in the reference chain: each frame's is
    packed by itself. Errors: InputError for numbers out of range, or codec "none", which encodes
    nothing; MachineError as ColourEncoder.
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
    ) -> None:
        check_quality(crf, bitrate_mbit)
        if key_every_s is not None and not 0 < key_every_s < math.inf:
            raise InputError(f"key frames every {key_every_s:g} s: expected a time above 0")
        self.size = size
        self._colour = ColourEncoder(_coding(codec), size, rate_hz, crf, bitrate_mbit)
        self._depth = DepthEncoder(size)
        self._key_every = max(1, round(key_every_s * rate_hz)) if key_every_s is not None else None
        self._number, self._last_key = 0, 0
        self._key_wanted = True

    def request_key(self) -> None:
        """Make the next frame a key frame, because an earlier one is missing."""
        self._key_wanted = True

    def encode(self, colour_srgb: NDArray[np.uint8], inverse_depth: NDArray[np.float32]) -> Packet:
        """Encode the next frame.

        colour_srgb: (h, w, 3). inverse_depth: (h, w) in 1/m, holes below 0. Rows in either order.
        Errors: ValueError.
        """
        _check_shapes(self.size, colour_srgb, inverse_depth)
        number = self._number
        is_due = self._key_every is not None and number - self._last_key >= self._key_every
        colour, key = self._colour.encode(covered(colour_srgb, inverse_depth), self._key_wanted or is_due)
        packet = Packet(number, key, colour, self._depth.encode(inverse_depth))
        self._number, self._key_wanted = number + 1, False
        self._last_key = number if key else self._last_key
        return packet


class Decoder:
    """Decode packets into pictures of one eye.

    They must come in the order of encoding; some may be missing.
    """

    def __init__(self, codec: str | Codec, size: tuple[int, int]) -> None:
        self.size = size
        self._colour = ColourDecoder(_coding(codec), size)
        self._depth = DepthDecoder(size)
        self._next: int | None = None  # None: wait for a key frame

    def decode(self, packet: Packet) -> Picture:
        """Return the frame as the client sees it.

        Errors: Undecodable for damaged bytes, and for every frame from a missing one to the next
        key frame.
        """
        if packet.key:
            self._colour.restart()
        elif packet.number != self._next:
            self._next = None
            raise Undecodable(f"frame {packet.number} builds on one that never came")
        colour = self._colour.decode(packet.colour)
        self._next = packet.number + 1
        inverse_depth = self._depth.decode(packet.depth)
        colour[inverse_depth < 0] = 0
        return Picture(colour, inverse_depth)


def _coding(codec: str | Codec) -> Codec:
    codec = codecs.get(codec) if isinstance(codec, str) else codec
    if codec.is_none:
        raise InputError(
            f"codec '{codec.name}' encodes nothing: "
            f"expected one of {', '.join(one.name for one in codecs if not one.is_none)}"
        )
    return codec


def _check_shapes(size: tuple[int, int], colour: NDArray, inverse_depth: NDArray) -> None:
    width, height = size
    if colour.shape != (height, width, 3) or colour.dtype != np.uint8 or inverse_depth.shape != (height, width):
        found = f"{colour.dtype} colour of shape {colour.shape} and inverse depth of shape {inverse_depth.shape}"
        raise ValueError(f"{found}: expected uint8 of shape {(height, width, 3)} and {(height, width)}")


@functools.cache
def _half_of_byte() -> NDArray[np.float16]:
    return linear_from_srgb(np.arange(256, dtype=np.uint8)).astype(np.float16)
