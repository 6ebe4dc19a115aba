"""What a user may state about a trace file in place of what its reader finds."""

from __future__ import annotations

import math

import attrs

from ..errors import InputError
from ..options import Declared, names_in, option

# Kinds of `poses.synth`, in words.
MOTIONS = "still, look-around, reversals, walk or fast-turns"
QUAT_ORDERS = ("xyzw", "wxyz")


@attrs.frozen
class TraceOptions(Declared):
    """Overrides for reading a trace; None leaves the matter to the file.

    Errors: InputError for values that are wrong whatever the file holds.
    """

    # Name of a trace format.
    format: str | None = option(
        None, f"Read the trace as this format: {names_in('poses/formats')}; by default it is detected."
    )
    quat_order: str | None = option(None, "Order of quaternions, xyzw or wxyz, where the file does not say.")
    # See `reading.axes.parse_axes`.
    up: str | None = option(
        None,
        "What is up in the file: an axis (y, z, -z); right,up,forward (x,z,y); or a direction (0.04,0.95,0.3).",
    )
    # Metres per unit.
    scale: float | None = option(
        None, "Metres per unit of the file's positions; by default as its format has it.", kind=float
    )
    # Samples per second.
    rate: float | None = option(
        None, "Samples per second, in place of the file's clock.", kind=float, name="trace_rate", unit="Hz"
    )
    # Which recording, counted from 1.
    segment: int | None = option(None, "Which recording of a file that holds several, from 1.", kind=int)

    def __attrs_post_init__(self) -> None:
        if self.quat_order is not None and self.quat_order not in QUAT_ORDERS:
            raise InputError(f"quaternion order '{self.quat_order}': expected {' or '.join(QUAT_ORDERS)}")
        if self.scale is not None and not (math.isfinite(self.scale) and 1e-6 <= self.scale <= 1e6):
            raise InputError(f"scale {self.scale}: expected metres per unit, from 1e-6 to 1e6")
        if self.rate is not None and not (math.isfinite(self.rate) and 1e-3 <= self.rate <= 1e6):
            raise InputError(f"rate {self.rate}: expected samples per second, from 0.001 to 1e6")
        if self.segment is not None and self.segment < 1:
            raise InputError(f"segment {self.segment}: recordings in a file are counted from 1")
