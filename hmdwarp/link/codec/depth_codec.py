"""Inverse depth on the link: codes that bound each pixel's error, and as video."""

from __future__ import annotations

import functools
import math
import struct
import zlib
from fractions import Fraction
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import MachineError, pyav
from .codecs import Codec, require
from .coding import AS_VIDEO, AS_VIDEO8
from .stream import (
    Packet,
    Undecodable,
    VideoDecoder,
    VideoEncoder,
    covered,
    from_two_parts,
    one_packet,
    padded,
    two_parts,
)

Size = tuple[int, int]
# 1/m: up to 64 per metre, which is 16 mm from the eye.
STEP = 2.0**-10
_NO_DEPTH = 65535


class DepthEncoder:
    """Packs the inverse depth of one eye's frames, of `size` (w, h).

    step: 1/m; the power of 2 at or below it is taken.
    Errors: MachineError if this PyAV lacks FFV1.
    """

    def __init__(self, size: Size, step: float = STEP) -> None:
        self._grey, self._exponent = _GreyEncoder(size, "depth"), math.frexp(step)[1] - 1

    def encode(self, inverse_depth: NDArray[np.float32]) -> bytes:
        """Pack (h, w) float32 in 1/m; below 0 is no depth.

        The rows may run either way. Errors: ValueError for NaN or infinity.
        """
        values, largest = _checked(inverse_depth)
        exponent = self._exponent
        while largest > (_NO_DEPTH - 1) * 2.0**exponent:
            exponent += 1
        # A power of 2: nothing is rounded.
        codes = np.ceil(np.maximum(values, 0) * np.float32(2.0**-exponent)).astype(np.uint16)
        if exponent > self._exponent:
            # A value too small for float32 next to an extremely near one.
            codes[(values > 0) & (codes == 0)] = 1
        codes[values < 0] = _NO_DEPTH
        return self._grey.encode(codes, exponent)


class DepthDecoder:
    """Unpacks the bytes of a DepthEncoder of the same size."""

    def __init__(self, size: Size) -> None:
        self._grey = _GreyDecoder(size, "depth")

    def decode(self, data: bytes) -> NDArray[np.float32]:
        """Return (h, w) float32 within half a step; no depth is -1.

        Errors: Undecodable for bytes that are damaged or of another size.
        """
        codes, exponent = self._grey.decode(data)
        values = (codes.astype(np.float32) - np.float32(0.5)) * np.float32(2.0**exponent)
        values[codes == 0] = 0
        values[codes == _NO_DEPTH] = -1
        return values


def _checked(inverse_depth: NDArray[np.float32]) -> tuple[NDArray[np.float32], float]:
    """Return the inverse depths and the largest."""
    values = np.asarray(inverse_depth, np.float32)
    largest = float(values.max(initial=0))
    if not np.isfinite(largest):
        raise ValueError(f"inverse depth {largest}: expected finite numbers, below 0 for no depth")
    return values, largest


