"""Rows of the store as frozen objects, and the JSON texts in them."""

from __future__ import annotations

import json
import math
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs


def to_json(data: Mapping[str, Any]) -> str:
    """Encode data; NaN and infinite numbers become null, NumPy's numbers and arrays plain ones.

    Errors: TypeError for other objects.
    """
    return json.dumps(_plain(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


class DamagedRow(sqlite3.DatabaseError):
    """A row is not as it was written, which SQLite cannot know."""

    sqlite_errorname = "SQLITE_CORRUPT"


def from_json(text: str) -> Any:
    """Decode a text that to_json wrote. Errors: DamagedRow."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DamagedRow(f"no JSON in {text[:20]!r}") from error


def dict_in(text: str) -> dict[str, Any]:
    """Decode a row's data, without the checksum of stores of 0.2. Errors: DamagedRow."""
    data = from_json(text)
    if not isinstance(data, dict):
        raise DamagedRow(f"no data in {text[:20]!r}")
    data.pop("seal", None)
    return data


def clean(text: str) -> str:
    """Replace lone surrogates, a terminal's broken bytes, by "?": the database refuses them."""
    return text.encode(errors="replace").decode()


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):  # NumPy's
        value = value.tolist()
    if isinstance(value, Mapping):
        return {clean(str(key)): _plain(held) for key, held in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(held) for held in value]
    if isinstance(value, str | Path):
        return clean(str(value))
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    raise TypeError(f"{type(value).__name__} cannot be stored: {value!r}")


ORIGINS = (PERSON, PILOT, SIMULATED) = ("person", "pilot", "simulated")
STATUSES = (RUNNING, INTERRUPTED, COMPLETE, STOPPED, SICK, DECLINED, UNCONSENTED) = (
    *("running", "interrupted", "complete", "stopped", "sick", "declined", "unconsented"),
)
# RUNNING: now, or its program died. INTERRUPTED: may be resumed. STOPPED: by the participant or the
# experimenter, without a reason. SICK: by the stop rule. DECLINED: the consent was refused;
# UNCONSENTED: stopped before it was given. Neither took part: they count nowhere. The last
# five are over.


@attrs.frozen
class Session:
    """One session of one participant, over one or more runs of the program."""

    id: int  # in the store
    code: str  # the participant's, as typed
    sub: str  # the participant's random word, which exports use
    number: int  # 1 for the participant's first session
    part: str
    row: int  # which order of the part's orders
    order: tuple[tuple[str, ...], ...]  # the conditions' names, one tuple per repeat
    origin: str  # one of ORIGINS
    status: str  # one of STATUSES
    plan: str  # text of the study file then
    started_utc: str  # ISO 8601, as all *_utc
    ended_utc: str = ""
    why: str = ""
    facts: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # versions, headset, GPU, seed
    consented: bool = True  # False while the plan's consent was not given, whatever the status


@attrs.frozen
class Answer:
    """A confirmed answer."""

    id: int
    session: int
    key: str  # of its step
    revision: int  # more than 1 where the question was repeated; the highest one counts
    phase: str
    trial: int
    scale: str
    item: str
    value: float | None  # None for "cannot say"
    seconds: float  # from the question to the answer
    by: str
    at_utc: str
    showing: int | None = None  # id of the Showing it is about
    text: str = ""  # of an answer in words


@attrs.frozen
class Showing:
    """A condition as it was really shown."""

    id: int
    session: int
    key: str  # of its step
    trial: int
    repeat: int
    condition: str
    presentation: int  # more than 1 where it had to be shown again
    complete: bool  # shown to its end
    settings: Mapping[str, Any] = attrs.field(factory=dict, hash=False)
    # Head trace, a file name in the store's `traces`, "" for none; may be missing if cut off.
    trace: str = ""
    actual: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # measured meanwhile: study/actual.py
    measured: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # by `study measure`, empty before
    started_utc: str = ""


@attrs.frozen
class Event:
    """An entry of the journal."""

    id: int
    session: int
    kind: str  # "shown", "answer", "pause", "continue", "break", "stop", "remark", "sick", "lost", "clock", ..
    key: str
    at_utc: str
    mono_ns: int  # monotonic clock of the machine, comparable within one run of the program
    data: Mapping[str, Any] = attrs.field(factory=dict, hash=False)


@attrs.frozen
class Contents:
    """All data of a study that are not withdrawn, in the order of their creation."""

    folder: Path  # of the store; traces lie in folder / "traces"
    name: str
    sessions: tuple[Session, ...]
    answers: tuple[Answer, ...]
    showings: tuple[Showing, ...]
    events: tuple[Event, ...]
    withdrawn: int = 0

    def session(self, id_: int) -> Session:
        """Return the session of that id. Errors: StopIteration."""
        return next(session for session in self.sessions if session.id == id_)
