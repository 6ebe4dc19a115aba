"""Time stamps as exact integers.

A whole part and billionths, so that neither 18-digit ticks nor epoch seconds lose digits.
"""

from __future__ import annotations

import datetime
import decimal
import math
import re

import attrs
import numpy as np
from numpy.typing import NDArray

from .. import quaternions

BILLION = 1_000_000_000
WIDTH = 48  # bytes kept of a time field; chunks with longer ones take the slow path
_LARGEST = 2**62
_DAY_S = 86400
_UNIX_DAY = datetime.date(1970, 1, 1).toordinal()
# Unix time from 2000 to 2100, and how far apart key frames of a map may be.
_UNIX_S, _APART_S = (946_684_800, 4_102_444_800), 30.0
DATE = re.compile(r"(?:[0-9]{4}[-/.][0-9][0-9]?[-/.][0-9][0-9]?|[0-9][0-9]?[-/.][0-9][0-9]?[-/.][0-9]{4})$")
_CLOCK = re.compile(
    rf"(?:({DATE.pattern[:-1]})[T _])?([0-9]{{1,2}}):([0-9]{{1,2}}):([0-9]{{1,2}})(?:[.,:]([0-9]+))?(?: ?([AP])M)?"
    r"(?: ?(?:Z|(?:UTC|GMT)?(?:([+-])([0-9][0-9]):?([0-9][0-9])?)?))?$",
    re.IGNORECASE,
)
UNITS_NS = {"s": BILLION, "ms": 1_000_000, "us": 1_000, "100ns": 100, "ns": 1}
_NAMES = "seconds", "milliseconds", "microseconds", "ticks of 100 ns", "nanoseconds"
UNIT_NAMES = dict(zip(UNITS_NS, _NAMES, strict=True))
_COUNTED = {3: "milliseconds", 6: "microseconds", 7: "ticks of 100 ns", 9: "nanoseconds"}  # by the digits of a second


@attrs.define
class Stamps:
    """Times in the file's unit."""

    whole: NDArray[np.int64]  # (n,)
    billionths: NDArray[np.int64]  # (n,) in 0..1e9-1
    clock: bool = False  # written as HH:MM:SS, so in seconds
    decimals: NDArray[np.int8] | None = None  # (n,) how many were written; above 9: unknown

    def __getitem__(self, keep: slice | NDArray[np.bool_] | NDArray[np.intp]) -> Stamps:
        decimals = None if self.decimals is None else self.decimals[keep]
        return Stamps(self.whole[keep], self.billionths[keep], self.clock, decimals)

    def __len__(self) -> int:
        return len(self.whole)

    def text(self) -> str:
        """Return the first stamp as a decimal number."""
        parts = f"{int(self.billionths[0]):09d}".rstrip("0")
        return f"{int(self.whole[0])}{'.' if parts else ''}{parts}"

    def steps(self) -> NDArray[np.float64]:
        """(n - 1,) differences in the file's unit; exact wherever they are small."""
        return np.diff(self.whole) + np.diff(self.billionths) * 1e-9


def parse_fields(fields: NDArray[np.bytes_]) -> Stamps:
    """Parse plain decimal stamps at once, others one by one. Errors: ValueError, also if cut."""
    fields = np.ascontiguousarray(fields)
    if fields.view(np.uint8).reshape(len(fields), -1)[:, -1].any():
        raise ValueError("a longer field than is kept")
    fast = _parse_plain(fields)
    return fast if fast is not None else stamps_of([parse_one(field.decode("latin-1")) for field in fields.tolist()])


def stamps_of(parsed: list[tuple[int, int, bool, int]]) -> Stamps:
    """Return stamps of what `parse_one` gives."""
    whole, parts, decimals = (np.array([stamp[k] for stamp in parsed], dtype=np.int64) for k in (0, 1, 3))
    return Stamps(whole, parts, any(stamp[2] for stamp in parsed), decimals.astype(np.int8))


