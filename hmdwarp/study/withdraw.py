"""Withdrawal: whoever took part may have everything erased, at any time and without a reason.

What goes: answers, showings with what was measured, events with remarks, sessions, the random id, head traces (they tell who somebody is).
What stays: the code, so that nobody gets it again and nobody withdraws twice. The order is free for another participant.
What this program cannot erase: earlier exports, reports and copies of the folder; snapshots and journals of a file system; blocks that a
flash disk took out of use. An encrypted disk answers for the last two.
"""

from __future__ import annotations

import attrs

from .store import Store

BEYOND = "Exports, reports, copies and backups made before still hold these data: delete them by hand."


@attrs.frozen
class Holdings:
    """How much there is of a participant. code: as it was first written. answers: of every revision, to questionnaires too. bytes: of
    the traces."""

    code: str
    sessions: int
    answers: int
    showings: int
    events: int
    traces: int
    bytes: int

    def words(self) -> str:
        """As "1 session, 12 answers (those given again counted), 6 showings, 40 events, 6 head traces (1.2 MB)"."""
        counts = (
            (self.sessions, "session", ""), (self.answers, "answer", " (those given again counted)"), (self.showings, "showing", ""),
            (self.events, "event", ""), (self.traces, "head trace", ""),
        )  # fmt: skip
        told = ", ".join(
            f"{count} {what}{'' if count == 1 else 's'}{more if count else ''}" for count, what, more in counts
        )
        return f"{told} ({self.bytes / 1e6:.1f} MB)" if self.traces else told


def holdings(store: Store, code: str) -> Holdings:
    """What would be erased. Errors: InputError for a code that is not known or has withdrawn."""
    code, sub, counts = store.holdings(code)
    files = [path for path in store.traces.glob(f"*{sub}*") if path.is_file()]
    return Holdings(code, **counts, traces=len(files), bytes=sum(path.stat().st_size for path in files))


def was_cut_off(store: Store, code: str) -> bool:
    """Whether this participant's withdrawal had been begun before and was cut off; it is over when this returns."""
    return code.lower() in [one.lower() for one in store.lock()]


def withdraw(store: Store, code: str) -> Holdings | None:
    """Erase a participant; what was erased. None where was_cut_off.

    Errors: InputError for a code that is not known or has withdrawn before; MachineError while a session runs, or while a program that
    reads the study keeps the old bytes from going: what is left then is erased at the next try, or when the next session begins.
    """
    if was_cut_off(store, code):
        return None
    erased = holdings(store, code)
    store.withdraw(code)
    return erased
