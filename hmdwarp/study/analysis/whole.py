"""The whole analysis as plain data: what the page, the printed tables and analysis.json show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs

from ...version import __version__
from ..design import Family
from ..scales import Scale
from . import sentences as say
from .claims import Claims, checked
from .comparisons import Resampling, compared
from .conditions import all_at_once, described, reference_missed
from .copied import copied
from .effects import order_effects
from .families import families_for
from .people import missing, questionnaires, scale_or_none, sickness, sittings
from .predicted import predicted
from .ratings import Ratings

SCHEMA = 1


def analyse(
    ratings: Ratings,
    resampling: Resampling = Resampling(),
    asked: Sequence[str] = (),
    claims: Claims | None = None,  # noqa: B008  (frozen)
) -> dict[str, Any]:
    """Everything that is known of these ratings. The same ratings and seed give the same result, whatever the order of the rows.

    asked: families as families_for has them. claims: published figures to hold against the data. Errors: as families_for; MachineError
    where statsmodels is missing.
    """
    ratings = attrs.evolve(ratings, rows=tuple(sorted(ratings.rows, key=_key)))
    families, why = families_for(ratings, asked)

    def known(name: str) -> Scale | None:
        return ratings.others.get(name) or scale_or_none(name)

    scales = [_on_scale(ratings, name, families, resampling, claims) for name in ratings.scales()]
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "title": ratings.title,
        "source": ratings.source,
        "origin": ratings.origin,
        "seed": resampling.seed,
        "resamples": resampling.resamples,
        "compared": why,
        "notes": list(ratings.notes),
        "participants": len({(row.part, row.participant) for row in ratings.rows}),
        "ratings": sum(row.value is not None for row in ratings.rows),
        "missing": sum(row.value is None for row in ratings.rows),
        "scales": scales,
        "sittings": sittings(ratings),
        "sickness": sickness(ratings, known),
        "questionnaires": questionnaires(ratings, known),
    }


def _key(row: Any) -> tuple[Any, ...]:
    """People in the order of their numbers where they are numbers, then as they went through the session."""
    number = int(row.participant) if row.participant.isdecimal() and len(row.participant) < 10 else 10**10
    return (row.part, number, row.participant, row.session, row.place, row.repeat, row.scale)


def _on_scale(
    ratings: Ratings, scale: str, families: Sequence[Family], resampling: Resampling, claims: Claims | None
) -> dict[str, Any]:
    measure = ratings.measures[scale]
    rows = compared(ratings, scale, families, resampling)
    for row in rows:
        row["sentence"] = say.of_comparison(row, measure)
    parts = [_part(ratings, part, scale, families, resampling) for part in ratings.parts() if ratings.of(part, scale)]
    doubles = copied(ratings, scale, resampling.seed)
    for double in doubles:
        double["sentence"] = say.of_copied(double)
    held = [] if claims is None else checked(claims, rows, ratings, scale)
    for one in held:
        one["sentence"] = say.of_claim(one, claims.title, measure)
    return {
        "measure": attrs.asdict(measure),
        "comparisons": rows,
        "parts": parts,
        "copied": doubles,
        "claims": held,
        "why_step": "" if claims is None else claims.why_step,
        "missing": missing(ratings, scale),
        "prediction": predicted(ratings.long, scale),
    }


def _part(
    ratings: Ratings, part: str, scale: str, families: Sequence[Family], resampling: Resampling
) -> dict[str, Any]:
    measure, table = ratings.measures[scale], ratings.table(part, scale)
    test = all_at_once(table)
    effects = order_effects(ratings.of(part, scale))
    reference = reference_missed(table, ratings.references(part), measure)
    found = {
        "part": part,
        "participants": len(table.participants),
        "conditions": described(ratings, part, scale),
        "friedman": None if test is None else test,
        "friedman_sentence": say.of_friedman(test, part),
        "order": effects,
        "order_sentences": say.of_order(effects, measure),
        "places": _places(ratings, part, scale),
        "reference": reference,
        "reference_sentence": say.of_reference(reference),
    }
    if reference and reference["missed"]:
        rows = compared(ratings, scale, families, resampling, without={part: set(reference["missed"])})
        found["without"] = [
            {key: row[key] for key in ("a", "b", "n", "mean", "p", "holm")} for row in rows if row["part"] == part
        ]
    return found


def _places(ratings: Ratings, part: str, scale: str) -> list[dict[str, Any]]:
    """Each rating less its participant's and its condition's mean, by the place of its trial; none where places are not known."""
    rows = [row for row in ratings.of(part, scale) if row.value is not None and row.place]
    if not rows:
        return []
    overall = sum(row.value for row in rows) / len(rows)

    def means(name: str) -> dict[str, float]:
        groups: dict[str, list[float]] = {}
        for row in rows:
            groups.setdefault(getattr(row, name), []).append(row.value)
        return {key: sum(values) / len(values) for key, values in groups.items()}

    people, conditions = means("participant"), means("condition")
    return [
        {"place": row.place, "rest": row.value - people[row.participant] - conditions[row.condition] + overall}
        for row in rows
    ]
