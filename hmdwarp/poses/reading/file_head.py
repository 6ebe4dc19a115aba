"""First look at a trace file: text or not, separator, header, first rows."""

from __future__ import annotations

import gzip
import io
import itertools
import os
import re
import zlib
from pathlib import Path
from typing import Any, BinaryIO, cast

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError
from ...options.named_files import LIST, TRACE, opened
from .bags import MAGICS as BAGS
from .bags import table_of_bag
from .cells import holds_vectors, table_of_cells
from .colmap import MARK, table_of_colmap
from .json_records import table_of_json
from .made import Made
from .mcap_messages import MAGIC, table_of_mcap
from .motion_capture import export_reader

LOOK_BYTES = 256 * 1024
_SAMPLE_ROWS = 64
_GZIP = b"\x1f\x8b"
_NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?$|[-+]?(nan|inf|infinity)$", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?$")
_WHOLE = re.compile(r"[-+]?\d+([eE][-+]?\d+)?$")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
COMMENT_SIGNS = ("#", "%", "//")


@attrs.frozen(eq=False)
class Source:
    """What the text of a file's rows comes from."""

    packed: bool = False  # by gzip
    made: Made = Made("text", b"")  # the rows that were made of what is no rows

    @property
    def kind(self) -> str:
        """Return "text", or what rows were made of, for instance "json"."""
        return self.made.kind

    def open(self, path: Path) -> BinaryIO:
        """Open the text of the rows. Errors: OSError."""
        if self.kind != "text":
            return io.BytesIO(self.made.text)
        file = opened(path, TRACE)
        if not self.packed:
            return file
        return cast("BinaryIO", io.BufferedReader(_Unpacked(path, file), 1 << 18))