def parse_one(text: str) -> tuple[int, int, bool, int]:
    """Return whole, billionths, whether it is a clock, decimals of a stamp. Errors: ValueError."""
    text = text.strip().strip('"').strip()
    clock = _CLOCK.match(text)
    if clock:
        day, hours, minutes, seconds, fraction, half, sign, *offset = clock.groups()
        hour = int(hours) % 12 + (12 if half in "pP" else 0) if half else int(hours)
        east = (-1 if sign == "-" else 1) * (int(offset[0] or 0) * 60 + int(offset[1] or 0))
        days = 0
        if day:  # where neither of two numbers is over 12, the day comes before the month
            a, b, c = map(int, re.split("[-/.]", day))
            year, month, date = (a, b, c) if a > 31 else (c, a, b) if b > 12 else (c, b, a)
            days = datetime.date(year, month, date).toordinal() - _UNIX_DAY
        whole = ((days * 24 + hour) * 60 + int(minutes) - east) * 60 + int(seconds)
        digits = fraction or ""
        return whole if day else whole % _DAY_S, int(digits[:9].ljust(9, "0")), True, min(len(digits), 10)
    if "_" in text:
        raise ValueError(f"'{text}' is no time")
    try:
        value = decimal.Decimal(text)
    except decimal.InvalidOperation:
        raise ValueError(f"'{text}' is no time") from None
    # Check the exponent before computing: int(Decimal("1e999999999")) would not end.
    if not value.is_finite() or value.adjusted() > 18:
        raise ValueError(f"'{text}' is no time")
    if value.adjusted() < -30:
        return 0, 0, False, 10
    with decimal.localcontext(prec=60):
        whole = int(value.to_integral_value(decimal.ROUND_FLOOR))
        parts = int((value - whole) * BILLION)
    if abs(whole) >= _LARGEST:
        raise ValueError(f"time '{text}' is beyond 2^62")
    digits = text.partition(".")[2]
    return whole, parts, False, min(len(digits), 10) if digits.isdigit() or not digits else 10


def _parse_plain(fields: NDArray[np.bytes_]) -> Stamps | None:
    """Parse digits with at most one point and a sign; None for anything else or too long."""
    ahead, _, rest = np.strings.partition(fields, b".")
    negative, digits = np.strings.startswith(ahead, b"-"), np.strings.lstrip(ahead, b"-")
    length, decimals = np.strings.str_len(digits), np.strings.str_len(rest)
    plain = np.strings.isdigit(digits) & (np.strings.isdigit(rest) | (decimals == 0))  # ".5" takes the slow path too
    if not (plain & (np.strings.str_len(ahead) == length + negative)).all():
        return None
    # 19 digits, nanoseconds since 1970, wrap from 9.2e18 on.
    if (length > 19).any() or ((length == 19) & (negative | (digits > b"4"))).any():
        return None
    whole = digits.astype(np.int64)
    parts = np.strings.ljust(rest, 9, b"0").astype("S9").astype(np.int64)
    borrow = negative & (parts > 0)
    whole, parts = np.where(negative, -whole - borrow, whole), np.where(borrow, BILLION - parts, parts)
    return Stamps(whole, parts, decimals=np.minimum(decimals, 10).astype(np.int8))


