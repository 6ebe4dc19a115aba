"""First look at a trace file: text or not, separator, header, first rows."""

from __future__ import annotations

import gzip
import io
import itertools
import os
import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, cast

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError
from ...options.named_files import LIST, TRACE, most_unpacked, opened
from ..assumptions import By, Defect
from ..options import Euler
from .colmap import MARK, table_of_colmap
from .columns import Made, names_rotation, rows_text
from .json_records import table_of_json
from .motion_capture import export_reader
from .pose_messages import MAGIC, BagPoses, McapPoses
from .pose_messages import MAGICS as BAGS

LOOK_BYTES = 256 * 1024
_SAMPLE_ROWS = 64
_GZIP = b"\x1f\x8b"
_NUMBER = re.compile(
    r"[-+]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)([eE][-+]?[0-9]+)?$|[-+]?(nan|inf|infinity)$", re.IGNORECASE
)
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?$")
_WHOLE = re.compile(r"[-+]?[0-9]+([eE][-+]?[0-9]+)?$")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
COMMENT_SIGNS = ("#", "%", "//")
_ENDINGS = (".csv", ".txt", ".tum", ".mcap", ".bag", ".db3")


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
        return file if not self.packed else cast("BinaryIO", io.BufferedReader(_Unpacked(path, file), 1 << 18))


class _Unpacked(io.RawIOBase):
    """What gzip packed. Errors: TraceError for more than most_unpacked, or TRACE, allows."""

    def __init__(self, path: Path, file: BinaryIO) -> None:
        self._path, self._file, self._unpacked = path, file, gzip.GzipFile(fileobj=file)
        self._most = min(TRACE.most_bytes, most_unpacked(os.fstat(file.fileno()).st_size))

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return self._unpacked.seek(offset, whence)

    def readinto(self, buffer: Any) -> int:
        count = self._unpacked.readinto(buffer)
        if self._unpacked.tell() > self._most:
            raise TraceError(f"{self._path}: more than {self._most} bytes, unpacked: expected a shorter recording")
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

    def numbers(self, columns: tuple[int, ...], commas: bool = True) -> NDArray[np.float64]:
        """Return these columns of the first rows, (n, columns), of those with a number in each."""
        rows = [[row[c] for c in columns] for row in self.rows if len(row) > max(columns)]
        rows = [[f.replace(",", ".") if commas else f for f in row] for row in rows]
        good = [row for row in rows if all(is_number(field) and "," not in field for field in row)]
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
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise TraceError(f"{path} is UTF-16 text: save it as UTF-8 (or plain ASCII)")
    if raw[:4] == b"PK\x03\x04":
        raise TraceError(f"{path} is a ZIP archive: unpack it first")
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
    comments, header, first = _preamble(path, lines, bool(source.made.names))
    begins, line, text = first
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
    return Head(path, separator, names, header_line, header_text, line, begins, rows, comments, comma, newline, source)


def _made(path: Path, start: bytes, file: BinaryIO, packed: bool) -> Made | None:
    """Return the table that a file's rows are made into, None where they are rows as they are."""
    if start.startswith(MAGIC):
        whole = io.BytesIO(_whole(path, file)) if packed else file
        size = whole.seek(0, os.SEEK_END)
        whole.seek(0)
        return McapPoses(path, whole, size).table()
    if start.startswith(BAGS):
        return BagPoses(path).table()
    if start.lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"{", b"["):
        return table_of_json(path, _whole(path, file))
    if MARK in start[:200]:
        return table_of_colmap(path, _whole(path, file))
    export = export_reader(path, start)
    if export is None and not holds_vectors(start.decode("utf-8", "replace").splitlines()):
        return None
    text = _whole(path, file).decode("utf-8-sig", "replace")
    return table_of_cells(text) if export is None else export(path, text)


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
            found = sorted(p.name for p in path.iterdir() if p.suffix in _ENDINGS)
            inside = f", for instance {found[0]} in it" if found else ""
            raise TraceError(f"{path} is a directory: expected a file of head poses{inside}")
        with opened(path, TRACE) as file:
            source = Source(packed=file.read(2) == _GZIP)
        with source.open(path) as file:  # gzip is unpacked as it is read, what is no text of rows at once
            start = file.read(LOOK_BYTES)
            file.seek(0)
            made = _made(path, start, file, source.packed)
        source = source if made is None else Source(source.packed, made)
        with source.open(path) as file:
            raw, more = file.read(LOOK_BYTES), bool(file.read(1))
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise TraceError(f"{path}: its gzip data are damaged ({error}): pack or copy it again") from None
    except (OSError, ValueError) as error:
        raise TraceError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not raw.strip():
        raise TraceError(f"{path} is empty: expected rows of time, position and orientation")
    return source, raw, more


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
        elif header is None and not named:
            fields = [f.strip('"([{') for f in re.split(r"[,;\t ]+", bare) if f]
            words = sum(1 for f in fields if f[:1].isalpha() and not is_number(f))
            if words * 2 <= len(fields):
                return comments, header, (offset, number, bare)
            header = (number, bare)
        else:
            return comments, header, (offset, number, bare)
    raise TraceError(f"{path} holds no rows of numbers, only {'a header' if header else 'comments'}")


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


