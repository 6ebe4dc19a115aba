"""What the store gives back: rows, frozen, as they were when asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

ORIGINS = (PERSON, PILOT, SIMULATED) = ("person", "pilot", "simulated")
STATUSES = (RUNNING, INTERRUPTED, COMPLETE, STOPPED, SICK) = ("running", "interrupted", "complete", "stopped", "sick")
# RUNNING: now, or its program died. INTERRUPTED: may be gone on with. STOPPED: by the participant or the experimenter, without a reason.
# SICK: by the stop rule. The last three are over.


@attrs.frozen
class Session:
    """One sitting of one participant, over one or more runs of the program.

    id: in the store. code: the participant's, as typed. sub: the random one that exports have. number: 1 for the first session. part: of
    the plan. row: which order of the part's orders. order: the conditions' names, a tuple for each repeat. plan: the file's text then.
    facts: versions, headset, GPU, seed. *_utc: ISO 8601.
    """

    id: int
    code: str
    sub: str
    number: int
    part: str
    row: int
    order: tuple[tuple[str, ...], ...]
    origin: str
    status: str
    plan: str
    started_utc: str
    ended_utc: str = ""
    why: str = ""
    facts: Mapping[str, Any] = attrs.field(factory=dict, hash=False)


@attrs.frozen
class Answer:
    """A confirmed one. key: of its step. revision: 1, more where the question was asked again; the highest one counts. showing: the id of
    the Showing it is about, None for none. value: None for "cannot say". seconds: from the question to the answer."""

    id: int
    session: int
    key: str
    revision: int
    phase: str
    trial: int
    scale: str
    item: str
    value: float | None
    seconds: float
    by: str
    at_utc: str
    showing: int | None = None


@attrs.frozen
class Showing:
    """A condition as it was really shown. key: of its step. presentation: 1, more where it had to be shown again. complete: whether it was
    shown to its end. trace: the head's recording, a file name within the store's `traces`, "" for none; of a showing that was cut off the
    file may be missing. actual: what was measured meanwhile (study/actual.py says which keys). measured: what `study measure` found out
    afterwards, empty before."""

    id: int
    session: int
    key: str
    trial: int
    repeat: int
    condition: str
    presentation: int
    complete: bool
    settings: Mapping[str, Any] = attrs.field(factory=dict, hash=False)
    trace: str = ""
    actual: Mapping[str, Any] = attrs.field(factory=dict, hash=False)
    measured: Mapping[str, Any] = attrs.field(factory=dict, hash=False)
    started_utc: str = ""


@attrs.frozen
class Event:
    """A line of the journal. kind: "shown", "answer", "pause", "continue", "break", "stop", "remark", "sick", "lost", "clock", ..
    data: what belongs to it. mono_ns: the machine's monotonic clock, comparable within one run of the program only."""

    id: int
    session: int
    kind: str
    key: str
    at_utc: str
    mono_ns: int
    data: Mapping[str, Any] = attrs.field(factory=dict, hash=False)


@attrs.frozen
class Contents:
    """Everything of a study that is not withdrawn, in the order it happened. folder: of the store; traces lie in folder / "traces"."""

    folder: Path
    name: str
    sessions: tuple[Session, ...]
    answers: tuple[Answer, ...]
    showings: tuple[Showing, ...]
    events: tuple[Event, ...]
    withdrawn: int = 0

    def session(self, id_: int) -> Session:
        """The one of that id. Errors: KeyError."""
        return next(one for one in self.sessions if one.id == id_)
