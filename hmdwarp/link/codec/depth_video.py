"""Inverse depth as a video: H.264 of 10-bit grey at a constant quality, and a map of what is none.

A video codec predicts each picture from several before it, which no code of single pictures can: at
the same mean error it takes half the bytes of the code without loss. It bounds no single pixel's
error. Infinite and missing depths travel beside it and are exact.

Codes are multiples of half a step up to 1023. Where nearer things need more, K log(1 + codes / K)
takes their place, with K so that the nearest fits: far things keep their step, and near ones have
one in proportion to their inverse depth.

Settings: x264, because x265 at 12 bits took twice the bytes at equal error. Small blocks and
several references count most: at 320x400 veryfast made 8.8 kB a picture, slow with all partitions
4.8 in twice the time, slower 4.6 in three times. me=umh, a wider search for motion: 5 % fewer bytes
at 640x800 and an equal error in the same time. psy: its grain would be depth.
"""

from __future__ import annotations

import functools
import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .codecs import Codec
from .depth_codec import checked
from .grey_codec import GreyDecoder, GreyEncoder
from .holes import covered
from .packet import Packet, from_two_parts, two_parts
from .stream import VideoDecoder, VideoEncoder, padded
from .undecodable import Undecodable

_FORMAT, _MOST = "gray10le", 1023
_CODEC = Codec(
    "depth as video",
    "H.264 by x264, 10-bit grey",
    "libx264",
    "h264",
    threads=2,
    options={
        "preset": "slow",
        "tune": "zerolatency",
        "forced-idr": "1",
        "sc_threshold": "0",
        "psy": "0",
        "x264-params": "partitions=all:no-dct-decimate=1:me=umh",
        # Of 63 at 10 bits: the stream weighs about as much as colour at its codec's own quality.
        # On average a pixel is off by half a step (walk, 320x400) to nine tenths of one
        # (look-around, 640x800); 3 to 10 in a hundred are by more than two.
        "qp": "22",
    },
)
# CRC-32 of everything after it, step, nearest inverse depth, bytes of the map, which follows; then
# the video.
_HEADER = struct.Struct("<IddI")
# Codes a step: what the video rounds anyway need not be rounded before.
_FINER = 2
_SURFACE, _FAR, _NONE = range(3)


class DepthVideoEncoder:
    """Encode the inverse depths of one stream, of `size` (w, h), at steps of `step` 1/m.

    Errors: MachineError as VideoEncoder.
    """

    def __init__(self, size: tuple[int, int], rate_hz: float, step: float) -> None:
        self._size, self._step = size, step / _FINER
        self._video = VideoEncoder(_CODEC, size, rate_hz, _FORMAT, {})
        self._kinds = GreyEncoder(size, "depth")
        self._number, self._nearest = 0, 0.0
        self._key_wanted = True

    def request_key(self) -> None:
        """Make the next picture a key frame, because an earlier one is missing."""
        self._key_wanted = True

    def encode(self, inverse_depth: NDArray[np.float32]) -> Packet:
        """Encode (h, w) float32 in 1/m; below 0 is no depth.

        Errors: ValueError for NaN or infinity, and for another size.
        """
        import av

        values, largest = checked(inverse_depth)
        if values.shape != self._size[::-1]:
            raise ValueError(f"inverse depth of shape {values.shape}: expected {self._size[::-1]}")
        # In powers of 2, and falling with a key frame only: another scale changes all of a video.
        nearest = 2.0 ** math.ceil(math.log2(largest)) if largest > 0 else 0.0
        self._nearest = max(nearest, 0.0 if self._key_wanted else self._nearest)
        none = values < 0
        codes = covered(_codes(np.maximum(values, 0), self._step, self._nearest)[..., None], none)[..., 0]
        frame = av.VideoFrame.from_ndarray(padded(codes, self._video.size), format=_FORMAT)
        video, key = self._video.encode(frame, self._key_wanted)
        kinds = np.where(none, _NONE, np.where(values == 0, _FAR, _SURFACE)).astype(np.uint16)
        told = self._kinds.encode(kinds)
        number, self._number, self._key_wanted = self._number, self._number + 1, False
        return Packet(number, key, two_parts(_HEADER, (self._step, self._nearest), told, video))


class DepthVideoDecoder:
    """Decode the packets of a DepthVideoEncoder of the same size.

    They must come in the order of encoding; some may be missing.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self._size = size
        self._video, self._kinds = VideoDecoder(_CODEC, size, "depth"), GreyDecoder(size, "depth")

    def decode(self, packet: Packet) -> NDArray[np.float32]:
        """Return (h, w) float32; no depth is -1, and 0 is what was infinitely far.

        Errors: Undecodable for damaged bytes or another size, and for every picture from a missing
        one to the next key frame.
        """
        self._video.begin(packet.number, packet.key)
        (step, nearest), told, video = from_two_parts(_HEADER, packet.data, "depth")
        if not (2.0**-30 <= step <= 2.0**30 and 0 <= nearest <= 2.0**128):
            raise Undecodable(f"damaged depth (steps of {step:g}, up to {nearest:g})")
        kinds, _ = self._kinds.decode(told)
        out = _values(step, nearest)[_first_plane(self._video.decode(video, packet.number), self._size)]
        out[kinds == _FAR] = 0
        out[kinds == _NONE] = -1
        return out


def _first_plane(frame: Any, size: tuple[int, int]) -> NDArray[np.uint16]:
    """Return the codes; FFmpeg's decoder gives grey with or without empty chroma."""
    plane = frame.planes[0]
    rows = np.frombuffer(plane, np.uint16).reshape(plane.height, plane.line_size // 2)
    return np.minimum(rows[: size[1], : size[0]], _MOST)


def _codes(values: NDArray[np.float32], step: float, nearest: float) -> NDArray[np.uint16]:
    """Return the code of each inverse depth from 0 to `nearest`."""
    bend = _bend(nearest / step)
    steps = values.astype(np.float64) / step
    codes = steps if bend is None else bend * np.log1p(steps / bend)
    return np.minimum(np.rint(codes), _MOST).astype(np.uint16)


@functools.lru_cache(maxsize=64)
def _values(step: float, nearest: float) -> NDArray[np.float32]:
    """Return the inverse depth of each code.

    0 stands for what is farther than half a step, without what is infinitely far.
    """
    bend, codes = _bend(nearest / step), np.arange(_MOST + 1, dtype=np.float64)
    codes[0] = 0.25
    return (step * (codes if bend is None else bend * np.expm1(codes / bend))).astype(np.float32)


@functools.lru_cache(maxsize=64)
def _bend(steps: float) -> float | None:
    """Return K, at which K log(1 + steps / K) is the last code; None where all fit as they are.

    By halving: it grows with K, towards the number of steps.
    """
    if steps <= _MOST:
        return None
    low, high = 1e-3, 1e12
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if middle * math.log1p(steps / middle) < _MOST else (low, middle)
    return low
