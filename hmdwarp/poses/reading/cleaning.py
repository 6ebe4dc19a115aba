"""From rows to one clean track.

Each step looks for one kind of defect, repairs or refuses it, and records what it did.
"""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError, counted
from .. import quaternions
from ..assumptions import Assumption, By, Defect, Layout, unstated
from ..options import TraceOptions
from ..track import PoseTrack, gap_limit_ns
from .axes import AXES, UP, WRAP, is_inverse
from .columns import head_rank
from .file_head import Head
from .judged_axes import JudgedAxes
from .plausibility import (
    find_jumps,
    inverted,
    rate_fault,
)
from .rows import Rows
from .times import BILLION, UNIT_NAMES, UNITS_NS, Stamps, Wraps, absurd_rows, guess_unit, midnights, to_ns, wraps_of

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
_WIDEST_GAZE = 0.5  # cosine: eyes turn by 55 degrees at most (Guitton and Volle 1987)
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
class LoadedTrace:
    """A trace and all facts about its file."""

    track: PoseTrack
    path: Path
    format: str
    defects: list[Defect]  # all defects and their repairs
    segments: list[Segment]  # recordings within the file, of which one was used
    time_unit: str  # of the file's clock, in words
    columns: str  # which were read as what, by name or number
    axes_assumed: bool  # nothing says which they are
    device: str = ""  # whose rows were taken, where a column names devices
    assumptions: tuple[Assumption, ...] = ()  # every fact by which the file was read, and who says it

    def notes(self) -> list[str]:
        """Return a line for each defect, and of the facts that are only assumed."""
        is_told = any(defect.kind == "axes-contradicted" for defect in self.defects)
        remedy = "" if "--axes" in self.axes else "; --axes states them"
        assumed = [f"the trace's axes: {self.axes}{remedy}"] if self.axes_assumed and not is_told else []
        others = (assumption for assumption in self.assumptions if assumption.what not in (AXES, UP))
        return [*assumed, *(f"The trace: {note}" for note in unstated(others)), *map(str, self.defects)]

    @property
    def axes(self) -> str:
        """Axes of the file, who says so, and what the motion shows, in words."""
        return self.track.axes

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.track.rate_hz


