"""The list of what was assumed of a trace file, with who says it."""

from __future__ import annotations

from ..assumptions import Assumption, By
from ..options import INVERSE, TraceOptions
from ..stated import Layout
from .axes import Axes

COLUMNS, ORIENTATION, POSE, LENGTH, AXES, UP, CLOCK, WRAP = (
    *("columns", "orientation", "pose", "length", "axes", "up", "clock", "clock wrap"),
)
DIRECTION = ("world from head", "head from world")  # of poses as they are, and of inverse ones


def assumptions_of(
    layout: Layout, options: TraceOptions, axes: Axes, axes_by: By, clock: str, has_position: bool
) -> tuple[Assumption, ...]:
    """Return every fact by which rows became poses; clock: its unit, in words."""
    facts = [_orientation(layout), _direction(layout, options)]
    if has_position:
        facts.append(_length(layout, options, axes, axes_by))
    facts.append(Assumption(AXES, axes.label(), axes_by, "--axes"))
    tilt = "" if axes.tilt is None else f", tilted to {options.up}"
    facts.append(Assumption(UP, f"{axes.up()}{tilt}", By.USER if tilt else axes_by, "--up"))
    by = By.USER if options.rate or options.time_unit else layout.unit_by
    facts.append(Assumption(CLOCK, clock, by, "--time-unit"))
    return tuple(facts)


def _orientation(layout: Layout) -> Assumption:
    if layout.euler is not None:
        return Assumption(ORIENTATION, f"angles {layout.euler.words()}", layout.order_by, "--euler")
    if layout.matrix:
        return Assumption(ORIENTATION, f"matrix {layout.matrix}", layout.order_by, "--matrix")
    return Assumption(ORIENTATION, f"quaternion {layout.order}", layout.order_by, "--quat-order")


def _direction(layout: Layout, options: TraceOptions) -> Assumption:
    by = By.USER if options.pose else layout.direction_by
    return Assumption(POSE, DIRECTION[is_inverse(layout, options)], by, "--pose")


def is_inverse(layout: Layout, options: TraceOptions) -> bool:
    """Return whether a file's poses are head from world."""
    return layout.inverse if options.pose is None else options.pose == INVERSE


def _length(layout: Layout, options: TraceOptions, axes: Axes, axes_by: By) -> Assumption:
    if options.scale is not None:
        scale, by = options.scale, By.USER
    elif axes.metres_per_unit is not None:
        scale, by = axes.metres_per_unit, axes_by
    else:
        scale, by = layout.scale, layout.scale_by
    return Assumption(LENGTH, f"{scale:g} m per unit", by, "--scale")
