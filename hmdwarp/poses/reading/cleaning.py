"""From rows to one clean track, by a table of steps, one for each kind of defect."""

from __future__ import annotations

import tomllib
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError, are_digits, counted
from .. import quaternions
from ..assumptions import Assumption, By, Defect, Fact, unstated
from ..track import PoseTrack, gap_limit_ns
from . import clocks
from .header import head_rank
from .layouts import columns_read
from .plausibility import JudgedAxes, find_jumps, inverted
from .text_table import Found, Recording, Segment

_COARSE_NORM = 1e-2
_WORST_NORM, _LARGEST_NORM = 0.5, 2.0
# Glasses write each pose twice, 0.1 ms apart at 30 to 1000 Hz.
_NEARER = 8
_PAIRED = 0.3  # share of steps
_LEAST_PAIRS = 20
_MEDIAN_NORM, _ZERO_NORM = 0.1, 1e-6
_LEAST_RUN = 3  # rows of one pose at the start
_WIDEST_GAZE = 0.5  # cosine: eyes turn by 55 degrees at most (Guitton and Volle 1987)


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
        others = (assumption for assumption in self.assumptions if assumption.what not in (Fact.AXES, Fact.UP))
        return [*assumed, *(f"The trace: {note}" for note in unstated(others)), *map(str, self.defects)]

    @property
    def axes(self) -> str:
        """Axes of the file, who says so, and what the motion shows, in words."""
        return self.track.axes


# The steps, in the order of six questions: which rows are poses of the head; when; which poses are
# new; are they rotations; in which axes and unit; what is missing between them. `find` is a
# function of `clocks` or a method of Cleaner, whose words fill the braces of `text` and `done`.
_STEPS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))["step"]


