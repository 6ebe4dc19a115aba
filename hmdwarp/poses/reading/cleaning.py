"""From rows to one clean track by six questions; cleaning.toml says how what they find is told.

Which rows are poses of the head; when; which poses are new; are they rotations; in which axes and
unit; what is missing between them.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import TraceError, are_digits, counted
from .. import quaternions
from ..assumptions import AXES_BY, Assumption, By, Defect, Fact, unstated
from ..options import FRAMES
from ..track import PoseTrack, gap_limit_ns
from .axes import assumptions_of, find_jumps, inverted, report_tilt, stated_facts, weigh_axes
from .columns import BILLION, UNITS_NS, head_rank
from .text_table import DAY_S, LARGEST, Recording, Segment, stamps_of, steps_of

UNIT_NAMES = dict.fromkeys(UNITS_NS, "ticks of 100 ns")
UNIT_NAMES |= {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}


@attrs.frozen(eq=False)
class LoadedTrace:
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
        return self.track.axes


def clean(r: Recording, form: str) -> LoadedTrace:
    """Answer all questions, each after those that it relies on. form: the name of the format."""
    r.layout, r.axes = stated_facts(r.layout, r.options)
    for answer in (_which_rows, _when, _which_are_new, _rotations, _axes_and_unit, _what_is_missing):
        answer(r)
    origins = (text.removeprefix("origin:").strip() for _, text in r.head.comments if text.startswith("origin:"))
    track = PoseTrack(
        r.time_ns - r.time_ns[0], r.position if r.position is not None else np.zeros((len(r), 3)), r.orientation,
        name=r.head.path.stem, origin=next(origins, ""),
        axes=f"{r.axes.label()}, {AXES_BY[r.layout.axes_by]}{r.shown}", notes=[str(d) for d in r.defects],
        epoch_ns=r.epoch_ns + int(r.time_ns[0]), jumps=r.jumps.tolist(), gaze=r.gaze,
    )  # fmt: skip
    facts, assumed = assumptions_of(r), r.layout.axes_by is By.DEFAULT
    columns = facts[0].value
    return LoadedTrace(track, r.head.path, form, r.defects, r.segments, r.time_unit, columns, assumed, r.taken, facts)


# By how much quaternions are off length 1, or no rotations at all.
_COARSE_NORM, _ZERO_NORM, _WORST_NORM, _LARGEST_NORM, _MEDIAN_NORM = 1e-2, 1e-6, 0.5, 2.0, 0.1
_WIDEST_GAZE = 0.5  # cosine: eyes turn by 55 degrees at most (Guitton and Volle 1987)
# Glasses write each pose twice, 0.1 ms apart at 30 to 1000 Hz: so much nearer, by share of steps.
_NEARER, _PAIRED, _LEAST_PAIRS = 8, 0.3, 20
_LEAST_RUN = 3  # rows of one pose at the start
# Shares of steps back in time: a file with restarts has few, a shuffled one half.
_SHUFFLED, _REVERSED, _LEAST_STEPS = 0.2, 0.9, 10
_SEGMENTS_LISTED = 1000  # a jittering clock can run backwards a million times
# Unix time from 2000 to 2100, and how far apart key frames of a map may be.
_UNIX_S, _APART_S = (946_684_800, 4_102_444_800), 30.0
_USUAL_HZ = 75  # the middle of what recorders use
_RATES_HZ = (10.0, 2000.0)  # of trackers
_IMPOSSIBLE_HZ = (0.01, 1e6)  # below and above this a clock was misread
_COUNTED = {3: "milliseconds", 6: "microseconds", 7: "ticks of 100 ns", 9: "nanoseconds"}  # by the digits of a second
# A counter of 32 bits, with a sign or without, in its own unit or in one 10^3, 10^6, 10^9 as large.
_TOPS = [2**bits / scale for bits in (32, 31) for scale in (1, 10**3, 10**6, 10**9)]
_LONG = 10**5  # steps a wrap: no recording ends by chance that near to the top, and begins near 0
_NEAR = 1000  # steps from the last stamp before a wrap to the first after it
_SHORTEST = 20  # rows a wrap or a leap
_SMOOTH = 3.0  # times the largest of the turns around it
# A leap of the clock: time, steps, rows compared on either side, and how far they turn a head.
_PAUSE_NS, _LONG_PAUSE, _AROUND, _TURNS_RAD = 30 * BILLION, 1000, 5, 3e-4
_DAY_NS = DAY_S * BILLION
_YEARS_NS = 3653 * _DAY_NS  # no recording pauses so long
# Coarse clocks: how exactly steps are looked at, of how many sizes, the least tick (and of a mean
# step), how near multiples are (15.6 ms printed as 15 and 16), what share of one size is steady.
_PRINTED_NS, _MOST_SIZES, _FEW_SIZES, _LEAST_TICK_NS, _LEAST_TICK = 100_000, 400, 7, 2_000_000, 0.2
_OFF_TICK, _ONE_SIZE, _EVENER, _IN_TICK = 0.08, 0.98, 0.5, 1.15


def _which_rows(r: Recording) -> None:
    """Drop what is no pose of the head: a cut last row, other devices, zeros."""
    if r.is_cut and len(r) > 1:
        length = np.linalg.norm(r.orientation[-2:], axis=1)
        off = np.abs(length - 1)
        late = not len(r.stamps) or steps_of(r.stamps[-2:])[0] > 0
        if off[1] > _COARSE_NORM >= off[0] or not late:
            r.found("last-row-cut", [-1], f"quaternion of length {length[1]:.2f}" if late else "time falls")
    stated, device, r.device = r.options.device, r.device, None
    if device is not None:  # the head's rows, or the first eye's, where rows of several devices are mixed
        names, first, counts = np.unique(device, return_index=True, return_counts=True)
        texts = [n.decode("latin-1") for n in names]
        if stated is not None and stated not in texts:
            raise TraceError(f"{r.head.path}: no rows of device '{stated}': there are those of {', '.join(texts[:8])}")
        tracked = np.abs(r.orientation).max(axis=1) > _ZERO_NORM
        lost = [not tracked[device == name].any() for name in names]
        order = [float(t) for t in texts] if all(map(are_digits, texts)) else first.tolist()
        best = min(range(len(texts)), key=lambda i: (lost[i], head_rank(texts[i]), order[i]))
        taken = best if stated is None else texts.index(stated)
        others, r.taken = np.flatnonzero(device != names[taken]), texts[taken]
        if r.head.made is not None and r.taken in r.head.made.nested:
            r.defects.append(r.head.made.nested[r.taken])
        several = len(names), ", ".join(texts[:6])
        r.found("devices-interleaved", others, *several, counts[taken], r.taken, len(others))
    elif stated is not None:
        raise TraceError(f"{r.head.path} has no column that names devices: leave --device out")
    zero = np.flatnonzero(np.abs(r.orientation).max(axis=1) < _ZERO_NORM)
    if len(zero) == len(r):
        raise TraceError(f"{r.head.path}: every quaternion is zero: no tracking, or the wrong columns were read")
    found = "matrix that is no rotation" if r.layout.matrix else "zero quaternion"
    r.found("zero-quaternion", zero, counted(len(zero), "row"), found)
    _need_two_rows(r)


def _need_two_rows(r: Recording) -> None:
    if len(r) < 2:
        known = "; ".join(map(str, r.defects[:3])) or "no defects"
        raise TraceError(f"{r.head.path} holds {len(r)} usable row: expected two or more ({known})")


def _when(r: Recording) -> None:
    """Read the stamps, count on where the clock begins again, take one recording."""
    if (rate := r.options.rate) is not None:
        frames, step_ns = r.layout.unit == FRAMES, BILLION / rate
        numbers = r.stamps.whole if frames else np.arange(len(r))
        first, what = int(numbers[0]), "frame" if frames else "row"
        if max(int(numbers.max()), -int(numbers.min())) * step_ns > LARGEST:
            how = "--time-column names the column of frames, --trace-rate their rate"
            raise TraceError(f"{r.head.path}: {what} {first} or later is over 146 years from {what} 0: {how}")
        counted_ns = np.rint((numbers - first) * step_ns).astype(np.int64) + round(first * step_ns)
        r.stamps, r.is_clock = stamps_of(counted_ns, 0 * counted_ns, 0 * counted_ns), False
        r.layout, r.time_unit = attrs.evolve(r.layout, unit="ns"), f"{what} numbers at {rate:g} Hz"
        aside = "the file's own clock is put aside" if r.layout.clock_ignored else "the file has no time"
        r.found("clock-by-rate", None, "the file numbers its frames" if frames else aside, f"{what} numbers", rate)
    _count_fractions(r)
    steps = steps_of(r.stamps)
    falls = float(np.mean(steps < 0)) if len(steps) > _LEAST_STEPS else 0.0
    if falls > _REVERSED and not (steps > 0).any():
        r.found("rows-reversed", np.arange(len(steps)))
        r.keep(slice(None, None, -1))
    elif falls > _SHUFFLED:
        what = f"time falls after {100 * falls:.0f} % of its rows: they are shuffled, or of several recordings"
        raise TraceError(f"{r.head.path}: {what}; sort them by time, or name the clock with --time-column")
    _find_unit(r)
    stamps, scale, first = r.stamps, UNITS_NS[r.unit], int(r.stamps.whole[0])
    # What is no time of this recording stays far enough to be another one.
    whole = np.clip(stamps.whole - first, -LARGEST // scale, LARGEST // scale)
    r.time_ns = whole * scale + stamps.billionths // (BILLION // scale)  # floored, which keeps their order
    r.epoch_ns, r.stamps = first * scale, stamps[:0]
    r.time_unit = r.time_unit or ("hours:minutes:seconds" if r.is_clock else UNIT_NAMES[r.unit])
    _clock_changes(r)
    _take_segment(r)
    if rate is not None:
        return
    _coarse_clock(r)
    if len(rises := (steps := np.diff(r.time_ns))[steps > 0]):
        rate_hz, read = BILLION / float(np.median(rises)), f"its clock, read as {UNIT_NAMES[r.unit]}, makes"
        others = {u: rate_hz * UNITS_NS[r.unit] / UNITS_NS[u] for u in UNITS_NS}
        fits = [u for u, hz in others.items() if _RATES_HZ[0] <= hz <= _RATES_HZ[1]]
        best = min(fits, key=lambda u: abs(np.log(others[u] / _USUAL_HZ)), default="")
        remedy = f"--time-unit {best} makes {others.get(best, 0):.4g} Hz"
        remedy = remedy if best else "--trace-rate gives the samples per second instead"
        if not _IMPOSSIBLE_HZ[0] <= rate_hz <= _IMPOSSIBLE_HZ[1] and len(steps) > 1:
            raise TraceError(f"{r.head.path}: {read} {rate_hz:.4g} Hz, which no recording has: {remedy}")
        if not _RATES_HZ[0] <= rate_hz <= _RATES_HZ[1] and len(steps) > 1:
            r.found("rate-implausible", None, UNIT_NAMES[r.unit], rate_hz, remedy)


def _count_fractions(r: Recording) -> None:
    """Find fractions that are counts without leading zeros: 12.5 with ns is 5 ns after 12."""
    # Counts never begin with 0; as decimals they fall when a digit is added, or end with 0.
    stamps, decimals = r.stamps, r.stamps.decimals
    if decimals.min() == decimals.max() or decimals.max() > 9:
        return
    counts = stamps.billionths // 10 ** (9 - decimals.astype(np.int64))
    falls = int(np.count_nonzero((np.diff(stamps.whole) == 0) & (np.diff(stamps.billionths) < 0)))
    padded = ((decimals > 1) & (stamps.billionths < BILLION // 10)).any()
    if padded or not (falls or ((counts > 0) & (counts % 10 == 0) & (decimals < decimals.max())).any()):
        return
    found: dict[float, tuple[Any, str]] = {}
    for size, unit in _COUNTED.items():
        read = stamps_of(stamps.whole, counts * 10 ** (9 - size), decimals)
        steps = steps_of(read)
        if size >= decimals.max() and 4 * np.count_nonzero(steps < 0) <= falls and (steps > 0).any():
            found.setdefault(round(float(np.log(steps.max() / np.median(steps[steps > 0]))), 1), (read, unit))
    if found:
        r.stamps, unit = found[min(found)]  # the most even; of such the coarsest
        r.found("fraction-unpadded", None, unit)


def _turned(orientation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle of each step of quaternions of any length, (n - 1,)."""
    unit = orientation / np.maximum(np.linalg.norm(orientation, axis=1, keepdims=True), 1e-9)
    return quaternions.angle_between(unit[:-1], unit[1:])