def as_counts(stamps: Stamps) -> tuple[Stamps, str] | None:
    """Read fractions that are counts without leading zeros: 12.5 of nanoseconds is 5 ns after 12.

    None where they are decimals. Counts never begin with 0, unlike one decimal in ten; as decimals
    they fall when a digit is added, or end with 0 where others are longer.
    """
    decimals = stamps.decimals
    if decimals is None or decimals.min() == decimals.max() or decimals.max() > 9:
        return None
    if ((decimals > 1) & (stamps.billionths < BILLION // 10)).any():
        return None
    counts = stamps.billionths // 10 ** (9 - decimals.astype(np.int64))
    falls = int(np.count_nonzero((np.diff(stamps.whole) == 0) & (np.diff(stamps.billionths) < 0)))
    if not falls and not ((counts > 0) & (counts % 10 == 0) & (decimals < decimals.max())).any():
        return None
    found: dict[float, tuple[Stamps, str]] = {}
    for size, unit in _COUNTED.items():
        read = Stamps(stamps.whole, counts * 10 ** (9 - size), stamps.clock)
        steps = read.steps()
        if size >= decimals.max() and 4 * np.count_nonzero(steps < 0) <= falls and (steps > 0).any():
            found.setdefault(round(float(np.log(steps.max() / np.median(steps[steps > 0]))), 1), (read, unit))
    return found[min(found)] if found else None  # the most even; of such the coarsest


def guess_unit(stamps: Stamps, median_step: float) -> str:
    """Return the unit whose implied rate is most plausible for a tracker.

    Stamps of 18 digits are ticks of 100 ns (.NET and Windows file time since their epochs), and
    those with decimals between 2000 and 2100 as Unix time are seconds, also of few key frames.
    Otherwise the unit whose rate is nearest, as a ratio, to 75 Hz, the middle of what recorders
    use; ticks of 100 ns only where no other unit lies within 10..1500 Hz.
    """
    if 10**17 <= int(stamps.whole[0]) < 10**18:
        return "100ns"
    is_unix = _UNIX_S[0] <= int(stamps.whole[0]) < _UNIX_S[1] and bool(stamps.billionths.any())
    if is_unix and median_step < _APART_S:
        return "s"

    def far(unit: str) -> float:
        return float(abs(np.log(BILLION / (median_step * UNITS_NS[unit]) / 75)))

    best = min((u for u in UNITS_NS if u != "100ns"), key=far)
    rate = BILLION / (median_step * UNITS_NS[best])
    return best if 10 <= rate <= 1500 else min(UNITS_NS, key=far)


def to_ns(stamps: Stamps, unit: str) -> tuple[NDArray[np.int64], int]:
    """Return (ns since the first stamp, the first stamp in ns as an unbounded Python integer).

    Errors: OverflowError when the span does not fit into 2^62 ns (146 years).
    """
    scale = UNITS_NS[unit]
    first, first_part = int(stamps.whole[0]), int(stamps.billionths[0])
    span = max(abs(int(stamps.whole.max()) - first), abs(int(stamps.whole.min()) - first))
    if span * scale > _LARGEST:
        raise OverflowError(f"a span of {span * scale / 1e9 / 86400 / 365:.3g} years")
    epoch = first * scale + first_part * scale // BILLION
    if scale == BILLION:
        return (stamps.whole - first) * BILLION + (stamps.billionths - first_part), epoch
    # billionths * scale stays below 1e15; floor keeps the order of stamps.
    return (stamps.whole - first) * scale + stamps.billionths * scale // BILLION - first_part * scale // BILLION, epoch


# A counter of 32 bits, with a sign or without, in its own unit or in one 10^3, 10^6, 10^9 as large;
# those of other sizes only where nothing is lost in between.
_BITS, _OTHER_BITS, _SCALES = (32, 31), (33, 30, 24, 16), (1, 10**3, 10**6, 10**9)
_LONG = 10**5  # steps a wrap: no recording ends by chance that near to the top, and begins near 0
_SHORTEST = 20  # steps a wrap
_NEAR, _NEAREST = 1000, 5  # steps from the last stamp before a wrap to the first after it
_SMOOTH = 3.0  # times the largest of the turns around it
# A leap of the clock: seconds, steps, rows compared on either side, and how far they turn a head.
_PAUSE_S, _LONG_PAUSE, _AROUND, _TURNS_RAD = 30.0, 1000, 5, 3e-4
YEARS_S = 10 * 365.25 * 86400  # no recording pauses so long
_MOST_ROWS = 3  # rows in succession with a stamp that is none
_MOST_SHARE = 0.01
_LEAST_ROWS = 20
# Coarse clocks: how exactly steps are looked at, of how many sizes, the least tick (and of a mean
# step), how near multiples are (15.6 ms printed as 15 and 16), what share of one size is steady.
_PRINTED_NS, _MOST_SIZES, _FEW_SIZES, _LEAST_TICK_NS, _LEAST_TICK = 100_000, 400, 7, 2_000_000, 0.2
_OFF_TICK, _ONE_SIZE, _EVENER, _IN_TICK = 0.08, 0.98, 0.5, 1.15
_IN_LINE = 10.0  # median steps
_ABSURD = 20.0  # times all other steps together


@attrs.frozen
class Wraps:
    """Where a clock begins again in one recording."""

    rows: NDArray[np.intp]  # the first of each round
    stamps: Stamps  # counted on
    what: str  # the length of a round, in words


def midnights(stamps: Stamps) -> Wraps | None:
    """Unwrap a time-of-day clock at midnight, where it falls by a day in one recording."""
    over = np.diff(stamps.whole) < -_DAY_S // 2
    over &= (stamps.whole[1:] < _DAY_S) & (stamps.whole[:-1] < _DAY_S)
    return (
        _counted_on(stamps, np.flatnonzero(over) + 1, _DAY_S * BILLION, "midnight")
        if stamps.clock and over.any()
        else None
    )


def wraps_of(stamps: Stamps, orientation: NDArray[np.float64]) -> Wraps | None:
    """Unwrap a counter of so many bits that falls from near its top to near 0, or to its bottom.

    Counters of nanoseconds wrap every 4 seconds: there the head must move on smoothly as well, and
    so with bits that are rare.
    """
    steps = stamps.steps()
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
        if not long:
            over &= _smooth(orientation)
        if over.any():
            what = f"2^{bits}{f'/{scale:g}' if scale > 1 else ''}"
            return _counted_on(stamps, np.flatnonzero(over) + 1, 2**bits * BILLION // scale, what)
    return None


def _counted_on(stamps: Stamps, rows: NDArray[np.intp], shift: int | list[int], what: str) -> Wraps:
    """Move the stamps from each of these rows on by as many billionths."""
    moved = [divmod(one, BILLION) for one in (shift if isinstance(shift, list) else [shift] * len(rows))]
    parts, wholes = stamps.billionths.copy(), np.zeros(len(stamps), np.int64)
    wholes[rows], more = np.array([one[0] for one in moved]), np.zeros(len(stamps), np.int64)
    more[rows] = [one[1] for one in moved]
    parts += np.cumsum(more)
    return Wraps(rows, Stamps(stamps.whole + np.cumsum(wholes) + parts // BILLION, parts % BILLION, stamps.clock), what)


def clock_changes(stamps: Stamps, unit: str, orientation: NDArray[np.float64]) -> Wraps | None:
    """Count on where time leaps and the head does not, half a minute at least, at rest years."""
    steps, n = stamps.steps(), len(stamps)
    rising = steps[steps > 0]
    step = float(np.median(rising)) if len(rising) else math.inf
    leap = np.abs(steps) * (UNITS_NS[unit] / BILLION)
    far = np.flatnonzero((leap > _PAUSE_S) & (np.abs(steps) > _LONG_PAUSE * step))
    far = far[(far >= _AROUND) & (far < n - _AROUND)]
    if not 0 < len(far) * _SHORTEST <= n:
        return None
    found = []
    for at in far.tolist():
        turned = _turned(orientation[at - _AROUND : at + _AROUND + 2])
        own, others = float(turned[_AROUND]), np.delete(turned, _AROUND)
        moves = float(np.median(others)) > _TURNS_RAD
        if own <= _SMOOTH * float(others.max(initial=0.0)) and (moves or leap[at] > YEARS_S):
            found.append(at)
    if not found:
        return None
    steady = int(step) * BILLION + round(step % 1 * BILLION)
    shifts = [
        steady - int(wholes) * BILLION - int(parts)
        for wholes, parts in zip(np.diff(stamps.whole)[found], np.diff(stamps.billionths)[found], strict=True)
    ]
    leaps = ", ".join(f"{float(steps[at]) * UNITS_NS[unit] / BILLION:+.6g} s" for at in found[:3])
    return _counted_on(stamps, np.array(found) + 1, shifts, leaps)


def unit_change(stamps: Stamps) -> int | None:
    """Return the row from which a clock counts a unit 10^3, 10^6 or 10^9 as large or small."""
    steps = stamps.steps()
    if len(steps) < 2 * _SHORTEST:
        return None
    at = int(np.argmax(np.abs(steps)))
    before, after = (part[part > 0] for part in (steps[:at], steps[at + 1 :]))
    if min(len(before), len(after)) < _SHORTEST:
        return None
    ratio = abs(math.log10(float(np.median(after) / np.median(before))))
    return at + 1 if any(abs(ratio - power) < 0.05 for power in (3, 6, 9)) else None


def _turned(orientation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle of each step of quaternions of any length, (n - 1,)."""
    unit = orientation / np.maximum(np.linalg.norm(orientation, axis=1, keepdims=True), 1e-9)
    return quaternions.angle_between(unit[:-1], unit[1:])


def _smooth(orientation: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return of each step whether it turns the head no more than those around it."""
    angle = _turned(orientation)
    padded = np.pad(angle, 3, mode="edge")
    around = np.max([padded[k : k + len(angle)] for k in (0, 1, 2, 4, 5, 6)], axis=0)
    return np.asarray(angle <= _SMOOTH * around + np.radians(1.0))


def absurd_rows(stamps: Stamps) -> NDArray[np.intp]:
    """Return rows whose stamp is out of line while those around it go on as if it were not there.

    Only a few: a clock that falls often has restarts or is no clock.
    """
    steps, n = stamps.steps(), len(stamps)
    falls = np.flatnonzero(steps < 0)
    if n < _LEAST_ROWS or not (steps > 0).any() or len(falls) > max(_MOST_ROWS, _MOST_SHARE * n):
        return np.empty(0, np.intp)
    step = float(np.median(steps[steps > 0]))
    found: set[int] = set()
    for fall in falls.tolist():
        if not {fall, fall + 1} & found:
            found |= _out_of_line(stamps, fall, step)
    if not found:  # no copy of what may be 10^7 rows
        return np.array(_far_ends(steps), dtype=np.intp)
    kept = np.setdiff1d(np.arange(n), sorted(found))
    ends = kept[list(_far_ends(stamps[kept].steps()))]
    return np.union1d(np.array(sorted(found), dtype=np.intp), ends)


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


@attrs.frozen(eq=False)
class CoarseClock:
    """A clock that stands still between its ticks, though the head does not."""

    tick_ns: float
    even_ns: NDArray[np.int64] | None  # (n,) evenly spaced times that fit every stamp; None where none do
    error_rad: float  # by how much stamps misplace a head, at the 95th percentile
    jittering: NDArray[np.intp]  # rows whose step is not the commonest


def coarse_clock(time_ns: NDArray[np.int64], orientation: NDArray[np.float64]) -> CoarseClock | None:
    """Find a clock of so few ticks that rows, taken evenly, fit the head better than stamps."""
    steps = np.diff(time_ns)
    if len(steps) < 2 * _SHORTEST or (tick := _tick(steps)) is None:
        return None
    ticks = np.rint(steps / tick)
    wide = min(2 * math.ceil(2 * tick / steps.mean()) + 5, len(steps))
    turned = _turned(orientation)
    weight = np.convolve(np.ones(len(steps)), np.ones(wide), "same")
    near, often = (np.convolve(one, np.ones(wide), "same") / weight for one in (turned, ticks))
    even, stamped = np.abs(turned - near).sum(), np.abs(turned - near * ticks / np.maximum(often, 1e-9)).sum()
    if not even < _EVENER * stamped:
        return None
    common = np.bincount(ticks.astype(np.int64)).argmax()
    fitted = _evenly(time_ns, tick)
    off = np.full(len(time_ns), tick / 2) if fitted is None else np.abs(fitted - time_ns)
    speed = near / max(float(steps.mean()), 1.0)
    return CoarseClock(tick, fitted, float(np.quantile(off[1:] * speed, 0.95)), np.flatnonzero(ticks != common) + 1)


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
