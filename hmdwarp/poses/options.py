"""Options of a trace file: facts that the user states in place of what its reader detects."""

from __future__ import annotations

import re

import attrs

from ..base import Declared, InputError, Number, names_in, one_of, option

# Kinds of `poses.synth`, in words.
MOTIONS = "still, look-around, reversals, walk, fast-turns, forward, backward, sideways or rotate"
# Predictors of the head, each with the file of poses/predictors that has it.
PREDICTORS = dict.fromkeys(("cautious", "constant_velocity", "none"), "cautious")
DEFAULT_PREDICTOR = "cautious"  # errs short, see docs/results-link.md
FRAMES = "frames"
TIME_UNITS = ("s", "ms", "us", "ns", "100ns", FRAMES)
DIRECT, INVERSE = "direct", "inverse"
ROWS, COLUMNS = "rows", "columns"
VECTOR = "vector"


@attrs.frozen
class Euler:
    """How angles make an orientation."""

    order: str  # turns about the fixed axes in the order of their use, such as "zxy"; or VECTOR
    degrees: bool
    signs: tuple[int, ...] = (1, 1, 1)  # of the turns

    def words(self) -> str:
        turns = self.order
        if turns != VECTOR:
            turns = "".join("-" * (sign < 0) + axis for axis, sign in zip(turns.upper(), self.signs, strict=True))
        return f"{turns},{'deg' if self.degrees else 'rad'}"


def parse_euler(text: str) -> Euler:
    """Parse `--euler`: turns about the fixed axes in order, and unit, as ZXY,deg of Unity.

    A minus turns about an axis the other way (-X-YZ,deg: roll, pitch, yaw of Unreal); "vector,rad"
    is a rotation vector.
    """
    order, _, unit = (part.strip() for part in text.strip().lower().partition(","))
    axes = order.replace("-", "")
    signed = order == VECTOR or (sorted(axes) == ["x", "y", "z"] and re.fullmatch("(-?[xyz]){3}", order))
    if not signed or unit not in ("deg", "rad"):
        raise InputError(f"--euler '{text}': expected the order in which turns are applied and a unit, such as ZXY,deg")
    signs = tuple(-1 if sign else 1 for sign in re.findall("(-?)[xyz]", order))
    return Euler(axes, unit == "deg", signs or (1, 1, 1))


@attrs.frozen
class TraceOptions(Declared):
    """Overrides for reading a trace; None leaves the fact to the file. Errors: InputError."""

    heading = "Reading the head trace"
    format: str | None = option(
        None, f"Read the trace as this format: {names_in('poses/formats')}; by default it is detected."
    )
    quat_order: str | None = option(
        None, "Order of quaternions, xyzw or wxyz, where the file does not say.", valid=one_of("xyzw", "wxyz")
    )
    up: str | None = option(None, "What is up in a file whose world is tilted: a direction (0.04,0.95,0.3).")
    axes: str | None = option(
        None, "Axes of the file: a preset (hmdwarp list axes), or world=right,up,forward head=right,up,forward."
    )
    scale: float | None = option(
        None, "Metres per unit of the file's positions; by default as its format has it.",
        valid=Number(least=1e-6, most=1e6),
    )  # fmt: skip
    rate: float | None = option(
        None, "Samples per second, in place of the file's clock.", name="trace_rate", unit="Hz",
        valid=Number(least=1e-3, most=1e6),
    )  # fmt: skip
    time_unit: str | None = option(  # A key of `reading.columns.UNITS_NS`, or FRAMES
        None, "Unit of the file's clock: s, ms, us, ns, 100ns, or frames of --trace-rate; else as it says, or guessed.",
        valid=one_of(*TIME_UNITS),
    )  # fmt: skip
    columns: str | None = option(  # See `reading.layouts.stated_layout`
        None,
        "Which columns to read, by name or number from 1: t=1,p=2+3+4,q=5+6+7+8 (x y z w); in place of q, m=2-17 (a "
        "matrix) or e=5+6+7 (with --euler).",
    )
    time_column: str | None = option(
        None, "The column of the clock, by name or number from 1; of frames with --trace-rate."
    )
    device: str | None = option(None, "Whose rows to read where a file holds those of several devices.")
    euler: str | None = option(  # See `parse_euler`
        None,
        "Read angles: the order of turns about the fixed axes, and deg or rad (Unity: ZXY,deg); vector,rad for a "
        "rotation vector.",
        valid=lambda _, __, value: value is None or parse_euler(value),
    )
    pose: str | None = option(
        None,
        "Direction of the file's poses: direct (world from head, the default) or inverse (head from world, as "
        "COLMAP and OpenCV write cameras).",
        valid=one_of(DIRECT, INVERSE),
    )
    matrix: str | None = option(
        None, "Order of a matrix's numbers, rows or columns; by default where 0,0,0,1 or the rotation lies says it.",
        valid=one_of(ROWS, COLUMNS),
    )  # fmt: skip
    lost_rows: float = option(  # share of all rows
        0.2, "Largest share of rows without a pose (lost tracking, a line of text) that is dropped.", kind=float,
        valid=Number(most=0.999),
    )  # fmt: skip
    segment: int | None = option(None, "Which recording of a file that holds several, from 1.", valid=Number(least=1))