def _find_unit(r: Recording) -> None:
    """Find the unit of the clock; where nothing says it, that whose rate is a tracker's."""
    stamps, steps, first = r.stamps, steps_of(r.stamps), int(r.stamps.whole[0])
    stated = None if r.options.rate else r.options.time_unit
    r.unit = "s" if r.is_clock else stated or r.layout.unit or ""
    if r.unit:
        return
    if not (steps > 0).any():
        raise TraceError(f"{r.head.path}: time never increases: --trace-rate gives the samples per second instead")
    step = float(np.median(steps[steps > 0]))
    if 2 * np.count_nonzero(steps == 0) > len(steps):  # a clock so coarse that most rows share a stamp
        step = float(steps[steps >= 0].mean())
    rates = {unit: BILLION / (step * ns) for unit, ns in UNITS_NS.items()}
    likely = sorted(rates, key=lambda unit: abs(np.log(rates[unit] / _USUAL_HZ)))
    best = next(unit for unit in likely if unit != "100ns")
    if 10**17 <= first < 10**18:  # ticks of .NET and Windows file time since their epochs
        r.unit = "100ns"
    elif _UNIX_S[0] <= first < _UNIX_S[1] and stamps.billionths.any() and step < _APART_S:
        r.unit = "s"
    else:
        r.unit = best if 10 <= rates[best] <= 1500 else likely[0]
    r.layout = attrs.evolve(r.layout, unit=r.unit, unit_by=By.DEFAULT)
    r.found("unit-guessed", None, UNIT_NAMES[r.unit], BILLION / (step * UNITS_NS[r.unit]))


