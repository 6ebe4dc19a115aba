"""What a user may state about a trace file instead of leaving it to detection."""

from __future__ import annotations

import math

import attrs

from ..errors import InputError

QUAT_ORDERS = ("xyzw", "wxyz")


@attrs.frozen
class TraceOptions:
    """Overrides for reading a trace; None leaves the matter to the file.

    Errors: InputError for an order, axes or numbers out of range.
    """

    format: str | None = None  # name of a trace format
    quat_order: str | None = None  # xyzw or wxyz
    up: str | None = None  # see `reading.axes.parse_axes`
    scale: float | None = None  # metres per unit of the file's positions
    rate: float | None = None  # samples per second, in place of the file's clock
    segment: int | None = None  # which recording of the file, from 1

    def __attrs_post_init__(self) -> None:
        if self.quat_order is not None and self.quat_order not in QUAT_ORDERS:
            raise InputError(f"quaternion order '{self.quat_order}': wanted {' or '.join(QUAT_ORDERS)}")
        if self.scale is not None and not (math.isfinite(self.scale) and 1e-6 <= self.scale <= 1e6):
            raise InputError(f"scale {self.scale}: wanted metres per unit, from 1e-6 to 1e6")
        if self.rate is not None and not (math.isfinite(self.rate) and 1e-3 <= self.rate <= 1e6):
            raise InputError(f"rate {self.rate}: wanted samples per second, from 0.001 to 1e6")
        if self.segment is not None and self.segment < 1:
            raise InputError(f"segment {self.segment}: recordings in a file are counted from 1")
