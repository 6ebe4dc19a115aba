"""Rescues what can be read of a damaged store into a new one."""

from __future__ import annotations

import secrets
import shutil
import sqlite3
from collections.abc import Mapping
from contextlib import closing, suppress
from pathlib import Path

import attrs

from ...errors import InputError
from ...report import counted, keep_private
from ...resources import __version__
from ..design import Design
from . import database
from .folders import DATABASE, TRACES, check_place, count_of_traces, make_folders
from .page_reader import Row, Value, rows_in
from .records import DamagedRow, from_json, to_json, unsealed
from .signature import plan_signature

TABLES = ("plan", "participant", "session", "showing", "answer", "event", "withdrawn")  # parents first


@attrs.frozen
class Rescued:
    """What came out of a damaged store."""

    rows: Mapping[str, int]  # written, by table
    left_out: Mapping[str, int]  # found, but broken or of a session that is lost
    altered: tuple[str, ...]  # entries of the journal that differ, or tell of rows that do, from what was written
    made_up: tuple[str, ...]  # what stands for something lost
    traces: int

    def describe(self) -> list[str]:
        """Return sentences for the user."""
        named = [table for table in TABLES if table not in ("plan", "withdrawn")]
        there = ", ".join(counted(self.rows[table], table) for table in named)
        lost = ", ".join(counted(count, table) for table, count in self.left_out.items() if count)
        return [
            f"rescued: {there}, {counted(self.traces, 'head trace')}",
            *([f"left out, as broken or of a session that is lost: {lost}"] if lost else []),
            *(f"check this against your notes: {text}" for text in self.altered),
            *self.made_up,
        ]


def recover(folder: Path, out: Path, design: Design | None, study: str, origin: str) -> Rescued:
    """Write what can be read of a store into a new one; the old one stays as it is.

    design: whose plan stands for one that is lost; without it such sessions are left out. study,
    origin: of the store, where it does not say. out: a folder that does not exist; it appears when
    it is whole.
    Errors: InputError for a store without a row, or an `out` that cannot be made.
    """
    if out.exists():
        raise InputError(f"{out}: exists: expected a new folder (--out)")
    check_place(out)
    found = rows_in(folder / DATABASE, database.shapes())
    if not any(found.values()):
        raise InputError(f"{folder / DATABASE}: no row of a study can be read: use an earlier copy of the folder")
    name = next((str(row[0]) for row in found["study"].values()), study)
    making = out.with_name(f".{out.name}.recovering")
    shutil.rmtree(making, ignore_errors=True)
    try:
        make_folders(making)
        path = making / DATABASE
        with database.translated(path), closing(database.open_to_write(making, name, __version__)) as into:
            with database.transaction(into, path):
                rescue = _Rescue(found, into, design, origin)
                rescue.all()
            into.execute("PRAGMA journal_mode = DELETE")  # all of it in one file
        traces = [trace for trace in (folder / TRACES).glob("*") if trace.is_file() and not trace.is_symlink()]
        for trace in traces:
            shutil.copyfile(trace, making / TRACES / trace.name)
        keep_private(*making.rglob("*"))
        making.rename(out)
    except BaseException:
        shutil.rmtree(making, ignore_errors=True)
        raise
    return Rescued(rescue.rows, rescue.left_out, tuple(rescue.altered), tuple(rescue.made_up), count_of_traces(traces))


class _Rescue:
    """Writes rows into a new store, parents first."""

    def __init__(
        self, found: dict[str, dict[int, Row]], into: sqlite3.Connection, design: Design | None, origin: str
    ) -> None:
        self._found, self._into, self._design, self._origin = found, into, design, origin
        self.rows, self.left_out = dict.fromkeys(TABLES, 0), dict.fromkeys(TABLES, 0)
        self.altered: list[str] = []
        self.made_up: list[str] = []

    def all(self) -> None:
        """Write all of them, then judge them by their seals."""
        self._stand_in()
        for table in TABLES:
            for id_, row in sorted(self._found[table].items()):
                written = self._write(table, id_, row)
                self.rows[table] += written
                self.left_out[table] += not written
        self._unseal()

    def _stand_in(self) -> None:
        """Let sessions keep a place whose participant or plan is lost."""
        for _, row in sorted(self._found["session"].items()):
            person, part, plan = row[1], row[3], row[6]
            if isinstance(person, int) and person not in self._found["participant"]:
                code = f"lost-{person}"
                self._found["participant"][person] = (None, code, secrets.token_hex(6), self._origin, 0)
                self.made_up.append(f"the code of a participant is lost: {code} stands for it")
            if isinstance(plan, int) and plan not in self._found["plan"] and self._design is not None:
                with suppress(StopIteration, KeyError, InputError):
                    meaning = to_json(plan_signature(self._design, str(part)))
                    self._found["plan"][plan] = (None, self._design.text, meaning)
                    self.made_up.append(f"a plan is lost: {self._design.path or self._design.name} stands for it")

    def _write(self, table: str, id_: int, row: Row) -> bool:
        names = list(database.columns()[table])
        values: list[Value] = [id_, *row[1:]] if names[0] == "id" else list(row)
        statement = f"INSERT INTO {table} ({', '.join(names)}) VALUES ({', '.join('?' * len(names))})"
        if table == "showing":
            self._drop_figures(values, names.index("measured"))
        with suppress(sqlite3.Error, OverflowError):
            for name, value in zip(names, values, strict=True):
                if name in ("facts", "settings", "actual", "measured", "data", "order_names", "meaning"):
                    from_json(str(value))
            self._into.execute(statement, values)
            return True
        return False

    def _drop_figures(self, values: list[Value], at: int) -> None:
        """Leave out what is not as `study measure` wrote it: it can be measured again."""
        try:
            unsealed(str(values[at]))
        except DamagedRow:
            values[at] = "{}"
            self.altered.append(f"figures of showing {values[0]!r} are lost: run 'study measure' again")

    def _unseal(self) -> None:
        """Name what differs from its seal, and take the seal off, so that the store can be used."""
        query = """SELECT e.id, e.key, e.data, p.code FROM event e JOIN session s ON s.id = e.session
          JOIN participant p ON p.id = s.participant ORDER BY e.id"""
        for id_, key, text, code in self._into.execute(query).fetchall():
            data = from_json(text)
            if database.is_broken(self._into, id_, data):
                what = key or "the session"
                self.altered.append(
                    f"{what} of {code}: entry {id_} of the journal, or what it tells of, is not as written"
                )
                kept = to_json(data) if isinstance(data, dict) else "{}"
                self._into.execute("UPDATE event SET data = ? WHERE id = ?", (kept, id_))
        query = """SELECT session, key, at_utc, json_object('value', value, 'revision', revision) FROM answer a
          WHERE NOT EXISTS (SELECT 1 FROM event e WHERE e.session = a.session AND e.kind = 'answer' AND e.key = a.key
          AND json_extract(e.data, '$.revision') = a.revision)"""
        if lonely := self._into.execute(query).fetchall():
            insert = "INSERT INTO event (session, kind, key, at_utc, mono_ns, data) VALUES (?, 'answer', ?, ?, 0, ?)"
            self._into.executemany(insert, lonely)
            self.altered.append(
                f"{counted(len(lonely), 'answer')} without an entry of the journal: words of theirs are lost"
            )
