"""The columns of what is exported: their order, their types, and what each is, for people and for sidecar files."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from ...metrics import metrics_in_order
from ..actual import NUMBERS, TEXTS
from ..design.settings import DISPLAY, KINDS
from ..scales import KINDS as SCALE_KINDS
from ..store import ORIGINS, STATUSES

TEXT, NUMBER, WHOLE, FLAG = "text", "number", "whole", "flag"
MISSING = "n/a"
CANNOT_SAY, NOT_ASKED, NOT_ALL = "cannot say", "not asked", "answers missing"
PHASES = ("before", "practice", "trial", "after")


@attrs.frozen
class Column:
    """type: of TEXT, NUMBER, WHOLE, FLAG. levels: words for the values there are. units: as BIDS writes them, "" for none."""

    name: str
    type: str
    description: str
    units: str = ""
    levels: Mapping[str, str] = attrs.field(factory=dict, hash=False)


_WHO = (
    Column("study", TEXT, "Name of the study"),
    Column("participant", TEXT, "Random word for the participant; who that is, nobody can tell from it"),
    Column("session", WHOLE, "Which sitting of the participant, from 1 on"),
    Column("part", TEXT, "Part of the study"),
    Column("origin", TEXT, "Who answered", levels=dict(zip(ORIGINS, (
        "a participant", "somebody who tried the study out", "a program"), strict=True))),
    Column("status", TEXT, "How the session ended", levels=dict(zip(STATUSES, (
        "it was going on", "it may be gone on with", "to its end", "ended by the participant or the experimenter, without a reason",
        "ended by the stop rule for sickness"), strict=True))),
    Column("order", WHOLE, "Which of the part's orders of conditions, from 0 on"),
)  # fmt: skip
_WHAT = (
    Column("trial", WHOLE, "Place of the trial in the session, from 1 on; 0 is the practice"),
    Column("repeat", WHOLE, "Which time the condition was shown in this session, from 1 on"),
    Column("condition", TEXT, "Name of the condition"),
    Column("reference", FLAG, "Whether it is the hidden reference"),
    Column("previous", TEXT, "Condition of the trial before, n/a for the first"),
)
# Always there, whatever a study sets; in the units of the live run.
SETTINGS = ("latency_ms", "warp", "fill", "scene", "effects", "lens")
_SETTING_TOLD = {
    "latency_ms": "From drawing a frame to showing it, as asked for",
    "warp": "What turns a late frame to the newest pose",
    "fill": "What fills the holes",
    "scene": "What is shown",
    "effects": "What of the scene is carried in layers",
    "lens": "Lens correction",
}
_SHOWN = (
    Column("scale", TEXT, "What was asked"),
    Column("item", TEXT, "Which question of the scale"),
    Column("value", NUMBER, "The answer"),
    Column("low_is_good", FLAG, "Direction of the scale: whether a low value is a good one"),
    Column("why_missing", TEXT, "Why there is no value, n/a where there is one", levels={
        CANNOT_SAY: "the participant could not say",
        NOT_ASKED: "the session came to its end without the question",
        NOT_ALL: "a score of which not all answers are there",
        **{f"session {status}": "the session was over or broken off before the answer" for status in STATUSES if status != "complete"},
    }),
    Column("seconds_to_answer", NUMBER, "From the question to the confirmed answer", "s"),
    Column("revision", WHOLE, "1, more where the question was asked again; the last one counts"),
    Column("presentation", WHOLE, "Which showing of the trial the answer is about; more than 1 where it had to be shown again"),
    Column("answered_by", TEXT, "Whose hands answered"),
)  # fmt: skip
_PHASE = (
    Column("phase", TEXT, "When it was asked", levels=dict(zip(PHASES, (
        "before the first trial", "after the practice", "after a trial", "after the last trial"), strict=True))),
    Column("kind", TEXT, "What the scale is", levels=dict(zip((*SCALE_KINDS, "score"), (
        "a rating of what was shown", "how sick somebody feels", "an answer to one question of several",
        "what the answers to a questionnaire come to"), strict=True))),
)  # fmt: skip

_UNITS = (("_ms", "ms"), ("_hz", "Hz"), ("_deg_s", "deg/s"), ("_m_s", "m/s"), ("_s", "s"), ("_db", "dB"))
_ACTUAL_TOLD = {
    "seconds": ("From the first picture to the last", "s"),
    "pictures": ("Pictures shown", ""),
    "rate_hz": ("Pictures a second, as they came", "Hz"),
    "latency_ms": ("Age of the frame when it was seen", "ms"),
    "period_ms": ("Between two pictures", "ms"),
    "missed": ("Refreshes of the display without a new picture", ""),
    "missed_share": ("Refreshes without a new picture, of all", ""),
    "over_budget_share": ("Pictures that took longer to make than a refresh, of all", ""),
    "hole_share": ("Pixels without anything after the warp and before the fill, of all", ""),
    "pose_age_ms": ("From reading the head to handing the picture over", "ms"),
    "passes_ms": ("What the passes took, both eyes together", "ms"),
    "angular_speed_deg_s": ("How fast the head turned", "deg/s"),
    "linear_speed_m_s": ("How fast the head moved", "m/s"),
    "lost_s": ("Without a display", "s"),
    "tracking_lost_share": ("Pictures for a head that was held where it was last known, of all", ""),
}
_OF = {"_median": "median", "_p95": "95th percentile", "_sd": "standard deviation", "_mean": "mean"}
_TEXT_TOLD = {
    "gpu": "GPU",
    "gl": "Version of OpenGL",
    "hmdwarp": "Version of hmdwarp",
    "size": "Pixels of one eye",
    "source": "Display",
}


def _actual(name: str) -> Column:
    if name in TEXTS:
        return Column(f"actual_{name}", TEXT, f"As it was shown: {_TEXT_TOLD.get(name, name)}")
    stem, how = next(
        ((name.removesuffix(end), f", {word}") for end, word in _OF.items() if name.endswith(end)), (name, "")
    )
    told, unit = _ACTUAL_TOLD.get(
        stem, (stem.replace("_", " "), next((u for end, u in _UNITS if stem.endswith(end)), ""))
    )
    return Column(
        f"actual_{name}", WHOLE if name in ("pictures", "missed") else NUMBER, f"As it was shown: {told}{how}", unit
    )


ACTUAL_COLUMNS = tuple(_actual(name) for name in (*NUMBERS, *TEXTS))
MEASURED_COLUMNS = (
    *(Column(f"measured_{metric.name}", NUMBER, f"Afterwards, mean of the measured pictures: {metric.description}", metric.unit)
      for metric in metrics_in_order()),
    Column("measured_refreshes", WHOLE, "How many refreshes were measured afterwards, both eyes of each"),
    Column("measured_every", WHOLE, "Every how many-th refresh was measured; figures of different steps are not to be compared"),
    Column("measured_size", TEXT, "Pixels of one eye in the measured pictures; figures of different sizes are not to be compared"),
)  # fmt: skip
_SETTING_COLUMNS = tuple(
    Column(name, NUMBER if name == "latency_ms" else TEXT, _SETTING_TOLD[name], "ms" if name == "latency_ms" else "")
    for name in SETTINGS
)
COLUMNS = (*_WHO, *_WHAT, *_SETTING_COLUMNS, *_SHOWN, *ACTUAL_COLUMNS, *MEASURED_COLUMNS)
LONG_COLUMNS = tuple(column.name for column in COLUMNS)

# Settings a study may have beside SETTINGS: in the table where it has them.
OTHER_SETTINGS = tuple(name for name in KINDS if name not in (*DISPLAY, *SETTINGS, "latency"))
_BY_NAME = {column.name: column for column in (*COLUMNS, *_PHASE)}


def column_of(name: str) -> Column:
    """The one of that name; a setting of a study where there is none."""
    if name in _BY_NAME:
        return _BY_NAME[name]
    kind = {"a number": NUMBER, "a whole number": WHOLE, "true or false": FLAG}.get(KINDS.get(name, ""), TEXT)
    return Column(name, kind, f"Setting of the condition: --{name.replace('_', '-')} of hmdwarp live")


def columns_for(rows: Sequence[Mapping[str, Any]], more: Sequence[str] = ()) -> tuple[Column, ...]:
    """COLUMNS, with the other settings the rows have after SETTINGS, and `more` before the scale."""
    others = [name for name in OTHER_SETTINGS if any(name in row for row in rows)]
    before, after = LONG_COLUMNS.index(SETTINGS[-1]) + 1, LONG_COLUMNS
    names = (*after[:before], *others, *more, *after[before:])
    return tuple(column_of(name) for name in names)


def label_of(text: str) -> str:
    """Letters and digits alone, as BIDS wants labels; never empty."""
    return re.sub(r"[^A-Za-z0-9]", "", text) or "study"
