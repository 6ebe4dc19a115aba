"""Inverse depth on the link: codes that bound each pixel's error, and as video."""

from __future__ import annotations

import functools
import math
import struct
import zlib
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import MachineError
from .codecs import Codec, require
from .stream import Packet, Undecodable, VideoDecoder, VideoEncoder, covered, from_two_parts, padded, two_parts

# 1/m: up to 64 per metre, which is 16 mm from the eye.
STEP = 2.0**-10
NO_DEPTH = 65535
_MOST_CODE = NO_DEPTH - 1


class DepthEncoder:
    """Packs the inverse depth of one eye's frames, of `size` (w, h).

    step: 1/m; the power of 2 at or below it is taken.

    Errors: MachineError if this PyAV lacks FFV1.
    """

    def __init__(self, size: tuple[int, int], step: float = STEP) -> None:
        self._grey, self._exponent = GreyEncoder(size, "depth"), math.frexp(step)[1] - 1

    def encode(self, inverse_depth: NDArray[np.float32]) -> bytes:
        """Pack (h, w) float32 in 1/m; below 0 is no depth.

        The rows may run either way. Errors: ValueError for NaN or infinity.
        """
        return self._grey.encode(*codes_of(inverse_depth, self._exponent))


class DepthDecoder:
    """Unpacks the bytes of a DepthEncoder of the same size."""

    def __init__(self, size: tuple[int, int]) -> None:
        self._grey = GreyDecoder(size, "depth")

    def decode(self, data: bytes) -> NDArray[np.float32]:
        """Return (h, w) float32 within half a step; no depth is -1.

        Errors: Undecodable for bytes that are damaged or of another size.
        """
        return inverse_depth_of(*self._grey.decode(data))


def checked(inverse_depth: NDArray[np.float32]) -> tuple[NDArray[np.float32], float]:
    """Return the inverse depths and the largest. Errors: as DepthEncoder.encode."""
    values = np.asarray(inverse_depth, np.float32)
    largest = float(values.max(initial=0))
    if not np.isfinite(largest):
        raise ValueError(f"inverse depth {largest}: expected finite numbers, below 0 for no depth")
    return values, largest


def codes_of(inverse_depth: NDArray[np.float32], least: int) -> tuple[NDArray[np.uint16], int]:
    """Return the code of each pixel and the exponent of the step, no smaller than `least`.

    Errors: as DepthEncoder.encode.
    """
    values, largest = checked(inverse_depth)
    exponent = least
    while largest > _MOST_CODE * 2.0**exponent:
        exponent += 1
    # A power of 2: nothing is rounded.
    codes = np.ceil(np.maximum(values, 0) * np.float32(2.0**-exponent)).astype(np.uint16)
    if exponent > least:
        # A value too small for float32 next to an extremely near one.
        codes[(values > 0) & (codes == 0)] = 1
    codes[values < 0] = NO_DEPTH
    return codes, exponent


def inverse_depth_of(codes: NDArray[np.uint16], exponent: int) -> NDArray[np.float32]:
    """Return 1/m of each code, -1 for no depth."""
    values = (codes.astype(np.float32) - np.float32(0.5)) * np.float32(2.0**exponent)
    values[codes == 0] = 0
    values[codes == NO_DEPTH] = -1
    return values


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


# CRC-32 of everything after it, width, height, a number of the user's, the first pixel, bytes of
# FFV1's configuration, which follows; none for a picture of one number.
_GREY_HEADER = struct.Struct("<IHHbHB")
_CHECKED_FROM = 4
_NAME, _GREY_FORMAT = "ffv1", "gray16le"
# A fixed number of slices: the same bytes on any machine.
_OPTIONS = {"level": "3", "slices": "4", "slicecrc": "0"}
_THREADS = 2
_SMALLEST = 16  # 4 slices of a picture need some rows and columns each


class GreyEncoder:
    """Packs pictures of `size` (w, h). what: what they are, for errors.

    Errors: MachineError if this PyAV lacks FFV1.
    """

    def __init__(self, size: tuple[int, int], what: str) -> None:
        import av

        require(what, _NAME, "w")
        context: Any = av.CodecContext.create(_NAME, "w")
        context.width, context.height = (max(side, _SMALLEST) for side in size)
        context.pix_fmt, context.gop_size, context.thread_count = _GREY_FORMAT, 1, _THREADS
        context.framerate, context.time_base = Fraction(60), Fraction(1, 60)  # required, unused
        context.options = dict(_OPTIONS)
        try:
            context.open()
        except (OSError, ValueError, av.FFmpegError) as error:
            raise MachineError(
                f"encoder '{_NAME}' does not take pictures of {size[0]}x{size[1]} ({error}): use another size"
            ) from error
        self._context = context
        self._configuration = bytes(context.extradata)

    def encode(self, codes: NDArray[np.uint16], beside: int = 0) -> bytes:
        """Pack (h, w) numbers, and one from -128 to 127 that belongs to all of them."""
        first = codes[0, 0]
        coded = b"" if (codes == first).all() else self._coded(codes)
        configuration = self._configuration if coded else b""
        height, width = codes.shape
        head = _GREY_HEADER.pack(0, width, height, beside, first, len(configuration))
        data = head[_CHECKED_FROM:] + configuration + coded
        return zlib.crc32(data).to_bytes(_CHECKED_FROM, "little") + data

    def _coded(self, codes: NDArray[np.uint16]) -> bytes:
        import av

        height, width = codes.shape
        padded = np.pad(codes, ((0, self._context.height - height), (0, self._context.width - width)), mode="edge")
        packets = self._context.encode(av.VideoFrame.from_ndarray(padded, format=_GREY_FORMAT))
        if len(packets) != 1:
            raise MachineError(
                f"encoder '{_NAME}' gave {len(packets)} packets for one picture: it cannot run without delay"
            )
        return bytes(packets[0])


