"""From the text of a trace to columns of numbers: a first look at the file, then its rows.

Line by line: memory stays at the size of the result. Every row keeps its line, for messages.
"""

from __future__ import annotations

import datetime
import decimal
import io
import itertools
import math
import re
import tomllib
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import TraceError
from ...base.named_files import LIST, TRACE, opened
from ..assumptions import Defect, Layout
from ..options import VECTOR, TraceOptions
from .columns import BILLION, COMMENT_SIGNS, UNITS_NS, Head, is_number
from .made_rows import maker_of
from .pose_messages import MAGICS as BAGS
from .pose_messages import table_of_bag

Array = NDArray[np.float64]
LOOK_BYTES = 256 * 1024
MOST_ROWS = 20_000_000  # of about 150 bytes each in memory
_SAMPLE_ROWS = 64
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?$")
_WHOLE = re.compile(r"[-+]?[0-9]+([eE][-+]?[0-9]+)?$")
_PLAIN = re.compile(r"[-+.,0-9eE]+$")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
_NO_TEXTS = {
    **dict.fromkeys((b"\xff\xfe", b"\xfe\xff"), "UTF-16 text: save it as UTF-8 (or plain ASCII)"),
    b"PK\x03\x04": "a ZIP archive: unpack it first",
    b"\x1f\x8b": "packed by gzip: unpack it first, as gunzip does",
}
_REPAIR = "; repair or remove that line"
_MATRIX_OFF = 0.05
# Angles within one turn are radians if they spread by half a degree, and degrees beyond two turns.
_TURN_RAD = 2 * math.pi
_TURNED_RAD = 0.5
_LONGEST_LINE = 1024 * 1024
_TOLD: dict[str, Any] = tomllib.loads(Path(__file__).with_name("cleaning.toml").read_text("utf-8"))
_WORDS = {"nan", "inf", "infinity", "null", "none"}
_FARTHEST = 1e9  # in the file's units: a position or component beyond this is no head's


def split(text: str, separator: str | None) -> list[str]:
    fields = map(str.strip, text.split(separator))
    return [f.strip('"').strip() for f in fields] if '"' in text else [*fields]


def read_head(path: Path) -> Head:
    """Inspect the file. Errors: TraceError for anything but a text of rows."""
    try:
        if path.is_dir():
            raise TraceError(f"{path} is a directory: expected a file of head poses")
        with opened(path, TRACE) as file:
            raw = file.read(LOOK_BYTES)
            if what := next((what for sign, what in _NO_TEXTS.items() if raw.startswith(sign)), ""):
                raise TraceError(f"{path} is {what}")
            made, maker = table_of_bag(path) if raw.startswith(BAGS) else None, maker_of(path, raw)
            if made is None and maker is not None:
                data = raw + file.read(LIST.most_bytes + 1)
                if len(data) > LIST.most_bytes:
                    raise TraceError(f"{path}: more than {LIST.most_bytes} bytes: expected fewer in a file of its kind")
                made = maker(path, data)
    except (OSError, ValueError) as error:
        raise TraceError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if made is not None and made.rows:
        return Head(path, made, ",", list(made.names), 1, 0, made.rows[:_SAMPLE_ROWS], [], False, "\n")
    if not raw.strip() or made is not None:
        raise TraceError(f"{path} is empty: expected rows of time, position and orientation")
    # Zeros at the very end are a file cut off by a crash; the rows before them may be good.
    if sign := _CONTROL.search(raw.rstrip(b"\x00") or raw):
        where = f"byte 0x{raw[sign.start()]:02x} in line {raw.count(bytes([10]), 0, sign.start()) + 1}"
        raise TraceError(f"{path} is no text: {where}; expected rows of numbers")
    newline = b"\n" if b"\n" in raw or b"\r" not in raw else b"\r"
    end = raw.rfind(newline) + 1 if len(raw) == LOOK_BYTES else len(raw)
    if not end:
        raise TraceError(f"{path}: line 1 is longer than {LOOK_BYTES // 1024} KiB: this is no table of head poses")
    return _head_of_text(path, raw[:end], newline)


