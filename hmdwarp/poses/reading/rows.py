"""From the text of a trace to columns of numbers.

A fast C parser reads chunk by chunk, and a tolerant reader takes the chunks that it refuses. Memory
stays at the size of the result plus one chunk. Every row keeps the number of its line, for
messages.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError, counted
from ..assumptions import Defect, Layout
from ..options import AXIS_ANGLE, VECTOR, Euler
from .file_head import COMMENT_SIGNS, Head, is_number, split
from .times import BILLION, UNITS_NS, WIDTH, Stamps, parse_fields, parse_one, stamps_of

Numbers = NDArray[np.float64]
MOST_ROWS = 20_000_000  # of about 150 bytes each in memory
CHUNK_BYTES = 4 * 1024 * 1024
_REPAIR = "; repair or remove that line"
_MATRIX_OFF = 0.05
# Angles within one turn are radians if they spread, by half a degree; beyond two turns they are
# degrees.
_TURN_RAD = 2 * math.pi
_TURNED_RAD = 0.5
_LONGEST_LINE = 1024 * 1024
_WORDS = {"nan", "inf", "infinity", "null", "none"}
_FARTHEST = 1e9  # in the file's units: a position or component beyond this is no head's


@attrs.define
class Rows:
    """The numbers of a file."""

    stamps: Stamps | None  # (n)
    orientation: NDArray[np.float64]  # (n, 4)
    position: NDArray[np.float64] | None  # (n, 3)
    device: NDArray[np.bytes_] | None  # (n)
    line: NDArray[np.int32]  # (n)
    gaze: NDArray[np.float64] | None = None  # (n, 3 or 4)

    def __len__(self) -> int:
        return len(self.line)

    def keep(self, which: NDArray[np.bool_] | slice) -> None:
        """Keep only these rows; one column at a time, to avoid a second copy of everything."""
        for name in ("orientation", "line", "stamps", "position", "gaze", "device"):
            if (column := getattr(self, name)) is not None:
                setattr(self, name, column[which])


@attrs.define
class _Chunk:
    text: bytes
    line: int
    count: int
    last: bool


class RowReader:
    """Reads the rows of one file."""

    def __init__(self, head: Head, layout: Layout, most_lost: float) -> None:
        self.head, self.layout = head, layout
        self._most_lost = most_lost  # share of rows without a pose that may be dropped
        self.defects: list[Defect] = []
        self.ends_with_newline = True
        self._repeated_headers: list[int] = []
        self._bad_rows = 0
        self._first_bad: tuple[int, TraceError] | None = None
        self._columns = [*layout.orientation, *(layout.position or ()), *layout.gaze]
        self._width = head.width
        names = head.names or []
        self._names = {c: names[c] if c < len(names) else f"column {c + 1}" for c in range(self._width)}

    def read(self) -> Rows:
        """Return all rows. Errors: TraceError naming file, line and field."""
        names, head = self.head.names, self.head
        ended = all(r[-1] == "" for r in head.rows if len(r) == self._width)  # each row ends with a separator
        if not (names is None or self._width == len(names) or (self._width == len(names) + 1 and ended)):
            where = f"{head.path}: line {head.first_line}"
            if len(head.rows) == 1 and self._width < len(names):
                cut = f"the only row ends after {self._width} of {len(names)} fields; it was cut off"
                raise TraceError(f"{where}: {cut}")
            raise self._wrong_width(where, self._width, len(names))
        parts: list[Rows] = []
        left = MOST_ROWS
        for chunk in self._chunks():
            rows = self._read_fast(chunk)
            parts.append(rows if rows is not None else self._read_slowly(chunk))
            if (left := left - len(parts[-1])) < 0:
                raise TraceError(f"{self.head.path}: more than {MOST_ROWS:,} rows; expected fewer: cut it")
        if self._repeated_headers:
            lines = self._repeated_headers
            what = f"the header comes again {counted(len(lines), 'time')}"
            self.defects.append(Defect("header-repeated", what, "skipped", len(lines), lines[0]))
        self._judge_bad_rows(sum(map(len, parts)))
        return self._joined(parts)

    def _judge_bad_rows(self, good: int) -> None:
        """Drop up to a share of rows without a pose; else the file was misread: TraceError."""
        if self._first_bad is None:
            return
        line, error = self._first_bad
        count, rows = self._bad_rows, self._bad_rows + good
        if count > self._most_lost * rows:
            rest = f"; --lost-rows {math.ceil(100 * count / rows) / 100:g} reads the others" if good > 1 else ""
            raise TraceError(f"{error} ({count} of {rows} rows hold no pose{rest})") from None
        reason = str(error).removeprefix(f"{self.head.path}: line {line}: ").removesuffix(_REPAIR)
        what = f"{count} of {rows} rows hold no pose, the first in line {line} ({reason})"
        self.defects.append(Defect("row-without-pose", what, "dropped", count, line))

    def _wrong_width(self, where: str, found: int, wanted: int) -> TraceError:
        message = (
            f"{where}: {found} fields where {'the header names' if self.head.names else 'the first row has'} {wanted}"
        )
        if self.head.separator == "," and found > wanted:
            return TraceError(
                f"{message}: it looks like decimal commas inside a comma-separated file, which cannot be told apart; "
                "write decimal points, or separate the fields with ';'"
            )
        return TraceError(f"{message}{_REPAIR}")

    def _chunks(self) -> Iterator[_Chunk]:
        """Yield pieces of whole lines."""
        line, rest, newline = self.head.first_line, b"", self.head.newline
        with self.head.open() as file:
            file.seek(self.head.first_byte)
            following = file.read(CHUNK_BYTES)
            while following:
                block, following = following, file.read(CHUNK_BYTES)
                text = rest + block
                cut = text.rfind(newline) + 1
                if not cut and len(text) > _LONGEST_LINE:
                    what = f"line {line} is longer than {_LONGEST_LINE // 1024} KiB"
                    raise TraceError(f"{self.head.path}: {what}: this is no row of numbers")
                rest = text[cut:]
                if cut:
                    count = text.count(newline, 0, cut)
                    yield _Chunk(text[:cut], line, count, last=not rest and not following)
                    line += count
        if rest.strip():
            self.ends_with_newline = False
            yield _Chunk(rest, line, 1, last=True)

    def _prepared(self, text: bytes) -> bytes:
        if self.head.newline == b"\r":
            text = text.replace(b"\r", b"\n")
        if self.head.decimal_comma:
            text = text.replace(b",", b".")
        if self.head.separator is not None:
            mark = self.head.separator.encode()
            for blank in (b" ", b"\t"):
                if blank != mark and blank in text:
                    text = text.replace(mark + blank, mark)
        return text

    def _read_fast(self, chunk: _Chunk) -> Rows | None:
        """Parse the whole chunk by numpy's C parser. Return None for anything unusual."""
        text, count = self._prepared(chunk.text), chunk.count
        if not self._regular(text, count):
            return None
        layout = self.layout
        kinds: list[tuple[Any, ...]] = [("v", np.float64, (len(self._columns),))]
        columns = list(self._columns)
        for name, column in (("t", layout.time), ("d", layout.device), ("r", layout.rest)):
            if column is not None:
                kinds.append((name, f"S{WIDTH}"))
                columns.append(column)
        try:
            how: dict[str, Any] = {"comments": None, "ndmin": 1, "encoding": "latin-1"}
            table = np.loadtxt(io.BytesIO(text), kinds, delimiter=self.head.separator, usecols=columns, **how)
            values = table["v"]
            # min and max are NaN if anything is
            if len(table) != count or not -_FARTHEST < values.min() <= values.max() < _FARTHEST:
                return None
            clock: Any = None if layout.time is None else table["t"]
            if layout.rest is not None and layout.rest_unit == "date":
                clock = np.strings.add(np.strings.add(table["r"], b" "), clock)
            stamps = None if clock is None else parse_fields(clock)
            if layout.device is not None and table["d"].view(np.uint8).reshape(count, -1)[:, -1].any():
                return None  # a name longer than its field would pass for another
            if stamps is not None and layout.rest is not None and layout.rest_unit != "date":
                stamps.billionths += parse_fields(table["r"]).whole * UNITS_NS[layout.rest_unit]
                stamps.decimals = None
        except (ValueError, OverflowError):
            return None
        device = None if layout.device is None else np.ascontiguousarray(table["d"])
        return self._rows(stamps, values, device, np.arange(chunk.line, chunk.line + count, dtype=np.int32))

    def _rows(
        self, stamps: Stamps | None, values: Numbers, device: NDArray[np.bytes_] | None, line: NDArray[np.int32]
    ) -> Rows:
        turns = len(self.layout.orientation)
        position = None if self.layout.position is None else values[:, turns : turns + 3].copy()
        gaze = values[:, -len(self.layout.gaze) :].copy() if self.layout.gaze else None
        return Rows(stamps, values[:, :turns].copy(), position, device, line, gaze)

    def _regular(self, text: bytes, count: int) -> bool:
        """Return whether all lines have as many fields: loadtxt with usecols ignores more."""
        if not text.strip():
            return False
        mark = self.head.separator or " "
        flat = np.frombuffer(text, np.uint8)
        at = np.flatnonzero(flat == ord(mark))
        per_line = self._width - 1
        if len(at) != count * per_line or b'"' in text:
            if self.head.separator is not None:
                return False
            # Aligned with several blanks: count the fields of each line.
            return b"\n\n" not in text and all(len(line.split()) == self._width for line in text.splitlines())
        ends = np.append(np.flatnonzero(flat == ord("\n")), len(flat))[:count]
        marks = at.reshape(count, per_line)
        return per_line == 0 or bool((marks[:, -1] < ends).all() and (marks[1:, 0] > ends[:-1]).all())

    def _read_slowly(self, chunk: _Chunk) -> Rows:
        """Parse line by line, skip what is no row, drop a cut last line, count other bad ones."""
        pieces = chunk.text.replace(b"\r", b"\n") if self.head.newline == b"\r" else chunk.text
        found = [
            (i, t)
            for i, t in enumerate(pieces.decode("utf-8", "replace").split("\n"), chunk.line)
            if t.strip(" \t\r\x00")
        ]
        rows: list[tuple[list[float], tuple[int, int, bool, int], bytes]] = []
        lines: list[int] = []
        for k, (number, text) in enumerate(found):
            bare = text.strip()
            if bare.startswith(COMMENT_SIGNS):
                continue
            if bare == self.head.header_text:
                self._repeated_headers.append(number)
                continue
            try:
                rows.append(self._parse_line(bare, number))
                lines.append(number)
            except TraceError as error:
                # NaN and words are faults, not truncation.
                words = {f.lower().lstrip("+-") for field in split(bare, None) for f in field.split(",")}
                cut = chunk.last and k == len(found) - 1 and not words & _WORDS
                if not cut:
                    self._bad_rows += 1
                    self._first_bad = self._first_bad or (number, error)
                    continue
                reason = str(error).removeprefix(f"{self.head.path}: line {number}: ")
                self.defects.append(Defect("last-row-cut", f"the last row is cut off ({reason})", "dropped", 1, number))
                continue
        table = np.array([row[0] for row in rows], dtype=np.float64).reshape(len(lines), len(self._columns))
        stamps = None if self.layout.time is None else stamps_of([row[1] for row in rows])
        device = None if self.layout.device is None else np.array([row[2] for row in rows], dtype=np.bytes_)
        return self._rows(stamps, table, device, np.array(lines, dtype=np.int32))

    def _parse_line(self, text: str, number: int) -> tuple[list[float], tuple[int, int, bool, int], bytes]:
        where = f"{self.head.path}: line {number}"
        fields = split(text, self.head.separator)
        if len(fields) == self._width + 1 and fields[-1] == "":
            fields.pop()
        if len(fields) != self._width:
            raise self._wrong_width(where, len(fields), self._width)
        row = [self._number(fields[c], c, where) for c in self._columns]
        time = (0, 0, False, 0)
        if self.layout.time is not None:
            field = fields[self.layout.time]
            try:
                rest = "" if self.layout.rest is None else fields[self.layout.rest]
                dated = f"{rest} " if self.layout.rest_unit == "date" else ""
                time = parse_one(dated + (field.replace(",", ".") if self.head.decimal_comma else field))
                if rest and not dated:
                    time = (time[0], time[1] + parse_one(rest)[0] * UNITS_NS[self.layout.rest_unit], time[2], 10)
            except ValueError as error:
                raise TraceError(f"{where}: {self._names[self.layout.time]}: {error}{_REPAIR}") from None
        device = b"" if self.layout.device is None else fields[self.layout.device].encode("utf-8", "replace")
        return row, time, device

    def _number(self, field: str, column: int, where: str) -> float:
        value = math.nan
        if is_number(field) and (self.head.decimal_comma or "," not in field):
            value = float(field.replace(",", "."))
        if abs(value) < _FARTHEST:
            return value
        shown = f"'{field[:40]}'" if field else "empty"
        raise TraceError(f"{where}: {self._names[column]} is {shown}: expected a finite number{_REPAIR}")

    def _joined(self, parts: list[Rows]) -> Rows:
        if not sum(map(len, parts)):
            cut = f" ({self.defects[0]})" if self.defects else ""
            raise TraceError(f"{self.head.path} holds no usable row{cut}")
        stamped, stamps = [p.stamps for p in parts if p.stamps is not None], None
        if stamped:
            whole, billionths = (
                np.concatenate([getattr(s, name) for s in stamped]) for name in ("whole", "billionths")
            )
            if self.layout.rest is not None and billionths.max() >= BILLION:  # a clock of its own
                whole, billionths = np.divmod(billionths, BILLION)
            decimals = (
                None if any(s.decimals is None for s in stamped) else np.concatenate([s.decimals for s in stamped])
            )
            stamps = Stamps(whole, billionths, any(s.clock for s in stamped), decimals)
            del stamped, whole, billionths
        columns: dict[str, Any] = {}
        for name in ("stamps", "orientation", "position", "device", "line", "gaze"):
            pieces = [getattr(p, name) for p in parts]
            for p in parts:  # free the pieces at once: the peak is the result and one column
                setattr(p, name, None)
            if name != "stamps":
                columns[name] = None if pieces[0] is None else np.concatenate(pieces)
            del pieces
        if self.layout.euler is not None:
            self._judge_angles(columns["orientation"], self.layout.euler)
        columns["orientation"] = _quaternions(columns["orientation"], self.layout, self.head)
        return Rows(stamps, **columns)

    def _judge_angles(self, angles: NDArray[np.float64], euler: Euler) -> None:
        """Warn where the unit of angles is not the one that they look like."""
        largest, spread = float(np.abs(angles).max()), float(np.ptp(angles, axis=0).max())
        fits = largest > _TURN_RAD if euler.degrees else largest < 2 * _TURN_RAD
        if fits or spread < _TURNED_RAD:
            return
        unit, other = ("degrees", "rad") if euler.degrees else ("radians", "deg")
        what = f"its angles, read as {unit}, reach {largest:.3g}"
        remedy = f"kept; --euler {attrs.evolve(euler, degrees=other == 'deg').words()} takes the other unit"
        self.defects.append(Defect("angles-implausible", what, remedy))