_CELL_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_PLAIN = re.compile(rf"(?:{_CELL_NUMBER}|[-+]?(?:nan|inf))$", re.IGNORECASE)
_LABELLED = re.compile(rf"([A-Za-z]+)[\"']*\s*[=:]\s*({_CELL_NUMBER})")
_UNREAL = re.compile(rf"(?:X|P|Pitch)={_CELL_NUMBER},?\s*(?:Y|Yaw)={_CELL_NUMBER},?\s*(?:Z|R|Roll)={_CELL_NUMBER}")
_COMMAS = re.compile(r"[-+]?[0-9]+,[0-9]+(?:[,;]\s+[-+]?[0-9]+,[0-9]+)+$")  # (0,1, 1,6): decimal commas
# Brackets, quotes or labels about numbers, or numbers apart by another sign than the cells are.
_SUSPECT = re.compile(
    rf"[(\[{{]\s*{_CELL_NUMBER}[\s,;]|[A-Za-z]\s*=\s*[-+.0-9]|[({{][\"'\s]*[A-Za-z]+[\"']*\s*:|\"\s*{_CELL_NUMBER}[\s,;]+{_CELL_NUMBER}[^\"]*\"|[;\t][^;\t,]*[0-9],[^;\t,]+,[^;\t]*[0-9]"
    rf"|,\s*{_CELL_NUMBER}\s+{_CELL_NUMBER}\s+{_CELL_NUMBER}"
)
_SAMPLE, _PREAMBLE, _LONGEST = 5, 200, 500  # rows, lines, characters that are looked at
_LABELS = {3: "xyz", 7: ("x", "y", "z", "q0", "q1", "q2", "q3")}
# FRotator::Quaternion of Unreal turns about x (roll) and y (pitch) against its axes.
_ROTATOR = {"r": "x", "p": "y", "y": "z", "roll": "x", "pitch": "y", "yaw": "z"}
_UNREAL_EULER = Euler("xyz", True, (-1, -1, 1))
_NAMELESS = Defect(
    "cells-nameless", "no header names its vectors", "three numbers taken as the position, four as the rotation"
)


def holds_vectors(lines: list[str]) -> bool:
    """Return whether the first rows hold several numbers in a cell."""
    rows = list(itertools.islice((line[:_LONGEST] for line in lines[:_PREAMBLE] if _is_row(line)), _SAMPLE))
    return bool(rows) and sum(_SUSPECT.search(row) is not None for row in rows) * 2 > len(rows)


