"""From rows to one clean track, by a table of steps, one for each kind of defect."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError, are_digits, counted
from .. import quaternions
from ..assumptions import Assumption, By, Defect, Layout, unstated
from ..options import FRAMES, TraceOptions
from ..track import PoseTrack, gap_limit_ns
from . import times
from .axes import AXES, UP, WRAP
from .columns import head_rank
from .file_head import Head
from .judged_axes import JudgedAxes, is_inverse
from .plausibility import IMPOSSIBLE_HZ, find_jumps, inverted, rate_fault
from .rows import Rows
from .times import BILLION, UNIT_NAMES, UNITS_NS, Stamps, Wraps

COARSE_NORM = 1e-2
WORST_NORM = 0.5
# Glasses write each pose twice, 0.1 ms apart at 30 to 1000 Hz.
_NEARER = 8
_PAIRED = 0.3  # share of steps
_LEAST_PAIRS = 20
# Shares of steps back in time: a file with restarts has few, a shuffled one half.
_SHUFFLED, _REVERSED = 0.2, 0.9
_LEAST_STEPS = 10
_MEDIAN_NORM, _ZERO_NORM = 0.1, 1e-6
_LEAST_RUN = 3  # rows of one pose at the start
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

    def __repr__(self) -> str:
        return f"<LoadedTrace {self.path.name}, {self.format}: {self.track!r}>"

    @property
    def notes(self) -> list[str]:
        """A line for each defect, and of the facts that are only assumed."""
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


Found = tuple[Any, ...] | None  # the rows concerned, or None for all, and the words of the text
# The steps, in the order of six questions: which rows are poses of the head; when; which poses are
# new; are they rotations; in which axes and unit; what is missing between them. `find` is a method
# of Cleaner, whose words fill the braces of `text` and `done`, and so is `mend`.
_STEPS = tomllib.loads(Path(__file__).with_name("cleaning.toml").read_text("utf-8"))["step"]


class Cleaner:
    """Run the cleaning steps over the rows of one file."""

    def __init__(self, head: Head, rows: Rows, layout: Layout, options: TraceOptions, ends_with_newline: bool) -> None:
        self.path, self.where = head.path, str(head.path)
        self.rows, self.layout, self.options = rows, layout, options
        self.defects_of_devices = head.source.made.nested
        self.may_be_cut = not ends_with_newline
        self.defects: list[Defect] = list(layout.caveats)
        self.segments: list[Segment] = []
        self.time_ns: NDArray[np.int64] = np.zeros(0, np.int64)  # of each row, once `read_times` has run
        self.unit = self.time_unit = ""  # a key of UNITS_NS; in words
        self.judged = JudgedAxes(layout, options, self.where, self.note)
        self.wrap = ""  # where the clock begins again, in words
        self.epoch_ns = 0
        self.device = ""
        self.jumps: NDArray[np.int64] = np.zeros(0, np.int64)

    def clean(self, origin: str) -> LoadedTrace:
        """Run all steps, each after those that it relies on."""
        for step in _STEPS:
            found = getattr(self, step["find"])()
            if found is not None:
                at, *words = found
                self.note(step["name"], step.get("text", "{}").format(*words), step["done"].format(*words), at)
                if "mend" in step:
                    getattr(self, step["mend"])(at)
        rows, judged = self.rows, self.judged
        track = PoseTrack(
            self.time_ns - self.time_ns[0], rows.position if rows.position is not None else np.zeros((len(rows), 3)),
            rows.orientation, name=self.path.stem, origin=origin, axes=judged.words(),
            notes=[str(d) for d in self.defects], epoch_ns=self.epoch_ns + int(self.time_ns[0]),
            jumps=self.jumps.tolist(), gaze=rows.gaze,
        )  # fmt: skip
        facts = judged.assumptions(self.layout, self.time_unit, rows.position is not None)
        facts += (Assumption(WRAP, self.wrap, By.NOBODY),) if self.wrap else ()
        assumed = judged.axes_by is By.NOBODY
        return LoadedTrace(
            track, self.path, "", self.defects, self.segments, self.time_unit, "", assumed, self.device, facts
        )

    def note(self, kind: str, what: str, done: str, at: NDArray[np.intp] | None = None) -> None:
        """Record a defect and its repair. at: the rows concerned."""
        count, line = (1, None) if at is None else (len(at), self.line(at[0]))
        self.defects.append(Defect(kind, what, done, count, line))

    def line(self, row: int | np.integer) -> int:
        """Return the line of a row."""
        return int(self.rows.line[row])

    def keep(self, which: NDArray[np.bool_] | slice) -> None:
        """Keep only these rows."""
        self.rows.keep(which)
        if len(self.time_ns):
            self.time_ns = self.time_ns[which]

    def drop(self, at: NDArray[np.intp]) -> None:
        """Drop these rows."""
        which = np.ones(len(self.rows), bool)
        which[at] = False
        self.keep(which)

    def reverse(self, _: NDArray[np.intp]) -> None:
        self.keep(slice(None, None, -1))

    @property
    def stamps(self) -> Stamps:
        """Stamps of the rows, until they are read as times."""
        stamps = self.rows.stamps
        assert stamps is not None, "count_by_rate gives stamps to a file without time"
        return stamps

    def pose_repeats(self) -> NDArray[np.bool_]:
        """Return of each row but the last whether the next has the same pose, (n - 1,)."""
        q, p = self.rows.orientation, self.rows.position
        same = (q[1:] == q[:-1]).all(axis=1)
        if p is not None:
            same &= (p[1:] == p[:-1]).all(axis=1)
        return np.asarray(same)

    def count_on(self, found: Wraps, what: str) -> Found:
        """Take stamps that are counted on where the clock begins again."""
        self.rows.stamps, self.wrap = found.stamps, what.format(counted(len(found.rows), "time"))
        return found.rows, self.wrap

    def need_two_rows(self) -> Found:
        if len(self.rows) < 2:
            known = "; ".join(str(d) for d in self.defects[:3])
            so_far = f" ({known})" if known else ""
            raise TraceError(f"{self.where} holds {len(self.rows)} usable row: expected two or more{so_far}")
        return None

    def cut_row(self) -> Found:
        """Find a last line without newline that is cut: its norm is off or its time decreases."""
        if not self.may_be_cut or len(self.rows) < 2:
            return None
        off = np.abs(np.linalg.norm(self.rows.orientation[-2:], axis=1) - 1)
        if off[1] > COARSE_NORM >= off[0]:
            return np.array([-1]), f"quaternion of length {np.linalg.norm(self.rows.orientation[-1]):.2f}"
        if self.rows.stamps is not None and self.rows.stamps[-2:].steps()[0] <= 0:
            return np.array([-1]), "its time is not after the one before"
        return None

    def devices(self) -> Found:
        """Find the head's rows, or the first eye's, where rows of several devices are mixed."""
        device, stated = self.rows.device, self.options.device
        if device is None:
            if stated is not None:
                raise TraceError(f"{self.where} has no column that names devices: leave --device out")
            return None
        names, first, counts = np.unique(device, return_index=True, return_counts=True)
        texts = [n.decode("latin-1") for n in names]
        if stated is not None and stated not in texts:
            raise TraceError(f"{self.where}: no rows of device '{stated}': there are those of {', '.join(texts[:8])}")
        if stated is None:
            tracked = np.abs(self.rows.orientation).max(axis=1) > _ZERO_NORM
            lost = [not tracked[device == name].any() for name in names]
            order = [float(t) for t in texts] if all(map(are_digits, texts)) else first.tolist()
            taken = min(range(len(texts)), key=lambda i: (lost[i], head_rank(texts[i]), order[i]))
        else:
            taken = texts.index(stated)
        self.device, self.rows.device = texts[taken], None
        if self.device in self.defects_of_devices:
            self.defects.append(self.defects_of_devices[self.device])
        others = np.flatnonzero(device != names[taken])
        return (
            (others, len(names), ", ".join(texts[:6]), counts[taken], self.device, len(others))
            if len(names) > 1
            else None
        )

    def zero_quaternions(self) -> Found:
        zero = np.abs(self.rows.orientation).max(axis=1) < _ZERO_NORM
        if zero.all():
            raise TraceError(f"{self.where}: every quaternion is zero: no tracking, or the wrong columns were read")
        found = "matrix that is no rotation" if self.layout.matrix else "zero quaternion"
        return (np.flatnonzero(zero), counted(int(zero.sum()), "row"), found) if zero.any() else None

    def count_by_rate(self) -> Found:
        """Replace the file's clock by --trace-rate."""
        rate = self.options.rate
        if rate is None:
            return None
        n, step_ns = len(self.rows), BILLION / rate
        if (n - 1) * step_ns > 2**62:
            raise TraceError(f"{self.where}: {n} rows at {rate:g} Hz last over 146 years; give a higher --trace-rate")
        if self.layout.unit == FRAMES:
            return None, "the file numbers its frames", "these numbers", rate
        self.rows.stamps = Stamps(np.rint(np.arange(n) * step_ns).astype(np.int64), np.zeros(n, np.int64))
        self.layout = attrs.evolve(self.layout, unit="ns")
        aside = "the file's own clock is put aside" if self.layout.clock_ignored else "the file has no time"
        return None, aside, "row numbers", rate

    def midnights(self) -> Found:
        found = times.midnights(self.stamps)
        return None if found is None else self.count_on(found, "the clock passes midnight {}")

    def counted_fractions(self) -> Found:
        if (found := times.as_counts(self.stamps)) is None:
            return None
        self.rows.stamps = found[0]
        return None, found[1]

    def absurd_stamps(self) -> Found:
        bad = times.absurd_rows(self.stamps)
        return (bad, counted(len(bad), "row"), self.stamps[bad[:1]].text()) if len(bad) else None

    def wraps(self) -> Found:
        found = times.wraps_of(self.stamps, self.rows.orientation)
        return None if found is None else self.count_on(found, f"the clock wraps {{}}, at {found.what}")

    def reversed_rows(self) -> Found:
        """Find rows that run backwards in time. Errors: TraceError for shuffled ones."""
        steps = self.stamps.steps()
        falls = float(np.mean(steps < 0)) if len(steps) > _LEAST_STEPS else 0.0
        if falls > _REVERSED and not (steps > 0).any():
            return (np.arange(len(steps)),)
        if falls > _SHUFFLED:
            what = f"time falls after {100 * falls:.0f} % of its rows: they are shuffled, or of several recordings"
            raise TraceError(f"{self.where}: {what}; sort them by time, or name the clock with --time-column")
        return None

    def find_unit(self) -> Found:
        steps = self.stamps.steps()
        if self.layout.unit == FRAMES:
            step_ns, first = BILLION / (self.options.rate or 1), int(self.stamps.whole[0])
            counted_ns = np.rint((self.stamps.whole - first) * step_ns).astype(np.int64) + round(first * step_ns)
            self.rows.stamps, self.unit = Stamps(counted_ns, np.zeros(len(steps) + 1, np.int64)), "ns"
            return None
        self.unit = "s" if self.stamps.clock else self.options.time_unit or self.layout.unit or ""
        if self.unit:
            return None
        if not (steps > 0).any():
            raise TraceError(f"{self.where}: time never increases: --trace-rate gives the samples per second instead")
        step = float(np.median(steps[steps > 0]))
        if 2 * np.count_nonzero(steps == 0) > len(steps):  # a clock so coarse that most rows share a stamp
            step = float(steps[steps >= 0].mean())
        self.unit = times.guess_unit(self.stamps, step)
        self.layout = attrs.evolve(self.layout, unit=self.unit, unit_by=By.NOBODY)
        return None, UNIT_NAMES[self.unit], BILLION / (step * UNITS_NS[self.unit])

    def clock_changes(self) -> Found:
        """Count on where the clock changes under a head that moves on; refuse another unit."""
        if (row := times.unit_change(self.stamps)) is not None:
            raise TraceError(f"{self.where}: its clock changes its unit in line {self.line(row)}: cut the file there")
        found = times.clock_changes(self.stamps, self.unit, self.rows.orientation)
        if found is None:
            return None
        self.rows.stamps = found.stamps
        return found.rows, counted(len(found.rows), "time"), found.what

    def find_segments(self) -> Found:
        """Split where time decreases or leaps by years, never sorting; choose the longest part."""
        stamps, years = self.stamps, times.YEARS_S * BILLION / UNITS_NS[self.unit]
        steps = stamps.steps()
        falls = np.flatnonzero((steps < 0) | (steps > years)) + 1
        starts, ends = np.concatenate([[0], falls]), np.concatenate([falls, [len(stamps)]])
        first, last = stamps[starts], stamps[ends - 1]
        span = (last.whole - first.whole) + (last.billionths - first.billionths) / BILLION
        span = span * (UNITS_NS[self.unit] / BILLION)
        wanted = self.options.segment
        if wanted is not None and wanted > len(span):
            raise TraceError(f"{self.where} holds {counted(len(span), 'recording')}: there is no segment {wanted}")
        taken = int(np.argmax(span)) if wanted is None else wanted - 1
        listed = [*range(min(len(span), _SEGMENTS_LISTED)), *([taken] if taken >= _SEGMENTS_LISTED else [])]
        self.segments = [
            Segment(i + 1, self.line(a), self.line(b - 1), int(b - a), float(span[i]), i == taken)
            for i, a, b in ((i, starts[i], ends[i]) for i in listed)
        ]
        if len(span) < 2:
            return None
        why = "the longest" if wanted is None else "as asked"
        length = f"{span[taken]:.3f} s of {span.sum():.3f} s"
        return falls, counted(len(falls), "time"), len(span), taken + 1, why, length

    def keep_segment(self, falls: NDArray[np.intp]) -> None:
        taken = next(segment.number for segment in self.segments if segment.taken)
        bounds = [0, *falls.tolist(), len(self.rows)]
        self.keep(slice(bounds[taken - 1], bounds[taken]))

    def read_times(self) -> Found:
        """Convert stamps to ns since the segment's first row, subtracted before scaling."""
        unit, stamps = self.unit, self.stamps
        try:
            self.time_ns, self.epoch_ns = times.to_ns(stamps, unit)
        except OverflowError as error:
            what = f"the stamps, taken as {UNIT_NAMES[unit]}, make {error}"
            raise TraceError(f"{self.where}: {what}: this is no head trace") from None
        self.rows.stamps = None
        self.time_unit = "hours:minutes:seconds" if stamps.clock else UNIT_NAMES[unit]
        if self.options.rate is not None:
            what = "frame" if self.layout.unit == FRAMES else "row"
            self.time_unit = f"{what} numbers at {self.options.rate:g} Hz"
        return None

    def coarse_clock(self) -> Found:
        """Find a clock of few ticks, and space the rows evenly where that fits every stamp."""
        found = None if self.options.rate is not None else times.coarse_clock(self.time_ns, self.rows.orientation)
        if found is None:
            return None
        done = "kept: speeds and predictions are off by as much"
        if found.even_ns is not None:
            self.epoch_ns += int(found.even_ns[0])
            self.time_ns = found.even_ns - found.even_ns[0]
            rate = BILLION / float(np.median(np.diff(self.time_ns)))
            done = f"rows taken evenly at {rate:.4g} Hz, which fits every stamp"
        return found.jittering, found.tick_ns / 1e6, np.degrees(found.error_rad), done

    def odd_rate(self) -> Found:
        """Find a rate of no tracker. Errors: TraceError for one that no recording can have."""
        steps = np.diff(self.time_ns)
        if self.options.rate is not None or len(steps) < 2 or not (steps > 0).any():
            return None
        step_ns = float(np.median(steps[steps > 0]))
        rate_hz, remedy = BILLION / step_ns, rate_fault(step_ns, self.unit)
        if not IMPOSSIBLE_HZ[0] <= rate_hz <= IMPOSSIBLE_HZ[1]:
            what = f"its clock, read as {UNIT_NAMES[self.unit]}, makes {rate_hz:.4g} Hz"
            raise TraceError(f"{self.where}: {what}, which no recording has: {remedy}")
        return (None, UNIT_NAMES[self.unit], rate_hz, remedy) if remedy else None

    def invert(self) -> Found:
        if is_inverse(self.layout, self.options):
            self.rows.orientation, self.rows.position = inverted(self.rows.orientation, self.rows.position)
        return None

    def default_rows(self) -> Found:
        """Find rows of no turn, or exactly at the origin, that the head jumps to and from."""
        q, p = self.rows.orientation, self.rows.position
        default = np.abs(q[:, :3]).max(axis=1) < _ZERO_NORM
        if p is not None:
            default |= ~p.any(axis=1)
        run = int(np.append(self.pose_repeats(), False).argmin()) + 1  # what recorders write until tracking starts
        default[:run] |= run >= _LEAST_RUN
        if default.all() or not default.any():
            return None
        jumps = np.zeros(len(q) + 1, bool)  # before each row, and after the last
        jumps[[0, -1]] = True
        jumps[find_jumps(self.time_ns, q, None if p is None else p * self.judged.scale()) + 1] = True
        starts, ends = (np.flatnonzero(np.diff(default.astype(np.int8), prepend=0, append=0) == way) for way in (1, -1))
        lost = [np.arange(a, b) for a, b in zip(starts, ends, strict=True) if jumps[a] and jumps[b]]
        return (np.concatenate(lost), counted(sum(map(len, lost)), "row"), counted(len(lost), "time")) if lost else None

    def duplicate_stamps(self) -> Found:
        at = np.flatnonzero(np.diff(self.time_ns) == 0)
        others = int(np.count_nonzero(~self.pose_repeats()[at])) if len(at) else 0
        return (at, counted(len(at), "row"), others) if len(at) else None

    def paired_rows(self) -> Found:
        steps = np.diff(self.time_ns)
        if len(steps) < _LEAST_PAIRS:
            return None
        near = np.flatnonzero(steps * _NEARER < np.quantile(steps, 0.9))
        return (near, len(near), np.median(steps[near]) / 1e6) if len(near) >= _PAIRED * len(steps) else None

    def normalise(self) -> Found:
        """Normalise quaternions: slightly off ones silently, bad ones noted; refuse the rest."""
        q = self.rows.orientation
        norm = np.linalg.norm(q, axis=1)
        hopeless = (norm < WORST_NORM) | (norm > _LARGEST_NORM)
        if hopeless.any():
            row = int(hopeless.argmax())
            what = f"a quaternion of length {norm[row]:.3g}, expected 1: {q[row].tolist()}"
            why = "were the wrong columns read, or is the row damaged?"
            raise TraceError(f"{self.where}: line {self.line(row)}: {what}; {why}")
        median = float(np.median(norm))
        if abs(median - 1) > _MEDIAN_NORM:
            what = f"half of the quaternions are longer than {median:.3g}, expected 1"
            raise TraceError(f"{self.where}: {what}: were the wrong columns read? --columns names the right ones")
        off = np.abs(norm - 1)
        bad, worst = np.flatnonzero(off > COARSE_NORM), int(off.argmax())
        q /= np.where(off > 4e-16, norm, 1.0)[:, None]
        return (bad, counted(len(bad), "quaternion"), COARSE_NORM, off[worst], self.line(worst)) if len(bad) else None

    def turn_and_scale(self) -> Found:
        """Convert to OpenXR's axes and to metres, and name what contradicts the axes."""
        self.judged.weigh(self.time_ns, self.rows)
        self.judged.axes.apply(self.rows.position, self.rows.orientation)
        if self.rows.position is None:
            return (None,)
        if (scale := self.judged.scale()) != 1:
            self.rows.position *= scale
        return None

    def find_gaze(self) -> Found:
        """Make the gaze a direction in the head's axes, NaN where the tracker had none."""
        found = self.rows.gaze
        if found is None:
            return None
        length = np.linalg.norm(found, axis=1, keepdims=True)
        lost = length[:, 0] < WORST_NORM
        if found.shape[1] == 4:
            lost |= ~found[:, :3].any(axis=1)  # where the eyes are lost, trackers write no turn at all
            turns = np.where(lost[:, None], (0.0, 0.0, 0.0, 1.0), found / np.maximum(length, _ZERO_NORM))
            self.judged.axes.apply(None, turns)
            world = quaternions.rotate(turns, np.array([[0.0, 0.0, -1.0]]))
            gaze = quaternions.rotate(self.rows.orientation * (-1, -1, -1, 1), world)
        else:
            gaze = found @ self.judged.axes.head.T
        lost |= gaze[:, 2] > -_WIDEST_GAZE
        gaze[lost] = np.nan
        self.rows.gaze = None if lost.all() else gaze
        return (np.flatnonzero(lost), counted(int(lost.sum()), "row")) if lost.any() else None

    def sign_flips(self) -> Found:
        """Make signs continuous: q and -q are one rotation, but interpolation needs one sign."""
        q = self.rows.orientation
        flips = np.flatnonzero(np.einsum("ij,ij->i", q[1:], q[:-1]) < 0) + 1
        quaternions.make_continuous(q)
        return (flips, counted(len(flips), "time")) if len(flips) else None

    def repeats(self) -> Found:
        at = np.flatnonzero(self.pose_repeats()) + 1
        return (at, counted(len(at), "row"), 100 * len(at) / len(self.rows)) if len(at) else None

    def gaps(self) -> Found:
        steps, limit = np.diff(self.time_ns), gap_limit_ns(self.time_ns)
        gaps = np.flatnonzero(steps > limit) + 1
        return (gaps, counted(len(gaps), "gap"), limit / 1e6, steps.max() / 1e9) if len(gaps) else None

    def short_steps(self) -> Found:
        """Find steps too short to divide by."""
        steps = np.diff(self.time_ns)
        short = np.flatnonzero(steps * 10 < int(np.median(steps))) + 1 if len(steps) else steps
        return (short, counted(len(short), "step"), steps.min() / 1e6) if len(short) else None

    def find_jumps(self) -> Found:
        """Find teleports: steps that no head can make."""
        self.jumps = find_jumps(self.time_ns, self.rows.orientation, self.rows.position)
        return (self.jumps + 1, counted(len(self.jumps), "jump")) if len(self.jumps) else None

    def tilt(self) -> Found:
        self.judged.report_tilt(self.rows.orientation)
        return None