def _clock_changes(r: Recording) -> None:
    """Count on where the clock begins again at its top, or leaps while the head moves on."""
    steps, scale = np.diff(r.time_ns), UNITS_NS[r.unit]
    rises = np.flatnonzero(steps > 0)
    if not len(rises):
        return
    at, step = int(np.argmax(np.abs(steps))), float(np.median(steps[rises]))
    before, after = (steps[part] for part in (rises[rises < at], rises[rises > at]))
    if min(len(before), len(after)) >= _SHORTEST:
        ratio = abs(math.log10(float(np.median(after) / np.median(before))))
        if any(abs(ratio - power) < 0.05 for power in (3, 6, 9)):
            raise TraceError(f"{r.head.path}: its clock changes its unit in line {r.line[at + 1]}: cut the file there")
    # By half a minute: at rest the head shows a leap of years alone, and a gap is none.
    far = np.flatnonzero((np.abs(steps) > _PAUSE_NS) & (np.abs(steps) > _LONG_PAUSE * step))
    if not 0 < len(far) * _SHORTEST <= len(r):
        return
    moved = np.zeros(len(r), np.int64)  # from each row on
    tops = [round(top * scale) for top in _TOPS if top * scale > _LONG * step]
    for leap in far.tolist():
        a, b = (r.epoch_ns + ns for ns in r.time_ns[leap : leap + 2].tolist())
        wraps = (top for top in tops if 0 < b - a + top <= step * _NEAR and a <= top and b >= -top / 2 - scale)
        top = next(wraps, 0)
        if r.is_clock and b - a < -_DAY_NS / 2 and max(a, b) < _DAY_NS:
            top = _DAY_NS  # midnight
        if top:
            moved[leap + 1] = top
        elif _AROUND <= leap < len(r) - _AROUND:
            turned = _turned(r.orientation[leap - _AROUND : leap + _AROUND + 2])
            own, others = float(turned[_AROUND]), np.delete(turned, _AROUND)
            moves = float(np.median(others)) > _TURNS_RAD or abs(b - a) > _YEARS_NS
            if moves and own <= _SMOOTH * float(others.max(initial=0.0)):
                moved[leap + 1] = round(step) - (b - a)
    r.time_ns = r.time_ns + np.cumsum(moved)
    rows = np.flatnonzero(moved)
    leaps = ", ".join(f"{steps[row - 1] / 1e9:+.6g} s" for row in rows[:3])
    r.found("clock-changes", rows, counted(len(rows), "time"), leaps)


