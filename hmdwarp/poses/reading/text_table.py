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
from typing import Any, BinaryIO

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import TraceError
from ...base.named_files import LIST, TRACE, opened
from ..assumptions import Defect, Layout
from ..options import VECTOR, TraceOptions
from .columns import BILLION, COMMENT_SIGNS, DATE, UNITS_NS, Head, Made, is_number
from .made_rows import MARK, cells_reader, export_reader, table_of_colmap, table_of_json
from .pose_messages import MAGICS as BAGS
from .pose_messages import table_of_bag

Array = NDArray[np.float64]
LOOK_BYTES = 256 * 1024
MOST_ROWS = 20_000_000  # of about 150 bytes each in memory
_SAMPLE_ROWS = 64
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?$")
_WHOLE = re.compile(r"[-+]?[0-9]+([eE][-+]?[0-9]+)?$")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
_NO_TEXTS = {
    **dict.fromkeys((b"\xff\xfe", b"\xfe\xff"), "UTF-16 text: save it as UTF-8 (or plain ASCII)"),
    b"PK\x03\x04": "a ZIP archive: unpack it first",
    b"\x1f\x8b": "packed by gzip: unpack it first, as gunzip does",
}
_REPAIR = "; repair or remove that line"
_MATRIX_OFF = 0.05
# Angles within one turn are radians if they spread, by half a degree; beyond two turns they are
# degrees.
_TURN_RAD = 2 * math.pi
_TURNED_RAD = 0.5
_LONGEST_LINE = 1024 * 1024
_TOLD: dict[str, Any] = tomllib.loads(Path(__file__).with_name("cleaning.toml").read_text("utf-8"))
_WORDS = {"nan", "inf", "infinity", "null", "none"}
_FARTHEST = 1e9  # in the file's units: a position or component beyond this is no head's


def split(text: str, separator: str | None) -> list[str]:
    quoted = '"' in text
    return [f.strip().strip('"').strip() if quoted else f.strip() for f in text.split(separator)]


def read_head(path: Path) -> Head:
    """Inspect the file. Errors: TraceError for anything but a text of rows."""
    made, raw, more = _start_of(path)
    newline = b"\n" if b"\n" in raw or b"\r" not in raw else b"\r"
    offset, end = 3 if raw.startswith(b"\xef\xbb\xbf") else 0, raw.rfind(newline) + 1 if more else len(raw)
    if not end:
        raise TraceError(f"{path}: line 1 is longer than {LOOK_BYTES // 1024} KiB: this is no table of head poses")
    lines: list[tuple[int, int, str]] = []  # byte offset, number and text of those that lie wholly in `raw`
    for number, piece in enumerate(raw[offset:end].split(newline), 1):
        lines.append((offset, number, piece.decode("utf-8", "replace").rstrip("\r\x00")))
        offset += len(piece) + 1
    names, header, first = list(made.names) if made is not None else [], "", None
    comments: list[tuple[int, str]] = []
    for begins, line, text in lines:
        bare = text.strip()
        if sign := next((s for s in COMMENT_SIGNS if bare.startswith(s)), ""):
            comments.append((line, bare[len(sign) :].strip()))
        elif bare:  # the header, or the first row; columns that are named already have no header
            fields = [f.strip('"([{') for f in re.split(r"[,;\t ]+", bare) if f]
            named = sum(1 for f in fields if f[:1].isalpha() and not is_number(f))
            if header or names or named * 2 <= len(fields):
                first = begins, line, bare
                break
            header = bare
    if first is None:
        raise TraceError(f"{path} holds no rows of numbers, only {'a header' if header else 'comments'}")
    separator, comma = _separator(first[2], header)
    texts = (t for _, _, t in lines if t.strip() and not t.lstrip().startswith(COMMENT_SIGNS))
    skipped = 1 if header else 0
    rows = [split(t, separator) for t in itertools.islice(texts, skipped, skipped + _SAMPLE_ROWS)]
    if header:
        names = split(header, separator)
    elif not names:
        # A comment names the columns if it has one word for each, none of them a number.
        said = (split(comment, separator) for _, comment in reversed(comments))
        fits = (f for f in said if len(f) == len(rows[0]) > 1 and not any(map(is_number, f)))
        names = next(fits, [])
    names = names[:-1] if len(names) > 1 and names[-1] == "" else names
    return Head(path, made, separator, names, first[1], first[0], rows, comments, comma, newline.decode())


