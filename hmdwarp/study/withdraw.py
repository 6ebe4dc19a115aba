"""Withdrawal: erases all data of a participant, at any time and without a reason.

Erased: answers, showings with their figures, events with remarks, sessions, the random word, and
head traces, which identify a person. Kept: the code, so that it is never reused. The order becomes
free for another participant. Beyond reach of this program: earlier exports, reports and copies of
the folder; snapshots and journals of a file system; blocks that a flash disk retired. Disk
encryption covers the last two.
"""

from __future__ import annotations

import attrs

from .store import Store

BEYOND = "Earlier exports, reports, copies and backups still hold these data: delete them by hand."


@attrs.frozen
class Holdings:
    """Amount of a participant's data."""

    code: str  # as first written
    sessions: int
    answers: int  # every revision, to questionnaires too
    showings: int
    events: int
    traces: int
    bytes: int  # of the traces

    def describe(self) -> str:
        """Return "1 session, 12 answers (revisions included), .., 6 head traces (1.2 MB)"."""
        counts = (
            (self.sessions, "session", ""),
            (self.answers, "answer", " (revisions included)"),
            (self.showings, "showing", ""),
            (self.events, "event", ""),
            (self.traces, "head trace", ""),
        )
        text = ", ".join(
            f"{count} {name}{'' if count == 1 else 's'}{more if count else ''}" for count, name, more in counts
        )
        return f"{text} ({self.bytes / 1e6:.1f} MB)" if self.traces else text


def holdings(store: Store, code: str) -> Holdings:
    """Return the amount of data to erase. Errors: InputError for an unknown or withdrawn code."""
    code, sub, counts = store.holdings(code)
    files = [path for path in store.traces.glob(f"*{sub}*") if path.is_file()]
    return Holdings(code, **counts, traces=len(files), bytes=sum(path.stat().st_size for path in files))


def finish_interrupted(store: Store, code: str) -> bool:
    """Return whether an interrupted withdrawal of this participant ended just now."""
    return code.lower() in [one.lower() for one in store.lock()]


def withdraw(store: Store, code: str) -> Holdings | None:
    """Erase a participant; return what was erased, or None for an interrupted withdrawal.

    Errors: InputError for an unknown or withdrawn code; MachineError while a session runs, or while
    a program that reads the study keeps the old bytes alive. The next withdrawal or session then
    erases the rest.
    """
    if finish_interrupted(store, code):
        return None
    erased = holdings(store, code)
    store.withdraw(code)
    return erased