def _take_segment(r: Recording) -> None:
    """Split where time decreases or leaps by years, never sorting; choose the longest part."""
    steps = np.diff(r.time_ns)
    falls = np.flatnonzero((steps < 0) | (steps > _YEARS_NS)) + 1
    starts, ends = np.concatenate([[0], falls]), np.concatenate([falls, [len(r)]])
    span = (r.time_ns[ends - 1] - r.time_ns[starts]) / 1e9
    wanted = r.options.segment
    if wanted is not None and wanted > len(span):
        raise TraceError(f"{r.head.path} holds {counted(len(span), 'recording')}: there is no segment {wanted}")
    taken = int(np.argmax(span)) if wanted is None else wanted - 1
    listed = [*range(min(len(span), _SEGMENTS_LISTED)), *([taken] if taken >= _SEGMENTS_LISTED else [])]
    r.segments = [
        Segment(i + 1, int(r.line[a]), int(r.line[b - 1]), int(b - a), float(span[i]), i == taken)
        for i, a, b in ((i, starts[i], ends[i]) for i in listed)
    ]
    if len(span) > 1:
        why, length = "the longest" if wanted is None else "as asked", f"{span[taken]:.3f} s of {span.sum():.3f} s"
        r.found("clock-restart", falls, counted(len(falls), "time"), len(span), taken + 1, why, length)
        r.keep(slice(starts[taken], ends[taken]))