def _head_of_text(path: Path, raw: bytes, newline: bytes) -> Head:
    offset = 3 if raw.startswith(b"\xef\xbb\xbf") else 0
    lines: list[tuple[int, int, str]] = []  # byte offset, number and text of the first rows
    comments: list[tuple[int, str]] = []  # before them
    header = ""
    for number, piece in enumerate(raw[offset:].split(newline), 1):
        bare = (text := piece.decode("utf-8", "replace").rstrip("\r\x00")).strip()
        if mark := next((mark for mark in COMMENT_SIGNS if bare.startswith(mark)), ""):
            comments += [] if lines else [(number, bare[len(mark) :].strip())]
        elif bare:  # the header, or a row
            fields = [f.strip('"([{') for f in re.split(r"[,;\t ]+", bare) if f]
            named = sum(1 for f in fields if f[:1].isalpha() and not is_number(f))
            if lines or header or named * 2 <= len(fields):
                lines.append((offset, number, text))
            else:
                header = bare
        offset += len(piece) + 1
        if len(lines) == _SAMPLE_ROWS:
            break
    if not lines:
        raise TraceError(f"{path} holds no rows of numbers, only {'a header' if header else 'comments'}")
    begins, first, text = lines[0]
    separator, comma = _separator(text.strip(), header)
    rows = [split(text, separator) for _, _, text in lines]
    # A comment names the columns if it has one word for each, none of them a number.
    said = (split(comment, separator) for _, comment in reversed(comments))
    fits = (f for f in said if len(f) == len(rows[0]) > 1 and not any(map(is_number, f)))
    names = split(header, separator) if header else next(fits, [])
    names = names[:-1] if len(names) > 1 and names[-1] == "" else names
    return Head(path, None, separator, names, first, begins, rows, comments, comma, newline.decode())


def _separator(row: str, header: str) -> tuple[str | None, bool]:
    """Return the separator, and whether numbers have a decimal comma."""

    def has_decimal_comma(fields: list[str]) -> bool:
        fields = [f.strip().strip('"') for f in fields if f.strip()]
        commas = any(_DECIMAL_COMMA.match(f) for f in fields)
        return commas and all(_DECIMAL_COMMA.match(f) or _WHOLE.match(f) or not is_number(f) for f in fields)

    for mark in ";\t":
        if mark in row and (mark == ";" or not all(f.endswith(",") for f in row.split(mark)[:-1])):
            return mark, has_decimal_comma(row.split(mark))
    blank = row.split()
    if "," in row and "," not in header and len(blank) >= 4 and has_decimal_comma(blank):
        return None, True
    return "," if "," in row else None, False


@attrs.frozen
class Segment:
    """One recording within a file."""

    number: int  # from 1
    first_line: int
    last_line: int
    rows: int
    duration_s: float
    taken: bool  # whether it was used


@attrs.define(eq=False)
class Recording:
    """The rows of a file on their way to a track, a column each, and what was found of them."""

    head: Head
    layout: Layout
    options: TraceOptions
    is_cut: bool  # the last line has no newline
    defects: list[Defect]
    stamps: Any  # (n), of `stamps_of`, until they are read as `time_ns`; none without a clock
    is_clock: bool  # they are written as HH:MM:SS, so in seconds
    line: NDArray[np.int32]  # (n)
    orientation: Array  # (n, 4)
    position: Array | None = None  # (n, 3)
    gaze: Array | None = None  # (n, 3 or 4)
    device: NDArray[np.bytes_] | None = None  # (n)
    time_ns: NDArray[np.int64] = attrs.field(factory=lambda: np.zeros(0, np.int64))  # (n)
    epoch_ns: int = 0
    unit: str = ""  # a key of UNITS_NS
    time_unit: str = ""  # in words
    taken: str = ""  # the device whose rows are kept
    segments: list[Segment] = attrs.field(factory=list)
    jumps: NDArray[np.int64] = attrs.field(factory=lambda: np.zeros(0, np.int64))
    axes: Any = None  # an axes.Axes, by the layout and the options
    shown: str = ""  # what the motion shows of them, in words

    def __len__(self) -> int:
        return len(self.line)

    def keep(self, which: NDArray[np.bool_] | slice) -> None:
        """Keep only these rows; one column at a time, to avoid a second copy of everything."""
        for name in ("orientation", "line", "stamps", "position", "gaze", "device", "time_ns"):
            if (column := getattr(self, name)) is not None and len(column):
                setattr(self, name, column[which])

    def found(self, kind: str, at: Sequence[int] | NDArray[np.integer] | None, *words: object) -> None:
        """Tell of a defect by cleaning.toml, and drop its rows if that says so. at: or None."""
        if at is None or len(at):
            told, (count, line) = _TOLD[kind], (1, None) if at is None else (len(at), int(self.line[at[0]]))
            text, done = told.get("text", "{}").format(*words), told["done"].format(*words)
            self.defects.append(Defect(kind, text, done, count, line))
            if told.get("drops"):
                kept = np.ones(len(self), bool)
                kept[at] = False
                self.keep(kept)


