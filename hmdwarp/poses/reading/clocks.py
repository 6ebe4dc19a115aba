"""When each row was taken: the steps of cleaning.toml about clocks, from stamps to nanoseconds."""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError, counted
from .. import quaternions
from ..assumptions import By
from ..options import FRAMES
from .text_table import Found, Recording, Segment
from .times import BILLION, DAY_S, LARGEST, UNIT_NAMES, UNITS_NS, Stamps

# Shares of steps back in time: a file with restarts has few, a shuffled one half.
_SHUFFLED, _REVERSED = 0.2, 0.9
_LEAST_STEPS = 10
_SEGMENTS_LISTED = 1000  # a jittering clock can run backwards a million times
# Unix time from 2000 to 2100, and how far apart key frames of a map may be.
_UNIX_S, _APART_S = (946_684_800, 4_102_444_800), 30.0
_USUAL_HZ = 75  # the middle of what recorders use
_RATES_HZ = (10.0, 2000.0)  # of trackers
_IMPOSSIBLE_HZ = (0.01, 1e6)  # below and above this a clock was misread
_COUNTED = {3: "milliseconds", 6: "microseconds", 7: "ticks of 100 ns", 9: "nanoseconds"}  # by the digits of a second
# A counter of 32 bits, with a sign or without, in its own unit or in one 10^3, 10^6, 10^9 as large;
# those of other sizes only where nothing is lost in between.
_BITS, _OTHER_BITS, _SCALES = (32, 31), (33, 30, 24, 16), (1, 10**3, 10**6, 10**9)
_LONG = 10**5  # steps a wrap: no recording ends by chance that near to the top, and begins near 0
_SHORTEST = 20  # steps a wrap
_NEAR, _NEAREST = 1000, 5  # steps from the last stamp before a wrap to the first after it
_SMOOTH = 3.0  # times the largest of the turns around it
# A leap of the clock: seconds, steps, rows compared on either side, and how far they turn a head.
_PAUSE_S, _LONG_PAUSE, _AROUND, _TURNS_RAD = 30.0, 1000, 5, 3e-4
_YEARS_S = 10 * 365.25 * 86400  # no recording pauses so long
_MOST_ROWS = 3  # rows in succession with a stamp that is none
_MOST_SHARE = 0.01
_LEAST_ROWS = 20
# Coarse clocks: how exactly steps are looked at, of how many sizes, the least tick (and of a mean
# step), how near multiples are (15.6 ms printed as 15 and 16), what share of one size is steady.
_PRINTED_NS, _MOST_SIZES, _FEW_SIZES, _LEAST_TICK_NS, _LEAST_TICK = 100_000, 400, 7, 2_000_000, 0.2
_OFF_TICK, _ONE_SIZE, _EVENER, _IN_TICK = 0.08, 0.98, 0.5, 1.15
_IN_LINE = 10.0  # median steps
_ABSURD = 20.0  # times all other steps together


def count_by_rate(r: Recording) -> Found:
    """Replace the file's clock by --trace-rate."""
    rate = r.options.rate
    if rate is None:
        return None
    n, step_ns = len(r), BILLION / rate
    if (n - 1) * step_ns > LARGEST:
        raise TraceError(f"{r.where}: {n} rows at {rate:g} Hz last over 146 years; give a higher --trace-rate")
    if r.layout.unit == FRAMES:
        return None, "the file numbers its frames", "these numbers", rate
    r.stamps = Stamps(np.rint(np.arange(n) * step_ns).astype(np.int64), np.zeros(n, np.int64))
    r.layout = attrs.evolve(r.layout, unit="ns")
    aside = "the file's own clock is put aside" if r.layout.clock_ignored else "the file has no time"
    return None, aside, "row numbers", rate