def _coarse_clock(r: Recording) -> None:
    """Find a clock of so few ticks that rows, taken evenly, fit the head better than stamps."""
    steps = np.diff(r.time_ns)
    tick = _tick(steps) if len(steps) >= 2 * _SHORTEST else None
    if tick is None:
        return
    ticks = np.rint(steps / tick)
    wide = min(2 * math.ceil(2 * tick / steps.mean()) + 5, len(steps))
    turned = _turned(r.orientation)
    weight = np.convolve(np.ones(len(steps)), np.ones(wide), "same")
    near, often = (np.convolve(one, np.ones(wide), "same") / weight for one in (turned, ticks))
    even, stamped = np.abs(turned - near).sum(), np.abs(turned - near * ticks / np.maximum(often, 1e-9)).sum()
    if not even < _EVENER * stamped:
        return
    common = np.bincount(ticks.astype(np.int64)).argmax()
    even_ns, done = _evenly(r.time_ns, tick), "kept: speeds and predictions are off by half a tick's motion"
    if even_ns is not None:
        r.epoch_ns += int(even_ns[0])
        r.time_ns = even_ns - even_ns[0]
        rate = BILLION / float(np.median(np.diff(r.time_ns)))
        done = f"rows taken evenly at {rate:.4g} Hz, which fits every stamp"
    r.found("clock-coarse", np.flatnonzero(ticks != common) + 1, tick / 1e6, done)


