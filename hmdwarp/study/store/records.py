"""Rows of the store as frozen objects, and the JSON texts in them."""

from __future__ import annotations

import json
import math
import os
import sqlite3
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..design import ONE, Condition, Design
from ..scales import Item, Scale


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
    actual: Mapping[str, Any] = attrs.field(factory=dict, hash=False)  # measured meanwhile: see actual_of
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


def plan_signature(design: Design, part: str) -> dict[str, Any]:
    """Return the signature as JSON data.

    Titles, comments, breaks, the consent's text, families and other parts are not in it: they may
    change. So may the folder of the file, together with the files beside it.
    """
    folder = f"{Path(design.path).parent.absolute()}{os.sep}"
    return {
        "conditions": [_condition(condition, folder) for condition in design.part(part).conditions],
        "seconds": ["until done", float(design.seconds)] if design.until_done else float(design.seconds),
        "repeats": design.repeats,
        "order": design.order,
        "seed": design.seed,
        "scales": [_scale(scale) for scale in design.scales],
        "practice": None
        if design.practice is None
        else [_condition(design.practice, folder), float(design.practice_seconds)],
        "sickness": _sickness(design),
        "before": [_scale(scale) for scale in design.before],
        "after": [_scale(scale) for scale in design.after],
        **_shows(design),
        **_task(design),
    }


def _shows(design: Design) -> dict[str, Any]:
    """Return what a trial shows; nothing for one condition, as older sessions have it."""
    return {} if design.shows == ONE else {"shows": design.shows}


def _task(design: Design) -> dict[str, Any]:
    """Return the task; nothing without one, as sessions from before there were tasks have it."""
    task = design.task
    return {} if task is None else {"task": [task.count, task.size_deg, task.seed, *task.conditions]}


def _condition(condition: Condition, folder: str) -> dict[str, Any]:
    settings = {
        name: value.removeprefix(folder) if isinstance(value, str) else value
        for name, value in sorted(condition.settings.items())
    }
    return {"name": condition.name, "settings": settings, "reference": condition.reference}


def _scale(scale: Scale) -> dict[str, Any]:
    """Return the questions in their words, and the possible answers."""
    return {
        "name": scale.name,
        "asked": [scale.prompt, *([item.key, item.text, *_own(item)] for item in scale.items)],
        "range": [scale.least, scale.most, scale.step],
        "anchors": {f"{value:g}": words for value, words in sorted(scale.anchors.items())},
        "low_is_good": scale.low_is_good,
    }


def _own(item: Item) -> list[Any]:
    """Return the answers of a question that has its own, or its own words for some."""
    if item.anchors:
        return [{f"{value:g}": words for value, words in item.anchors.items()}]
    return [item.answer, list(item.choices), item.least, item.most, item.step] if item.answer else []


def _sickness(design: Design) -> dict[str, Any] | None:
    rule = design.sickness
    return (
        None
        if rule is None
        else {"scale": _scale(rule.scale), "every": rule.every, "stop_at": rule.stop_at, "rise": rule.rise}
    )


