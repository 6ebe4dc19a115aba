"""A 16-bit code of vectors, packed without further loss; pixels do not affect each other.

Each channel is rounded to a multiple of the step: of velocities, normals, shares, coverage. 0 and
1 are exact, every other value is within step / 2. step is 2^-10, up to 32 either way; for a picture
with larger numbers it is doubled until they fit. Of a velocity that is 1 mm/s, of a normal a tilt
of 0.03 degrees at most.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from .grey_codec import GreyDecoder, GreyEncoder
from .undecodable import Undecodable

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