class Cleaner:
    """Run the cleaning steps over the rows of one file."""

    def __init__(self, head: Head, rows: Rows, layout: Layout, options: TraceOptions, ends_with_newline: bool) -> None:
        self.path, self.where = head.path, str(head.path)
        self.rows, self.layout, self.options = rows, layout, options
        self._defects_of_devices = head.source.made.nested
        self._may_be_cut = not ends_with_newline
        self.defects: list[Defect] = list(layout.caveats)
        self.segments: list[Segment] = []
        self.time_ns: NDArray[np.int64] = np.zeros(0, np.int64)  # of each row, once `read_times` has run
        self.time_unit = ""
        self.judged = JudgedAxes(layout, options, self.where, self._note)
        self.wrap = ""  # where the clock begins again, in words
        self.epoch_ns = 0
        self.device = ""

    def clean(self, origin: str) -> LoadedTrace:
        """Run all steps, each after those that it relies on."""
        self.drop_cut_row()
        self.take_one_device()
        self.drop_zero_quaternions()
        self.need_two_rows()
        self.count_by_rate()
        self.take_one_segment()
        self.read_times()
        self.invert()
        self.trim_default_start()
        self.drop_duplicate_stamps()
        self.join_pairs()
        self.normalise()
        self.turn_and_scale()
        self.find_gaze()
        self.join_hemispheres()
        self.report_repeats()
        self.report_gaps()
        jumps = self.find_jumps()
        self.judged.report_tilt(self.rows.orientation)
        self.need_two_rows()
        track = PoseTrack(
            self.time_ns - self.time_ns[0],
            self.rows.position if self.rows.position is not None else np.zeros((len(self.rows), 3)),
            self.rows.orientation,
            name=self.path.stem,
            origin=origin,
            axes=self.judged.words(),
            notes=[str(d) for d in self.defects],
            epoch_ns=self.epoch_ns,
            jumps=jumps,
            gaze=self.rows.gaze,
        )
        wrap = (Assumption(WRAP, self.wrap, By.NOBODY),) if self.wrap else ()
        return LoadedTrace(
            track,
            self.path,
            "",
            self.defects,
            self.segments,
            self.time_unit,
            "",
            self.judged.axes_by is By.NOBODY,
            self.device,
            (*self.judged.assumptions(self.layout, self.time_unit, self.rows.position is not None), *wrap),
        )

    def _note(self, kind: str, what: str, done: str, at: NDArray[np.intp] | None = None, count: int = 0) -> None:
        """Record a defect and its repair. at: the rows concerned; count: of what else."""
        count = count or (1 if at is None else len(at))
        self.defects.append(Defect(kind, what, done, count, None if at is None else self._line(at[0])))

    def _line(self, row: int | np.integer) -> int:
        return int(self.rows.line[row])

    def _keep(self, which: NDArray[np.bool_] | slice) -> None:
        self.rows.keep(which)
        self.time_ns = self.time_ns[which]

    def _pose_repeats(self) -> NDArray[np.bool_]:
        """Return of each row but the last whether the next has the same pose, (n - 1,)."""
        q, p = self.rows.orientation, self.rows.position
        same = (q[1:] == q[:-1]).all(axis=1)
        if p is not None:
            same &= (p[1:] == p[:-1]).all(axis=1)
        return np.asarray(same)

    def need_two_rows(self) -> None:
        """Refuse a single row: one pose is no motion."""
        if len(self.rows) < 2:
            known = "; ".join(str(d) for d in self.defects[:3])
            so_far = f" ({known})" if known else ""
            raise TraceError(f"{self.where} holds {len(self.rows)} usable row: expected two or more{so_far}")

    def drop_cut_row(self) -> None:
        """Drop a last line without newline that is cut: its norm is off or its time decreases."""
        rows = self.rows
        if not self._may_be_cut or len(rows) < 2:
            return
        off = np.abs(np.linalg.norm(rows.orientation[-2:], axis=1) - 1)
        reason = ""
        if off[1] > COARSE_NORM >= off[0]:
            reason = f"quaternion of length {np.linalg.norm(rows.orientation[-1]):.2f}"
        elif rows.stamps is not None and rows.stamps[-2:].steps()[0] <= 0:
            reason = "its time is not after the one before"
        if reason:
            what = f"the last row is cut off ({reason}, no newline)"
            self._note("last-row-cut", what, "dropped", np.array([-1]))
            rows.keep(slice(None, -1))

    def take_one_device(self) -> None:
        """Keep the head's rows, or the first eye's, where rows of several devices are mixed."""
        device, stated = self.rows.device, self.options.device
        if device is None:
            if stated is not None:
                raise TraceError(f"{self.where} has no column that names devices: leave --device out")
            return
        names, first, counts = np.unique(device, return_index=True, return_counts=True)
        texts = [n.decode("latin-1") for n in names]
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
        if self.device in self._defects_of_devices:
            self.defects.append(self._defects_of_devices[self.device])
        if len(names) < 2:
            return
        others = len(device) - int(counts[taken])
        self._note(
            "devices-interleaved",
            f"rows of {len(names)} devices or eyes are interleaved ({', '.join(texts[:6])})",
            f"the {counts[taken]} rows of {texts[taken]} taken, {others} others left out; --device takes another",
            np.sort(np.delete(first, taken)),
            others,
        )
        self.rows.keep(device == names[taken])
        self.rows.device = None

    def drop_zero_quaternions(self) -> None:
        """Drop rows with a zero quaternion, or a matrix without a turn: a mark of lost tracking."""
        zero = np.abs(self.rows.orientation).max(axis=1) < _ZERO_NORM
        if zero.all():
            raise TraceError(
                f"{self.where}: every quaternion is zero: the tracker had nothing, or the wrong columns were read"
            )
        if zero.any():
            found = "matrix that is no rotation" if self.layout.matrix else "zero quaternion"
            what = f"{counted(int(zero.sum()), 'row')} with a {found}, a marker for no tracking"
            self._note("zero-quaternion", what, "dropped", np.flatnonzero(zero))
            self.rows.keep(~zero)

    @property
    def _stamps(self) -> Stamps:
        stamps = self.rows.stamps
        assert stamps is not None, "count_by_rate gives stamps to a file without time"
        return stamps

    def count_by_rate(self) -> None:
        """Replace the file's clock by --trace-rate."""
        rate = self.options.rate
        if rate is None:
            return
        n, step_ns = len(self.rows), BILLION / rate
        if (n - 1) * step_ns > 2**62:
            raise TraceError(
                f"{self.where}: {n} rows at a rate of {rate:g} Hz last over 146 years; give a higher --trace-rate"
            )
        what = "the file's own clock is put aside" if self.layout.clock_ignored else "the file has no time"
        self._note("clock-by-rate", what, f"row numbers at {rate:g} Hz, as --trace-rate says")
        self.rows.stamps = Stamps(np.rint(np.arange(n) * step_ns).astype(np.int64), np.zeros(n, np.int64))
        self.layout = attrs.evolve(self.layout, unit="ns")

    def take_one_segment(self) -> None:
        """Split where time decreases, never sorting; keep the longest recording or the chosen."""
        self._mend_clock()
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
            Segment(i + 1, self._line(a), self._line(b - 1), int(b - a), float(span[i]), i == taken)
            for i, a, b in ((i, starts[i], ends[i]) for i in listed)
        ]
        if len(span) > 1:
            why = "the longest" if wanted is None else "as asked"
            what = f"time falls {counted(len(falls), 'time')}: the file holds {len(span)} recordings"
            length = f"{span[taken]:.3f} s of {span.sum():.3f} s"
            done = f"segment {taken + 1} taken, {why} ({length}); --segment takes another"
            self._note("clock-restart", what, done, falls)
            self.rows.keep(slice(starts[taken], ends[taken]))

    def _judge_order(self) -> None:
        """Turn rows around that run backwards in time. Errors: TraceError for shuffled ones."""
        steps = self._stamps.steps()
        falls = float(np.mean(steps < 0)) if len(steps) > _LEAST_STEPS else 0.0
        if falls > _REVERSED and not (steps > 0).any():
            what = "time falls from row to row: the file is in reverse order"
            self._note("rows-reversed", what, "read from its end", np.arange(len(steps)))
            self.rows.keep(slice(None, None, -1))
        elif falls > _SHUFFLED:
            raise TraceError(
                f"{self.where}: time falls after {100 * falls:.0f} % of its rows: they are shuffled, or of several "
                "recordings; sort them by time, or name the clock with --time-column"
            )

    def _mend_clock(self) -> None:
        """Count on where the clock wraps or passes midnight, and drop stamps that are none."""
        found = midnights(self._stamps)
        if found is not None:
            self._count_on(found, "midnight", f"the clock passes midnight {counted(len(found.rows), 'time')}")
        bad = absurd_rows(self._stamps)
        if len(bad):
            stamp = self._stamps[bad[:1]]
            what = f"{counted(len(bad), 'row')} with a time out of line with the others, the first {stamp.text()}"
            self._note("stamp-absurd", what, "dropped", bad)
            self.rows.keep(_without(bad, len(self.rows)))
        found = wraps_of(self._stamps, self.rows.orientation)
        if found is not None:
            what = f"the clock wraps {counted(len(found.rows), 'time')}, at {found.what}"
            self._count_on(found, "clock-wrap", what)

    def _count_on(self, found: Wraps, kind: str, what: str) -> None:
        self._note(kind, what, "counted on", found.rows)
        self.rows.stamps = found.stamps
        self.wrap = what

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
            self.layout = attrs.evolve(self.layout, unit=unit, unit_by=By.NOBODY)
            done = f"{UNIT_NAMES[unit]} taken, which makes {BILLION / (step * UNITS_NS[unit]):.4g} Hz"
            self._note("unit-guessed", "the file does not say in what unit its time is", done)
        return unit

    def read_times(self) -> None:
        """Convert stamps to nanoseconds since the segment's first row.

        That row's time is subtracted before anything is scaled.
        """
        unit, stamps = self._unit(self._stamps), self._stamps
        try:
            self.time_ns, self.epoch_ns = to_ns(stamps, unit)
        except OverflowError as error:
            raise TraceError(
                f"{self.where}: the stamps, taken as {UNIT_NAMES[unit]}, make {error}: this is no head trace"
            ) from None
        self.time_unit = "hours:minutes:seconds" if stamps.clock else UNIT_NAMES[unit]
        if self.options.rate is not None:
            self.time_unit = f"row numbers at {self.options.rate:g} Hz"
        elif len(self.time_ns) > 2:
            self._check_rate(unit)
        self.rows.stamps = None

    def _check_rate(self, unit: str) -> None:
        """Warn of a rate that no tracker has, with the unit that would make it one."""
        steps = np.diff(self.time_ns)
        step_ns = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
        if remedy := rate_fault(step_ns, unit) if step_ns else "":
            what = f"its clock, read as {UNIT_NAMES[unit]}, makes {BILLION / step_ns:.4g} Hz, which no tracker has"
            self._note("rate-implausible", what, f"kept; {remedy}")

    def invert(self) -> None:
        """Turn poses that are head from world around."""
        if is_inverse(self.layout, self.options):
            self.rows.orientation, self.rows.position = inverted(self.rows.orientation, self.rows.position)

    def trim_default_start(self) -> None:
        """Drop the default pose that some recorders write until tracking starts."""
        q, p = self.rows.orientation, self.rows.position
        differs = (q != q[0]).any(axis=1)
        if p is not None:
            differs |= (p != p[0]).any(axis=1)
        run = int(differs.argmax())
        default = abs(abs(q[0, 3]) - 1) < 1e-6 or (p is not None and not p[0].any())
        if not run or not (default or run >= 3):
            return
        change = slice(run - 1, run + 1)
        metres = None if p is None else p[change] * self.judged.scale()
        if not len(find_jumps(self.time_ns[change], q[change], metres)):
            return
        rows = f"{run} rows hold" if run > 1 else "row holds"
        what = f"the first {rows} one default pose, then the head jumps"
        self._note("default-start", what, "trimmed", np.arange(run))
        self.epoch_ns += int(self.time_ns[run] - self.time_ns[0])
        self._keep(slice(run, None))

    def drop_duplicate_stamps(self) -> None:
        """Keep the last of several rows at one instant, which is the newest."""
        at = np.flatnonzero(np.diff(self.time_ns) == 0)
        if len(at):
            others = int(np.count_nonzero(~self._pose_repeats()[at]))
            what = f"{counted(len(at), 'row')} with the time stamp of the next, {others} of them with another pose"
            self._note("duplicate-stamp", what, "the last row of each instant kept", at)
            self._keep(_without(at, len(self.rows)))

    def join_pairs(self) -> None:
        """Keep the last of two rows at nearly one instant, where the file is made of such pairs."""
        steps = np.diff(self.time_ns)
        if len(steps) < _LEAST_PAIRS:
            return
        near = np.flatnonzero(steps * _NEARER < np.quantile(steps, 0.9))
        if len(near) >= _PAIRED * len(steps):
            apart_ms = np.median(steps[near]) / 1e6
            what = f"{len(near)} rows come {apart_ms:.3g} ms before the next, at nearly the same instant"
            self._note("paired-rows", what, "the last of each pair kept", near)
            self._keep(_without(near, len(self.rows)))

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
                f"{self.where}: line {self._line(row)}: a quaternion of length {norm[row]:.3g}, expected 1: "
                f"{q[row].tolist()}; were the wrong columns read, or is the row damaged?"
            )
        median = float(np.median(norm))
        if abs(median - 1) > _MEDIAN_NORM:
            raise TraceError(
                f"{self.where}: half of the quaternions are longer than {median:.3g}, expected 1: "
                "were the wrong columns read? --columns names the right ones"
            )
        off = np.abs(norm - 1)
        bad = np.flatnonzero(off > COARSE_NORM)
        if len(bad):
            worst = int(off.argmax())
            self._note(
                "norm-off",
                f"{counted(len(bad), 'quaternion')} off length 1 by over {COARSE_NORM:g}, by {off[worst]:.3f} in "
                f"line {self._line(worst)}",
                "normalised; do not trust them",
                bad,
            )
        q /= np.where(off > 4e-16, norm, 1.0)[:, None]

    def turn_and_scale(self) -> None:
        """Convert to OpenXR's axes and to metres, and name what contradicts the axes."""
        self.judged.weigh(self.time_ns, self.rows)
        self.judged.axes.apply(self.rows.position, self.rows.orientation)
        scale = self.judged.scale()
        if self.rows.position is None:
            self._note("no-position", "the file has no positions (rotation only)", "the head stays at (0, 0, 0)")
        elif scale != 1:
            self.rows.position *= scale

    def find_gaze(self) -> None:
        """Make the gaze a direction in the head's axes, NaN where the tracker had none."""
        found = self.rows.gaze
        if found is None:
            return
        length = np.linalg.norm(found, axis=1, keepdims=True)
        if found.shape[1] == 4:
            # Where the eyes are lost, trackers write no turn at all.
            lost = (length[:, 0] < WORST_NORM) | ~found[:, :3].any(axis=1)
            turns = np.where(lost[:, None], (0.0, 0.0, 0.0, 1.0), found / np.maximum(length, _ZERO_NORM))
            self.judged.axes.apply(None, turns)
            world = quaternions.rotate(turns, np.array([[0.0, 0.0, -1.0]]))
            gaze = quaternions.rotate(self.rows.orientation * (-1, -1, -1, 1), world)
        else:
            lost, gaze = length[:, 0] < WORST_NORM, found @ self.judged.axes.head.T
        lost |= gaze[:, 2] > -_WIDEST_GAZE
        if lost.any():
            what = f"the gaze is not known in {counted(int(lost.sum()), 'row')}, as while the eyes blink"
            self._note("gaze-lost", what, "the gaze before is held", np.flatnonzero(lost))
        gaze[lost] = np.nan
        self.rows.gaze = None if lost.all() else gaze

    def join_hemispheres(self) -> None:
        """Make signs continuous: q and -q are one rotation, but interpolation needs one sign."""
        before = self.rows.orientation[:, 3].copy()
        if count := quaternions.make_continuous(self.rows.orientation):
            what = f"the quaternion changes its sign {counted(count, 'time')}"
            changed = np.atleast_1d((before != self.rows.orientation[:, 3]).argmax())
            self._note("sign-flip", what, "signs made continuous", changed, count)

    def report_repeats(self) -> None:
        """Report repeated poses (a tracker slower than the recorder); replay needs their timing."""
        at = np.flatnonzero(self._pose_repeats()) + 1
        if len(at):
            share = 100 * len(at) / len(self.rows)
            what = f"{counted(len(at), 'row')} ({share:.3g} %) with the pose of the row before"
            self._note("repeated-pose", what, "kept for replay, left out of speeds and prediction", at)

    def report_gaps(self) -> None:
        """Report gaps in time, and steps too short to divide by."""
        if len(self.time_ns) < 2:
            return
        steps, limit = np.diff(self.time_ns), gap_limit_ns(self.time_ns)
        gaps = np.flatnonzero(steps > limit) + 1
        if len(gaps):
            what = f"{counted(len(gaps), 'gap')} longer than {limit / 1e6:g} ms, up to {steps.max() / 1e9:.3f} s"
            self._note("gap", what, "the pose before is held within them, never interpolated", gaps)
        short = np.flatnonzero(steps * 10 < int(np.median(steps))) + 1
        if len(short):
            least = f"{steps.min() / 1e6:.3g} ms"
            what = f"{counted(len(short), 'step')} shorter than a tenth of the median, down to {least}"
            self._note("short-step", what, "kept; speeds are taken over a fixed span, never over one step", short)

    def find_jumps(self) -> list[int]:
        """Find teleports: steps that no head can make."""
        jumps = find_jumps(self.time_ns, self.rows.orientation, self.rows.position)
        if len(jumps):
            what = f"{counted(len(jumps), 'jump')} of position or orientation faster than a head can move"
            self._note("jump", what, "kept; nothing is interpolated or predicted across them", jumps + 1)
        return [int(i) for i in jumps]


def _without(rows: NDArray[np.intp], count: int) -> NDArray[np.bool_]:
    """Return which of `count` rows stay without these."""
    keep = np.ones(count, bool)
    keep[rows] = False
    return keep


def _is_index(text: str) -> bool:
    try:
        return abs(float(text)) < 1e9
    except ValueError:
        return False
