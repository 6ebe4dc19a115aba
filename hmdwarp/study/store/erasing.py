"""Erases a participant: rows, traces, and the bytes they took; an interrupted erasure resumes.

A mark comes first (from then on the participant is no longer read), the traces next, the rows and
the mark in one transaction, the copy and the bytes of the file last. Erased are answers, showings
with their figures, events with remarks, sessions, the random word and the head traces. The code
stays, so that it is never reused, and the order becomes free. Beyond reach are earlier exports,
reports and backups, snapshots and journals of a file system, blocks that a flash disk retired or
that an older copy of the store had: disk encryption covers the last three. A promise of erasure
must cover these too.
"""

from __future__ import annotations

import sqlite3
from contextlib import suppress
from pathlib import Path

import attrs

from ...base import HmdwarpError, InputError, MachineError
from ...report import counted, sync
from .admission import check_code
from .database import DATABASE, TRACES, erase_copies, overwrite, transaction, translated

BEYOND = "Earlier exports, reports, copies and backups still hold these data: delete them by hand."


@attrs.frozen
class Holdings:
    """Amount of a participant's data."""

    code: str  # as first written
    sub: str  # the random word that exports have in place of the code
    sessions: int
    answers: int  # every revision, to questionnaires too
    showings: int
    events: int
    traces: int
    bytes: int  # of the traces

    def describe(self) -> str:
        """Return "1 session, 12 answers (revisions included), .., 6 head traces (1.2 MB)"."""
        tables = ("session", "answer", "showing", "event")
        names = {name: counted(getattr(self, f"{name}s"), name) for name in tables}
        names["answer"] += " (revisions included)" if self.answers else ""
        text = ", ".join([*names.values(), counted(self.traces, "head trace")])
        return f"{text} ({self.bytes / 1e6:.1f} MB)" if self.traces else text


def erase(db: sqlite3.Connection, folder: Path, code: str) -> None:
    """Erase all data of a participant but the code. Errors: InputError, as known."""
    with transaction(db, folder / DATABASE):
        participant, _ = known(db, code)
        db.execute("UPDATE participant SET withdrawing = 1 WHERE id = ?", (participant,))
    finish_erasing(db, folder)


def known(db: sqlite3.Connection, code: str) -> tuple[int, str]:
    """Return the participant's row and sub. Errors: InputError where unknown or withdrawn."""
    check_code(code)
    if db.execute("SELECT 1 FROM withdrawn WHERE code = ?", (code,)).fetchone():
        raise InputError(f"participant {code} has withdrawn already: nothing is left of them here")
    found = db.execute("SELECT id, sub FROM participant WHERE code = ?", (code,)).fetchone()
    if found is None:
        raise InputError(f"participant {code} is not known here: see whether the code is right")
    return (int(found[0]), str(found[1]))


def finish_erasing(db: sqlite3.Connection, folder: Path) -> list[str]:
    """Finish erasures that are marked, or that a program left when it died; return the codes."""
    with translated(folder / DATABASE):
        marked = db.execute("SELECT id, code, sub FROM participant WHERE withdrawing").fetchall()
    for id_, code, sub in marked:
        _erase_traces(folder / TRACES, sub)
        with transaction(db, folder / DATABASE):
            _erase_rows(db, id_, code)
    with translated(folder / DATABASE):
        codes = [code for (code,) in db.execute("SELECT code FROM withdrawn WHERE NOT cleaned")]
    if codes:
        _clean(db, folder, [sub for _, _, sub in marked])
    return codes


def _erase_rows(db: sqlite3.Connection, participant: int, code: str) -> None:
    of_sessions = "session IN (SELECT id FROM session WHERE participant = ?)"
    for table in ("answer", "event", "showing"):  # answers point at showings
        db.execute(f"DELETE FROM {table} WHERE {of_sessions}", (participant,))
    db.execute("DELETE FROM session WHERE participant = ?", (participant,))
    db.execute("DELETE FROM plan WHERE id NOT IN (SELECT plan FROM session)")
    db.execute("DELETE FROM participant WHERE id = ?", (participant,))
    db.execute("INSERT INTO withdrawn (code, cleaned) VALUES (?, 0)", (code,))


def _erase_traces(traces: Path, sub: str) -> None:
    """Overwrite, then unlink the traces: unlinking alone would leave the poses on the disk."""
    try:
        for path in sorted(traces.iterdir()) if traces.is_dir() else ():
            if sub in path.name:  # also of a copy or partial file
                if path.is_file() and not path.is_symlink():
                    overwrite(path)
                path.unlink()
        if traces.is_dir():
            sync(traces)
    except OSError as error:
        raise _unerasable(traces, error) from error


def _unerasable(folder: Path, error: OSError) -> MachineError:
    why = error.strerror or str(error)
    return MachineError(f"{folder}: cannot erase ({why}); the next try erases the rest: make it writable")


def _clean(db: sqlite3.Connection, folder: Path, subs: list[str]) -> None:
    """Erase the copy, rewrite the file without the deleted rows, and empty its log.

    secure_delete has overwritten the rows, but not copies in pages that were split, nor the log.
    """
    try:
        erase_copies(folder)
    except OSError as error:
        raise _unerasable(folder, error) from error
    with translated(folder / DATABASE):
        _empty_log(db, folder)  # zeros over the old rows in their own place, before the file gets shorter
        db.execute("VACUUM")
        _empty_log(db, folder)
    _check_bytes(folder, subs)
    with transaction(db, folder / DATABASE):
        db.execute("UPDATE withdrawn SET cleaned = 1")


def _empty_log(db: sqlite3.Connection, folder: Path) -> None:
    if db.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]:
        raise MachineError(
            f"{folder}: another program reads the study's data, so the erasure is not finished: close it and "
            "repeat the command"
        )


def _check_bytes(folder: Path, subs: list[str]) -> None:
    """Check that the random word of all of a person's files and rows is gone."""
    for path in sorted(folder.rglob("*")):
        with suppress(FileNotFoundError):
            found = [sub for sub in subs if sub in path.name or (path.is_file() and sub.encode() in path.read_bytes())]
            if found:
                raise HmdwarpError(
                    f"{path}: still holds data of a participant who withdrew: do not pass it on, and report this"
                )
