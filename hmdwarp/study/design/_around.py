"""What stands around the trials in a study file: practice, breaks, sickness, questionnaires, consent."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...tables import Table, text_of, told
from ..scales import QUESTIONNAIRE, RATING, Scale
from ._parts import Checker
from ._scales import scale_at, scales_of
from .nouns import Breaks, Condition, Consent, Sickness
from .settings import PICTURE

PRACTICE = "practice"
_UNLESS_SAID = {"latency": 0, "warp": "none", "fill": "none"}


def practice_of(data: Table, checker: Checker) -> Condition | None:
    """No latency and no warp unless said otherwise; how it looks is taken from [common]. None where the file has no [practice]."""
    if PRACTICE not in data:
        return None
    table = data.table(PRACTICE)
    own = {key: table.raw(key) for key in table.keys() if key != "seconds"}  # noqa: SIM118  (a Table is no dict)
    return Condition(PRACTICE, checker.settings(table, own, "practice", beneath=_UNLESS_SAID, only=PICTURE))


def breaks_of(data: Table) -> Breaks:
    """None without [breaks]."""
    if "breaks" not in data:
        return Breaks()
    table = data.table("breaks")
    return Breaks(table.whole("every", 0, 10_000), table.within("seconds", 0, 3600, 0.0))


def sickness_of(data: Table, folder: Path) -> Sickness | None:
    """None without [sickness]. stop_at must be an answer beyond the best one, or nobody would ever begin."""
    if "sickness" not in data:
        return None
    table = data.table("sickness")
    scale = scale_at(table, "scale", table.text("scale"), folder)
    if scale.kind == QUESTIONNAIRE:
        raise table.fault(
            "scale",
            f"has '{scale.name}', a questionnaire of {len(scale.items)} items: wanted what is asked in a moment",
        )
    if scale.kind == RATING:
        raise table.fault(
            "scale",
            f"has '{scale.name}', a rating, and would stand among those of the trials: wanted fms, misc or the like",
        )
    stop_at = table.within("stop_at", scale.least, scale.most, None)
    if stop_at is not None and scale.badness(stop_at) <= 0:
        raise table.fault(
            "stop_at", f"is {stop_at:g}, the best answer of '{scale.name}': wanted a worse one, or everybody is stopped"
        )
    rise = table.within("rise", 0, scale.most - scale.least, None, above=True)
    return Sickness(scale, table.whole("every", 1, 10_000, 1), stop_at, rise)


def questionnaires_of(data: Table, folder: Path) -> tuple[tuple[Scale, ...], tuple[Scale, ...]]:
    """(before, after) the session."""
    if "questionnaires" not in data:
        return (), ()
    table = data.table("questionnaires")
    before, after = (scales_of(table, key, folder, questionnaires=True) for key in ("before", "after"))
    return before, after


def consent_of(data: Table, folder: Path) -> Consent | None:
    """None without [consent]. Its text stands there, or in a file beside the study's."""
    if "consent" not in data:
        return None
    table = data.table("consent")
    version = table.text("version")
    if ("text" in table) == ("file" in table):
        raise table.fault(None, "wanted either text, or file, which names a text beside the study file")
    return Consent(version, table.text("text") if "text" in table else _text_of(table, folder))


def _text_of(table: Table, folder: Path) -> str:
    path = folder / table.text("file")
    try:
        text = text_of(path, "a text that participants read")
    except InputError as error:
        raise table.fault("file", f"is {told(str(path))}: {error}") from error
    if not text.strip():
        raise table.fault("file", f"is {told(str(path))}, which is empty: wanted a text that participants read")
    return text