def _start_of(path: Path) -> tuple[Made | None, bytes, bool]:
    """Return the table that a file is made into, its first bytes, and whether there are more."""
    try:
        if path.is_dir():
            raise TraceError(f"{path} is a directory: expected a file of head poses")
        with opened(path, TRACE) as file:
            start = file.read(LOOK_BYTES)
            if what := next((what for sign, what in _NO_TEXTS.items() if start.startswith(sign)), ""):
                raise TraceError(f"{path} is {what}")
            file.seek(0)
            made = _made(path, start, file)
        with _text_of(path, made) as file:
            raw, more = file.read(LOOK_BYTES), bool(file.read(1))
    except (OSError, ValueError) as error:
        raise TraceError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not raw.strip():
        raise TraceError(f"{path} is empty: expected rows of time, position and orientation")
    # Zeros at the very end are a file cut off by a crash; the rows before them may be good.
    found_sign = _CONTROL.search(raw.rstrip(b"\x00"))
    if found_sign or not raw.rstrip(b"\x00"):
        at = found_sign.start() if found_sign else 0
        where = f"byte 0x{raw[at]:02x} in line {raw.count(bytes([10]), 0, at) + 1}"
        raise TraceError(f"{path} is no text: {where}; expected rows of numbers")
    return made, raw, more


def _text_of(path: Path, made: Made | None) -> BinaryIO:
    """Open the text of the rows. Errors: OSError."""
    return opened(path, TRACE) if made is None else io.BytesIO(made.text)


def _made(path: Path, start: bytes, file: BinaryIO) -> Made | None:
    """Return the table that a file's rows are made into, None where they are rows as they are."""
    if start.startswith(BAGS):
        return table_of_bag(path)
    is_json = start.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"[")
    reader = export_reader(path, start) or cells_reader(start)
    if not is_json and MARK not in start[:200] and reader is None:
        return None
    data = file.read(LIST.most_bytes + 1)
    if len(data) > LIST.most_bytes:
        raise TraceError(f"{path}: more than {LIST.most_bytes} bytes: expected fewer in a file of its kind")
    if is_json:
        return table_of_json(path, data)
    if MARK in start[:200]:
        return table_of_colmap(path, data)
    return reader(path, data.decode("utf-8-sig", "replace")) if reader else None


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
    stamps: Stamps  # (n), until they are read as `time_ns`; none in a file without a clock
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
    judged: Any = None  # its axes, by axes.JudgedAxes

    def __len__(self) -> int:
        return len(self.line)

    @property
    def where(self) -> str:
        return str(self.head.path)

    def keep(self, which: NDArray[np.bool_] | slice) -> None:
        """Keep only these rows; one column at a time, to avoid a second copy of everything."""
        for name in ("orientation", "line", "stamps", "position", "gaze", "device", "time_ns"):
            if (column := getattr(self, name)) is not None and len(column):
                setattr(self, name, column[which])

    def note(self, kind: str, what: str, done: str, at: Sequence[int] | NDArray[np.integer] | None = None) -> None:
        """Record a defect and its repair. at: the rows concerned."""
        count, line = (1, None) if at is None else (len(at), int(self.line[at[0]]))
        self.defects.append(Defect(kind, what, done, count, line))

    def found(self, kind: str, at: Sequence[int] | NDArray[np.integer] | None, *words: object) -> None:
        """Tell of a defect by cleaning.toml, and drop its rows if that says so. at: or None."""
        if at is None or len(at):
            told = _TOLD[kind]
            self.note(kind, told.get("text", "{}").format(*words), told["done"].format(*words), at)
            if told.get("drops"):
                kept = np.ones(len(self), bool)
                kept[at] = False
                self.keep(kept)