def read_rows(head: Head, layout: Layout, options: TraceOptions) -> Recording:
    """Return all rows of a file. Errors: TraceError naming file, line and field."""
    names, turns, has_time = head.names, len(layout.orientation), layout.time is not None
    columns = [*layout.orientation, *(layout.position or ()), *layout.gaze]
    defects = [*(() if head.made is None else head.made.defects), *layout.caveats]
    ended = all(r[-1] == "" for r in head.rows if len(r) == head.width)  # each row ends with a separator
    if names and head.width != len(names) and not (head.width == len(names) + 1 and ended):
        raise TraceError(f"{head.path}: line {head.first_line}: {_wrong_width(head, head.width, len(names))}")
    numbers, whole, parts, decimals, lines = array("d"), array("q"), array("q"), array("b"), array("i")
    devices, clock, bad, line, fields, is_cut = list[bytes](), False, 0, 0, list[str](), False
    first_bad: tuple[int, str] | None = None
    last_bad = 0, ""
    for line, fields, is_cut in _lines(head):  # noqa: B007 (the last one is looked at below)
        try:
            row, time, device = _parse_row(head, layout, columns, fields)
            parts.append(time[1])  # first, as it alone may be too large
            whole.append(time[0])
        except (ValueError, OverflowError) as error:
            bad, last_bad = bad + 1, (line, str(error))
            first_bad = first_bad or last_bad
            continue
        numbers.extend(row)
        clock |= time[2]
        decimals.append(time[3])
        lines.append(line)
        devices.append(device)
        if len(lines) > MOST_ROWS:
            raise TraceError(f"{head.path}: more than {MOST_ROWS:,} rows; expected fewer: cut it")
    # NaN and words are faults, not truncation.
    words = {word.lower().lstrip("+-") for field in fields for word in re.split("[, ]", field)}
    if last_bad[0] == line and not words & _WORDS:
        defects.append(Defect("last-row-cut", f"the last row is cut off ({last_bad[1]})", "dropped", 1, line))
        bad -= 1
    if bad and first_bad is not None:  # up to a share of rows without a pose are dropped; else it was misread
        (line, reason), rows = first_bad, bad + len(lines)
        if bad > options.lost_rows * rows:
            rest = f"; --lost-rows {math.ceil(100 * bad / rows) / 100:g} reads the others" if len(lines) > 1 else ""
            raise TraceError(f"{head.path}: line {line}: {reason} ({bad} of {rows} rows hold no pose{rest})")
        what = f"{bad} of {rows} rows hold no pose, the first in line {line} ({reason.removesuffix(_REPAIR)})"
        defects.append(Defect("row-without-pose", what, "dropped", bad, line))
    if not lines:
        why = f" ({defects[0]})" if defects else ""
        raise TraceError(f"{head.path} holds no usable row{why}")
    values = np.frombuffer(numbers).reshape(len(lines), -1)
    wholes, rests = np.frombuffer(whole, np.int64), np.frombuffer(parts, np.int64)
    if layout.rest is not None and rests.max() >= BILLION:  # a clock of its own
        wholes, rests = np.divmod(rests, BILLION)
    stamps = stamps_of(wholes, rests, np.array(decimals))
    return Recording(
        head, layout, options, is_cut, defects, stamps if has_time else stamps[:0], clock,
        np.array(lines), orientation=_quaternions(head.path, layout, values[:, :turns].copy(), defects),
        position=None if layout.position is None else values[:, turns : turns + 3].copy(),
        gaze=values[:, -len(layout.gaze) :].copy() if layout.gaze else None,
        device=None if layout.device is None else np.array(devices, np.bytes_),
    )  # fmt: skip


