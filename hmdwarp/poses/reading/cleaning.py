"""From rows to one clean track.

Each step looks for one kind of defect, repairs or refuses it, and records what it did.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, TraceError, counted
from .. import quaternions
from ..defects import Defect
from ..options import TraceOptions
from ..track import PoseTrack, gap_limit_ns
from .axes import AUTO, Axes, is_tilt, parse_axes, parse_up, tilted
from .columns import head_rank
from .motion_faults import find_jumps, gravity_axis
from .plausibility import (
    CLEAR,
    Evidence,
    Verdict,
    best_points,
    evidence_of,
    height_fault,
    judge,
    place_fault,
    rate_fault,
)
from .rows import ASSUMED, BY_MOTION, BY_USER, Layout, Rows
from .times import BILLION, UNIT_NAMES, UNITS_NS, Stamps, guess_unit, to_ns

COARSE_NORM = 1e-2
WORST_NORM = 0.5
# Glasses write each pose twice, 0.1 ms apart at 30 to 1000 Hz.
_NEARER = 8
_PAIRED = 0.3  # share of steps
_LEAST_PAIRS = 20
# Shares of steps back in time: a file with restarts has few, a shuffled one half.
_SHUFFLED, _REVERSED = 0.2, 0.9
_LEAST_STEPS = 10
_MEDIAN_NORM = 0.1
_ZERO_NORM = 1e-6
_LARGEST_NORM = 2.0
_DAY_S = 86400
_TILT_SHOWN_DEG = 10.0
_SEGMENTS_LISTED = 1000  # a jittering clock can run backwards a million times


@attrs.frozen
class Segment:
    """One recording within a file."""

    number: int  # from 1
    first_line: int
    last_line: int
    rows: int
    duration_s: float
    taken: bool  # whether it was used


@attrs.frozen(eq=False)
class Cleaned:
    """Result of cleaning a file."""

    track: PoseTrack
    defects: list[Defect]  # every defect, with its repair
    segments: list[Segment]  # recordings of the file
    time_unit: str  # of the file's clock, in words
    axes_assumed: bool  # nothing says which they are
    device: str = ""  # whose rows were taken, where a column names devices
    columns: str = ""  # which columns were read as what


class Cleaner:
    """Run the cleaning steps over the rows of one file; `where` names the file in messages."""

    def __init__(self, where: str, rows: Rows, layout: Layout, options: TraceOptions, ends_with_newline: bool) -> None:
        self.where, self.rows, self.layout, self.options = where, rows, layout, options
        self.cut_possible = not ends_with_newline
        self.defects: list[Defect] = list(layout.caveats)
        self.segments: list[Segment] = []
        self.time_unit = ""
        self.axes, self.axes_by = self._stated_axes()
        self._axes_wrong = False
        self._tilt_deg = 0.0
        self.leaves_open = ""
        self.epoch_ns = 0
        self.device = ""
        self.defects_of_devices: dict[str, Defect] = {}

    def clean(self, name: str, origin: str) -> Cleaned:
        """Run all steps, each after those that it relies on."""
        self.drop_cut_row()
        self.take_one_device()
        self.drop_zero_quaternions()
        self.need_two_rows()
        self.count_by_rate()
        self.take_one_segment()
        time_ns = self.times()
        time_ns = self.trim_default_start(time_ns)
        time_ns = self.drop_duplicate_stamps(time_ns)
        time_ns = self.join_pairs(time_ns)
        self.normalise()
        self.turn_and_scale(time_ns)
        self.join_hemispheres()
        self.report_repeats()
        self.report_gaps(time_ns)
        jumps = self.find_jumps(time_ns)
        self.report_tilt()
        self.need_two_rows()
        time_ns = time_ns - time_ns[0]
        position = self.rows.position if self.rows.position is not None else np.zeros((len(self.rows), 3))
        notes = tuple(str(d) for d in self.defects)
        track = PoseTrack(
            time_ns,
            position,
            self.rows.orientation,
            name=name,
            origin=origin,
            axes=self._axes_in_words(),
            notes=notes,
            epoch_ns=self.epoch_ns,
            jumps=tuple(jumps),
        )
        return Cleaned(
            track,
            self.defects,
            self.segments,
            self.time_unit,
            self.axes_by == ASSUMED,
            self.device,
        )

    def note(self, kind: str, what: str, done: str, count: int = 1, line: int | None = None) -> None:
        """Record a defect and its repair."""
        self.defects.append(Defect(kind, what, done, count, line))

    def _line(self, row: int) -> int:
        return int(self.rows.line[row])

    def _at(self, row: int) -> str:
        return f"{self.where}: line {self._line(row)}"

    def _so_far(self) -> str:
        said = "; ".join(str(d) for d in self.defects[:3])
        return f" ({said})" if said else ""

    def need_two_rows(self) -> None:
        """Refuse a single row: one pose is no motion."""
        if len(self.rows) < 2:
            raise TraceError(f"{self.where} holds {len(self.rows)} usable row: expected two or more{self._so_far()}")

    def drop_cut_row(self) -> None:
        """Drop a last line that ends in the middle of a number.

        It lacks its newline, and its norm is off or its time decreases.
        """
        rows = self.rows
        if not self.cut_possible or len(rows) < 2:
            return
        off = np.abs(np.linalg.norm(rows.orientation[-2:], axis=1) - 1)
        reason = ""
        if off[1] > COARSE_NORM >= off[0]:
            reason = f"quaternion of length {np.linalg.norm(rows.orientation[-1]):.2f}"
        elif rows.stamps is not None and rows.stamps[-2:].steps()[0] <= 0:
            reason = "its time is not after the one before"
        if reason:
            self.note(
                "last-row-cut",
                f"the last row is cut off ({reason}, no newline)",
                "dropped",
                1,
                self._line(len(rows) - 1),
            )
            rows.keep(slice(None, -1))

    def take_one_device(self) -> None:
        """Keep the head's rows, or the first eye's, where rows of several devices are mixed."""
        device = self.rows.device
        if device is None:
            if self.options.device is not None:
                raise TraceError(f"{self.where} has no column that names devices: leave --device out")
            return
        names, first, counts = np.unique(device, return_index=True, return_counts=True)
        texts = [n.decode("latin-1") for n in names]
        stated = self.options.device
        if stated is not None and stated not in texts:
            raise TraceError(f"{self.where}: no rows of device '{stated}': there are those of {', '.join(texts[:8])}")
        if stated is None:
            tracked = np.abs(self.rows.orientation).max(axis=1) > _ZERO_NORM
            lost = [not tracked[device == name].any() for name in names]
            order = [float(t) for t in texts] if all(_is_index(t) for t in texts) else first.tolist()
            taken = min(range(len(texts)), key=lambda i: (lost[i], head_rank(texts[i]), order[i]))
        else:
            taken = texts.index(stated)
        self.device = texts[taken]
        if self.device in self.defects_of_devices:
            self.defects.append(self.defects_of_devices[self.device])
        if len(names) < 2:
            return
        others = len(device) - int(counts[taken])
        self.note(
            "devices-interleaved",
            f"rows of {len(names)} devices or eyes are interleaved ({', '.join(texts[:6])})",
            f"the {counts[taken]} rows of {texts[taken]} taken, {others} others left out; --device takes another",
            others,
            self._line(int(first[first != first[taken]].min())),
        )
        self.rows.keep(device == names[taken])
        self.rows.device = None

    def drop_zero_quaternions(self) -> None:
        """Drop rows with a zero quaternion, or a matrix without a turn: a mark of lost tracking."""
        zero = np.abs(self.rows.orientation).max(axis=1) < _ZERO_NORM
        count = int(zero.sum())
        if not count:
            return
        if count == len(zero):
            raise TraceError(
                f"{self.where}: every quaternion is zero: the tracker had nothing, or the wrong columns were read"
            )
        found = "matrix that is no rotation" if self.layout.matrix else "zero quaternion"
        what = f"{counted(count, 'row')} with a {found}, a marker for no tracking"
        self.note("zero-quaternion", what, "dropped", count, self._line(int(zero.argmax())))
        self.rows.keep(~zero)

    @property
    def _stamps(self) -> Stamps:
        stamps = self.rows.stamps
        assert stamps is not None, "count_by_rate gives stamps to a file without time"
        return stamps

    def count_by_rate(self) -> None:
        """Replace the file's clock by --trace-rate."""
        if self.options.rate is None:
            return
        n = len(self.rows)
        step_ns = BILLION / self.options.rate
        if (n - 1) * step_ns > 2**62:
            raise TraceError(
                f"{self.where}: {n} rows at a rate of {self.options.rate:g} Hz last over 146 years; give a higher "
                "--trace-rate"
            )
        stamps_ns = np.rint(np.arange(n) * step_ns).astype(np.int64)
        what = "the file's own clock is put aside" if self.layout.clock_ignored else "the file has no time"
        self.note("clock-by-rate", what, f"row numbers at {self.options.rate:g} Hz, as --trace-rate says")
        self.rows.stamps = Stamps(stamps_ns, np.zeros(n, np.int64))
        self.layout = attrs.evolve(self.layout, unit="ns")

    def take_one_segment(self) -> None:
        """Split where time decreases; keep the longest recording, or the chosen one.

        Rows are never sorted across a split.
        """
        self.rows.stamps = self._midnights(self._stamps)
        self._judge_order()
        stamps = self._stamps
        falls = np.flatnonzero(stamps.steps() < 0) + 1
        starts, ends = np.concatenate([[0], falls]), np.concatenate([falls, [len(stamps)]])
        seconds = UNITS_NS[self._unit(stamps)] / BILLION
        first, last = stamps[starts], stamps[ends - 1]
        span = ((last.whole - first.whole) + (last.billionths - first.billionths) / BILLION) * seconds
        wanted = self.options.segment
        if wanted is not None and wanted > len(span):
            raise TraceError(f"{self.where} holds {counted(len(span), 'recording')}: there is no segment {wanted}")
        taken = int(np.argmax(span)) if wanted is None else wanted - 1
        listed = [*range(min(len(span), _SEGMENTS_LISTED)), *([taken] if taken >= _SEGMENTS_LISTED else [])]
        self.segments = [
            Segment(
                i + 1,
                self._line(starts[i]),
                self._line(ends[i] - 1),
                int(ends[i] - starts[i]),
                float(span[i]),
                i == taken,
            )
            for i in listed
        ]
        if len(span) > 1:
            why = "the longest" if wanted is None else "as asked"
            self.note(
                "clock-restart",
                f"time falls {counted(len(falls), 'time')}: the file holds {len(span)} recordings",
                f"segment {taken + 1} taken, {why} ({span[taken]:.3f} s of {span.sum():.3f} s); --segment takes "
                "another",
                len(falls),
                self._line(int(falls[0])),
            )
            self.rows.keep(slice(starts[taken], ends[taken]))

    def _judge_order(self) -> None:
        """Turn rows around that run backwards in time. Errors: TraceError for shuffled ones."""
        steps = self._stamps.steps()
        falls = float(np.mean(steps < 0)) if len(steps) > _LEAST_STEPS else 0.0
        if falls > _REVERSED and not (steps > 0).any():
            what = "time falls from row to row: the file is in reverse order"
            self.note("rows-reversed", what, "read from its end", len(steps), self._line(0))
            self.rows.keep(slice(None, None, -1))
        elif falls > _SHUFFLED:
            raise TraceError(
                f"{self.where}: time falls after {100 * falls:.0f} % of its rows: they are shuffled, or of several "
                "recordings; sort them by time, or name the clock with --time-column"
            )

    def _midnights(self, stamps: Stamps) -> Stamps:
        """Unwrap a time-of-day clock at midnight, where it falls by a day in one recording."""
        if not stamps.clock:
            return stamps
        steps = np.diff(stamps.whole)
        over = steps < -_DAY_S // 2
        over &= (stamps.whole[1:] < _DAY_S) & (stamps.whole[:-1] < _DAY_S)
        if not over.any():
            return stamps
        row = int(over.argmax()) + 1
        self.note(
            "midnight",
            f"the clock passes midnight {counted(int(over.sum()), 'time')}",
            "counted on",
            int(over.sum()),
            self._line(row),
        )
        days = np.concatenate([[0], np.cumsum(over)])
        return Stamps(stamps.whole + days * _DAY_S, stamps.billionths, True)

    def _unit(self, stamps: Stamps) -> str:
        if stamps.clock:
            return "s"
        if self.options.time_unit is not None:
            return self.options.time_unit
        unit = self.layout.unit
        if unit is None:
            steps = stamps.steps()
            rising = steps[steps > 0]
            if not len(rising):
                raise TraceError(
                    f"{self.where}: time never increases; if it is no clock, --trace-rate gives the samples per second "
                    "instead"
                )
            step = float(np.median(rising))
            unit = guess_unit(stamps, step)
            self.layout = attrs.evolve(self.layout, unit=unit)
            rate = BILLION / (step * UNITS_NS[unit])
            done = f"{UNIT_NAMES[unit]} taken, which makes {rate:.4g} Hz"
            self.note("unit-guessed", "the file does not say in what unit its time is", done)
        return unit

    def times(self) -> NDArray[np.int64]:
        """Return nanoseconds since the segment's first row.

        That row's time is subtracted before anything is scaled.
        """
        unit = self._unit(self._stamps)
        try:
            time_ns, self.epoch_ns = to_ns(self._stamps, unit)
        except OverflowError as error:
            raise TraceError(
                f"{self.where}: the stamps, taken as {UNIT_NAMES[unit]}, make {error}: this is no head trace"
            ) from None
        self.time_unit = UNIT_NAMES[unit] if not self._stamps.clock else "hours:minutes:seconds"
        if self.options.rate is not None:
            self.time_unit = f"row numbers at {self.options.rate:g} Hz"
        elif len(time_ns) > 2:
            self._check_rate(time_ns, unit)
        self.rows.stamps = None
        return time_ns

    def _check_rate(self, time_ns: NDArray[np.int64], unit: str) -> None:
        """Warn of a rate that no tracker has, with the unit that would make it one."""
        steps = np.diff(time_ns)
        step_ns = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
        remedy = rate_fault(step_ns, unit) if step_ns else ""
        if remedy:
            what = f"its clock, read as {UNIT_NAMES[unit]}, makes {BILLION / step_ns:.4g} Hz, which no tracker has"
            self.note("rate-implausible", what, f"kept; {remedy}")

    def trim_default_start(self, time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Drop the default pose that some recorders write until tracking starts."""
        q, p = self.rows.orientation, self.rows.position
        differs = (q != q[0]).any(axis=1)
        if p is not None:
            differs |= (p != p[0]).any(axis=1)
        run = int(differs.argmax())
        if not run:
            return time_ns
        default = abs(abs(q[0, 3]) - 1) < 1e-6 or (p is not None and not p[0].any())
        if not (default or run >= 3) or not len(
            find_jumps(time_ns[run - 1 : run + 1], q[run - 1 : run + 1], self._metres(run))
        ):
            return time_ns
        self.note(
            "default-start",
            f"the first {run} rows hold one default pose, then the head jumps",
            "trimmed",
            run,
            self._line(0),
        )
        self.epoch_ns += int(time_ns[run] - time_ns[0])
        self.rows.keep(slice(run, None))
        return time_ns[run:]

    def _metres(self, row: int) -> NDArray[np.float64] | None:
        p = self.rows.position
        return None if p is None else p[row - 1 : row + 1] * self._scale()

    def _scale(self) -> float:
        if self.options.scale is not None:
            return self.options.scale
        return self.layout.scale if self.axes.metres_per_unit is None else self.axes.metres_per_unit

    def drop_duplicate_stamps(self, time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Keep the last of several rows at one instant, which is the newest."""
        same = np.diff(time_ns) == 0
        count = int(same.sum())
        if not count:
            return time_ns
        rows = self.rows
        at = np.flatnonzero(same)
        other = (rows.orientation[at] != rows.orientation[at + 1]).any(axis=1)
        if rows.position is not None:
            other |= (rows.position[at] != rows.position[at + 1]).any(axis=1)
        self.note(
            "duplicate-stamp",
            f"{counted(count, 'row')} with the time stamp of the next, {int(other.sum())} of them with another pose",
            "the last row of each instant kept",
            count,
            self._line(int(at[0])),
        )
        keep = np.append(~same, True)
        rows.keep(keep)
        return time_ns[keep]

    def join_pairs(self, time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
        """Keep the last of two rows at nearly one instant, where the file is made of such pairs."""
        steps = np.diff(time_ns)
        if len(steps) < _LEAST_PAIRS:
            return time_ns
        near = steps * _NEARER < np.quantile(steps, 0.9)
        count = int(near.sum())
        if count < _PAIRED * len(steps):
            return time_ns
        what = f"{count} rows come {np.median(steps[near]) / 1e6:.3g} ms before the next, at nearly the same instant"
        self.note("paired-rows", what, "the last of each pair kept", count, self._line(int(near.argmax())))
        keep = np.append(~near, True)
        self.rows.keep(keep)
        return time_ns[keep]

    def normalise(self) -> None:
        """Normalise quaternions: slightly off ones silently, bad ones with a warning.

        Refuse the rest.
        """
        q = self.rows.orientation
        norm = np.linalg.norm(q, axis=1)
        hopeless = (norm < WORST_NORM) | (norm > _LARGEST_NORM)
        if hopeless.any():
            row = int(hopeless.argmax())
            raise TraceError(
                f"{self._at(row)}: a quaternion of length {norm[row]:.3g}, expected 1: {q[row].tolist()}; "
                "were the wrong columns read, or is the row damaged?"
            )
        median = float(np.median(norm))
        if abs(median - 1) > _MEDIAN_NORM:
            raise TraceError(
                f"{self.where}: half of the quaternions are longer than {median:.3g}, expected 1: "
                "were the wrong columns read? --columns names the right ones"
            )
        off = np.abs(norm - 1)
        bad = off > COARSE_NORM
        if bad.any():
            worst = int(off.argmax())
            self.note(
                "norm-off",
                f"{counted(int(bad.sum()), 'quaternion')} off length 1 by over {COARSE_NORM:g}, by {off[worst]:.3f} in "
                f"line {self._line(worst)}",
                "normalised; do not trust them",
                int(bad.sum()),
                self._line(int(bad.argmax())),
            )
        q /= np.where(off > 4e-16, norm, 1.0)[:, None]

    def turn_and_scale(self, time_ns: NDArray[np.int64]) -> None:
        """Convert to OpenXR's axes and to metres, and name what contradicts the axes."""
        self._weigh_axes(time_ns)
        self.axes.apply(self.rows.position, self.rows.orientation)
        scale = self._scale()
        if self.rows.position is None:
            self.note("no-position", "the file has no positions (rotation only)", "the head stays at (0, 0, 0)")
        elif scale != 1:
            self.rows.position *= scale

    def _stated_axes(self) -> tuple[Axes, str]:
        """Return the axes and who says so: --axes and --up before the file and its format.

        `--up z` for a format whose z is up changes nothing.
        """
        own = parse_axes(self.layout.axes)
        stated, up = self.options.axes, self.options.up
        if up is not None and is_tilt(up):
            axes, by = (parse_axes(stated), BY_USER) if stated not in (None, AUTO) else (own, self.layout.axes_by)
            return tilted(axes, up), by
        if up is not None and stated is not None:
            raise InputError(
                "--axes and --up both name axes: say one; with --axes, --up may hold three numbers, a tilt"
            )
        if stated is not None and stated != AUTO:
            return parse_axes(stated), BY_USER
        if up is None or own.has_up(up.strip().lower().removeprefix("+")):
            return own, self.layout.axes_by
        return parse_up(up), BY_USER

    def _weigh_axes(self, time_ns: NDArray[np.int64]) -> None:
        """Warn where the motion contradicts the axes; --axes auto takes better ones if clear."""
        p = self.rows.position
        metres = None if p is None else p * self._scale()
        evidence = evidence_of(time_ns, self.rows.orientation, metres, np.array(self.layout.gravity_down))
        what, remedy = place_fault(time_ns, metres) if metres is not None else ("", "")
        if self.layout.order_assumed:
            self._check_order(time_ns, evidence)
        verdict = judge(evidence, self.axes)
        if not what and not verdict.faults:
            what, remedy = height_fault(float(self.axes.world[1] @ evidence.height_m))
        if what:
            self.note("place-implausible", what, f"kept; {remedy}")
        self.leaves_open = verdict.leaves_open
        auto = self.options.axes == AUTO
        if verdict.world_alone and self._is_tilted():
            return
        if auto and verdict.better is not None and verdict.clear:
            self.note("axes-chosen", f"as {self.axes.label()}: {', '.join(verdict.faults)}", _chosen(verdict), 1)
            self.axes, self.axes_by = attrs.evolve(verdict.better, tilt=self.axes.tilt), BY_MOTION
        elif verdict.faults:
            what = f"read as {self.axes.label()}, {self.axes_by}: {', '.join(verdict.faults)}"
            self.note("axes-contradicted", what, _advice(verdict, auto))
            self._axes_wrong = True

    def _check_order(self, time_ns: NDArray[np.int64], evidence: Evidence) -> None:
        """Refuse an assumed order of quaternions if only the other one shows a person."""
        other = evidence_of(time_ns, np.roll(self.rows.orientation, -1, axis=1), self.rows.position, evidence.gravity)
        if best_points(other) > best_points(evidence) + CLEAR:
            raise TraceError(
                f"{self.where}: read with w last, as in TUM files, its quaternions make no person's motion; "
                "with w first they do: say --quat-order wxyz, or xyzw if it is right as it is"
            )

    def _is_tilted(self) -> bool:
        """Return whether up lies between the file's axes: `report_tilt` then says by how much."""
        axis = gravity_axis(self.axes.in_openxr(self.rows.orientation))
        return axis is not None and float(np.abs(axis).max()) < math.cos(math.radians(_TILT_SHOWN_DEG))

    def _axes_in_words(self) -> str:
        words = f"{self.axes.label()}, {self.axes_by}"
        if self._axes_wrong:
            return f"{words}; the motion contradicts them"
        if self._tilt_deg:
            return f"{words}; up is tilted by {self._tilt_deg:.0f} degrees"
        if self.axes_by != ASSUMED:
            return words
        return f"{words}; the motion {'does not show ' + self.leaves_open if self.leaves_open else 'agrees'}"

    def join_hemispheres(self) -> None:
        """Make signs continuous: q and -q are one rotation, but interpolation needs one sign."""
        before = self.rows.orientation[:, 3].copy()
        count = quaternions.make_continuous(self.rows.orientation)
        if count:
            row = int((before != self.rows.orientation[:, 3]).argmax())
            self.note(
                "sign-flip",
                f"the quaternion changes its sign {counted(count, 'time')}",
                "signs made continuous",
                count,
                self._line(row),
            )

    def report_repeats(self) -> None:
        """Report repeated poses (a tracker slower than the recorder); replay needs their timing."""
        q, p = self.rows.orientation, self.rows.position
        same = (q[1:] == q[:-1]).all(axis=1)
        if p is not None:
            same &= (p[1:] == p[:-1]).all(axis=1)
        count = int(same.sum())
        if count:
            share = 100 * count / len(q)
            self.note(
                "repeated-pose",
                f"{counted(count, 'row')} ({share:.3g} %) with the pose of the row before",
                "kept for replay, left out of speeds and prediction",
                count,
                self._line(int(same.argmax()) + 1),
            )

    def report_gaps(self, time_ns: NDArray[np.int64]) -> None:
        """Report gaps in time, and steps too short to divide by."""
        if len(time_ns) < 2:
            return
        steps = np.diff(time_ns)
        limit = gap_limit_ns(time_ns)
        gaps = steps > limit
        if gaps.any():
            self.note(
                "gap",
                f"{counted(int(gaps.sum()), 'gap')} longer than {limit / 1e6:g} ms, up to {steps.max() / 1e9:.3f} s",
                "the pose before is held within them, never interpolated",
                int(gaps.sum()),
                self._line(int(gaps.argmax()) + 1),
            )
        median = int(np.median(steps))
        short = steps * 10 < median
        if short.any():
            self.note(
                "short-step",
                f"{counted(int(short.sum()), 'step')} shorter than a tenth of the median, down to "
                f"{steps.min() / 1e6:.3g} ms",
                "kept; speeds are taken over a fixed span, never over one step",
                int(short.sum()),
                self._line(int(short.argmax()) + 1),
            )

    def find_jumps(self, time_ns: NDArray[np.int64]) -> list[int]:
        """Find teleports: steps that no head can make."""
        jumps = find_jumps(time_ns, self.rows.orientation, self.rows.position)
        if len(jumps):
            self.note(
                "jump",
                f"{counted(len(jumps), 'jump')} of position or orientation faster than a head can move",
                "kept; nothing is interpolated or predicted across them",
                len(jumps),
                self._line(int(jumps[0]) + 1),
            )
        return [int(i) for i in jumps]

    def report_tilt(self) -> None:
        """Report gravity that is not along +y, judged by how the head is held.

        Wrong axes are another matter: turning the world alone would leave the head on its side.
        """
        if self._axes_wrong:
            return
        axis = gravity_axis(self.rows.orientation)
        if axis is None:
            return
        tilt = float(np.degrees(np.arccos(np.clip(axis[1], -1, 1))))
        if tilt > _TILT_SHOWN_DEG:
            shown = ",".join(f"{a:.2f}" for a in axis)
            what = f"judging by the head, up is ({shown}), {tilt:.0f} degrees from +y"
            self._tilt_deg = tilt
            self.note("tilt", what, f"kept as it is; --up={shown} sets the world upright")


def _advice(verdict: Verdict, auto: bool) -> str:
    if verdict.better is None:
        return "kept; nothing else fits better: look at the head with 'trace info --plot', and say --axes"
    sure = "clearly fits" if verdict.clear else "fits better, though not clearly"
    also = f" (so do {', '.join(verdict.also)}; motion cannot tell them apart)" if verdict.also else ""
    kept = "kept, as --axes auto takes only what is clear" if auto else "kept"
    own, better = verdict.points
    return f"{kept}; --axes '{_stated(verdict.better)}' {sure}{also}: {better:.1f} points against {own:.1f}"


def _chosen(verdict: Verdict) -> str:
    assert verdict.better is not None
    also = f"; {', '.join(verdict.also)} would fit as well" if verdict.also else ""
    own, better = verdict.points
    return f"--axes auto takes {verdict.better.label()}: {better:.1f} points against {own:.1f}{also}"


def _stated(axes: Axes) -> str:
    return axes.name or axes.words()


def _is_index(text: str) -> bool:
    try:
        return abs(float(text)) < 1e9
    except ValueError:
        return False
