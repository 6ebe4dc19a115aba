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

BILLION = 1_000_000_000
WIDTH = 48  # bytes kept of a time field; chunks with longer ones take the slow path
LARGEST = 2**62
DAY_S = 86400
_UNIX_DAY = datetime.date(1970, 1, 1).toordinal()
DATE = re.compile(r"(?:[0-9]{4}[-/.][0-9][0-9]?[-/.][0-9][0-9]?|[0-9][0-9]?[-/.][0-9][0-9]?[-/.][0-9]{4})$")
_CLOCK = re.compile(
    rf"(?:({DATE.pattern[:-1]})[T _])?([0-9]{{1,2}}):([0-9]{{1,2}}):([0-9]{{1,2}})(?:[.,:]([0-9]+))?(?: ?([AP])M)?"
    r"(?: ?(?:Z|(?:UTC|GMT)?(?:([+-])([0-9][0-9]):?([0-9][0-9])?)?))?$",
    re.IGNORECASE,
)
UNITS_NS = {"s": BILLION, "ms": 1_000_000, "us": 1_000, "100ns": 100, "ns": 1}
_NAMES = "seconds", "milliseconds", "microseconds", "ticks of 100 ns", "nanoseconds"
UNIT_NAMES = dict(zip(UNITS_NS, _NAMES, strict=True))


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
        return whole if day else whole % DAY_S, int(digits[:9].ljust(9, "0")), True, min(len(digits), 10)
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
    if abs(whole) >= LARGEST:
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