def _wrong_width(head: Head, found: int, wanted: int) -> str:
    what = f"{found} fields where {'the header names' if head.names else 'the first row has'} {wanted}"
    if head.separator == "," and found > wanted:
        return f"{what}: it looks like decimal commas inside a comma-separated file: write points, or separate by ';'"
    return f"{what}{_REPAIR}"


def _lines(head: Head) -> Iterator[tuple[int, list[str], bool]]:
    """Yield number and fields of each line with any, and whether the line has no end."""
    if head.made is not None:
        yield from ((number, [cell.strip() for cell in row], False) for number, row in enumerate(head.made.rows, 1))
        return
    with opened(head.path, TRACE) as file:
        file.seek(head.first_byte)
        text = io.TextIOWrapper(file, "utf-8", "replace", newline=head.newline)
        for number in itertools.count(head.first_line):
            if not (line := text.readline(_LONGEST_LINE + 1)):
                return
            if len(line) > _LONGEST_LINE:
                what = f"line {number} is longer than {_LONGEST_LINE // 1024} KiB"
                raise TraceError(f"{head.path}: {what}: this is no row of numbers")
            bare = line.strip(" \t\r\n\x00")
            if bare and not bare.startswith(COMMENT_SIGNS):
                yield number, split(line.strip(), head.separator), not line.endswith(head.newline)


def _parse_row(
    head: Head, layout: Layout, columns: Sequence[int], fields: list[str]
) -> tuple[list[float], tuple[int, int, bool, int], bytes]:
    """Return numbers, time and device of a row. Errors: ValueError."""
    comma, row = head.decimal_comma, []
    if len(fields) == head.width + 1 and fields[-1] == "":
        fields = fields[:-1]
    if len(fields) != head.width:
        raise ValueError(_wrong_width(head, len(fields), head.width))
    for column in columns:
        field = fields[column]
        try:  # float() takes 1_0 and digits of other scripts as well
            value = float(field.replace(",", ".") if comma else field) if _PLAIN.match(field) else math.nan
        except ValueError:
            value = math.nan
        if not abs(value) < _FARTHEST:
            shown = f"'{field[:40]}'" if field else "empty"
            raise ValueError(f"{head.name_of(column)} is {shown}: expected a finite number{_REPAIR}")
        row.append(value)
    time = (0, 0, False, 0)
    if layout.time is not None:
        field = fields[layout.time]
        try:
            rest = "" if layout.rest is None else fields[layout.rest]
            time = _parse_time(field.replace(",", ".") if comma else field)
            if rest:
                time = (time[0], time[1] + _parse_time(rest)[0] * UNITS_NS[layout.rest_unit], time[2], 10)
        except ValueError as error:
            raise ValueError(f"{head.name_of(layout.time)}: {error}{_REPAIR}") from None
    return row, time, b"" if layout.device is None else fields[layout.device].encode("utf-8", "replace")