def table_of_cells(text: str) -> Made | None:
    """Return one column for each number of the cells; None where cells cannot be separated."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    begin = next((i for i, line in enumerate(lines) if _is_row(line)), None)
    if begin is None:
        return None
    outside = re.sub(r"\[[^\[\]]*\]", "", lines[begin])
    outside = re.sub(r'"[^"]*"|\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}', "", outside)
    separator = next((mark for mark in ";\t," if mark in outside), None)
    first = [_parts(cell) for cell in _cells(lines[begin], separator)]
    header = [_header_name(cell) for cell in _cells(lines[begin - 1], separator)] if begin else []
    named = len(header) == len(first)
    names: list[str] = []
    for i, parts in enumerate(first):
        plain = {1: "time" if i == 0 else f"column {i + 1}", 3: "position", 4: "rotation"}.get(len(parts), f"{i + 1}")
        name, labels = header[i] if named else (plain, "")
        names += _names(name, labels, parts)
    if max(map(len, first)) < 2 or len(set(names)) < len(names):
        return None
    rows = [[text for cell in _cells(line, separator) for _, text in _parts(cell)] for line in lines[begin:]]
    unreal = _UNREAL.search(lines[begin]) is not None
    facts: dict[str, Any] = {} if named else {"columns_by": By.NOBODY}
    if unreal and any(_is_rotator([label for label, _ in parts]) for parts in first):
        facts |= {"euler": _UNREAL_EULER, "order_by": By.FORMAT}
    defects = () if named else (_NAMELESS,)
    return Made("unreal" if unreal else "vectors", rows_text(rows), tuple(names), defects, facts=facts)


def _is_row(line: str) -> bool:
    """Return whether a line holds numbers, and no names or a remark."""
    bare = line[:_LONGEST].strip()
    if not bare or bare.startswith(("#", "%", "//")):
        return False
    words = re.findall(r"[A-Za-z_]\w*", bare)
    return len(_LABELLED.findall(bare)) > 1 or len(re.findall(rf"(?<![\w.]){_CELL_NUMBER}(?![\w.])", bare)) > len(words)


def _cells(line: str, separator: str | None) -> Iterator[str]:
    """Yield the cells of a line; brackets and quotes hold theirs together."""
    depth, quoted, begin = 0, False, 0
    for i, sign in enumerate(line):
        quoted ^= sign == '"'
        depth += (sign in "([{") - (sign in ")]}")
        if depth <= 0 and not quoted and (sign == separator or (separator is None and sign.isspace())):
            if separator is not None or line[begin:i].strip():
                yield line[begin:i]
            begin = i + 1
    if line[begin:].strip():
        yield line[begin:]


def _parts(cell: str) -> list[tuple[str, str]]:
    """Return label and number of each part; a cell of one value is a part without a label."""
    bare = cell.strip().strip('"').strip()
    if re.fullmatch(r"[-+]?[0-9]*,[0-9]+", bare):
        return [("", bare.replace(",", "."))]
    labelled = _LABELLED.findall(bare)
    if len(labelled) > 1:
        return [(label.lower(), number) for label, number in labelled]
    inner = re.sub(r"^[A-Za-z_][\w.]*\s*(?=[(\[{])|[()\[\]{}<>]", " ", bare).strip()
    if _COMMAS.match(inner):
        return [("", part.replace(",", ".")) for part in re.split(r"[,;]\s+", inner)]
    found = [part for part in re.split(r"[;,\s]+", inner) if part]
    if len(found) > 1 and all(_PLAIN.match(part) for part in found):
        return [("", part) for part in found]
    return [("", bare.replace(",", " "))]


def _header_name(cell: str) -> tuple[str, str]:
    """Return a column's name, and the letters that it lists: Rotation (x, y, z, w)."""
    bare = cell.strip().strip('"').strip("# ")
    letters = re.search(r"[(\[{]((?:\s*[A-Za-z]\s*[,;\s])+\s*[A-Za-z])\s*[)\]}]$", bare)
    if letters is None:
        return bare, ""
    return bare[: letters.start()].strip(), "".join(re.findall("[A-Za-z]", letters[1])).lower()


def _is_rotator(labels: list[str]) -> bool:
    return set(labels) in ({"p", "y", "r"}, {"pitch", "yaw", "roll"})


def _names(name: str, letters: str, parts: list[tuple[str, str]]) -> list[str]:
    count, labels = len(parts), [label for label, _ in parts]
    if count == 1:
        return [name]
    if _is_rotator(labels):
        turned = name if names_rotation(name) else f"{name}.rotation"
        return [f"{turned}.{_ROTATOR[label]}" for label in labels]
    if not all(labels):
        numbered = [f"q{i}" for i in range(4)] if count == 4 and names_rotation(name) else map(str, range(count))
        labels = list(letters if len(letters) == count else _LABELS.get(count, numbered))
    return [f"{name}.{label}" for label in labels]
