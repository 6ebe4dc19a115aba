"""Rows of a database that SQLite may refuse: what the pages of its file and its log hold.

Python's sqlite3 has no recovery, and neither do apsw's builds. Every leaf of a table is read by
itself, so that a broken page costs its own rows only, even the first one, which has the schema.
Source: sqlite.org/fileformat2.html, sections 1.6, 2.1 and 4.1.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

_PAGE, _WAL, _FRAME = 4096, 32, 24  # bytes of a page, as SQLite makes them here, and of the log's headers
_LEAF = 0x0D  # first byte of a leaf of a table
_BROKEN = (IndexError, KeyError, ValueError, struct.error)
_BYTES = (0, 1, 2, 3, 4, 6, 8, 8, 0, 0)  # of a value, by its type up to 9
Value = float | str | bytes | None
Row = tuple[Value, ...]
Pages = Mapping[int, bytes]
# How many columns each table has, and which of them are texts; others are numbers or null.
Shapes = Mapping[str, tuple[int, frozenset[int]]]


def rows_in(path: Path, shapes: Shapes) -> dict[str, dict[int, Row]]:
    """Return the rows of each table that can be read, by their ids; a row is known by its shape."""
    pages = _pages(path)
    found: dict[str, dict[int, Row]] = {table: {} for table in shapes}
    for page in pages.values():
        for id_, row in _cells(page, pages):
            shape = len(row), frozenset(place for place, value in enumerate(row) if isinstance(value, str))
            for table in (table for table, kind in shapes.items() if kind == shape and row[0] not in shapes):
                found[table].setdefault(id_, row)  # but for rows of sqlite_sequence, which begin with a table's name
    return found


def _pages(path: Path) -> dict[int, bytes]:
    """Return the pages by their numbers, those of the log's transactions in place of older ones."""
    data = _bytes(path)
    pages = {at // _PAGE + 1: data[at : at + _PAGE] for at in range(0, len(data), _PAGE)}
    log = _bytes(path.with_name(f"{path.name}-wal"))
    pending: dict[int, bytes] = {}
    for at in range(_WAL, len(log) - _FRAME - _PAGE + 1, _FRAME + _PAGE):
        number, size, *salts = struct.unpack_from(">4I", log, at)
        if tuple(salts) != struct.unpack_from(">2I", log, 16):
            break  # left of an older log
        pending[number] = log[at + _FRAME : at + _FRAME + _PAGE]
        if size:  # a transaction ends
            pages |= pending
            pending.clear()
    return pages


def _bytes(path: Path) -> bytes:
    with suppress(OSError):
        return path.read_bytes() if path.is_file() else b""
    return b""


def _cells(page: bytes, pages: Pages) -> Iterator[tuple[int, Row]]:
    start = 100 if page.startswith(b"SQLite format 3") else 0
    if page[start : start + 1] != bytes([_LEAF]):
        return
    for number in range(int.from_bytes(page[start + 3 : start + 5])):
        with suppress(*_BROKEN):
            (at,) = struct.unpack_from(">H", page, start + 8 + 2 * number)
            size, at = _varint(page, at)
            id_, at = _varint(page, at)
            yield id_, _record(_payload(page, at, size, pages))


def _payload(page: bytes, at: int, size: int, pages: Pages) -> bytes:
    """Return a record, with what is on pages of its own where it is long."""
    least = (_PAGE - 12) * 32 // 255 - 23
    local = least + (size - least) % (_PAGE - 4)
    local = size if size <= _PAGE - 35 else local if local <= _PAGE - 35 else least
    record = page[at : at + local]
    following = int.from_bytes(page[at + local : at + local + 4]) if local < size else 0
    for _ in range(len(pages)):
        if len(record) >= size:
            break
        record += pages[following][4:]
        following = int.from_bytes(pages[following][:4])
    if len(record) < size:
        raise ValueError("cut off")
    return record[:size]


def _record(record: bytes) -> Row:
    end, at = _varint(record, 0)
    types = []
    while at < end:
        kind, at = _varint(record, at)
        types.append(kind)
    row: list[Value] = []
    for kind in types:
        length = _BYTES[kind] if kind < len(_BYTES) else (kind - 12) // 2
        value = record[at : at + length]
        if len(value) < length or kind in (10, 11):
            raise ValueError("cut off")
        row.append(_value(kind, value))
        at += length
    return tuple(row)


def _value(kind: int, value: bytes) -> Value:
    if kind == 7:
        return float(struct.unpack(">d", value)[0])
    if kind in (8, 9):
        return kind - 8
    if kind < 12:
        return int.from_bytes(value, signed=True) if kind else None
    return value.decode() if kind % 2 else value


def _varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for place in range(at, at + 8):
        value = value << 7 | data[place] & 0x7F
        if data[place] < 0x80:
            return value, place + 1
    return value << 8 | data[at + 8], at + 9
