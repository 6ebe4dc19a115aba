"""What the answers to a questionnaire come to."""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import InputError
from ...registry import unknown_name
from ._model import SCORES, Scale, Score


def scored(scale: Scale, answers: Mapping[str, float | None]) -> dict[str, float | None]:
    """Each score of the scale by name; None where an answer it is made of is missing or None. answers: by the keys of the items.

    Errors: InputError for an item the scale has not, or an answer outside of it.
    """
    known = [item.key for item in scale.items]
    for key, value in answers.items():
        if key not in known:
            raise unknown_name(f"item of scale '{scale.name}'", key, known)
        if value is not None and not scale.least <= value <= scale.most:
            raise InputError(
                f"scale '{scale.name}', item '{key}': {value:g}: wanted an answer from {scale.least:g} to {scale.most:g}"
            )
    sums: dict[str, float | None] = {}
    scores: dict[str, float | None] = {}
    for score in scale.scores:
        sums[score.name] = total = _sum(score, [answers.get(key) for key in known], sums, scores)
        scores[score.name] = None if total is None else total * score.weight
    return scores


def most_scored(scale: Scale) -> dict[str, float]:
    """What each score comes to where every answer is the highest one."""
    return scored(scale, {item.key: scale.most for item in scale.items})  # type: ignore[return-value]


def _sum(score: Score, values: list[float | None], sums: Mapping, scores: Mapping) -> float | None:
    """Before its weight."""
    parts = (
        [(scores if score.of_what == SCORES else sums)[name] for name in score.of]
        if score.of
        else [values[n - 1] for n in score.items]
    )
    return None if None in parts else sum(parts)  # type: ignore[arg-type]
