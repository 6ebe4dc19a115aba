"""Options of a trace file: facts that the user states in place of what its reader detects."""

from __future__ import annotations

import math

import attrs

from ..errors import InputError
from ..options import Declared, names_in, option

# Kinds of `poses.synth`, in words.
MOTIONS = "still, look-around, reversals, walk, fast-turns, forward, backward, sideways or rotate"
TIME_UNITS = ("s", "ms", "us", "ns", "100ns")
QUAT_ORDERS = ("xyzw", "wxyz")


@attrs.frozen
class TraceOptions(Declared):
    """Overrides for reading a trace; None leaves the fact to the file.

    Errors: InputError for values that no file can have.
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
    # See `reading.axes.parse_axes`.
    axes: str | None = option(
        None,
        "Axes of the file: a preset (hmdwarp list axes), world=right,up,forward head=right,up,forward, or auto.",
    )
    # Metres per unit.
    scale: float | None = option(
        None, "Metres per unit of the file's positions; by default as its format has it.", kind=float
    )
    # Samples per second.
    rate: float | None = option(
        None, "Samples per second, in place of the file's clock.", kind=float, name="trace_rate", unit="Hz"
    )
    # A key of `reading.times.UNITS_NS`.
    time_unit: str | None = option(
        None, "Unit of the file's clock: s, ms, us, ns or 100ns; by default as the file says, or guessed."
    )
    # See `stated.StatedColumns`.
    columns: str | None = option(
        None, "Which columns to read, by name or number from 1: t=1,p=2+3+4,q=5+6+7+8 (x y z w)."
    )
    # A name, or a number from 1.
    time_column: str | None = option(None, "The column of the clock, by name or number from 1.")
    # Of the rows of several devices.
    device: str | None = option(None, "Whose rows to read where a file holds those of several devices.")
    # See `formats._base.parse_euler`.
    euler: str | None = option(
        None, "Read Euler angles: the order of turns about the fixed axes, and deg or rad (Unity: ZXY,deg)."
    )
    # Number of the recording, from 1.
    segment: int | None = option(None, "Which recording of a file that holds several, from 1.", kind=int)

    def __attrs_post_init__(self) -> None:
        if self.quat_order is not None and self.quat_order not in QUAT_ORDERS:
            raise InputError(f"quaternion order '{self.quat_order}': expected {' or '.join(QUAT_ORDERS)}")
        if self.scale is not None and not (math.isfinite(self.scale) and 1e-6 <= self.scale <= 1e6):
            raise InputError(f"scale {self.scale}: expected metres per unit, from 1e-6 to 1e6")
        if self.rate is not None and not (math.isfinite(self.rate) and 1e-3 <= self.rate <= 1e6):
            raise InputError(f"rate {self.rate}: expected samples per second, from 0.001 to 1e6")
        if self.time_unit is not None and self.time_unit not in TIME_UNITS:
            raise InputError(f"time unit '{self.time_unit}': expected {', '.join(TIME_UNITS)}")
        if self.segment is not None and self.segment < 1:
            raise InputError(f"segment {self.segment}: recordings in a file are counted from 1")
