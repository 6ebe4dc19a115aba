"""From the text of a trace to columns of numbers: a first look at the file, then its rows.

A fast C parser reads chunk by chunk, a tolerant reader takes the chunks that it refuses: memory
stays at the size of the result plus one chunk. Every row keeps its line, for messages.
"""

from __future__ import annotations

import datetime
import decimal
import io
import itertools
import math
import os
import re
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError, counted
from ...options.named_files import LIST, TRACE, opened
from ..assumptions import Defect, Layout
from ..options import VECTOR, TraceOptions
from .header import COMMENT_SIGNS, Made, is_number
from .made_rows import MARK, cells_reader, export_reader, table_of_colmap, table_of_json
from .pose_messages import MAGIC, table_of_bag, table_of_mcap
from .pose_messages import MAGICS as BAGS

Array = NDArray[np.float64]
LOOK_BYTES = 256 * 1024
CHUNK_BYTES = 4 * 1024 * 1024
MOST_ROWS = 20_000_000  # of about 150 bytes each in memory
_SAMPLE_ROWS = 64
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?$")
_WHOLE = re.compile(r"[-+]?[0-9]+([eE][-+]?[0-9]+)?$")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
_ENDINGS = (".csv", ".txt", ".tum", ".mcap", ".bag", ".db3")
_NO_TEXTS = {
    b"\xff\xfe": "UTF-16 text: save it as UTF-8 (or plain ASCII)",
    b"\xfe\xff": "UTF-16 text: save it as UTF-8 (or plain ASCII)",
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
_STAMPS = ("whole", "billionths", "decimals")
_WORDS = {"nan", "inf", "infinity", "null", "none"}
_FARTHEST = 1e9  # in the file's units: a position or component beyond this is no head's


@attrs.frozen
class Head:
    """The findings from the first part of a trace file."""

    path: Path
    made: Made | None  # the rows that were made of what is no rows
    separator: str | None  # "," ";" "\t" or None for blanks
    names: list[str] | None  # the header's; a comment counts if it names as many columns as the rows have
    header_text: str
    first_line: int  # where the rows begin
    first_byte: int  # where the rows begin
    rows: list[list[str]]  # fields of the first rows
    comments: list[tuple[int, str]]  # (line, text without the comment sign) before the rows
    decimal_comma: bool  # numbers are written 0,5
    newline: bytes  # b"\n" or b"\r"

    @property
    def kind(self) -> str:
        """Of the rows: "text", or what they were made of, such as "json"."""
        return "text" if self.made is None else self.made.kind

    @property
    def width(self) -> int:
        """Fields in the first row."""
        return len(self.rows[0])

    def numbers(self, columns: tuple[int, ...], commas: bool = True) -> Array:
        """Return (n, columns) of those of the first rows that have a number in each."""
        rows = [[row[c] for c in columns] for row in self.rows if len(row) > max(columns)]
        rows = [[f.replace(",", ".") if commas else f for f in row] for row in rows]
        good = [row for row in rows if all(is_number(field) and "," not in field for field in row)]
        return np.array(good, dtype=np.float64).reshape(-1, len(columns))

    def column(self, name: str) -> int | None:
        return self.names.index(name) if self.names and name in self.names else None

    def name_of(self, column: int) -> str:
        """Return its name in the header, or its number."""
        return self.names[column] if self.names and column < len(self.names) else f"column {column + 1}"

    def describe(self) -> str:
        how = {None: "blank", ",": "comma", ";": "semicolon", "\t": "tab"}[self.separator]
        named = f"the columns {', '.join(self.names)}" if self.names else "no header"
        return f"{self.width} {how}-separated columns and {named if len(named) < 160 else named[:157] + '...'}"


def split(text: str, separator: str | None) -> list[str]:
    return [f.strip().strip('"').strip() for f in text.split(separator)]


def read_head(path: Path) -> Head:
    """Inspect the file. Errors: TraceError for anything but a text of rows."""
    try:
        if path.is_dir():
            found = sorted(p.name for p in path.iterdir() if p.suffix in _ENDINGS)
            inside = f", for instance {found[0]} in it" if found else ""
            raise TraceError(f"{path} is a directory: expected a file of head poses{inside}")
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
    newline = b"\n" if b"\n" in raw or b"\r" not in raw else b"\r"
    offset, end = 3 if raw.startswith(b"\xef\xbb\xbf") else 0, raw.rfind(newline) + 1 if more else len(raw)
    if not end:
        raise TraceError(f"{path}: line 1 is longer than {LOOK_BYTES // 1024} KiB: this is no table of head poses")
    lines: list[tuple[int, int, str]] = []  # byte offset, number and text of those that lie wholly in `raw`
    for number, piece in enumerate(raw[offset:end].split(newline), 1):
        lines.append((offset, number, piece.decode("utf-8", "replace").rstrip("\r\x00")))
        offset += len(piece) + 1
    names = list(made.names) if made is not None else []
    comments, header, (begins, line, text) = _preamble(path, lines, bool(names))
    separator, comma = _separator(text, header)
    texts = (t for _, _, t in lines if t.strip() and not t.lstrip().startswith(COMMENT_SIGNS))
    first = 1 if header else 0
    rows = [split(t, separator) for t in itertools.islice(texts, first, first + _SAMPLE_ROWS)]
    if header:
        names = split(header, separator)
    elif not names:
        # A comment names the columns if it has one word for each, none of them a number.
        said = (split(comment, separator) for _, comment in reversed(comments))
        fits = (f for f in said if len(f) == len(rows[0]) > 1 and not any(map(is_number, f)))
        names = next(fits, [])
    names = names[:-1] if len(names) > 1 and names[-1] == "" else names
    return Head(path, made, separator, names or None, header or "", line, begins, rows, comments, comma, newline)


def _text_of(path: Path, made: Made | None) -> BinaryIO:
    """Open the text of the rows. Errors: OSError."""
    return opened(path, TRACE) if made is None else io.BytesIO(made.text)


def _made(path: Path, start: bytes, file: BinaryIO) -> Made | None:
    """Return the table that a file's rows are made into, None where they are rows as they are."""

    def whole() -> bytes:
        data = file.read(LIST.most_bytes + 1)
        if len(data) > LIST.most_bytes:
            raise TraceError(f"{path}: more than {LIST.most_bytes} bytes: expected fewer in a file of its kind")
        return data

    if start.startswith(MAGIC):
        return table_of_mcap(path, file, os.fstat(file.fileno()).st_size)
    if start.startswith(BAGS):
        return table_of_bag(path)
    if start.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"["):
        return table_of_json(path, whole())
    if MARK in start[:200]:
        return table_of_colmap(path, whole())
    reader = export_reader(path, start) or cells_reader(start)
    return None if reader is None else reader(path, whole().decode("utf-8-sig", "replace"))