def _quaternions(numbers: NDArray[np.float64], layout: Layout, head: Head) -> NDArray[np.float64]:
    """Return (n, 4) quaternions xyzw; zeros for a matrix without a turn. Errors: TraceError."""
    euler = layout.euler
    if not layout.matrix and euler is None:
        return numbers
    from scipy.spatial.transform import Rotation

    if euler is not None and euler.order in (VECTOR, AXIS_ANGLE):
        if euler.order == AXIS_ANGLE:
            length = np.linalg.norm(numbers[:, :3], axis=1, keepdims=True)
            numbers = numbers[:, 3:] * numbers[:, :3] / np.where(length > 0, length, 1)
        return np.asarray(Rotation.from_rotvec(numbers, degrees=euler.degrees).as_quat())
    if euler is not None:
        return np.asarray(Rotation.from_euler(euler.order, numbers * euler.signs, degrees=euler.degrees).as_quat())
    matrices = numbers.reshape(-1, 3, 3)
    off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    if np.median(off) > _MATRIX_OFF or np.median(np.linalg.det(matrices)) < 0:
        what = f"off by {np.median(off):.3g}, determinant {np.median(np.linalg.det(matrices)):.3g}"
        raise TraceError(f"{head.path}: half of its matrices are no rotations ({what}): were the wrong columns read?")
    out = np.zeros((len(matrices), 4))
    turns = np.linalg.det(matrices) > 0.1  # lost tracking writes zeros
    out[turns] = Rotation.from_matrix(matrices[turns]).as_quat()
    return out