@attrs.frozen(eq=False)
class _DepthVideo:
    """How codes of depth become a picture of a video."""

    codec: Codec
    format: str  # FFmpeg's, of pixels
    most: int  # code
    # By how much the nearest step may exceed the farthest, where not all fit as they are.
    most_bend: float = math.inf

    def picture(self, codes: NDArray[np.uint16], size: Size) -> Any:
        """Return a frame of PyAV, of `size`."""
        grey, frame = padded(codes, size), pyav().VideoFrame
        if self.format == "gray10le":
            return frame.from_ndarray(grey, format=self.format)
        neutral = np.full((size[1] // 2, size[0]), 128, np.uint8)
        return frame.from_ndarray(np.vstack([grey.astype(np.uint8), neutral]), format=self.format)

    def codes_in(self, frame: Any, size: Size) -> NDArray[np.integer[Any]]:
        """Return the codes; FFmpeg's decoder gives grey with or without empty chroma."""
        plane, kind = frame.planes[0], np.dtype(np.uint8 if self.most < 256 else np.uint16)
        rows = np.frombuffer(plane, kind).reshape(plane.height, plane.line_size // kind.itemsize)
        return np.minimum(rows[: size[1], : size[0]], self.most)

    def codes_of(self, values: NDArray[np.float32], step: float, nearest: float) -> NDArray[np.uint16]:
        """Return the code of each inverse depth from 0 to `nearest`."""
        bend = self.bend(nearest / step)
        steps = values.astype(np.float64) / step
        codes = steps if bend is None else bend * np.log1p(steps / bend)
        return np.minimum(np.rint(codes), self.most).astype(np.uint16)

    def least_step(self, nearest: float) -> float:
        """Return the step from which on steps grow by `most_bend` up to the nearest code.

        K log(1 + n / K) is the last code where the last step is 1 + n / K of the first.
        """
        most_bend = self.most_bend
        return nearest * math.log(most_bend) / ((most_bend - 1) * self.most) if 1 < most_bend < math.inf else 0.0

    @functools.lru_cache(maxsize=64)  # noqa: B019 (there are two of them)
    def values(self, step: float, nearest: float) -> NDArray[np.float32]:
        """Return the inverse depth of each code.

        0 stands for what is farther than half a step, without what is infinitely far.
        """
        bend, codes = self.bend(nearest / step), np.arange(self.most + 1, dtype=np.float64)
        codes[0] = 0.25
        return (step * (codes if bend is None else bend * np.expm1(codes / bend))).astype(np.float32)

    @functools.lru_cache(maxsize=64)  # noqa: B019 (there are two of them)
    def bend(self, steps: float) -> float | None:
        """Return K, at which K log(1 + steps / K) is the last code; None where all fit as they are.

        By halving: it grows with K, towards the number of steps.
        """
        if steps <= self.most:
            return None
        low, high = 1e-3, 1e12
        for _ in range(200):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if middle * math.log1p(steps / middle) < self.most else (low, middle)
        return low


def _codec(bits: str, qp: int) -> Codec:
    options = {"preset": "slow", "tune": "zerolatency", "forced-idr": "1", "sc_threshold": "0", "psy": "0"}
    options |= {"x264-params": "partitions=all:no-dct-decimate=1:me=umh", "qp": str(qp)}
    return Codec(f"depth as {bits} video", f"H.264 by x264, {bits} grey", "libx264", "h264", threads=2, options=options)


# Of 63: the stream weighs about as much as colour at its codec's own quality. On average
# a pixel is off by half a step (walk, 320x400) to nine tenths of one (look-around, 640x800); 3 to
# 10 in a hundred are by more than two.
_TEN_BITS = _DepthVideo(_codec("10-bit", 22), "gray10le", 1023)
# What headsets and browsers decode in hardware: 8 bits, 4:2:0, all chroma in the middle. At 10 of
# 51 it weighs what the one of 10 bits does, and warped pictures are within 0.03 dB of those by
# exact depth (room: walk and sideways, 200 ms, 320x400). A bend of 3 costs `walk` 0.04 dB, of 20
# only bits; at 14 of 51 it is a quarter lighter for 0.05 dB.
_EIGHT_BITS = _DepthVideo(_codec("8-bit", 10), "yuv420p", 255, most_bend=8.0)
DEPTH_VIDEOS = {AS_VIDEO: _TEN_BITS, AS_VIDEO8: _EIGHT_BITS}
# CRC-32 of everything after it, step, nearest inverse depth, bytes of the map, which follows; then
# the video. Beside a picture that is no key frame, the map is XORed with the one before: a
# headset's hidden area stays. It is packed by FFV1, beside 8 bits by what a browser has.
_HEADER = struct.Struct("<IddI")
# Codes a step: what the video rounds anyway need not be rounded before.
_FINER = 2
_SURFACE, _FAR, _NONE = range(3)


class DepthVideoEncoder:
    """Encode the inverse depths of one stream, of `size` (w, h), at steps of `step` 1/m.

    Errors: MachineError as VideoEncoder.
    """

    def __init__(self, size: Size, rate_hz: float, step: float, how: _DepthVideo = _TEN_BITS) -> None:
        self._size, self._step, self._how = size, step / _FINER, how
        self._video = VideoEncoder(how.codec, size, rate_hz, how.format, {})
        self._grey = None if how is _EIGHT_BITS else _GreyEncoder(size, "depth")
        self._before = np.zeros(size[::-1], np.uint8)
        self._number, self._nearest = 0, 0.0

    def encode(self, inverse_depth: NDArray[np.float32], key: bool = False) -> Packet:
        """Encode (h, w) float32 in 1/m; below 0 is no depth. key: make it a key frame.

        Errors: ValueError for NaN or infinity, and for another size.
        """
        values, largest = _checked(inverse_depth)
        if values.shape != self._size[::-1]:
            raise ValueError(f"inverse depth of shape {values.shape}: expected {self._size[::-1]}")
        wants_key = key or not self._number
        # In powers of 2, and falling with a key frame only: another scale changes all of a video.
        nearest = 2.0 ** math.ceil(math.log2(largest)) if largest > 0 else 0.0
        self._nearest = max(nearest, 0.0 if wants_key else self._nearest)
        none = values < 0
        step = max(self._step, self._how.least_step(self._nearest))
        codes = self._how.codes_of(np.maximum(values, 0), step, self._nearest)
        picture = self._how.picture(covered(codes[..., None], none)[..., 0], self._video.size)
        video, is_key = self._video.encode(picture, wants_key)
        kinds = np.where(none, _NONE, np.where(values == 0, _FAR, _SURFACE)).astype(np.uint8)
        told = kinds if is_key else kinds ^ self._before
        packed = self._grey.encode(told.astype(np.uint16)) if self._grey else zlib.compress(told.tobytes())
        number, self._number, self._before = self._number, self._number + 1, kinds
        return Packet(number, is_key, two_parts(_HEADER, (step, self._nearest), packed, video))


class DepthVideoDecoder:
    """Decode the packets of a DepthVideoEncoder of the same size.

    They must come in the order of encoding; some may be missing.
    """

    def __init__(self, size: Size, how: _DepthVideo = _TEN_BITS) -> None:
        self._size, self._how = size, how
        self._video = VideoDecoder(how.codec, size, "depth")
        self._grey = None if how is _EIGHT_BITS else _GreyDecoder(size, "depth")
        self._before = np.zeros(size[::-1], np.uint8)

    def decode(self, packet: Packet) -> NDArray[np.float32]:
        """Return (h, w) float32; no depth is -1, and 0 is what was infinitely far.

        Errors: Undecodable for damaged bytes or another size, and for every picture from a missing
        one to the next key frame.
        """
        self._video.begin(packet.number, packet.key)
        (step, nearest), told, video = from_two_parts(_HEADER, packet.data, "depth")
        if not (2.0**-30 <= step <= 2.0**30 and 0 <= nearest <= 2.0**128):
            raise Undecodable(f"damaged depth (steps of {step:g}, up to {nearest:g})")
        if self._grey:
            kinds = self._grey.decode(told)[0].astype(np.uint8)
        else:
            try:
                kinds = np.frombuffer(zlib.decompressobj().decompress(told, self._before.size + 1), np.uint8)
                kinds = kinds.reshape(self._before.shape)
            except (zlib.error, ValueError) as error:
                raise Undecodable(f"damaged depth ({error})") from error
        self._before = kinds = kinds if packet.key else kinds ^ self._before
        codes = self._how.codes_in(self._video.decode(video, packet.number), self._size)
        out: NDArray[np.float32] = self._how.values(step, nearest)[codes]
        out[kinds == _FAR] = 0
        out[kinds == _NONE] = -1
        return out


# See two_parts. The fields: width, height, a number of the user's, the first pixel; the parts:
# FFV1's configuration and the picture, nothing for one of one number.
_GREY_HEADER = struct.Struct("<IHHbHB")
_NAME, _GREY_FORMAT = "ffv1", "gray16le"
# A fixed number of slices: the same bytes on any machine.
_OPTIONS = {"level": "3", "slices": "4", "slicecrc": "0"}
_THREADS = 2


def _grey_size(size: Size) -> Size:
    """Return the (w, h) that is coded: 4 slices of a picture need some rows and columns each."""
    return max(size[0], 16), max(size[1], 16)


class _GreyEncoder:
    """Packs pictures of `size` (w, h). what: what they are, for errors."""

    def __init__(self, size: Size, what: str) -> None:
        av = pyav()
        require(what, _NAME, "w")
        context: Any = av.CodecContext.create(_NAME, "w")
        context.width, context.height = self._coded = _grey_size(size)
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

    def encode(self, codes: NDArray[np.uint16], beside: int = 0) -> bytes:
        """Pack (h, w) numbers, and one from -128 to 127 that belongs to all of them."""
        first, (height, width), packed = codes[0, 0], codes.shape, b""
        configuration = b"" if (codes == first).all() else bytes(self._context.extradata)
        if configuration:
            frame = pyav().VideoFrame.from_ndarray(padded(codes, self._coded), format=_GREY_FORMAT)
            packed = bytes(one_packet(self._context, _NAME, frame))
        return two_parts(_GREY_HEADER, (width, height, beside, first), configuration, packed)


class _GreyDecoder:
    """Unpacks the bytes of a _GreyEncoder of the same size."""

    def __init__(self, size: Size, what: str) -> None:
        require(what, _NAME, "r")
        self._size, self._what = size, what
        self._context: Any = None
        self._configuration = b""

    def decode(self, data: bytes) -> tuple[NDArray[np.uint16], int]:
        """Return what _GreyEncoder.encode was given. Errors: Undecodable."""
        (width, height, beside, first), configuration, packed = from_two_parts(_GREY_HEADER, data, self._what)
        if (width, height) != tuple(self._size):
            raise Undecodable(f"damaged {self._what} (of {width}x{height} pixels)")
        if not configuration:
            return np.full(self._size[::-1], first, np.uint16), beside
        av = pyav()
        try:
            if self._context is None or configuration != self._configuration:
                made: Any = av.CodecContext.create(_NAME, "r")
                made.width, made.height = _grey_size(self._size)
                made.thread_type, made.thread_count = "SLICE", _THREADS
                made.extradata, self._configuration, self._context = configuration, configuration, made
            frames = self._context.decode(av.Packet(packed))
        except (OSError, ValueError, av.FFmpegError) as error:
            raise Undecodable(f"damaged {self._what} ({error})") from error
        expected = (*_grey_size(self._size), _GREY_FORMAT)
        if [(frame.width, frame.height, frame.format.name) for frame in frames] != [expected]:
            raise Undecodable(f"damaged {self._what} (not one picture of the stream's size)")
        return frames[0].to_ndarray()[: self._size[1], : self._size[0]], beside


_EXPONENT, _ZERO = -10, 2**15


class VectorEncoder:
    """Packs pictures of `channels` numbers a pixel, of `size` (w, h).

    Errors: MachineError if this PyAV lacks FFV1.
    """

    def __init__(self, size: Size, channels: int) -> None:
        self._grey, self._channels = _GreyEncoder(size, "vectors"), channels

    def encode(self, vectors: NDArray[np.floating]) -> bytes:
        """Pack (h, w, channels). Errors: ValueError for NaN or infinity."""
        values = np.asarray(vectors, np.float32)
        largest = float(np.abs(values).max(initial=0))
        if not np.isfinite(largest):
            raise ValueError(f"a vector of {largest}: expected finite numbers")
        exponent = _EXPONENT
        while largest > (_ZERO - 1) * 2.0**exponent:
            exponent += 1
        codes = (np.rint(values * np.float32(2.0**-exponent)) + _ZERO).astype(np.uint16)
        parts = [self._grey.encode(codes[..., channel], exponent) for channel in range(self._channels)]
        return struct.pack(f"<{len(parts)}I", *map(len, parts)) + b"".join(parts)


class VectorDecoder:
    """Unpacks the bytes of a VectorEncoder of the same size and channels."""

    def __init__(self, size: Size, channels: int) -> None:
        self._grey, self._channels = _GreyDecoder(size, "vectors"), channels

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