class RowReader:
    """Reads the rows of one file."""

    def __init__(self, head: Head, layout: Layout, options: TraceOptions) -> None:
        self.head, self.layout, self.options = head, layout, options
        self.defects: list[Defect] = [*(() if head.made is None else head.made.defects), *layout.caveats]
        self._columns = [*layout.orientation, *(layout.position or ()), *layout.gaze]
        self._width, self._is_cut = head.width, False

    def read(self) -> Recording:
        """Return all rows. Errors: TraceError naming file, line and field."""
        names, head, layout, turns = self.head.names, self.head, self.layout, len(self.layout.orientation)
        ended = all(r[-1] == "" for r in head.rows if len(r) == self._width)  # each row ends with a separator
        if names and self._width != len(names) and not (self._width == len(names) + 1 and ended):
            raise TraceError(f"{head.path}: line {head.first_line}: {self._wrong_width(self._width, len(names))}")
        numbers, whole, parts, decimals, lines = array("d"), array("q"), array("q"), array("b"), array("i")
        devices, clock, bad = list[bytes](), False, 0
        first_bad: tuple[int, str] | None = None
        cut: tuple[int, str] | None = None
        for line, text in self._lines():
            if cut is not None:  # it was not the last row
                bad, first_bad, cut = bad + 1, first_bad or cut, None
            try:
                row, time, device = self._parse_line(text)
                parts.append(time[1])  # first, as it alone may be too large
                whole.append(time[0])
                numbers.extend(row)
            except (ValueError, OverflowError) as error:
                # NaN and words are faults, not truncation.
                words = {f.lower().lstrip("+-") for field in split(text, None) for f in field.split(",")}
                if words & _WORDS:
                    bad, first_bad = bad + 1, first_bad or (line, str(error))
                else:
                    cut = line, str(error)
                continue
            clock |= time[2]
            decimals.append(time[3])
            lines.append(line)
            devices.append(device)
            if len(lines) > MOST_ROWS:
                raise TraceError(f"{head.path}: more than {MOST_ROWS:,} rows; expected fewer: cut it")
        if cut is not None:
            self.defects.append(Defect("last-row-cut", f"the last row is cut off ({cut[1]})", "dropped", 1, cut[0]))
        if first_bad is not None:  # up to a share of rows without a pose are dropped; else it was misread
            (line, reason), rows = first_bad, bad + len(lines)
            if bad > self.options.lost_rows * rows:
                rest = f"; --lost-rows {math.ceil(100 * bad / rows) / 100:g} reads the others" if len(lines) > 1 else ""
                raise TraceError(f"{head.path}: line {line}: {reason} ({bad} of {rows} rows hold no pose{rest})")
            what = f"{bad} of {rows} rows hold no pose, the first in line {line} ({reason.removesuffix(_REPAIR)})"
            self.defects.append(Defect("row-without-pose", what, "dropped", bad, line))
        if not lines:
            why = f" ({self.defects[0]})" if self.defects else ""
            raise TraceError(f"{head.path} holds no usable row{why}")
        values = np.frombuffer(numbers).reshape(len(lines), -1)
        wholes, rests = np.frombuffer(whole, np.int64), np.frombuffer(parts, np.int64)
        if layout.rest is not None and rests.max() >= BILLION:  # a clock of its own
            wholes, rests = np.divmod(rests, BILLION)
        stamps = Stamps(wholes, rests, clock, np.array(decimals))
        return Recording(
            head, layout, self.options, self._is_cut, self.defects, stamps if layout.time is not None else stamps[:0],
            np.array(lines), orientation=self._quaternions(values[:, :turns].copy()),
            position=None if layout.position is None else values[:, turns : turns + 3].copy(),
            gaze=values[:, -len(layout.gaze) :].copy() if layout.gaze else None,
            device=None if layout.device is None else np.array(devices, np.bytes_),
        )  # fmt: skip

    def _wrong_width(self, found: int, wanted: int) -> str:
        what = f"{found} fields where {'the header names' if self.head.names else 'the first row has'} {wanted}"
        if self.head.separator == "," and found > wanted:
            what += ": it looks like decimal commas inside a comma-separated file, which cannot be told apart"
            return f"{what}; write decimal points, or separate the fields with ';'"
        return f"{what}{_REPAIR}"

    def _lines(self) -> Iterator[tuple[int, str]]:
        """Yield number and text of each line but remarks and empty ones."""
        newline = self.head.newline
        with _text_of(self.head.path, self.head.made) as file:
            file.seek(self.head.first_byte)
            text = io.TextIOWrapper(file, "utf-8", "replace", newline=newline)
            for number in itertools.count(self.head.first_line):
                if not (line := text.readline(_LONGEST_LINE + 1)):
                    return
                if len(line) > _LONGEST_LINE:
                    what = f"line {number} is longer than {_LONGEST_LINE // 1024} KiB"
                    raise TraceError(f"{self.head.path}: {what}: this is no row of numbers")
                bare = line.strip(" \t\r\n\x00")
                if bare and not bare.startswith(COMMENT_SIGNS):
                    self._is_cut = not line.endswith(newline)
                    yield number, line.strip()

    def _parse_line(self, text: str) -> tuple[list[float], tuple[int, int, bool, int], bytes]:
        """Return numbers, time and device of a row. Errors: ValueError."""
        layout, comma = self.layout, self.head.decimal_comma
        fields = split(text, self.head.separator)
        if len(fields) == self._width + 1 and fields[-1] == "":
            fields.pop()
        if len(fields) != self._width:
            raise ValueError(self._wrong_width(len(fields), self._width))
        try:  # what float() takes and is_number does not: 1_0, and digits of other scripts
            row = [float(fields[column]) for column in self._columns] if "_" not in text and text.isascii() else []
        except ValueError:
            row = []
        if not row or not all(-_FARTHEST < value < _FARTHEST for value in row):
            row = []
            for column in self._columns:
                field, value = fields[column], math.nan
                if is_number(field) and (comma or "," not in field):
                    value = float(field.replace(",", "."))
                if not abs(value) < _FARTHEST:
                    shown = f"'{field[:40]}'" if field else "empty"
                    raise ValueError(f"{self.head.name_of(column)} is {shown}: expected a finite number{_REPAIR}")
                row.append(value)
        time = (0, 0, False, 0)
        if layout.time is not None:
            field = fields[layout.time]
            try:
                rest = "" if layout.rest is None else fields[layout.rest]
                dated = f"{rest} " if layout.rest_unit == "date" else ""
                time = _parse_one(dated + (field.replace(",", ".") if comma else field))
                if rest and not dated:
                    time = (time[0], time[1] + _parse_one(rest)[0] * UNITS_NS[layout.rest_unit], time[2], 10)
            except ValueError as error:
                raise ValueError(f"{self.head.name_of(layout.time)}: {error}{_REPAIR}") from None
        return row, time, b"" if layout.device is None else fields[layout.device].encode("utf-8", "replace")

    def _quaternions(self, numbers: Array) -> Array:
        """Return (n, 4) quaternions xyzw; zeros for a matrix without a turn. Errors: TraceError."""
        euler = self.layout.euler
        if not self.layout.matrix and euler is None:
            return numbers
        from scipy.spatial.transform import Rotation

        if euler is not None:
            largest, spread = float(np.abs(numbers).max()), float(np.ptp(numbers, axis=0).max())
            fits = largest > _TURN_RAD if euler.degrees else largest < 2 * _TURN_RAD
            if not fits and spread >= _TURNED_RAD:  # the unit is not the one that they look like
                what = f"its angles, read as {'degrees' if euler.degrees else 'radians'}, reach {largest:.3g}"
                other = attrs.evolve(euler, degrees=not euler.degrees).words()
                remedy = f"kept; --euler {other} takes the other unit"
                self.defects.append(Defect("angles-implausible", what, remedy))
            if euler.order == VECTOR:
                return np.asarray(Rotation.from_rotvec(numbers, degrees=euler.degrees).as_quat())
            return np.asarray(Rotation.from_euler(euler.order, numbers * euler.signs, degrees=euler.degrees).as_quat())
        matrices = numbers.reshape(-1, 3, 3)
        off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        turns = np.linalg.det(matrices)
        if np.median(off) > _MATRIX_OFF or np.median(turns) < 0:
            what = f"off by {np.median(off):.3g}, determinant {np.median(turns):.3g}"
            where, why = self.head.path, "were the wrong columns read?"
            raise TraceError(f"{where}: half of its matrices are no rotations ({what}): {why}")
        out = np.zeros((len(matrices), 4))
        out[turns > 0.1] = Rotation.from_matrix(matrices[turns > 0.1]).as_quat()  # lost tracking writes zeros
        return out