class _Unpacked(io.RawIOBase):
    """What gzip packed. Errors: TraceError beyond the bound of a file that is not packed."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self._path, self._file, self._unpacked = path, file, gzip.GzipFile(fileobj=file)

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._unpacked.seek(offset, whence)

    def readinto(self, buffer: Any) -> int:
        count = self._unpacked.readinto(buffer)
        if self._unpacked.tell() > TRACE.most_bytes:
            raise TraceError(
                f"{self._path}: more than {TRACE.most_bytes} bytes, unpacked: expected a shorter recording"
            )
        return count

    def close(self) -> None:
        self._unpacked.close()
        self._file.close()
        super().close()


@attrs.frozen
class Head:
    """The findings from the first part of a trace file."""

    path: Path
    separator: str | None  # "," ";" "\t" or None for blanks
    names: list[str] | None  # the header's column names
    header_line: int | None  # a comment line counts if it names as many columns as the rows have
    header_text: str
    first_line: int  # where the rows begin
    first_byte: int  # where the rows begin
    rows: list[list[str]]  # fields of the first rows
    comments: list[tuple[int, str]]  # (line, text without the comment sign) before the rows
    decimal_comma: bool  # numbers are written 0,5
    newline: bytes  # b"\n" or b"\r"
    source: Source

    def open(self) -> BinaryIO:
        """Open the text of the rows. Errors: OSError."""
        return self.source.open(self.path)

    @property
    def width(self) -> int:
        """Fields in the first row."""
        return len(self.rows[0])

    def numbers(self, columns: tuple[int, ...]) -> NDArray[np.float64]:
        """Return these columns of the first rows, (n, columns), of those with a number in each."""
        rows = [[row[c].replace(",", ".") for c in columns] for row in self.rows if len(row) > max(columns)]
        good = [row for row in rows if all(is_number(field) for field in row)]
        return np.array(good, dtype=np.float64).reshape(-1, len(columns))

    def column(self, name: str) -> int | None:
        """Return the index of the column called exactly `name`."""
        return self.names.index(name) if self.names and name in self.names else None

    def describe(self) -> str:
        """Return one phrase for error messages."""
        how = {None: "blank", ",": "comma", ";": "semicolon", "\t": "tab"}[self.separator]
        named = f"the columns {', '.join(self.names)}" if self.names else "no header"
        return f"{self.width} {how}-separated columns and {named if len(named) < 160 else named[:157] + '...'}"


def split(text: str, separator: str | None) -> list[str]:
    """Return the fields of one line without blanks and quotes around them."""
    return [f.strip().strip('"').strip() for f in text.split(separator)]


def is_number(field: str) -> bool:
    """Return whether the field is a number, with decimal point or comma."""
    return _NUMBER.match(field) is not None


def read_head(path: Path) -> Head:
    """Inspect the file. Errors: TraceError for anything but a text of rows."""
    source, raw, more = _first_bytes(path)
    _refuse_binary(path, raw)
    newline = b"\n" if b"\n" in raw or b"\r" not in raw else b"\r"
    lines = _whole_lines(path, raw, more, newline)
    comments, header, first = _preamble(path, lines, bool(source.made.names))
    offset, line, text = first
    separator, comma = _separator(text, header)
    texts = (t for _, _, t in lines if t.strip() and not t.lstrip().startswith(COMMENT_SIGNS))
    first_row = 1 if header else 0
    rows = [split(t, separator) for t in itertools.islice(texts, first_row, first_row + _SAMPLE_ROWS)]
    names, header_line, header_text = list(source.made.names) or None, None, ""
    if names:
        pass
    elif header:
        header_line, header_text = header
        names = split(header_text, separator)
    else:
        for header_line_, comment in reversed(comments):
            found = split(comment, separator)
            # A comment names the columns if it has one word for each, none of them a number.
            if len(found) == len(rows[0]) and len(found) > 1 and not any(is_number(f) for f in found):
                names, header_line = found, header_line_
                break
    if names and names[-1] == "" and len(names) > 1:
        names = names[:-1]
    return Head(path, separator, names, header_line, header_text, line, offset, rows, comments, comma, newline, source)


def _source(path: Path) -> Source:
    """Unpack what is no text of rows: gzip as it is read, the rest at once.

    Errors: OSError; TraceError and MachineError as `table_of_mcap`; TraceError for an export that
    holds no poses.
    """
    with opened(path, TRACE) as file:
        text = Source(packed=file.read(2) == _GZIP)
    with text.open(path) as file:
        start = file.read(LOOK_BYTES)
        file.seek(0)
        made = _made(path, start, file, text.packed)
    return text if made is None else Source(text.packed, made)


def _made(path: Path, start: bytes, file: BinaryIO, packed: bool) -> Made | None:
    """Return the table that a file's rows are made into, None where they are rows as they are."""
    if start.startswith(MAGIC):
        whole = io.BytesIO(_whole(path, file)) if packed else file
        size = whole.seek(0, os.SEEK_END)
        whole.seek(0)
        return table_of_mcap(path, whole, size)
    return table_of_bag(path) if start.startswith(BAGS) else _made_of_text(path, start, file)


def _made_of_text(path: Path, start: bytes, file: BinaryIO) -> Made | None:
    if start.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"["):
        return table_of_json(_whole(path, file))
    if MARK in start[:200]:
        return table_of_colmap(path, _whole(path, file))
    if (export := export_reader(path, start)) is not None:
        return export(path, _whole(path, file).decode("utf-8-sig", "replace"))
    if holds_vectors(start.decode("utf-8", "replace").splitlines()):
        return table_of_cells(_whole(path, file).decode("utf-8-sig", "replace"))
    return None


def _whole(path: Path, file: BinaryIO) -> bytes:
    """Return all bytes of what is not read row by row. Errors: TraceError for too many."""
    data = file.read(LIST.most_bytes + 1)
    if len(data) > LIST.most_bytes:
        raise TraceError(f"{path}: more than {LIST.most_bytes} bytes, unpacked: expected fewer in a file of its kind")
    return data


def _first_bytes(path: Path) -> tuple[Source, bytes, bool]:
    """Return the source of the rows, their first bytes, and whether more follow."""
    try:
        if path.is_dir():
            raise TraceError(f"{path} is a directory: expected a file of head poses{_inside(path)}")
        source = _source(path)
        with source.open(path) as file:
            raw, more = file.read(LOOK_BYTES), bool(file.read(1))
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise TraceError(f"{path}: its gzip data are damaged ({error}): pack or copy it again") from None
    except (OSError, ValueError) as error:
        raise TraceError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not raw.strip():
        raise TraceError(f"{path} is empty: expected rows of time, position and orientation")
    return source, raw, more