def _preamble(
    path: Path, lines: list[tuple[int, int, str]], named: bool
) -> tuple[list[tuple[int, str]], str, tuple[int, int, str]]:
    """Return comments, the header line or "" (columns that are named have none), the first row."""
    comments: list[tuple[int, str]] = []
    header = ""
    for offset, number, text in lines:
        bare = text.strip()
        sign = next((s for s in COMMENT_SIGNS if bare.startswith(s)), None)
        if sign:
            comments.append((number, bare[len(sign) :].strip()))
        elif bare:
            fields = [f.strip('"([{') for f in re.split(r"[,;\t ]+", bare) if f]
            words = sum(1 for f in fields if f[:1].isalpha() and not is_number(f))
            if header or named or words * 2 <= len(fields):
                return comments, header, (offset, number, bare)
            header = bare
    raise TraceError(f"{path} holds no rows of numbers, only {'a header' if header else 'comments'}")


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
    wrap: str = ""  # where the clock begins again, in words
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


# Of a chunk: its numbers, a column each of those that are read, lines, devices and times.
_Piece = tuple[Array, NDArray[np.int32], Any, Any]


class RowReader:
    """Reads the rows of one file."""

    def __init__(self, head: Head, layout: Layout, options: TraceOptions) -> None:
        self.head, self.layout, self.options = head, layout, options
        self.defects: list[Defect] = [*(() if head.made is None else head.made.defects), *layout.caveats]
        self._is_cut = False
        self._repeated_headers: list[int] = []
        self._bad_rows = 0
        self._first_bad: tuple[int, str] | None = None
        self._columns = [*layout.orientation, *(layout.position or ()), *layout.gaze]
        self._width = head.width

    def read(self) -> Recording:
        """Return all rows. Errors: TraceError naming file, line and field."""
        names, head = self.head.names, self.head
        ended = all(r[-1] == "" for r in head.rows if len(r) == self._width)  # each row ends with a separator
        if names and self._width != len(names) and not (self._width == len(names) + 1 and ended):
            what = self._wrong_width(self._width, len(names))
            if len(head.rows) == 1 and self._width < len(names):
                what = f"the only row ends after {self._width} of {len(names)} fields; it was cut off"
            raise TraceError(f"{head.path}: line {head.first_line}: {what}")
        count, pieces = 0, list[_Piece]()
        for text, first, lines, is_last in self._chunks():
            pieces.append(self._read_fast(text, first, lines) or self._read_slowly(text, first, is_last))
            count += len(pieces[-1][0])
            if count > MOST_ROWS:
                raise TraceError(f"{head.path}: more than {MOST_ROWS:,} rows; expected fewer: cut it")
        if again := self._repeated_headers:
            what = f"the header comes again {counted(len(again), 'time')}"
            self.defects.append(Defect("header-repeated", what, "skipped", len(again), again[0]))
        if self._first_bad is not None:  # up to a share of rows without a pose are dropped; else it was misread
            (line, reason), bad, rows = self._first_bad, self._bad_rows, self._bad_rows + count
            if bad > self.options.lost_rows * rows:
                rest = f"; --lost-rows {math.ceil(100 * bad / rows) / 100:g} reads the others" if count > 1 else ""
                raise TraceError(f"{head.path}: line {line}: {reason} ({bad} of {rows} rows hold no pose{rest})")
            what = f"{bad} of {rows} rows hold no pose, the first in line {line} ({reason.removesuffix(_REPAIR)})"
            self.defects.append(Defect("row-without-pose", what, "dropped", bad, line))
        if not count:
            cut = f" ({self.defects[0]})" if self.defects else ""
            raise TraceError(f"{head.path} holds no usable row{cut}")
        layout, turns = self.layout, len(self.layout.orientation)
        values, numbers = np.concatenate([piece[0] for piece in pieces]), np.concatenate([piece[1] for piece in pieces])
        device = None if layout.device is None else np.concatenate([piece[2] for piece in pieces])
        stamps = [piece[3] for piece in pieces]
        pieces.clear()  # before the columns are copied
        whole, parts, decimals = (np.concatenate([getattr(one, part) for one in stamps]) for part in _STAMPS)
        if layout.rest is not None and parts.max(initial=0) >= BILLION:  # a clock of its own
            whole, parts = np.divmod(parts, BILLION)
        return Recording(
            head, layout, self.options, self._is_cut, self.defects,
            Stamps(whole, parts, any(one.clock for one in stamps), decimals), numbers,
            orientation=self._quaternions(values[:, :turns].copy()),
            position=None if layout.position is None else values[:, turns : turns + 3].copy(),
            gaze=values[:, -len(layout.gaze) :].copy() if layout.gaze else None, device=device,
        )  # fmt: skip

    def _wrong_width(self, found: int, wanted: int) -> str:
        what = f"{found} fields where {'the header names' if self.head.names else 'the first row has'} {wanted}"
        if self.head.separator == "," and found > wanted:
            what += ": it looks like decimal commas inside a comma-separated file, which cannot be told apart"
            return f"{what}; write decimal points, or separate the fields with ';'"
        return f"{what}{_REPAIR}"

    def _chunks(self) -> Iterator[tuple[bytes, int, int, bool]]:
        """Yield pieces of whole lines: text, its first line, how many, whether it is the last."""
        line, rest = self.head.first_line, b""
        with _text_of(self.head.path, self.head.made) as file:
            file.seek(self.head.first_byte)
            following = file.read(CHUNK_BYTES)
            while following:
                block, following = following, file.read(CHUNK_BYTES)
                text = rest + (block.replace(b"\r", b"\n") if self.head.newline == b"\r" else block)
                cut = text.rfind(b"\n") + 1
                if not cut and len(text) > _LONGEST_LINE:
                    what = f"line {line} is longer than {_LONGEST_LINE // 1024} KiB"
                    raise TraceError(f"{self.head.path}: {what}: this is no row of numbers")
                rest = text[cut:]
                if cut:
                    count = text.count(b"\n", 0, cut)
                    yield text[:cut], line, count, not rest and not following
                    line += count
        if rest.strip():
            self._is_cut = True
            yield rest, line, 1, True

    def _read_fast(self, text: bytes, line: int, count: int) -> _Piece | None:
        """Parse the whole chunk by numpy's C parser; return None for anything unusual."""
        layout, texts = self.layout, {}
        if layout.rest is not None or b'"' in text:
            return None
        # A field for every column, of one byte where it is not read: other rows are refused.
        kinds: dict[int, Any] = dict.fromkeys(range(self._width), "S1") | dict.fromkeys(self._columns, np.float64)
        kinds |= {column: f"S{WIDTH}" for column in (layout.time, layout.device) if column is not None}
        text = text.replace(b",", b".") if self.head.decimal_comma else text
        how: dict[str, Any] = {"comments": None, "ndmin": 1, "encoding": "latin-1", "delimiter": self.head.separator}
        try:
            table = np.loadtxt(io.BytesIO(text), [(f"c{column}", kind) for column, kind in kinds.items()], **how)
            values = np.column_stack([table[f"c{column}"].astype(np.float64) for column in self._columns])
            # min and max are NaN if anything is
            if len(table) != count or not -_FARTHEST < values.min() <= values.max() < _FARTHEST:
                return None
            for column in {layout.time, layout.device} - {None}:
                field = np.ascontiguousarray(table[f"c{column}"])
                if field.view(np.uint8).reshape(count, -1)[:, -1].any():
                    return None  # longer than what is kept of it
                texts[column] = np.strings.strip(field)
            stamps: Stamps | None = _stamps_of([])
            if layout.time is not None and (stamps := _parse_plain(texts[layout.time])) is None:
                stamps = _stamps_of([_parse_one(one.decode("latin-1")) for one in texts[layout.time].tolist()])
        except (ValueError, OverflowError):
            return None
        return values, np.arange(line, line + count, dtype=np.int32), texts.get(layout.device), stamps

    def _read_slowly(self, chunk: bytes, line: int, is_last: bool) -> _Piece:
        """Parse line by line, skip what is no row, drop a cut last line, count other bad ones."""
        lines = enumerate(chunk.decode("utf-8", "replace").split("\n"), line)
        found = [(number, t.strip()) for number, t in lines if t.strip(" \t\r\x00")]
        rows: list[tuple[int, list[float], tuple[int, int, bool, int], bytes]] = []
        for number, bare in found:
            if bare.startswith(COMMENT_SIGNS):
                continue
            if bare == self.head.header_text:
                self._repeated_headers.append(number)
                continue
            try:
                rows.append((number, *self._parse_line(bare)))
            except ValueError as error:
                # NaN and words are faults, not truncation.
                words = {f.lower().lstrip("+-") for field in split(bare, None) for f in field.split(",")}
                if is_last and number == found[-1][0] and not words & _WORDS:
                    what = f"the last row is cut off ({error})"
                    self.defects.append(Defect("last-row-cut", what, "dropped", 1, number))
                else:
                    self._bad_rows += 1
                    self._first_bad = self._first_bad or (number, str(error))
        values = np.array([row[1] for row in rows], np.float64).reshape(len(rows), len(self._columns))
        stamps = _stamps_of([row[2] for row in rows if self.layout.time is not None])
        devices = np.array([row[3] for row in rows], np.bytes_)
        return values, np.array([row[0] for row in rows], np.int32), devices, stamps

    def _parse_line(self, text: str) -> tuple[list[float], tuple[int, int, bool, int], bytes]:
        layout, fields = self.layout, split(text, self.head.separator)
        if len(fields) == self._width + 1 and fields[-1] == "":
            fields.pop()
        if len(fields) != self._width:
            raise ValueError(self._wrong_width(len(fields), self._width))
        row = []
        for column in self._columns:
            field, value = fields[column], math.nan
            if is_number(field) and (self.head.decimal_comma or "," not in field):
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
                time = _parse_one(dated + (field.replace(",", ".") if self.head.decimal_comma else field))
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
        parts = f"{int(self.billionths[0]):09d}".rstrip("0")
        return f"{int(self.whole[0])}{'.' if parts else ''}{parts}"

    def steps(self) -> NDArray[np.float64]:
        """(n - 1,) differences in the file's unit; exact wherever they are small."""
        return np.diff(self.whole) + np.diff(self.billionths) * 1e-9


def _stamps_of(parsed: list[tuple[int, int, bool, int]]) -> Stamps:
    whole, parts, decimals = (np.array([stamp[k] for stamp in parsed], dtype=np.int64) for k in (0, 1, 3))
    return Stamps(whole, parts, any(stamp[2] for stamp in parsed), decimals.astype(np.int8))


def _parse_one(text: str) -> tuple[int, int, bool, int]:
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