def _tick(steps: NDArray[np.int64]) -> float | None:
    """Return the tick of which common steps are several multiples; None for a fine clock."""
    sizes, counts = np.unique(np.rint(steps / _PRINTED_NS), return_counts=True)
    if len(sizes) > _MOST_SIZES:
        return None
    common = sizes[(counts * 200 > len(steps)) | (len(sizes) < _FEW_SIZES)] * _PRINTED_NS
    apart = np.abs(common[:, None] - common).ravel()
    for size in sorted({*common.tolist(), *apart.tolist()}, reverse=True):
        if size < max(_LEAST_TICK_NS, _LEAST_TICK * steps.mean()):
            return None
        ticks = np.rint(steps / size)
        fits = (np.abs(steps / size - ticks) < _OFF_TICK) & ((ticks > 0) | (steps < _PRINTED_NS))
        if fits.mean() > 0.98:
            usual = float(np.count_nonzero(ticks == max(np.median(ticks), 1)))
            return float(steps[fits].sum() / ticks[fits].sum()) if usual < _ONE_SIZE * len(steps) else None
    return None


def _evenly(time_ns: NDArray[np.int64], tick: float) -> NDArray[np.int64] | None:
    """Return times, even over each run without a gap, within half a tick of every stamp."""
    out = time_ns.copy()
    limit = 3 * max(tick, float(np.diff(time_ns).mean()))
    for run in np.split(np.arange(len(time_ns)), np.flatnonzero(np.diff(time_ns) > limit) + 1):
        late = (time_ns[run] - time_ns[run[0]]).astype(np.float64)
        ticked = np.flatnonzero(np.diff(late)) + 1  # a tick is about to begin at the rows before
        if len(ticked) < 3:
            return None
        slope, first = np.polyfit(ticked, late[ticked], 1)
        line = first + slope * np.arange(len(run))
        if slope <= 0 or np.ptp(late - line) > _IN_TICK * tick:
            return None
        out[run] = time_ns[run[0]] + np.rint(line).astype(np.int64)
    return out if (np.diff(out) > 0).all() else None


def _pose_repeats(r: Recording) -> NDArray[np.bool_]:
    """Return of each row but the last whether the next has the same pose, (n - 1,)."""
    same = (r.orientation[1:] == r.orientation[:-1]).all(axis=1)
    return np.asarray(same if r.position is None else same & (r.position[1:] == r.position[:-1]).all(axis=1))


def _which_are_new(r: Recording) -> None:
    """Drop rows of an instant that has another, and default poses, to and from which it jumps."""
    if r.layout.inverse:
        r.orientation, r.position = inverted(r.orientation, r.position)
    at = np.flatnonzero(np.diff(r.time_ns) == 0)
    others = int(np.count_nonzero(~_pose_repeats(r)[at])) if len(at) else 0
    r.found("duplicate-stamp", at, counted(len(at), "row"), others)
    if len(steps := np.diff(r.time_ns)) >= _LEAST_PAIRS:
        near = np.flatnonzero(steps * _NEARER < np.quantile(steps, 0.9))
        if len(near) >= _PAIRED * len(steps):
            r.found("paired-rows", near, len(near), np.median(steps[near]) / 1e6)
    q, p = r.orientation, r.position
    default = np.abs(q[:, :3]).max(axis=1) < _ZERO_NORM  # no turn, or exactly at the origin
    if p is not None:
        default |= ~p.any(axis=1)
    run = int(np.append(_pose_repeats(r), False).argmin()) + 1  # what recorders write until tracking starts
    default[:run] |= run >= _LEAST_RUN
    if default.all() or not default.any():
        return
    jumps = np.zeros(len(q) + 1, bool)  # before each row, and after the last
    jumps[[0, -1]] = True
    jumps[find_jumps(r.time_ns, q, None if p is None else p * r.layout.scale) + 1] = True
    starts, ends = (np.flatnonzero(np.diff(default.astype(np.int8), prepend=0, append=0) == way) for way in (1, -1))
    lost = [np.arange(a, b) for a, b in zip(starts, ends, strict=True) if jumps[a] and jumps[b]]
    if lost:
        r.found("default-pose", np.concatenate(lost), counted(sum(map(len, lost)), "row"), counted(len(lost), "time"))