def _quaternions(path: Path, layout: Layout, numbers: Array, defects: list[Defect]) -> Array:
    """Return (n, 4) quaternions xyzw; zeros for a matrix without a turn. Errors: TraceError."""
    euler = layout.euler
    if not layout.matrix and euler is None:
        return numbers
    from scipy.spatial.transform import Rotation

    if euler is not None:
        largest, spread = float(np.abs(numbers).max()), float(np.ptp(numbers, axis=0).max())
        fits = largest > _TURN_RAD if euler.degrees else largest < 2 * _TURN_RAD
        if not fits and spread >= _TURNED_RAD:  # the unit is not the one that they look like
            what = f"its angles, read as {'degrees' if euler.degrees else 'radians'}, reach {largest:.3g}"
            other = attrs.evolve(euler, degrees=not euler.degrees).words()
            defects.append(Defect("angles-implausible", what, f"kept; --euler {other} takes the other unit"))
        if euler.order == VECTOR:
            return np.asarray(Rotation.from_rotvec(numbers, degrees=euler.degrees).as_quat())
        return np.asarray(Rotation.from_euler(euler.order, numbers * euler.signs, degrees=euler.degrees).as_quat())
    matrices = numbers.reshape(-1, 3, 3)
    off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    turns = np.linalg.det(matrices)
    if np.median(off) > _MATRIX_OFF or np.median(turns) < 0:
        what = f"off by {np.median(off):.3g}, determinant {np.median(turns):.3g}"
        raise TraceError(f"{path}: half of its matrices are no rotations ({what}): were the wrong columns read?")
    out = np.zeros((len(matrices), 4))
    out[turns > 0.1] = Rotation.from_matrix(matrices[turns > 0.1]).as_quat()  # lost tracking writes zeros
    return out


LARGEST = 2**62
DAY_S = 86400
_DIGITS = re.compile(r"([0-9]{1,18})\.?((?<=\.)[0-9]{0,40}|)\Z")
_EXACT = decimal.Context(prec=60)
_UNIX_DAY = datetime.date(1970, 1, 1).toordinal()
_DATE = r"(?:[0-9]{4}[-/.][0-9][0-9]?[-/.][0-9][0-9]?|[0-9][0-9]?[-/.][0-9][0-9]?[-/.][0-9]{4})"
_CLOCK = re.compile(
    rf"(?:({_DATE})[T _])?([0-9]{{1,2}}):([0-9]{{1,2}}):([0-9]{{1,2}})(?:[.,:]([0-9]+))?(?: ?([AP])M)?"
    r"(?: ?(?:Z|(?:UTC|GMT)?(?:([+-])([0-9][0-9]):?([0-9][0-9])?)?))?$",
    re.IGNORECASE,
)


def stamps_of(*columns: NDArray[np.integer]) -> Any:
    """Return records in the file's unit: whole, billionths of one, how many decimals it has."""
    return np.rec.fromarrays(columns, np.dtype([("whole", "i8"), ("billionths", "i8"), ("decimals", "i1")]))


def steps_of(stamps: Any) -> Array:
    """Return (n - 1,) differences in the file's unit; exact wherever they are small."""
    return np.asarray(np.diff(stamps.whole) + np.diff(stamps.billionths) * 1e-9)


def _parse_time(text: str) -> tuple[int, int, bool, int]:
    """Return whole, billionths, whether it is a clock, decimals of a stamp. Errors: ValueError."""
    text = text.strip().strip('"').strip()
    if plain := _DIGITS.match(text):
        return int(plain[1]), int(plain[2][:9].ljust(9, "0")), False, min(len(plain[2]), 10)
    if ":" in text and (clock := _CLOCK.match(text)):
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
    try:
        value = decimal.Decimal(text if _PLAIN.match(text) else "nan")
        # Check the exponent before computing: int(Decimal("1e999999999")) would not end.
        if not value.is_finite() or value.adjusted() > 18:
            raise decimal.InvalidOperation
    except decimal.InvalidOperation:
        raise ValueError(f"'{text}' is no time") from None
    if value.adjusted() < -30:
        return 0, 0, False, 10
    whole = int(value.to_integral_value(decimal.ROUND_FLOOR))
    if abs(whole) >= LARGEST:
        raise ValueError(f"time '{text}' is beyond 2^62")
    digits = text.partition(".")[2]
    parts = int(_EXACT.multiply(_EXACT.subtract(value, whole), BILLION))
    return whole, parts, False, min(len(digits), 10) if digits.isdigit() or not digits else 10
