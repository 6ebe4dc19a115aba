"""A 16-bit code of inverse depth, packed without further loss; pixels do not affect each other.

The code of a pixel: 0 is infinitely far, 65535 no depth, and k between them the inverse depths in
((k - 1) step, k step], decoded as (k - 1/2) step. So infinite and missing depths are exact, and
every other value is within step / 2. step is a power of 2, and reaches up to 65534 steps; for a
picture with nearer things it is doubled until they fit.

Equal steps of inverse depth, not of depth: see depth_step.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .grey_codec import GreyDecoder, GreyEncoder

# 1/m: up to 64 per metre, which is 16 mm from the eye.
STEP = 2.0**-10
NO_DEPTH = 65535
_MOST = NO_DEPTH - 1


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
    while largest > _MOST * 2.0**exponent:
        exponent += 1
    # A power of 2: nothing is rounded.
    codes = np.ceil(np.maximum(values, 0) * np.float32(2.0**-exponent)).astype(np.uint16)
    if exponent > least:
        # A value too small for float32 beside an extremely near one.
        codes[(values > 0) & (codes == 0)] = 1
    codes[values < 0] = NO_DEPTH
    return codes, exponent


def inverse_depth_of(codes: NDArray[np.uint16], exponent: int) -> NDArray[np.float32]:
    """Return 1/m of each code, -1 for no depth."""
    values = (codes.astype(np.float32) - np.float32(0.5)) * np.float32(2.0**exponent)
    values[codes == 0] = 0
    values[codes == NO_DEPTH] = -1
    return values
