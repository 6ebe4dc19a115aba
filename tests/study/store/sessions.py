"""A small study and sessions of it, for the tests of the store: no pictures, all else as it is."""

from __future__ import annotations

import contextlib
import functools
import sqlite3
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

from hmdwarp.study.design import Ask, Design, Show, Step, design_from_text, steps_of
from hmdwarp.study.store import PERSON, Session, Showing, Store

from ..plans import text_of

ROOT = Path(__file__).resolve().parents[3]
TEXT = text_of("late")


@functools.cache
def design(text: str = TEXT, path: str = "late.toml") -> Design:
    """The study of a text."""
    return design_from_text(text, path, checked=False)


def steps(session: Session, of: Design | None = None) -> tuple[Step, ...]:
    """All of a session."""
    return steps_of(of or design(), session.order, session.part)


def shows(session: Session) -> list[Show]:
    """The practice and the trials."""
    return [step for step in steps(session) if isinstance(step, Show)]


def asks(session: Session) -> list[Ask]:
    """Every question."""
    return [step for step in steps(session) if isinstance(step, Ask)]


def begun(store: Store, code: str = "P01", part: str = "one", origin: str = PERSON, **more) -> Session:
    """A session that runs."""
    return store.begin(design(), part, code, origin, **more)


def go_through(
    store: Store, session: Session, value=2.25, trace="", of: Design | None = None, until: int = 99, actual=None
) -> None:
    """Every step of it that is not done, up to this trial. value: of every answer, or a function of
    the step, whose last value counts if there are several. trace: what is written as each head's
    recording, "" for none, or a function that writes it. actual: a function of the step.
    """
    showing: Showing | None = None
    for step in steps(session, of):
        if step.key in store.done(session):
            continue
        if getattr(step, "trial", 0) > until:
            break
        if isinstance(step, Show):
            showing = store.begin_showing(session, step, step.condition.settings, recorded=bool(trace))
            if callable(trace):
                trace(store.traces / showing.trace, step)
            elif trace:
                (store.traces / showing.trace).write_text(trace, encoding="utf-8")
            seen = actual(step) if actual else {"seconds": step.seconds, "missed": 3}
            showing = store.end_showing(session, showing, seen, complete=True)
        elif isinstance(step, Ask):
            values = value(step) if callable(value) else value
            for one in values if isinstance(values, tuple) else (values,):
                store.answer(session, step, one, 1.5, "participant", showing if step.about else None)
        else:
            store.finish_step(session, step.key)


def whole(store: Store, code: str, status: str = "complete", **more) -> Session:
    """A session from its beginning to its end."""
    session = begun(store, code, **more)
    go_through(store, session)
    return store.end(session, status)


class SetClock:
    """A clock that goes on whenever it is read, and may be set."""

    def __init__(self, begin: datetime = datetime(2026, 3, 1, 9, 0, tzinfo=UTC), step_s: int = 1) -> None:
        self.instant, self.mono, self._step_s = begin, 0, step_s

    def utc(self) -> datetime:
        self.instant += timedelta(seconds=self._step_s)
        return self.instant

    def mono_ns(self) -> int:
        self.mono += 1_000_000_000 * self._step_s
        return self.mono


def sql(file: Path, statement: str) -> None:
    """Do that to a database."""
    with contextlib.closing(sqlite3.connect(file)) as db:
        db.execute(statement)
        db.commit()


def child(code: str, *words: object, before: tuple[str, ...] = (), **more) -> subprocess.Popen:
    """Another program that runs `code`, with the names of this module, in the project's folder.
    before: what it is started by.
    """
    head = "import sys, os, json\nfrom pathlib import Path\nfrom tests.study.store.sessions import *\n"
    command = [*before, sys.executable, "-c", head + code, *map(str, words)]
    return subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)


def answered(code: str, *words: object, before: tuple[str, ...] = ()) -> str:
    """What it printed."""
    process = child(code, *words, before=before)
    try:
        out, err = process.communicate(timeout=120)
    finally:
        process.kill()
    assert process.returncode == 0, err
    return out