def _rotations(r: Recording) -> None:
    """Normalise quaternions: slightly off ones silently, bad ones noted; refuse the rest."""
    q, norm = r.orientation, np.linalg.norm(r.orientation, axis=1)
    off, median = np.abs(norm - 1), float(np.median(norm))
    bad, worst = np.flatnonzero(off > _COARSE_NORM), int(off.argmax())
    if norm.min() < _WORST_NORM or norm.max() > _LARGEST_NORM or abs(median - 1) > _MEDIAN_NORM:
        what = f"a quaternion of length {norm[worst]:.3g}, half of them longer than {median:.3g}, expected 1"
        remedy = "were the wrong columns read (--columns names the right ones), or is the row damaged?"
        raise TraceError(f"{r.head.path}: line {r.line[worst]}: {what}: {q[worst].tolist()}; {remedy}")
    q /= np.where(off > 4e-16, norm, 1.0)[:, None]
    r.found("norm-off", bad, counted(len(bad), "quaternion"), _COARSE_NORM, off[worst], r.line[worst])


def _axes_and_unit(r: Recording) -> None:
    """Convert to OpenXR's axes and to metres, and name what contradicts the axes."""
    weigh_axes(r)
    r.axes.apply(r.position, r.orientation)
    if r.position is None:
        r.found("no-position", None)
    elif (scale := r.layout.scale) != 1:
        r.position *= scale
    if (found := r.gaze) is None:
        return
    # A direction in the head's axes, NaN where the tracker had none.
    length = np.linalg.norm(found, axis=1, keepdims=True)
    lost = length[:, 0] < _WORST_NORM
    if found.shape[1] == 4:
        lost |= ~found[:, :3].any(axis=1)  # where the eyes are lost, trackers write no turn at all
        turns = np.where(lost[:, None], (0.0, 0.0, 0.0, 1.0), found / np.maximum(length, _ZERO_NORM))
        r.axes.apply(None, turns)
        world = quaternions.rotate(turns, np.array([[0.0, 0.0, -1.0]]))
        gaze = quaternions.rotate(r.orientation * (-1, -1, -1, 1), world)
    else:
        gaze = found @ r.axes.head.T
    lost |= gaze[:, 2] > -_WIDEST_GAZE
    gaze[lost] = np.nan
    r.gaze = None if lost.all() else gaze
    r.found("gaze-lost", np.flatnonzero(lost), counted(int(lost.sum()), "row"))


def _what_is_missing(r: Recording) -> None:
    """Note what lies between the poses, none of which is mended but signs."""
    flips = quaternions.make_continuous(r.orientation)  # q and -q are one rotation, but interpolation needs one sign
    r.found("sign-flip", flips, counted(len(flips), "time"))
    at = np.flatnonzero(_pose_repeats(r)) + 1
    r.found("repeated-pose", at, counted(len(at), "row"), 100 * len(at) / len(r))
    steps, limit = np.diff(r.time_ns), gap_limit_ns(r.time_ns)
    if len(steps):
        far, short = (np.flatnonzero(which) + 1 for which in (steps > limit, steps * 10 < int(np.median(steps))))
        r.found("gap", far, counted(len(far), "gap"), limit / 1e6, steps.max() / 1e9)
        r.found("short-step", short, counted(len(short), "step"), steps.min() / 1e6)
    r.jumps = find_jumps(r.time_ns, r.orientation, r.position)  # steps that no head can make
    r.found("jump", r.jumps + 1, counted(len(r.jumps), "jump"))
    report_tilt(r)
    _need_two_rows(r)
