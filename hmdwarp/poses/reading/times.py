"""Time stamps as exact integers.

A whole part and billionths, so that neither 18-digit ticks nor epoch seconds lose digits.
"""

from __future__ import annotations

import datetime
import decimal
import re

import attrs
import numpy as np
from numpy.typing import NDArray

from .. import quaternions

BILLION = 1_000_000_000
WIDTH = 32  # bytes kept of a time field; longer ones take the slow path
_LARGEST = 2**62
# Unix time from 2000 to 2100, and how far apart key frames of a map may be.
_UNIX_S, _APART_S = (946_684_800, 4_102_444_800), 30.0
_CLOCK = re.compile(
    r"(?:([0-9]{4}[-/.][0-9][0-9]?[-/.][0-9][0-9]?|[0-9][0-9]?[-/.][0-9][0-9]?[-/.][0-9]{4})[T _])?"
    r"([0-9]{1,2}):([0-9][0-9]):([0-9][0-9])(?:[.,:]([0-9]+))?(?: ?([AP])M)?(?:Z|[+-][0-9][0-9]:?[0-9][0-9])?$",
    re.IGNORECASE,
)
UNITS_NS = {"s": BILLION, "ms": 1_000_000, "us": 1_000, "100ns": 100, "ns": 1}
_NAMES = "seconds", "milliseconds", "microseconds", "ticks of 100 ns", "nanoseconds"
UNIT_NAMES = dict(zip(UNITS_NS, _NAMES, strict=True))


@attrs.define
class Stamps:
    """whole (n,) int64 and billionths (n,) int64 in 0..1e9-1, in the file's unit; clock.

    Written as HH:MM:SS, so in seconds.
    """

    whole: NDArray[np.int64]
    billionths: NDArray[np.int64]
    clock: bool = False

    def __getitem__(self, keep: slice | NDArray[np.bool_] | NDArray[np.intp]) -> Stamps:
        return Stamps(self.whole[keep], self.billionths[keep], self.clock)

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
    """Parse plain decimal stamps at once, others one by one. Errors: ValueError."""
    fast = _parse_plain(fields)
    return fast if fast is not None else stamps_of([parse_one(field.decode("latin-1")) for field in fields.tolist()])


def stamps_of(parsed: list[tuple[int, int, bool]]) -> Stamps:
    """Return stamps of what `parse_one` gives."""
    whole, parts = (np.array([stamp[k] for stamp in parsed], dtype=np.int64) for k in (0, 1))
    return Stamps(whole, parts, any(stamp[2] for stamp in parsed))


def parse_one(text: str) -> tuple[int, int, bool]:
    """Return (whole, billionths, written as a clock) of one stamp. Errors: ValueError."""
    text = text.strip().strip('"').strip()
    clock = _CLOCK.match(text)
    if clock:
        day, hours, minutes, seconds, fraction, half = clock.groups()
        hour = int(hours) % 12 + (12 if half in "pP" else 0) if half else int(hours)
        whole = ((_days(day) * 24 + hour) * 60 + int(minutes)) * 60 + int(seconds)
        return whole, int((fraction or "0")[:9].ljust(9, "0")), True
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
        return 0, 0, False
    with decimal.localcontext(prec=60):
        whole = int(value.to_integral_value(decimal.ROUND_FLOOR))
        parts = int((value - whole) * BILLION)
    if abs(whole) >= _LARGEST:
        raise ValueError(f"time '{text}' is beyond 2^62")
    return whole, parts, False


def _days(day: str | None) -> int:
    """Return the days of a date before a clock; 0 without one.

    Where the year comes last, day and month are distinguished by which is over 12, and taken as day
    and month where neither is: only a recording over midnight would notice.
    """
    if not day:
        return 0
    a, b, c = map(int, re.split("[-/.]", day))
    year, month, date = (a, b, c) if a > 31 else (c, a, b) if b > 12 else (c, b, a)
    return datetime.date(year, month, date).toordinal()


def _parse_plain(fields: NDArray[np.bytes_]) -> Stamps | None:
    """Parse digits with at most one point and a sign; None for anything else or too long."""
    n = len(fields)
    # One row per character position: the loop below then runs over neighbouring bytes.
    text = np.ascontiguousarray(np.ascontiguousarray(fields).view(np.uint8).reshape(n, -1).T)
    if text[-1].any():
        return None
    whole, parts = np.zeros(n, np.int64), np.zeros(n, np.int64)
    weight = np.full(n, BILLION, np.int64)  # 10^(9 - decimals seen); 0 once more than nine were seen
    digits, pointed = np.zeros(n, np.int8), np.zeros(n, bool)
    negative = text[0] == ord("-")
    for j, c in enumerate(text):
        if not c.any():
            break
        digit = c - np.uint8(ord("0"))  # wraps around: any non-digit is above 9
        is_digit = digit <= 9
        point = c == ord(".")
        if (point & pointed).any() or not (is_digit | point | (c == 0) | (negative if j == 0 else False)).all():
            return None
        before = is_digit & ~pointed
        whole = np.where(before, whole * 10 + digit, whole)
        digits += before
        after = is_digit & pointed
        weight = np.where(after, weight // 10, weight)
        parts += np.where(after, weight * digit, 0)
        pointed |= point
    # ".5" takes the slow path, and so does what might overflow: 19 digits (nanoseconds since 1970)
    # wrap from 9.2e18 on.
    if (digits == 0).any() or (digits > 19).any() or ((digits == 19) & (negative | (text[0] > ord("3")))).any():
        return None
    if negative.any():
        borrow = negative & (parts > 0)
        whole = np.where(negative, -whole - borrow, whole)
        parts = np.where(borrow, BILLION - parts, parts)
    return Stamps(whole, parts)


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


_DAY_S = 86400
# A counter of 32 bits, with a sign or without, in its own unit or in one 10^3, 10^6, 10^9 as large;
# those of other sizes only where nothing is lost in between.
_BITS, _OTHER_BITS, _SCALES = (32, 31), (33, 30, 24, 16), (1, 10**3, 10**6, 10**9)
_LONG = 10**5  # steps a wrap: no recording ends by chance that near to the top, and begins near 0
_SHORTEST = 20  # steps a wrap
_NEAR, _NEAREST = 1000, 5  # steps from the last stamp before a wrap to the first after it
_SMOOTH = 3.0  # times the largest of the turns around it
_MOST_ROWS = 3  # rows in succession with a stamp that is none
_MOST_SHARE = 0.01
_LEAST_ROWS = 20
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
    return _counted_on(stamps, over, _DAY_S * BILLION, "midnight") if stamps.clock and over.any() else None


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
            return _counted_on(stamps, over, 2**bits * BILLION // scale, what)
    return None


def _counted_on(stamps: Stamps, over: NDArray[np.bool_], length: int, what: str) -> Wraps:
    rounds = np.concatenate([[0], np.cumsum(over)])
    whole, billionths = divmod(length, BILLION)
    parts = stamps.billionths + rounds * billionths
    counted = Stamps(stamps.whole + rounds * whole + parts // BILLION, parts % BILLION, stamps.clock)
    return Wraps(np.flatnonzero(over) + 1, counted, what)


def _smooth(orientation: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return of each step whether it turns the head no more than those around it."""
    unit = orientation / np.maximum(np.linalg.norm(orientation, axis=1, keepdims=True), 1e-9)
    angle = quaternions.angle_between(unit[:-1], unit[1:])
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
