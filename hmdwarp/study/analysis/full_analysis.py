"""The whole analysis: as plain data, and as report.html, analysis.json and tables/*.csv."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...report import OutputFolder
from ...report.study import csv_tables, render_study_report
from ...resources import __version__
from ..design import Family
from ..prediction import prediction_data
from ..scales import Scale
from . import sentences as say
from .claims import Claims, checked
from .comparisons import Resampling, compared, families_for
from .descriptives import (
    asked_once_rows,
    condition_rows,
    friedman_row,
    missing_rows,
    order_effects,
    place_residuals,
    questionnaire_rows,
    reference_votes,
    scale_or_none,
    session_counts,
    sickness_rows,
)
from .preferences import preference_results
from .ratings import Rating, Ratings
from .shared_rows import copied_rows
from .sources import TASK_MEASURES

SCHEMA = 1
REPORT, DATA = "report.html", "analysis.json"


def analysis_folder(folder: str | os.PathLike[str], *, force: bool = False) -> OutputFolder:
    """Return the folder to write an analysis to; made before the work, it checks the place.

    Errors: InputError or MachineError for a place that cannot be written.
    """
    return OutputFolder(folder, owned=("tables/*.csv", REPORT), last=DATA, force=force)


def write_analysis(out: OutputFolder, data: Mapping[str, Any], command: str) -> Path:
    """Write an analysis and return the path that its page will have.

    Errors: InputError or MachineError for a place that cannot be written.
    """
    for name, (columns, rows) in csv_tables(data).items():
        out.write_csv(f"tables/{name}", rows, columns)
    out.write_text(REPORT, render_study_report(data, command))
    out.write_json(DATA, data)
    return out.folder / REPORT


def analyse(
    ratings: Ratings,
    resampling: Resampling = Resampling(),  # noqa: B008  (frozen)
    families: Sequence[str] = (),
    claims: Claims | None = None,
) -> dict[str, Any]:
    """Return the whole analysis as plain data, the same whatever the order of the rows.

    families: as families_for takes them. claims: published figures to compare with the data.
    Errors: as families_for; MachineError where statsmodels is missing.
    """
    ratings = attrs.evolve(ratings, rows=tuple(sorted(ratings.rows, key=_key)))
    compare, why = families_for(ratings, families)

    rated = [row for row in ratings.rows if row.scale not in TASK_MEASURES]

    def known(name: str) -> Scale | None:
        return ratings.scales.get(name) or scale_or_none(name)

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
        "participants": len(
            {(row.part, row.participant) for row in ratings.rows}
            | {(preference.part, preference.participant) for preference in ratings.preferences}
        ),
        "ratings": sum(row.value is not None for row in rated),
        "missing": sum(row.value is None for row in rated),
        "scales": [_on_scale(ratings, name, compare, resampling, claims) for name in ratings.rated_scales()],
        "preferences": preference_results(ratings, compare, resampling),
        "sittings": session_counts(ratings),
        "sickness": sickness_rows(ratings, known),
        "questionnaires": questionnaire_rows(ratings, known),
        "asked_once": asked_once_rows(ratings, known),
    }


def _key(row: Rating) -> tuple[Any, ...]:
    """Sort people by number where they are numbers, then as they went through the session."""
    number = int(row.participant) if row.participant.isdecimal() and len(row.participant) < 10 else 10**10
    return (row.part, number, row.participant, row.session, row.place, row.repeat, row.scale)


def _on_scale(
    ratings: Ratings, scale: str, families: Sequence[Family], resampling: Resampling, claims: Claims | None
) -> dict[str, Any]:
    info = ratings.scale_info[scale]
    rows = compared(ratings, scale, families, resampling)
    for row in rows:
        row["sentence"] = say.of_comparison(row, info)
    parts = [_part(ratings, part, scale, families, resampling) for part in ratings.parts() if ratings.of(part, scale)]
    copies = copied_rows(ratings, scale, resampling.seed)
    for copy in copies:
        copy["sentence"] = say.of_copied(copy)
    published = [] if claims is None else checked(claims, rows, ratings, scale)
    for claim in published:
        claim["sentence"] = say.of_claim(claim, claims.title if claims else "", info)
    return {
        "measure": attrs.asdict(info),
        "comparisons": rows,
        "parts": parts,
        "copied": copies,
        "claims": published,
        "why_step": "" if claims is None else claims.why_step,
        "missing": missing_rows(ratings, scale),
        "prediction": prediction_data(ratings.long, scale),
    }


def _part(
    ratings: Ratings, part: str, scale: str, families: Sequence[Family], resampling: Resampling
) -> dict[str, Any]:
    info, table = ratings.scale_info[scale], ratings.table(part, scale)
    test = friedman_row(table)
    effects = order_effects(ratings.of(part, scale))
    reference = reference_votes(table, ratings.references(part), info)
    found = {
        "part": part,
        "participants": len(table.participants),
        "conditions": condition_rows(ratings, part, scale),
        "friedman": test,
        "friedman_sentence": say.of_friedman(test, part),
        "order": effects,
        "order_sentences": say.of_order(effects, info),
        "places": place_residuals(ratings, part, scale),
        "reference": reference,
        "reference_sentence": say.of_reference(reference),
    }
    if reference and reference["missed"]:
        rows = compared(ratings, scale, families, resampling, without={part: set(reference["missed"])})
        found["without"] = [
            {key: row[key] for key in ("condition", "baseline", "n", "mean", "p", "holm")}
            for row in rows
            if row["part"] == part
        ]
    return found
