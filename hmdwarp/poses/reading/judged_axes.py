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
from .axes import AUTO, DIRECTION, Axes, assumptions_of, is_inverse, is_tilt, parse_axes, parse_up, tilted, upright
from .plausibility import (
    CLEAR,
    SURE,
    Evidence,
    Verdict,
    best_points,
    every,
    evidence_of,
    gravity_axis,
    height_fault,
    inverse_gain,
    inverted,
    judge,
    place_fault,
)
from .rows import Rows

_GAZE = "which way it looks is not clear"
_TILT_SHOWN_DEG = 10.0
_TILT_STATED_DEG = 0.5  # by gravity columns
# How an unstated order was read, the other one, and the options that state them.
_ORDERS = {
    "matrix": ("by rows, its matrices", "by columns", "--matrix columns, or rows"),
    "quaternion": (
        *("with w last, as in TUM files, its quaternions", "with w first"),
        "--quat-order wxyz, or xyzw",
    ),
}
Note = Callable[[str, str, str], None]  # records a defect: its kind, what it is, what was done


class JudgedAxes:
    """What turns a file's poses into OpenXR's axes, and who says so."""

    def __init__(self, layout: Layout, options: TraceOptions, where: str, note: Note) -> None:
        self.layout, self.options, self.where, self._note = layout, options, where, note
        self.axes, self.axes_by = self._stated_axes()
        self._wrong = False
        self._tilt_deg = 0.0
        self._leaves_open = ""
        self._gaze_unclear = False
        self._upright, self._upright_by = "", By.MOTION  # the direction that --axes auto sets upright

    def assumptions(self, layout: Layout, clock: str, has_position: bool) -> tuple[Assumption, ...]:
        """Return the facts of the file. clock: its unit, in words."""
        facts = assumptions_of(layout, self.options, self.axes, self.axes_by, clock, has_position)
        if not self._upright:
            return facts
        up = attrs.evolve(facts[-2], value=self._upright, by=self._upright_by)
        return (*facts[:-2], up, facts[-1])

    def scale(self) -> float:
        """Return the metres of a unit of the file."""
        if self.options.scale is not None:
            return self.options.scale
        return self.layout.scale if self.axes.metres_per_unit is None else self.axes.metres_per_unit

    def _stated_axes(self) -> tuple[Axes, By]:
        """Return the axes and who says so: --axes and --up before the file and its format.

        `--up z` for a format whose z is up changes nothing.
        """
        own = parse_axes(self.layout.axes)
        stated, up = self.options.axes, self.options.up
        if up is not None and is_tilt(up):
            axes, by = (parse_axes(stated), By.USER) if stated not in (None, AUTO) else (own, self.layout.axes_by)
            return tilted(axes, up), by
        if up is not None and stated is not None:
            raise InputError(
                "--axes and --up both name axes: say one; with --axes, --up may hold three numbers, a tilt"
            )
        if stated is not None and stated != AUTO:
            return parse_axes(stated), By.USER
        if up is None or own.up() == up.strip().lower().removeprefix("+"):
            return own, self.layout.axes_by
        return parse_up(up), By.USER

    def weigh(self, time_ns: NDArray[np.int64], rows: Rows) -> None:
        """Warn where the motion contradicts the axes; --axes auto takes better ones if clear."""
        p, gravity = rows.position, np.array(self.layout.gravity_down)
        metres = None if p is None else p * self.scale()
        evidence = evidence_of(time_ns, rows.orientation, metres, gravity)
        what, remedy = place_fault(time_ns, metres) if metres is not None else ("", "")
        if self.layout.order_by is By.NOBODY:
            self._check_order(evidence, time_ns, rows)
        verdict = judge(evidence, self.axes)
        if not what and not verdict.faults:
            what, remedy = height_fault(float(self.axes.world[1] @ evidence.height_m))
        if what:
            self._note("place-implausible", what, f"kept; {remedy}")
        self._leaves_open = verdict.leaves_open
        auto = self.options.axes == AUTO
        if self._is_inverse(evidence, time_ns, rows.orientation, metres, bool(verdict.faults)):
            return
        if verdict.world_alone and self._is_tilted(rows.orientation):
            self._set_upright(gravity, rows.orientation)
            return
        if auto and verdict.better is not None and verdict.clear:
            self._note("axes-chosen", f"as {self.axes.label()}: {', '.join(verdict.faults)}", _chosen(verdict))
            self.axes, self.axes_by = attrs.evolve(verdict.better, tilt=self.axes.tilt), By.MOTION
        elif auto and verdict.upright is not None:
            done = (
                f"--axes auto takes {verdict.upright.label()}, which sets the head upright; {_GAZE}: --axes states it"
            )
            self._note("axes-chosen", f"as {self.axes.label()}: {', '.join(verdict.faults)}", done)
            self.axes, self.axes_by = attrs.evolve(verdict.upright, tilt=self.axes.tilt), By.MOTION
            self._gaze_unclear = True
        elif verdict.faults:
            what = f"read as {self.axes.label()}, {AXES_BY[self.axes_by]}: {', '.join(verdict.faults)}"
            self._note("axes-contradicted", what, _advice(verdict, auto))
            self._wrong = True
        if not self._wrong:
            self._set_upright(gravity, rows.orientation)

    def _is_inverse(
        self,
        evidence: Evidence,
        time_ns: NDArray[np.int64],
        orientation: NDArray[np.float64],
        metres: NDArray[np.float64] | None,
        contradicted: bool,
    ) -> bool:
        """Suggest the other direction of the poses where only that one makes a person's motion."""
        if self.options.pose is not None:
            return False
        at = every(time_ns)  # first, as an inverse copies all poses
        poses = inverted(orientation[at], None if metres is None else metres[at])
        other = evidence_of(time_ns[at], *poses, evidence.gravity)
        gain = inverse_gain(evidence, other)
        if gain <= (CLEAR if contradicted else SURE):
            return False
        here, there = DIRECTION[::-1] if is_inverse(self.layout, self.options) else DIRECTION
        verdict = judge(other, self.axes)
        axes = f" --axes '{verdict.better.name or verdict.better.words()}'" if verdict.better is not None else ""
        word = INVERSE if here == DIRECTION[0] else DIRECT
        what = f"its poses, read as {here}, make a person's motion if they are {there}: {gain:.1f} points more"
        self._note("pose-contradicted", what, f"kept; --pose {word}{axes} takes them so")
        self._wrong = True
        return True

    def _set_upright(self, gravity_down: NDArray[np.float64], orientation: NDArray[np.float64]) -> None:
        """Turn the world as the file's gravity or the head says, where --axes auto asks for it."""
        if self.options.axes != AUTO or self.axes.tilt is not None:
            return
        stated = bool(gravity_down.any())
        axis = -self.axes.world @ gravity_down if stated else gravity_axis(self.axes.in_openxr(orientation))
        if axis is None:
            return
        axis = axis / np.linalg.norm(axis)
        tilt = _tilt_of(axis)
        if tilt <= (_TILT_STATED_DEG if stated else _TILT_SHOWN_DEG):
            return
        shown = ",".join(f"{a:.2f}" for a in axis)
        what = f"by the {'gravity columns' if stated else 'head'}, up is ({shown}), {tilt:.0f} degrees from +y"
        self._note("tilt-set", what, f"--axes auto sets the world upright, as --up={shown} does")
        self.axes = attrs.evolve(self.axes, tilt=upright(axis))
        self._upright, self._upright_by = f"({shown})", By.FILE if stated else By.MOTION

    def _check_order(self, evidence: Evidence, time_ns: NDArray[np.int64], rows: Rows) -> None:
        """Refuse an assumed order of quaternions or matrices if only the other shows a person."""
        if self.layout.euler is not None:
            return
        at = every(time_ns)
        q, p = rows.orientation[at], None if rows.position is None else rows.position[at]
        turned = quaternions.conjugate(q) if self.layout.matrix else np.roll(q, -1, axis=1)
        other = evidence_of(time_ns[at], turned, p, evidence.gravity)
        if best_points(other) <= best_points(evidence) + CLEAR:
            return
        what, right, wrong = _ORDERS["matrix" if self.layout.matrix else "quaternion"]
        raise TraceError(
            f"{self.where}: read {what} make no person's motion; {right} they do: say {wrong} if it is right as it is"
        )

    def _is_tilted(self, orientation: NDArray[np.float64]) -> bool:
        """Return whether up lies between the file's axes: `report_tilt` then says by how much."""
        axis = gravity_axis(self.axes.in_openxr(orientation))
        return axis is not None and float(np.abs(axis).max()) < math.cos(math.radians(_TILT_SHOWN_DEG))

    def words(self) -> str:
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
        axis = None if self._wrong else gravity_axis(orientation)
        if axis is None:
            return
        tilt = _tilt_of(axis)
        if tilt > _TILT_SHOWN_DEG:
            shown = ",".join(f"{a:.2f}" for a in axis)
            what = f"judging by the head, up is ({shown}), {tilt:.0f} degrees from +y"
            self._tilt_deg = tilt
            self._note("tilt", what, f"kept as it is; --up={shown} sets the world upright")


def _tilt_of(up: NDArray[np.float64]) -> float:
    """Return the angle of a direction (3,) from +y, in degrees."""
    return float(np.degrees(np.arccos(np.clip(up[1], -1, 1))))


def _advice(verdict: Verdict, auto: bool) -> str:
    if verdict.better is None:
        return "kept; nothing else fits better: --axes or --up states them; 'trace info --plot' shows the head"
    sure = "clearly fits" if verdict.clear else "fits better, though not clearly"
    also = f" (so do {', '.join(verdict.also)}; motion cannot tell them apart)" if verdict.also else ""
    kept = "kept, as --axes auto takes only what is clear" if auto else "kept"
    own, better = verdict.points
    named = verdict.better.name or verdict.better.words()
    return f"{kept}; --axes '{named}' {sure}{also}: {better:.1f} points against {own:.1f}"


def _chosen(verdict: Verdict) -> str:
    assert verdict.better is not None
    also = f"; {', '.join(verdict.also)} would fit as well" if verdict.also else ""
    own, better = verdict.points
    return f"--axes auto takes {verdict.better.label()}: {better:.1f} points against {own:.1f}{also}"