def counted_fractions(r: Recording) -> Found:
    """Find fractions that are counts without leading zeros: 12.5 of nanoseconds is 5 ns after 12.

    Counts never begin with 0, unlike one decimal in ten; as decimals they fall when a digit is
    added, or end with 0 where others are longer.
    """
    stamps, decimals = r.stamps, r.stamps.decimals
    if decimals is None or decimals.min() == decimals.max() or decimals.max() > 9:
        return None
    counts = stamps.billionths // 10 ** (9 - decimals.astype(np.int64))
    falls = int(np.count_nonzero((np.diff(stamps.whole) == 0) & (np.diff(stamps.billionths) < 0)))
    padded = ((decimals > 1) & (stamps.billionths < BILLION // 10)).any()
    if padded or not (falls or ((counts > 0) & (counts % 10 == 0) & (decimals < decimals.max())).any()):
        return None
    found: dict[float, tuple[Stamps, str]] = {}
    for size, unit in _COUNTED.items():
        read = Stamps(stamps.whole, counts * 10 ** (9 - size), stamps.clock)
        steps = read.steps()
        if size >= decimals.max() and 4 * np.count_nonzero(steps < 0) <= falls and (steps > 0).any():
            found.setdefault(round(float(np.log(steps.max() / np.median(steps[steps > 0]))), 1), (read, unit))
    if not found:
        return None
    r.stamps, unit = found[min(found)]  # the most even; of such the coarsest
    return None, unit


def midnights(r: Recording) -> Found:
    """Find where a time of day falls by a day in one recording."""
    whole = r.stamps.whole
    over = (np.diff(whole) < -DAY_S // 2) & (whole[1:] < DAY_S) & (whole[:-1] < DAY_S)
    if not r.stamps.clock or not over.any():
        return None
    return _wrapped(r, np.flatnonzero(over) + 1, DAY_S * BILLION, "the clock passes midnight {}")


def absurd_stamps(r: Recording) -> Found:
    """Find rows whose stamp is out of line while those around it go on as if it were not there.

    Only a few: a clock that falls often has restarts or is no clock.
    """
    stamps, steps = r.stamps, r.stamps.steps()
    falls = np.flatnonzero(steps < 0)
    if len(r) < _LEAST_ROWS or not (steps > 0).any() or len(falls) > max(_MOST_ROWS, _MOST_SHARE * len(r)):
        return None
    step = float(np.median(steps[steps > 0]))
    found: set[int] = set()
    for fall in falls.tolist():
        if not {fall, fall + 1} & found:
            found |= _out_of_line(stamps, fall, step)
    if found:
        kept = np.setdiff1d(np.arange(len(r)), sorted(found))
        bad = np.union1d(sorted(found), kept[list(_far_ends(stamps[kept].steps()))])
    else:  # no copy of what may be 10^7 rows
        bad = np.array(_far_ends(steps), dtype=np.intp)
    if not len(bad):
        return None
    parts = f"{int(stamps.billionths[bad[0]]):09d}".rstrip("0")
    return bad, counted(len(bad), "row"), f"{int(stamps.whole[bad[0]])}{'.' if parts else ''}{parts}"


def _out_of_line(stamps: Stamps, fall: int, step: float) -> set[int]:
    """Return the rows at a step back without which time goes on; empty where it starts anew."""
    for count in range(1, _MOST_ROWS + 1):
        for before, after in ((fall - count, fall + 1), (fall, fall + 1 + count)):
            inside = before >= 0 and after < len(stamps)
            gap = float(stamps[np.array([before, after])].steps()[0]) if inside else 0.0
            if 0 < gap <= _IN_LINE * step * (count + 1):
                return set(range(before + 1, after))
    return set()


def _far_ends(steps: NDArray[np.float64]) -> range:
    """Return the first or the last few rows where one step away from them dwarfs all others."""
    far = int(np.argmax(steps))
    others = float(steps[steps > 0].sum() - steps[far])
    if not 0 < others * _ABSURD < steps[far]:
        return range(0)
    if far < _MOST_ROWS:
        return range(far + 1)
    return range(far + 1, len(steps) + 1) if len(steps) - far <= _MOST_ROWS else range(0)


def wraps(r: Recording) -> Found:
    """Find a counter of so many bits that falls from near its top to near 0, or to its bottom.

    Counters of nanoseconds wrap every 4 seconds: there the head must move on smoothly as well, and
    so with bits that are rare.
    """
    stamps, steps = r.stamps, r.stamps.steps()
    falls = np.flatnonzero(steps < 0)
    if stamps.clock or not 0 < len(falls) * _SHORTEST <= len(stamps):
        return None
    step = float(np.median(steps[steps > 0]))
    scales = _SCALES if stamps.billionths.any() else (1,)
    for bits, scale in ((bits, scale) for bits in (*_BITS, *_OTHER_BITS) for scale in scales):
        top = 2**bits / scale
        if top < _SHORTEST * step:
            continue
        long = bits in _BITS and top / step > _LONG
        after = steps[falls] + top
        near = (after > 0) & (after <= step * (_NEAR if long else _NEAREST))
        near &= (stamps.whole[falls] <= top) & (stamps.whole[falls + 1] >= -top / 2 - 1)
        over = np.zeros(len(steps), bool)
        over[falls[near]] = True
        if not long:  # a step that turns the head no more than those around it
            angle = _turned(r.orientation)
            padded = np.pad(angle, 3, mode="edge")
            around = np.max([padded[k : k + len(angle)] for k in (0, 1, 2, 4, 5, 6)], axis=0)
            over &= angle <= _SMOOTH * around + np.radians(1.0)
        if over.any():
            what = f"the clock wraps {{}}, at 2^{bits}{f'/{scale:g}' if scale > 1 else ''}"
            return _wrapped(r, np.flatnonzero(over) + 1, 2**bits * BILLION // scale, what)
    return None


def _wrapped(r: Recording, rows: NDArray[np.intp], length: int, what: str) -> Found:
    """Count on where the clock begins again, after a round of so many billionths."""
    _count_on(r, rows, [length] * len(rows))
    r.wrap = what.format(counted(len(rows), "time"))
    return rows, r.wrap


def _count_on(r: Recording, rows: NDArray[np.intp], shifts: list[int]) -> None:
    """Move the stamps from each of these rows on by so many billionths."""
    moved = np.zeros((len(r), 2), np.int64)
    moved[rows] = [divmod(one, BILLION) for one in shifts]
    wholes, parts = np.cumsum(moved, axis=0).T
    parts += r.stamps.billionths
    r.stamps = Stamps(r.stamps.whole + wholes + parts // BILLION, parts % BILLION, r.stamps.clock)


def _turned(orientation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle of each step of quaternions of any length, (n - 1,)."""
    unit = orientation / np.maximum(np.linalg.norm(orientation, axis=1, keepdims=True), 1e-9)
    return quaternions.angle_between(unit[:-1], unit[1:])


def reversed_rows(r: Recording) -> Found:
    """Find rows that run backwards in time. Errors: TraceError for shuffled ones."""
    steps = r.stamps.steps()
    falls = float(np.mean(steps < 0)) if len(steps) > _LEAST_STEPS else 0.0
    if falls > _REVERSED and not (steps > 0).any():
        return (np.arange(len(steps)),)
    if falls > _SHUFFLED:
        what = f"time falls after {100 * falls:.0f} % of its rows: they are shuffled, or of several recordings"
        raise TraceError(f"{r.where}: {what}; sort them by time, or name the clock with --time-column")
    return None


def find_unit(r: Recording) -> Found:
    """Find the unit of the clock; where nothing says it, that whose rate is a tracker's.

    Stamps of 18 digits are ticks of 100 ns (.NET and Windows file time since their epochs), and
    those with decimals between 2000 and 2100 as Unix time are seconds, also of few key frames.
    Otherwise it is the unit whose rate is nearest to the usual one, as a ratio; ticks of 100 ns
    only where no other unit lies within 10..1500 Hz.
    """
    stamps, steps, first = r.stamps, r.stamps.steps(), int(r.stamps.whole[0])
    if r.layout.unit == FRAMES:
        step_ns = BILLION / (r.options.rate or 1)
        if step_ns * max(int(stamps.whole.max()), -int(stamps.whole.min())) > LARGEST:
            what = f"frame {first} is over 146 years from frame 0"
            raise TraceError(f"{r.where}: {what}: --time-column names the column of frames, --trace-rate their rate")
        counted_ns = np.rint((stamps.whole - first) * step_ns).astype(np.int64) + round(first * step_ns)
        r.stamps, r.unit = Stamps(counted_ns, np.zeros(len(r), np.int64)), "ns"
        return None
    r.unit = "s" if stamps.clock else r.options.time_unit or r.layout.unit or ""
    if r.unit:
        return None
    if not (steps > 0).any():
        raise TraceError(f"{r.where}: time never increases: --trace-rate gives the samples per second instead")
    step = float(np.median(steps[steps > 0]))
    if 2 * np.count_nonzero(steps == 0) > len(steps):  # a clock so coarse that most rows share a stamp
        step = float(steps[steps >= 0].mean())
    rates = {unit: BILLION / (step * ns) for unit, ns in UNITS_NS.items()}
    likely = sorted(rates, key=lambda unit: abs(np.log(rates[unit] / _USUAL_HZ)))
    best = next(unit for unit in likely if unit != "100ns")
    if 10**17 <= first < 10**18:
        r.unit = "100ns"
    elif _UNIX_S[0] <= first < _UNIX_S[1] and stamps.billionths.any() and step < _APART_S:
        r.unit = "s"
    else:
        r.unit = best if 10 <= rates[best] <= 1500 else likely[0]
    r.layout = attrs.evolve(r.layout, unit=r.unit, unit_by=By.DEFAULT)
    return None, UNIT_NAMES[r.unit], BILLION / (step * UNITS_NS[r.unit])


def clock_changes(r: Recording) -> Found:
    """Count on where the clock leaps while the head moves on, by half a minute or at rest years.

    Errors: TraceError for a clock that counts another unit from some row on.
    """
    stamps, steps, size = r.stamps, r.stamps.steps(), UNITS_NS[r.unit] / BILLION
    at = int(np.argmax(np.abs(steps))) if len(steps) else 0
    before, after = (part[part > 0] for part in (steps[:at], steps[at + 1 :]))
    if len(steps) >= 2 * _SHORTEST and min(len(before), len(after)) >= _SHORTEST:
        ratio = abs(math.log10(float(np.median(after) / np.median(before))))
        if any(abs(ratio - power) < 0.05 for power in (3, 6, 9)):
            raise TraceError(f"{r.where}: its clock changes its unit in line {r.line[at + 1]}: cut the file there")
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else math.inf
    far = np.flatnonzero((np.abs(steps) * size > _PAUSE_S) & (np.abs(steps) > _LONG_PAUSE * step))
    far = far[(far >= _AROUND) & (far < len(r) - _AROUND)]
    if not 0 < len(far) * _SHORTEST <= len(r):
        return None
    found = []
    for leap in far.tolist():
        turned = _turned(r.orientation[leap - _AROUND : leap + _AROUND + 2])
        own, others = float(turned[_AROUND]), np.delete(turned, _AROUND)
        moves = float(np.median(others)) > _TURNS_RAD or abs(steps[leap]) * size > _YEARS_S
        if moves and own <= _SMOOTH * float(others.max(initial=0.0)):
            found.append(leap)
    if not found:
        return None
    leaps = ", ".join(f"{float(steps[leap]) * UNITS_NS[r.unit] / BILLION:+.6g} s" for leap in found[:3])
    steady = int(step) * BILLION + round(step % 1 * BILLION)
    wholes, parts = np.diff(stamps.whole)[found].tolist(), np.diff(stamps.billionths)[found].tolist()
    rows = np.array(found) + 1
    _count_on(r, rows, [steady - a * BILLION - b for a, b in zip(wholes, parts, strict=True)])
    return rows, counted(len(rows), "time"), leaps


def find_segments(r: Recording) -> Found:
    """Split where time decreases or leaps by years, never sorting; choose the longest part."""
    stamps, years = r.stamps, _YEARS_S * BILLION / UNITS_NS[r.unit]
    steps = stamps.steps()
    falls = np.flatnonzero((steps < 0) | (steps > years)) + 1
    starts, ends = np.concatenate([[0], falls]), np.concatenate([falls, [len(stamps)]])
    first, last = stamps[starts], stamps[ends - 1]
    span = (last.whole - first.whole) + (last.billionths - first.billionths) / BILLION
    span = span * (UNITS_NS[r.unit] / BILLION)
    wanted = r.options.segment
    if wanted is not None and wanted > len(span):
        raise TraceError(f"{r.where} holds {counted(len(span), 'recording')}: there is no segment {wanted}")
    taken = int(np.argmax(span)) if wanted is None else wanted - 1
    listed = [*range(min(len(span), _SEGMENTS_LISTED)), *([taken] if taken >= _SEGMENTS_LISTED else [])]
    r.segments = [
        Segment(i + 1, int(r.line[a]), int(r.line[b - 1]), int(b - a), float(span[i]), i == taken)
        for i, a, b in ((i, starts[i], ends[i]) for i in listed)
    ]
    if len(span) < 2:
        return None
    why = "the longest" if wanted is None else "as asked"
    length = f"{span[taken]:.3f} s of {span.sum():.3f} s"
    return falls, counted(len(falls), "time"), len(span), taken + 1, why, length


def keep_segment(r: Recording, falls: NDArray[np.intp]) -> None:
    """Keep the segment that is taken. falls: the first rows of the others."""
    taken = next(segment.number for segment in r.segments if segment.taken)
    bounds = [0, *falls.tolist(), len(r)]
    r.keep(slice(bounds[taken - 1], bounds[taken]))


def read_times(r: Recording) -> Found:
    """Convert stamps to ns since the segment's first row, subtracted before scaling."""
    stamps, scale, size = r.stamps, UNITS_NS[r.unit], BILLION // UNITS_NS[r.unit]
    first, part = int(stamps.whole[0]), int(stamps.billionths[0]) // size
    span = max(abs(int(stamps.whole.max()) - first), abs(int(stamps.whole.min()) - first)) * scale
    if span > LARGEST:
        what = f"the stamps, taken as {UNIT_NAMES[r.unit]}, make a span of {span / 1e9 / 86400 / 365:.3g} years"
        raise TraceError(f"{r.where}: {what}: this is no head trace")
    r.epoch_ns = first * scale + part
    r.time_ns = (stamps.whole - first) * scale + stamps.billionths // size - part  # floored, which keeps their order
    r.time_unit = "hours:minutes:seconds" if stamps.clock else UNIT_NAMES[r.unit]
    if r.options.rate is not None:
        r.time_unit = f"{'frame' if r.layout.unit == FRAMES else 'row'} numbers at {r.options.rate:g} Hz"
    r.stamps = Stamps(np.zeros(0, np.int64), np.zeros(0, np.int64))
    return None


def coarse_clock(r: Recording) -> Found:
    """Find a clock of so few ticks that rows, taken evenly, fit the head better than stamps.

    It stands still between them, though the head does not. Rows are spaced evenly where that fits
    every stamp.
    """
    steps = np.diff(r.time_ns)
    tick = _tick(steps) if r.options.rate is None and len(steps) >= 2 * _SHORTEST else None
    if tick is None:
        return None
    ticks = np.rint(steps / tick)
    wide = min(2 * math.ceil(2 * tick / steps.mean()) + 5, len(steps))
    turned = _turned(r.orientation)
    weight = np.convolve(np.ones(len(steps)), np.ones(wide), "same")
    near, often = (np.convolve(one, np.ones(wide), "same") / weight for one in (turned, ticks))
    even, stamped = np.abs(turned - near).sum(), np.abs(turned - near * ticks / np.maximum(often, 1e-9)).sum()
    if not even < _EVENER * stamped:
        return None
    common = np.bincount(ticks.astype(np.int64)).argmax()
    jittering = np.flatnonzero(ticks != common) + 1
    even_ns = _evenly(r.time_ns, tick)
    off = np.full(len(r), tick / 2) if even_ns is None else np.abs(even_ns - r.time_ns)
    speed = near / max(float(steps.mean()), 1.0)
    error_deg = np.degrees(float(np.quantile(off[1:] * speed, 0.95)))
    done = "kept: speeds and predictions are off by as much"
    if even_ns is not None:
        r.epoch_ns += int(even_ns[0])
        r.time_ns = even_ns - even_ns[0]
        rate = BILLION / float(np.median(np.diff(r.time_ns)))
        done = f"rows taken evenly at {rate:.4g} Hz, which fits every stamp"
    return jittering, tick / 1e6, error_deg, done


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


def odd_rate(r: Recording) -> Found:
    """Find a rate of no tracker. Errors: TraceError for one that no recording can have."""
    steps = np.diff(r.time_ns)
    if r.options.rate is not None or len(steps) < 2 or not (steps > 0).any():
        return None
    rate_hz = BILLION / float(np.median(steps[steps > 0]))
    if _RATES_HZ[0] <= rate_hz <= _RATES_HZ[1]:
        return None
    others = {u: rate_hz * UNITS_NS[r.unit] / UNITS_NS[u] for u in UNITS_NS}
    fits = [u for u, hz in others.items() if _RATES_HZ[0] <= hz <= _RATES_HZ[1]]
    best = min(fits, key=lambda u: abs(np.log(others[u] / _USUAL_HZ)), default="")
    remedy = f"--time-unit {best} makes {others.get(best, 0):.4g} Hz"
    remedy = remedy if best else "--trace-rate gives the samples per second instead"
    if not _IMPOSSIBLE_HZ[0] <= rate_hz <= _IMPOSSIBLE_HZ[1]:
        what = f"its clock, read as {UNIT_NAMES[r.unit]}, makes {rate_hz:.4g} Hz"
        raise TraceError(f"{r.where}: {what}, which no recording has: {remedy}")
    return None, UNIT_NAMES[r.unit], rate_hz, remedy