def signature_changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Describe what differs between two signatures, both decoded from JSON."""
    changed = [key for key in {**before, **now} if before.get(key) != now.get(key)]
    return [_conditions(before[key], now[key]) if key == "conditions" else key for key in changed]


def _conditions(before: list[dict[str, Any]], now: list[dict[str, Any]]) -> str:
    was, is_ = ({condition["name"]: condition for condition in side} for side in (before, now))
    words = [f"'{name}' is new" for name in is_ if name not in was] + [
        f"'{name}' is gone" for name in was if name not in is_
    ]
    words += [f"'{name}' changed" for name in is_ if name in was and was[name] != is_[name]]
    return f"conditions ({', '.join(words) or 'in another order'})"


Column = Callable[[str], NDArray[np.float64]]

# None where unknown.
NUMBERS = (
    "onset_s", "seconds", "pictures", "rate_hz", "latency_ms_median", "latency_ms_p95", "latency_ms_sd",
    "period_ms_median", "period_ms_p95", "missed", "missed_share", "over_budget_share", "hole_share_mean",
    "hole_share_p95", "pose_age_ms_median", "pose_age_ms_p95", "passes_ms_median", "passes_ms_p95",
    "angular_speed_deg_s_median", "linear_speed_m_s_median", "lost_s", "tracking_lost_share", "head_turn_deg",
    "head_shift_m", "task_targets", "task_found", "task_misses", "task_target_s", "task_turned_deg",
)  # fmt: skip
# Whole numbers among them.
COUNTS = ("pictures", "missed", "task_targets", "task_found", "task_misses")
FLAGS = ("head_still",)
TEXTS = (
    "warp", "fill", "scene", "effects", "lens", "headset", "gpu", "gl", "source", "hmdwarp", "size", "ended_by",
    "task_times_s",
)  # fmt: skip
NOTHING: dict[str, Any] = {**dict.fromkeys((*NUMBERS, *FLAGS)), **dict.fromkeys(TEXTS, "")}
_EYES = (0, 1)


def actual_of(summary: Mapping[str, Any], column: Column) -> dict[str, Any]:
    """Return NUMBERS, FLAGS and TEXTS from a live run's summary and its columns.

    A summary without pictures gives None throughout. The session adds its own: onset_s, from the
    session's start to the first picture; head_turn_deg, head_shift_m: largest distances of the head
    from where it was first; head_still: session/wording.py; ended_by: "time", or who
    ended a trial that is shown until done, "" for one that was not seen to its end;
    task_..: session/wording.py, of trials with a task.

    seconds: from the first picture to the last. rate_hz: pictures per second. latency: from drawing
    the frame to showing it. period: between two pictures. missed: refreshes without a new picture,
    with their share of all refreshes. over_budget: drawing and passes took longer than a refresh.
    hole_share: of both eyes' pixels, after the warp and before the fill. pose_age: from reading the
    head to handing the picture over. passes: of both eyes together. lost_s: without a display.
    tracking_lost: pictures for a head that was held at its last known pose.
    """
    if not summary:
        return dict(NOTHING)
    live, pictures = summary["live"], summary["frames"]
    holes, passes = _of_eyes(column, "hole_share", np.nanmean), _of_eyes(column, "total_ms", np.nansum)
    latency = _known(column("age_ms"))
    numbers = {
        "seconds": live["seconds"],
        "pictures": pictures,
        "rate_hz": (pictures - 1) / live["seconds"] if live["seconds"] else None,
        **_middle_and_tail("latency_ms", latency),
        "latency_ms_sd": float(np.std(latency, ddof=1)) if len(latency) > 1 else None,
        **_middle_and_tail("period_ms", _known(column("period_ms"))),
        "missed": live["missed"],
        "missed_share": live["missed"] / (live["missed"] + pictures),
        "over_budget_share": live["over"] / live["timed"] if live["timed"] else None,
        "hole_share_mean": math.fsum(holes) / len(holes) if len(holes) else None,
        "hole_share_p95": _tail(holes),
        **_middle_and_tail("pose_age_ms", _known(column("pose_age_ms"))),
        **_middle_and_tail("passes_ms", passes),
        "angular_speed_deg_s_median": _middle(_known(column("angular_speed_deg_s"))),
        "linear_speed_m_s_median": _middle(_known(column("linear_speed_m_s"))),
        "lost_s": math.fsum(loss["away_s"] or 0.0 for loss in live["lost"]),
        "tracking_lost_share": sum(live["notices"].values()) / pictures,
    }
    return {**NOTHING, **numbers, **_texts(summary)}


def _texts(summary: Mapping[str, Any]) -> dict[str, str]:
    machine = summary["machine"]
    return {
        **{name: str(summary[name]) for name in ("warp", "fill", "scene", "lens", "headset", "hmdwarp")},
        "effects": "+".join(summary["effects"]),
        "gpu": machine["gl_renderer"],
        "gl": machine["gl_version"],
        "source": summary["live"]["source"],
        "size": "x".join(map(str, summary["size"])),
    }


def _of_eyes(column: Column, name: str, together: Callable[..., NDArray[np.float64]]) -> NDArray[np.float64]:
    """Combine both eyes of each refresh, without refreshes that were not measured."""
    eyes = np.array([column(f"{name}/{eye}") for eye in _EYES])
    return together(eyes[:, ~np.isnan(eyes).all(axis=0)], axis=0)


def _known(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[~np.isnan(values)]


def _middle(values: NDArray[np.float64]) -> float | None:
    return float(np.median(values)) if len(values) else None


def _tail(values: NDArray[np.float64]) -> float | None:
    return float(np.percentile(values, 95)) if len(values) else None


def _middle_and_tail(name: str, values: NDArray[np.float64]) -> dict[str, float | None]:
    return {f"{name}_median": _middle(values), f"{name}_p95": _tail(values)}
