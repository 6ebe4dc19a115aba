"""Codes of numbers with a bounded error, as grey pictures: the code itself, and that of vectors."""

from __future__ import annotations

import struct
import zlib
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import MachineError
from .codecs import require
from .stream import Undecodable

# CRC-32 of everything after it, width, height, a number of the user's, the first pixel, bytes of
# FFV1's configuration, which follows; none for a picture of one number.
_HEADER = struct.Struct("<IHHbHB")
_CHECKED_FROM = 4
_NAME, _FORMAT = "ffv1", "gray16le"
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
        context.pix_fmt, context.gop_size, context.thread_count = _FORMAT, 1, _THREADS
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
        head = _HEADER.pack(0, width, height, beside, first, len(configuration))
        data = head[_CHECKED_FROM:] + configuration + coded
        return zlib.crc32(data).to_bytes(_CHECKED_FROM, "little") + data

    def _coded(self, codes: NDArray[np.uint16]) -> bytes:
        import av

        height, width = codes.shape
        padded = np.pad(codes, ((0, self._context.height - height), (0, self._context.width - width)), mode="edge")
        packets = self._context.encode(av.VideoFrame.from_ndarray(padded, format=_FORMAT))
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
            checksum, *size, beside, first, length = _HEADER.unpack_from(data)
            if tuple(size) != tuple(self.size):
                raise ValueError(f"of {size[0]}x{size[1]} pixels")
            if zlib.crc32(data[_CHECKED_FROM:]) != checksum:
                raise ValueError("its checksum is wrong")
            if not length:
                return np.full(self.size[::-1], first, np.uint16), beside
            start = _HEADER.size + length
            frames = self._context_for(data[_HEADER.size : start]).decode(av.Packet(data[start:]))
        except (struct.error, OSError, ValueError, av.FFmpegError) as error:
            raise Undecodable(f"damaged {self._what} ({error})") from error
        width, height = (max(side, _SMALLEST) for side in self.size)
        if len(frames) != 1 or (frames[0].width, frames[0].height, frames[0].format.name) != (width, height, _FORMAT):
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
_MOST = _ZERO - 1


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
        while largest > _MOST * 2.0**exponent:
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
