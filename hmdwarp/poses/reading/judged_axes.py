"""The axes of a file: as they are stated, weighed against the motion, and set upright."""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, TraceError
from .. import quaternions
from ..assumptions import AXES_BY, Assumption, By, Layout
from ..options import DIRECT, INVERSE, TraceOptions
from . import plausibility
from .axes import AUTO, AXES, CLOCK, DIRECTION, LENGTH, ORIENTATION, POSE, UP, Axes, parse_axes, parse_up, upright
from .plausibility import CLEAR, SURE, Evidence, Verdict
from .rows import Rows

_GAZE = "which way it looks is not clear"
_TILT_SHOWN_DEG = 10.0
_TILT_STATED_DEG = 0.5  # by gravity columns
# How an unstated order was read, the other one, and the options that state them.
_BY_ROWS = "by rows, its matrices", "by columns", "--matrix columns, or rows"
_W_LAST = "with w last, as in TUM files, its quaternions", "with w first", "--quat-order wxyz, or xyzw"
Note = Callable[[str, str, str], None]  # records a defect: its kind, what it is, what was done


def is_inverse(layout: Layout, options: TraceOptions) -> bool:
    """Return whether a file's poses are head from world."""
    return layout.inverse if options.pose is None else options.pose == INVERSE


class JudgedAxes:
    """What turns a file's poses into OpenXR's axes, and who says so."""

    def __init__(self, layout: Layout, options: TraceOptions, where: str, note: Note) -> None:
        self.layout, self.options, self.where, self._note = layout, options, where, note
        self.axes, self.axes_by = self._stated_axes()
        self._wrong = self._gaze_unclear = False
        self._tilt_deg = 0.0
        self._leaves_open = ""
        self._upright, self._upright_by = "", By.MOTION  # the direction that --axes auto sets upright

    def assumptions(self, layout: Layout, clock: str, has_position: bool) -> tuple[Assumption, ...]:
        """Return every fact by which rows became poses. clock: its unit, in words."""
        options, (scale, scale_by) = self.options, self._scale()
        if layout.euler is not None:
            turn, option = f"angles {layout.euler.words()}", "--euler"
        elif layout.matrix:
            turn, option = f"matrix {layout.matrix}", "--matrix"
        else:
            turn, option = f"quaternion {layout.order}", "--quat-order"
        way, tilt = DIRECTION[is_inverse(layout, options)], self.axes.tilt is not None and not self._upright
        up = self._upright or f"{self.axes.up()}{f', tilted to {options.up}' if tilt else ''}"
        up_by = self._upright_by if self._upright else By.USER if tilt else self.axes_by
        length = Assumption(LENGTH, f"{scale:g} m per unit", scale_by, "--scale")
        return (
            Assumption(ORIENTATION, turn, layout.order_by, option),
            Assumption(POSE, way, By.USER if options.pose else layout.direction_by, "--pose"),
            *([length] if has_position else []), Assumption(AXES, self.axes.label(), self.axes_by, "--axes"),
            Assumption(UP, up, up_by, "--up"),
            Assumption(CLOCK, clock, By.USER if options.rate or options.time_unit else layout.unit_by, "--time-unit"),
        )  # fmt: skip

    def scale(self) -> float:
        """Return the metres of a unit of the file."""
        return self._scale()[0]

    def _scale(self) -> tuple[float, By]:
        if self.options.scale is not None:
            return self.options.scale, By.USER
        own = self.axes.metres_per_unit
        return (self.layout.scale, self.layout.scale_by) if own is None else (own, self.axes_by)

    def _stated_axes(self) -> tuple[Axes, By]:
        """Return the axes and who says so: --axes and --up before the file and its format.

        `--up z` for a format whose z is up changes nothing.
        """
        own, by = parse_axes(self.layout.axes), self.layout.axes_by
        up, stated = self.options.up, self.options.axes if self.options.axes != AUTO else None
        if up is not None and not any(axis in up.lower() for axis in "xyz"):  # a direction in numbers
            axes, by = (own, by) if stated is None else (parse_axes(stated), By.USER)
            return attrs.evolve(axes, tilt=parse_up(up).tilt), by
        if up is not None and self.options.axes is not None:
            raise InputError(
                "--axes and --up both name axes: say one; beside --axes, --up may be three numbers, a tilt"
            )
        if stated is not None:
            return parse_axes(stated), By.USER
        if up is None or own.up() == up.strip().lower().removeprefix("+"):
            return own, by
        return parse_up(up), By.USER

    def weigh(self, time_ns: NDArray[np.int64], rows: Rows) -> None:
        """Warn where the motion contradicts the axes; --axes auto takes better ones if clear."""
        p, gravity = rows.position, np.array(self.layout.gravity_down)
        metres = None if p is None else p * self.scale()
        evidence = plausibility.evidence_of(time_ns, rows.orientation, metres, gravity)
        what, remedy = plausibility.place_fault(time_ns, metres) if metres is not None else ("", "")
        if self.layout.order_by is By.NOBODY and self.layout.euler is None:
            at = plausibility.every(time_ns)  # an assumed order of numbers: does only the other one show a person?
            turned = rows.orientation[at]
            turned = quaternions.conjugate(turned) if self.layout.matrix else np.roll(turned, -1, axis=1)
            other = plausibility.evidence_of(time_ns[at], turned, None if p is None else p[at], evidence.gravity)
            if plausibility.best_points(other) > plausibility.best_points(evidence) + CLEAR:
                what, right, wrong = _BY_ROWS if self.layout.matrix else _W_LAST
                is_right = f"{right} they do: say {wrong} if it is right as it is"
                raise TraceError(f"{self.where}: read {what} make no person's motion; {is_right}")
        verdict = plausibility.judge(evidence, self.axes)
        if not what and not verdict.faults:
            what, remedy = plausibility.height_fault(float(self.axes.world[1] @ evidence.height_m))
        if what:
            self._note("place-implausible", what, f"kept; {remedy}")
        self._leaves_open = verdict.leaves_open
        if self._is_inverse(evidence, time_ns, rows.orientation, metres, bool(verdict.faults)):
            return
        if verdict.world_alone:
            # Where up lies between the file's axes, `report_tilt` says by how much.
            axis = plausibility.gravity_axis(self.axes.in_openxr(rows.orientation))
            if axis is not None and float(np.abs(axis).max()) < math.cos(math.radians(_TILT_SHOWN_DEG)):
                self._set_upright(gravity, rows.orientation)
                return
        self._take_or_contradict(verdict)
        if not self._wrong:
            self._set_upright(gravity, rows.orientation)

    def _take_or_contradict(self, verdict: Verdict) -> None:
        auto, faults, (own, best) = self.options.axes == AUTO, ", ".join(verdict.faults), verdict.points
        found, points = verdict.better, f"{best:.1f} points against {own:.1f}"
        if auto and found is not None and verdict.clear:
            also = f"; {', '.join(verdict.also)} would fit as well" if verdict.also else ""
            done = f"--axes auto takes {found.label()}: {points}{also}"
        elif auto and verdict.upright is not None:
            found, self._gaze_unclear = verdict.upright, True
            done = f"--axes auto takes {found.label()}, which sets the head upright; {_GAZE}: --axes states it"
        elif faults:
            done = "kept; nothing else fits better: --axes or --up states them; 'trace info --plot' shows the head"
            if found is not None:
                sure = "clearly fits" if verdict.clear else "fits better, though not clearly"
                also = f" (so do {', '.join(verdict.also)}; motion cannot tell them apart)" if verdict.also else ""
                kept = "kept, as --axes auto takes only what is clear" if auto else "kept"
                done = f"{kept}; --axes '{found.name or found.words()}' {sure}{also}: {points}"
            what = f"read as {self.axes.label()}, {AXES_BY[self.axes_by]}: {faults}"
            self._note("axes-contradicted", what, done)
            self._wrong = True
            return
        else:
            return
        self._note("axes-chosen", f"as {self.axes.label()}: {faults}", done)
        self.axes, self.axes_by = attrs.evolve(found, tilt=self.axes.tilt), By.MOTION

    def _is_inverse(
        self, evidence: Evidence, time_ns: NDArray[np.int64], orientation: NDArray[np.float64],
        metres: NDArray[np.float64] | None, contradicted: bool,
    ) -> bool:  # fmt: skip
        """Suggest the other direction of the poses where only that one makes a person's motion."""
        if self.options.pose is not None:
            return False
        at = plausibility.every(time_ns)  # first, as an inverse copies all poses
        poses = plausibility.inverted(orientation[at], None if metres is None else metres[at])
        other = plausibility.evidence_of(time_ns[at], *poses, evidence.gravity)
        gain = plausibility.inverse_gain(evidence, other)
        if gain <= (CLEAR if contradicted else SURE):
            return False
        here, there = DIRECTION[::-1] if self.layout.inverse else DIRECTION
        better, word = plausibility.judge(other, self.axes).better, DIRECT if self.layout.inverse else INVERSE
        axes = f" --axes '{better.name or better.words()}'" if better is not None else ""
        what = f"its poses, read as {here}, make a person's motion if they are {there}: {gain:.1f} points more"
        self._note("pose-contradicted", what, f"kept; --pose {word}{axes} takes them so")
        self._wrong = True
        return True

    def _set_upright(self, gravity_down: NDArray[np.float64], orientation: NDArray[np.float64]) -> None:
        """Turn the world as the file's gravity or the head says, where --axes auto asks for it."""
        if self.options.axes != AUTO or self.axes.tilt is not None:
            return
        stated = bool(gravity_down.any())
        axis = (
            -self.axes.world @ gravity_down if stated else plausibility.gravity_axis(self.axes.in_openxr(orientation))
        )
        if axis is None:
            return
        axis = axis / np.linalg.norm(axis)
        tilt, shown = _tilt_of(axis), ",".join(f"{a:.2f}" for a in axis)
        if tilt > (_TILT_STATED_DEG if stated else _TILT_SHOWN_DEG):
            what = f"by the {'gravity columns' if stated else 'head'}, up is ({shown}), {tilt:.0f} degrees from +y"
            self._note("tilt-set", what, f"--axes auto sets the world upright, as --up={shown} does")
            self.axes = attrs.evolve(self.axes, tilt=upright(axis))
            self._upright, self._upright_by = f"({shown})", By.FILE if stated else By.MOTION

    def words(self) -> str:
        """Return the axes, who says so, and what the motion shows."""
        words = f"{self.axes.label()}, {AXES_BY[self.axes_by]}"
        if self._wrong:
            return f"{words}; the motion contradicts them"
        if self._gaze_unclear:
            words += f"; {_GAZE}"
        if self._upright:
            return f"{words}; {self._upright} set upright by --axes auto"
        if self._tilt_deg:
            return f"{words}; up is tilted by {self._tilt_deg:.0f} degrees"
        if self.axes_by is not By.NOBODY:
            return words
        if self._leaves_open:
            return f"{words}; the motion does not show {self._leaves_open}; --axes or --up states it"
        return f"{words}; the motion agrees"

    def report_tilt(self, orientation: NDArray[np.float64]) -> None:
        """Report gravity that is not along +y, judged by how the head is held.

        Wrong axes are another matter: turning the world alone would leave the head on its side.
        """
        axis = None if self._wrong else plausibility.gravity_axis(orientation)
        if axis is not None and (tilt := _tilt_of(axis)) > _TILT_SHOWN_DEG:
            self._tilt_deg, shown = tilt, ",".join(f"{a:.2f}" for a in axis)
            what = f"judging by the head, up is ({shown}), {tilt:.0f} degrees from +y"
            self._note("tilt", what, f"kept as it is; --up={shown} sets the world upright")


def _tilt_of(up: NDArray[np.float64]) -> float:
    """Return the angle of a direction (3,) from +y, in degrees."""
    return float(np.degrees(np.arccos(np.clip(up[1], -1, 1))))