class GreyDecoder:
    """Unpacks the bytes of a GreyEncoder of the same size."""

    def __init__(self, size: tuple[int, int], what: str) -> None:
        require(what, _NAME, "r")
        self.size, self._what = size, what
        self._context: Any = None
        self._configuration = b""

    def decode(self, data: bytes) -> tuple[NDArray[np.uint16], int]:
        """Return what GreyEncoder.encode was given.

        Errors: Undecodable for bytes that are damaged or of another size.
        """
        import av

        try:
            checksum, *size, beside, first, length = _GREY_HEADER.unpack_from(data)
            if tuple(size) != tuple(self.size):
                raise ValueError(f"of {size[0]}x{size[1]} pixels")
            if zlib.crc32(data[_CHECKED_FROM:]) != checksum:
                raise ValueError("its checksum is wrong")
            if not length:
                return np.full(self.size[::-1], first, np.uint16), beside
            start = _GREY_HEADER.size + length
            frames = self._context_for(data[_GREY_HEADER.size : start]).decode(av.Packet(data[start:]))
        except (struct.error, OSError, ValueError, av.FFmpegError) as error:
            raise Undecodable(f"damaged {self._what} ({error})") from error
        width, height = (max(side, _SMALLEST) for side in self.size)
        if len(frames) != 1 or (frames[0].width, frames[0].height, frames[0].format.name) != (
            width,
            height,
            _GREY_FORMAT,
        ):
            raise Undecodable(f"damaged {self._what} (not one picture of the stream's size)")
        return frames[0].to_ndarray()[: self.size[1], : self.size[0]], beside

    def _context_for(self, configuration: bytes) -> Any:
        import av

        if self._context is None or configuration != self._configuration:
            context: Any = av.CodecContext.create(_NAME, "r")
            context.width, context.height = (max(side, _SMALLEST) for side in self.size)
            context.thread_type, context.thread_count = "SLICE", _THREADS
            context.extradata = configuration
            self._context, self._configuration = context, configuration
        return self._context


_EXPONENT = -10
_ZERO = 2**15
_LARGEST = _ZERO - 1


class VectorEncoder:
    """Packs pictures of `channels` numbers a pixel, of `size` (w, h).

    Errors: MachineError if this PyAV lacks FFV1.
    """

    def __init__(self, size: tuple[int, int], channels: int) -> None:
        self._grey, self._channels = GreyEncoder(size, "vectors"), channels

    def encode(self, vectors: NDArray[np.floating]) -> bytes:
        """Pack (h, w, channels). Errors: ValueError for NaN or infinity."""
        values = np.asarray(vectors, np.float32)
        largest = float(np.abs(values).max(initial=0))
        if not np.isfinite(largest):
            raise ValueError(f"a vector of {largest}: expected finite numbers")
        exponent = _EXPONENT
        while largest > _LARGEST * 2.0**exponent:
            exponent += 1
        codes = (np.rint(values * np.float32(2.0**-exponent)) + _ZERO).astype(np.uint16)
        parts = [self._grey.encode(codes[..., channel], exponent) for channel in range(self._channels)]
        return struct.pack(f"<{len(parts)}I", *map(len, parts)) + b"".join(parts)


class VectorDecoder:
    """Unpacks the bytes of a VectorEncoder of the same size and channels."""

    def __init__(self, size: tuple[int, int], channels: int) -> None:
        self._grey, self._channels = GreyDecoder(size, "vectors"), channels

    def decode(self, data: bytes) -> NDArray[np.float32]:
        """Return (h, w, channels) within half a step.

        Errors: Undecodable for bytes that are damaged or of another size.
        """
        try:
            lengths = struct.unpack_from(f"<{self._channels}I", data)
        except struct.error as error:
            raise Undecodable(f"damaged vectors ({error})") from error
        channels, start = [], 4 * self._channels
        for length in lengths:
            codes, exponent = self._grey.decode(data[start : start + length])
            channels.append((codes.astype(np.float32) - _ZERO) * np.float32(2.0**exponent))
            start += length
        return np.stack(channels, axis=-1)
