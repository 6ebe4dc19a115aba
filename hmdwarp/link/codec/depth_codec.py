"""A 16-bit code of inverse depth, packed without further loss; pixels do not affect each other.

The code of a pixel: 0 is infinitely far, 65535 no depth, and k between them the inverse depths in
((k - 1) step, k step], decoded as (k - 1/2) step. So infinite and missing depths are exact, and
every other value is within step / 2. step is 2^-10 per metre, up to 64 per metre (16 mm from the
eye); for a picture with nearer things it is doubled until they fit.

Equal steps of inverse depth, not of depth: an error of step / 2 moves a warped pixel by focal
length * step / 2 * the eye's translation, the same for every pixel. At 700 pixels per unit of
tangent and 0.2 m that is 0.07 pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .grey_codec import GreyDecoder, GreyEncoder

STEP = 2.0**-10
_EXPONENT = -10
NO_DEPTH = 65535
_MOST = NO_DEPTH - 1


class DepthEncoder:
    """Packs the inverse depth of one eye's frames, of `size` (w, h).

    Errors: MachineError if this PyAV lacks FFV1.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self._grey = GreyEncoder(size, "depth")

    def encode(self, inverse_depth: NDArray[np.float32]) -> bytes:
        """Pack (h, w) float32 in 1/m; below 0 is no depth.

        The rows may run either way. Errors: ValueError for NaN or infinity.
        """
        return self._grey.encode(*codes_of(inverse_depth))


class DepthDecoder:
    """Unpacks the bytes of a DepthEncoder of the same size."""

    def __init__(self, size: tuple[int, int]) -> None:
        self._grey = GreyDecoder(size, "depth")

    def decode(self, data: bytes) -> NDArray[np.float32]:
        """Return (h, w) float32 within half a step; no depth is -1.

        Errors: Undecodable for bytes that are damaged or of another size.
        """
        return inverse_depth_of(*self._grey.decode(data))


def codes_of(inverse_depth: NDArray[np.float32]) -> tuple[NDArray[np.uint16], int]:
    """Return the code of each pixel and the exponent of the step.

    Errors: as DepthEncoder.encode.
    """
    values = np.asarray(inverse_depth, np.float32)
    largest = float(values.max(initial=0))
    if not np.isfinite(largest):
        raise ValueError(f"inverse depth {largest}: expected finite numbers, below 0 for no depth")
    exponent = _EXPONENT
    while largest > _MOST * 2.0**exponent:
        exponent += 1
    # A power of 2: nothing is rounded.
    codes = np.ceil(np.maximum(values, 0) * np.float32(2.0**-exponent)).astype(np.uint16)
    if exponent > _EXPONENT:
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