def _inside(path: Path) -> str:
    try:
        found = sorted(p.name for p in path.iterdir() if p.suffix in (".csv", ".txt", ".tum", ".mcap", ".bag", ".db3"))
    except OSError:
        return ""
    return f", for instance {found[0]} in it" if found else ""


def _refuse_binary(path: Path, raw: bytes) -> None:
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise TraceError(f"{path} is UTF-16 text: save it as UTF-8 (or plain ASCII)")
    if raw[:4] == b"PK\x03\x04":
        raise TraceError(f"{path} is a ZIP archive: unpack it first")
    # Zeros at the very end are a file cut off by a crash; the rows before them may be good.
    found = _CONTROL.search(raw.rstrip(b"\x00"))
    if found or not raw.rstrip(b"\x00"):
        at = found.start() if found else 0
        raise TraceError(
            f"{path} is no text: byte 0x{raw[at]:02x} in line {raw.count(bytes([10]), 0, at) + 1}; expected rows of "
            "numbers"
        )


def _whole_lines(path: Path, raw: bytes, more: bool, newline: bytes) -> list[tuple[int, int, str]]:
    """Return (byte offset, line number, text) of the lines that lie wholly in `raw`."""
    start = 3 if raw.startswith(b"\xef\xbb\xbf") else 0
    end = len(raw)
    if more:
        end = raw.rfind(newline) + 1
        if end == 0:
            raise TraceError(f"{path}: line 1 is longer than {LOOK_BYTES // 1024} KiB: this is no table of head poses")
    out, offset = [], start
    for number, piece in enumerate(raw[start:end].split(newline), 1):
        out.append((offset, number, piece.decode("utf-8", "replace").rstrip("\r\x00")))
        offset += len(piece) + 1
    return out


def _preamble(
    path: Path, lines: list[tuple[int, int, str]], named: bool
) -> tuple[list[tuple[int, str]], tuple[int, str] | None, tuple[int, int, str]]:
    """Return comments, the header line if there is one, and the first row.

    named: the columns have names, so that no line is a header.
    """
    comments: list[tuple[int, str]] = []
    header: tuple[int, str] | None = None
    for offset, number, text in lines:
        bare = text.strip()
        if not bare:
            continue
        sign = next((s for s in COMMENT_SIGNS if bare.startswith(s)), None)
        if sign:
            comments.append((number, bare[len(sign) :].strip()))
        elif header is None and not named and _looks_like_names(bare):
            header = (number, bare)
        else:
            return comments, header, (offset, number, bare)
    raise TraceError(f"{path} holds no rows of numbers, only {'a header' if header else 'comments'}")


def _looks_like_names(text: str) -> bool:
    fields = [f for f in re.split(r"[,;\t ]+", text) if f]
    words = sum(1 for f in fields if f.strip('"')[:1].isalpha() and not is_number(f.strip('"')))
    return words * 2 > len(fields)


def _separator(row: str, header: tuple[int, str] | None) -> tuple[str | None, bool]:
    """Return the separator, and whether numbers have a decimal comma."""
    if ";" in row:
        return ";", _has_decimal_comma(row.split(";"))
    if "\t" in row and not all(f.endswith(",") for f in row.split("\t")[:-1]):
        return "\t", _has_decimal_comma(row.split("\t"))
    if "," in row:
        blank = row.split()
        named_by_comma = header is not None and "," in header[1]
        if not named_by_comma and len(blank) >= 4 and _has_decimal_comma(blank):
            return None, True
        return ",", False
    return None, False


def _has_decimal_comma(fields: list[str]) -> bool:
    fields = [f.strip().strip('"') for f in fields if f.strip()]
    commas = sum(1 for f in fields if _DECIMAL_COMMA.match(f))
    return commas > 0 and all(_DECIMAL_COMMA.match(f) or _WHOLE.match(f) or not is_number(f) for f in fields)
