"""Stop rule: when a session has to end because the participant feels sick."""

from __future__ import annotations

from collections.abc import Iterable

from ..design import Sickness
from ..store import Answer

AFTER = "after"


def counting(answers: Iterable[Answer]) -> dict[str, Answer]:
    """Return the newest revision of each answer by the key of its question.

    They are in the order in which the questions were first answered.
    """
    newest: dict[str, Answer] = {}
    for answer in answers:
        known = newest.get(answer.key)
        if known is None or answer.revision > known.revision:
            newest[answer.key] = answer
    return newest


def why_sick(rule: Sickness | None, answers: Iterable[Answer]) -> str:
    """Return why the stop rule ends the session, in words; "" as long as it may go on.

    The newest answer on the rule's scale decides, so that a slip corrected at once does not end the
    session; "cannot say" decides nothing. A rise counts from the first answer of the session.
    Questions after all trials end nothing any more.
    """
    if rule is None:
        return ""
    asked = [one for one in counting(answers).values() if one.scale == rule.scale.name and one.phase != AFTER]
    given = [one.value for one in asked if one.value is not None]
    if not given:
        return ""
    first, last = given[0], given[-1]
    title = rule.scale.title
    if rule.stop_at is not None and rule.scale.badness(last) >= rule.scale.badness(rule.stop_at):
        return f"{title}: {last:g}, and the session ends at {rule.stop_at:g}"
    if rule.rise is not None and rule.scale.badness(last) - rule.scale.badness(first) >= rule.rise:
        return f"{title}: {last:g} after {first:g} at first, and the session ends at a rise of {rule.rise:g}"
    return ""