class Cleaner:
    """The steps of cleaning that look at poses; `clean` runs all of them."""

    def __init__(self, recording: Recording) -> None:
        self.r, self.judged = recording, JudgedAxes(recording)

    def clean(self, form: str) -> LoadedTrace:
        """Run all steps, each after those that it relies on. form: the name of the format."""
        r, judged = self.r, self.judged
        for step in _STEPS:
            of_clocks = getattr(clocks, step["find"], None)
            found: Found = getattr(self, step["find"])() if of_clocks is None else of_clocks(r)
            if found is None:
                continue
            at, *words = found
            r.note(step["name"], step.get("text", "{}").format(*words), step["done"].format(*words), at)
            match step.get("mend"):
                case "drop":
                    kept = np.ones(len(r), bool)
                    kept[at] = False
                    r.keep(kept)
                case "reverse":
                    r.keep(slice(None, None, -1))
                case "keep_segment":
                    clocks.keep_segment(r, at)
        origins = (text.removeprefix("origin:").strip() for _, text in r.head.comments if text.startswith("origin:"))
        track = PoseTrack(
            r.time_ns - r.time_ns[0], r.position if r.position is not None else np.zeros((len(r), 3)), r.orientation,
            name=r.head.path.stem, origin=next(origins, ""), axes=judged.words(), notes=[str(d) for d in r.defects],
            epoch_ns=r.epoch_ns + int(r.time_ns[0]), jumps=r.jumps.tolist(), gaze=r.gaze,
        )  # fmt: skip
        columns = columns_read(r.head, r.layout, r.taken)
        facts = (Assumption(Fact.COLUMNS, columns, r.layout.columns_by, "--columns"), *judged.assumptions())
        assumed, unit = judged.axes_by is By.DEFAULT, r.time_unit
        return LoadedTrace(track, r.head.path, form, r.defects, r.segments, unit, columns, assumed, r.taken, facts)

    def pose_repeats(self) -> NDArray[np.bool_]:
        """Return of each row but the last whether the next has the same pose, (n - 1,)."""
        q, p = self.r.orientation, self.r.position
        same = (q[1:] == q[:-1]).all(axis=1)
        if p is not None:
            same &= (p[1:] == p[:-1]).all(axis=1)
        return np.asarray(same)

    def need_two_rows(self) -> Found:
        if len(self.r) < 2:
            known = "; ".join(str(d) for d in self.r.defects[:3])
            so_far = f" ({known})" if known else ""
            raise TraceError(f"{self.r.where} holds {len(self.r)} usable row: expected two or more{so_far}")
        return None

    def cut_row(self) -> Found:
        """Find a last line without newline that is cut: its norm is off or its time decreases."""
        r = self.r
        if not r.is_cut or len(r) < 2:
            return None
        length = np.linalg.norm(r.orientation[-2:], axis=1)
        off = np.abs(length - 1)
        if off[1] > _COARSE_NORM >= off[0]:
            return np.array([-1]), f"quaternion of length {length[1]:.2f}"
        if len(r.stamps) and r.stamps[-2:].steps()[0] <= 0:
            return np.array([-1]), "its time is not after the one before"
        return None

    def devices(self) -> Found:
        """Find the head's rows, or the first eye's, where rows of several devices are mixed."""
        r, stated = self.r, self.r.options.device
        if r.device is None:
            if stated is not None:
                raise TraceError(f"{r.where} has no column that names devices: leave --device out")
            return None
        names, first, counts = np.unique(r.device, return_index=True, return_counts=True)
        texts = [n.decode("latin-1") for n in names]
        if stated is not None and stated not in texts:
            raise TraceError(f"{r.where}: no rows of device '{stated}': there are those of {', '.join(texts[:8])}")
        if stated is None:
            tracked = np.abs(r.orientation).max(axis=1) > _ZERO_NORM
            lost = [not tracked[r.device == name].any() for name in names]
            order = [float(t) for t in texts] if all(map(are_digits, texts)) else first.tolist()
            taken = min(range(len(texts)), key=lambda i: (lost[i], head_rank(texts[i]), order[i]))
        else:
            taken = texts.index(stated)
        others, r.taken, r.device = np.flatnonzero(r.device != names[taken]), texts[taken], None
        if r.head.made is not None and r.taken in r.head.made.nested:
            r.defects.append(r.head.made.nested[r.taken])
        found = others, len(names), ", ".join(texts[:6]), counts[taken], r.taken, len(others)
        return found if len(names) > 1 else None

    def zero_quaternions(self) -> Found:
        zero = np.flatnonzero(np.abs(self.r.orientation).max(axis=1) < _ZERO_NORM)
        if len(zero) == len(self.r):
            raise TraceError(f"{self.r.where}: every quaternion is zero: no tracking, or the wrong columns were read")
        found = "matrix that is no rotation" if self.r.layout.matrix else "zero quaternion"
        return (zero, counted(len(zero), "row"), found) if len(zero) else None

    def invert(self) -> Found:
        if self.judged.is_inverse:
            self.r.orientation, self.r.position = inverted(self.r.orientation, self.r.position)
        return None

    def default_rows(self) -> Found:
        """Find rows of no turn, or exactly at the origin, that the head jumps to and from."""
        q, p = self.r.orientation, self.r.position
        default = np.abs(q[:, :3]).max(axis=1) < _ZERO_NORM
        if p is not None:
            default |= ~p.any(axis=1)
        run = int(np.append(self.pose_repeats(), False).argmin()) + 1  # what recorders write until tracking starts
        default[:run] |= run >= _LEAST_RUN
        if default.all() or not default.any():
            return None
        jumps = np.zeros(len(q) + 1, bool)  # before each row, and after the last
        jumps[[0, -1]] = True
        jumps[find_jumps(self.r.time_ns, q, None if p is None else p * self.judged.scale[0]) + 1] = True
        starts, ends = (np.flatnonzero(np.diff(default.astype(np.int8), prepend=0, append=0) == way) for way in (1, -1))
        lost = [np.arange(a, b) for a, b in zip(starts, ends, strict=True) if jumps[a] and jumps[b]]
        return (np.concatenate(lost), counted(sum(map(len, lost)), "row"), counted(len(lost), "time")) if lost else None

    def duplicate_stamps(self) -> Found:
        at = np.flatnonzero(np.diff(self.r.time_ns) == 0)
        others = int(np.count_nonzero(~self.pose_repeats()[at])) if len(at) else 0
        return (at, counted(len(at), "row"), others) if len(at) else None

    def paired_rows(self) -> Found:
        steps = np.diff(self.r.time_ns)
        if len(steps) < _LEAST_PAIRS:
            return None
        near = np.flatnonzero(steps * _NEARER < np.quantile(steps, 0.9))
        return (near, len(near), np.median(steps[near]) / 1e6) if len(near) >= _PAIRED * len(steps) else None

    def normalise(self) -> Found:
        """Normalise quaternions: slightly off ones silently, bad ones noted; refuse the rest."""
        q, where = self.r.orientation, self.r.where
        norm = np.linalg.norm(q, axis=1)
        hopeless = (norm < _WORST_NORM) | (norm > _LARGEST_NORM)
        if hopeless.any():
            row = int(hopeless.argmax())
            what = f"a quaternion of length {norm[row]:.3g}, expected 1: {q[row].tolist()}"
            why = "were the wrong columns read, or is the row damaged?"
            raise TraceError(f"{where}: line {self.r.line[row]}: {what}; {why}")
        median = float(np.median(norm))
        if abs(median - 1) > _MEDIAN_NORM:
            what = f"half of the quaternions are longer than {median:.3g}, expected 1"
            raise TraceError(f"{where}: {what}: were the wrong columns read? --columns names the right ones")
        off = np.abs(norm - 1)
        bad, worst = np.flatnonzero(off > _COARSE_NORM), int(off.argmax())
        q /= np.where(off > 4e-16, norm, 1.0)[:, None]
        found = bad, counted(len(bad), "quaternion"), _COARSE_NORM, off[worst], self.r.line[worst]
        return found if len(bad) else None

    def turn_and_scale(self) -> Found:
        """Convert to OpenXR's axes and to metres, and name what contradicts the axes."""
        self.judged.weigh()
        self.judged.axes.apply(self.r.position, self.r.orientation)
        if self.r.position is None:
            return (None,)
        if (scale := self.judged.scale[0]) != 1:
            self.r.position *= scale
        return None

    def find_gaze(self) -> Found:
        """Make the gaze a direction in the head's axes, NaN where the tracker had none."""
        found = self.r.gaze
        if found is None:
            return None
        length = np.linalg.norm(found, axis=1, keepdims=True)
        lost = length[:, 0] < _WORST_NORM
        if found.shape[1] == 4:
            lost |= ~found[:, :3].any(axis=1)  # where the eyes are lost, trackers write no turn at all
            turns = np.where(lost[:, None], (0.0, 0.0, 0.0, 1.0), found / np.maximum(length, _ZERO_NORM))
            self.judged.axes.apply(None, turns)
            world = quaternions.rotate(turns, np.array([[0.0, 0.0, -1.0]]))
            gaze = quaternions.rotate(self.r.orientation * (-1, -1, -1, 1), world)
        else:
            gaze = found @ self.judged.axes.head.T
        lost |= gaze[:, 2] > -_WIDEST_GAZE
        gaze[lost] = np.nan
        self.r.gaze = None if lost.all() else gaze
        return (np.flatnonzero(lost), counted(int(lost.sum()), "row")) if lost.any() else None

    def sign_flips(self) -> Found:
        """Make signs continuous: q and -q are one rotation, but interpolation needs one sign."""
        flips = quaternions.make_continuous(self.r.orientation)
        return (flips, counted(len(flips), "time")) if len(flips) else None

    def repeats(self) -> Found:
        at = np.flatnonzero(self.pose_repeats()) + 1
        return (at, counted(len(at), "row"), 100 * len(at) / len(self.r)) if len(at) else None

    def gaps(self) -> Found:
        steps, limit = np.diff(self.r.time_ns), gap_limit_ns(self.r.time_ns)
        gaps = np.flatnonzero(steps > limit) + 1
        return (gaps, counted(len(gaps), "gap"), limit / 1e6, steps.max() / 1e9) if len(gaps) else None

    def short_steps(self) -> Found:
        """Find steps too short to divide by."""
        steps = np.diff(self.r.time_ns)
        short = np.flatnonzero(steps * 10 < int(np.median(steps))) + 1 if len(steps) else steps
        return (short, counted(len(short), "step"), steps.min() / 1e6) if len(short) else None

    def find_jumps(self) -> Found:
        """Find teleports: steps that no head can make."""
        self.r.jumps = find_jumps(self.r.time_ns, self.r.orientation, self.r.position)
        return (self.r.jumps + 1, counted(len(self.r.jumps), "jump")) if len(self.r.jumps) else None

    def tilt(self) -> Found:
        self.judged.report_tilt()
        return None