LARGEST = 2**62
DAY_S = 86400
_UNIX_DAY = datetime.date(1970, 1, 1).toordinal()
_CLOCK = re.compile(
    rf"(?:({DATE.pattern[:-1]})[T _])?([0-9]{{1,2}}):([0-9]{{1,2}}):([0-9]{{1,2}})(?:[.,:]([0-9]+))?(?: ?([AP])M)?"
    r"(?: ?(?:Z|(?:UTC|GMT)?(?:([+-])([0-9][0-9]):?([0-9][0-9])?)?))?$",
    re.IGNORECASE,
)


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

    def steps(self) -> NDArray[np.float64]:
        """(n - 1,) differences in the file's unit; exact wherever they are small."""
        return np.diff(self.whole) + np.diff(self.billionths) * 1e-9


def _parse_one(text: str) -> tuple[int, int, bool, int]:
    """Return whole, billionths, whether it is a clock, decimals of a stamp. Errors: ValueError."""
    text = text.strip().strip('"').strip()
    ahead, _, digits = text.partition(".")
    if (
        ahead.isascii()
        and ahead.isdigit()
        and len(ahead) < 19
        and (not digits or digits.isascii() and digits.isdigit())
    ):
        return int(ahead), int(digits[:9].ljust(9, "0")), False, min(len(digits), 10)
    if clock := _CLOCK.match(text):
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
    return whole, parts, False, min(len(digits), 10) if digits.isdigit() or not digits else 10
