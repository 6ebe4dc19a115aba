"""The analysis of a study: one long table of ratings, what it says, and its page and files."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...options import PAPER, PaperOptions
from ...report import OutputFolder, write_paper
from ...report.study import csv_tables, study_page
from ...resources import __version__, made_with
from ..design import SHIPPED, Family
from . import findings, sentences
from .correlation import correlation_data
from .findings import Claims, Resampling, families_for, load_claims
from .long_table import Ratings, SourceOptions, from_csv

SCHEMA = 1
REPORT, DATA = "report.html", "analysis.json"
Row = dict[str, Any]


def analysis_folder(folder: str | os.PathLike[str], *, force: bool = False) -> OutputFolder:
    """Return the folder to write an analysis to; made before the work, it checks the place.

    Errors: InputError or MachineError for a place that cannot be written.
    """
    return OutputFolder(folder, owned=("tables/*.csv", REPORT, *PAPER), last=DATA, force=force)


def write_analysis(out: OutputFolder, data: Mapping[str, Any], command: str, paper: PaperOptions | None = None) -> Path:
    """Write an analysis and return the path that its page will have. Errors: as analysis_folder."""
    for name, (columns, rows) in csv_tables(data).items():
        out.write_csv(f"tables/{name}", rows, columns)
    page = study_page(data, command)
    out.write_text(REPORT, page.html())
    write_paper(out, page, paper or PaperOptions())
    out.write_json(DATA, data)
    return out.folder / REPORT


def analyse(
    ratings: Ratings,
    resampling: Resampling = Resampling(),  # noqa: B008  (frozen)
    families: Sequence[str] = (),
    claims: Claims | None = None,
) -> Row:
    """Return the whole analysis as plain data, the same whatever the order of the rows.

    families: as families_for takes them. claims: published figures to compare with the data.
    Errors: as families_for; MachineError where statsmodels is missing.
    """
    rows = ratings.rows.assign(number=ratings.rows["participant"].str.extract(r"^([0-9]{1,9})$")[0].astype(float))
    order = ["part", "number", "participant", "session", "place", "repeat", "scale"]
    ratings = attrs.evolve(ratings, rows=rows.sort_values(order))
    compare, why = families_for(ratings, families)
    people = [*zip(ratings.rows["part"], ratings.rows["participant"], strict=True)]
    people += [*zip(ratings.preferences["part"], ratings.preferences["participant"], strict=True)]
    questionnaires, asked_once = findings.questionnaire_rows(ratings)
    return {
        "schema": SCHEMA,
        "hmdwarp": __version__,
        "made_with": made_with(),
        "title": ratings.title,
        "source": ratings.source,
        "origin": ratings.origin,
        "seed": resampling.seed,
        "resamples": resampling.resamples,
        "compared": why,
        "notes": list(ratings.notes),
        "participants": len(set(people)),
        "ratings": int(ratings.rows["value"].notna().sum()),
        "missing": int(ratings.rows["value"].isna().sum()),
        "scales": [_on_scale(ratings, name, compare, resampling, claims) for name in ratings.rated_scales()],
        "preferences": sentences.said_of_preferences(findings.preference_results(ratings, compare, resampling)),
        "sittings": findings.session_counts(ratings),
        "sickness": findings.sickness_rows(ratings),
        "questionnaires": questionnaires,
        "asked_once": asked_once,
    }


def _on_scale(
    ratings: Ratings, scale: str, families: Sequence[Family], resampling: Resampling, claims: Claims | None
) -> Row:
    info = ratings.scale_info[scale]
    rows = findings.compared(ratings, scale, families, resampling)
    copied = findings.copied_rows(ratings, scale, resampling.seed)
    published = [] if claims is None else [findings.checked(one, rows, ratings, scale) for one in claims.claims]
    return {
        "measure": attrs.asdict(info),
        "comparisons": [row | {"sentence": sentences.sentence_of_comparison(row, info)} for row in rows],
        "parts": [
            _part(ratings, part, scale, families, resampling)
            for part in ratings.parts()
            if len(ratings.of(part, scale))
        ],
        "copied": [row | {"sentence": sentences.sentence_of_copied(row)} for row in copied],
        "claims": [
            row | {"sentence": sentences.sentence_of_claim(row, claims.title, info)} for row in published if claims
        ],
        "why_step": "" if claims is None else claims.why_step,
        "missing": findings.missing_rows(ratings, scale),
        "prediction": correlation_data(ratings.rows, scale),
    }


def _part(ratings: Ratings, part: str, scale: str, families: Sequence[Family], resampling: Resampling) -> Row:
    info, table, rows = ratings.scale_info[scale], ratings.table(part, scale), ratings.of(part, scale)
    test, effects = findings.friedman_row(table), findings.order_effects(rows)
    reference = findings.reference_votes(table, ratings.references(part), info)
    found = {
        "part": part,
        "participants": len(table),
        "conditions": findings.condition_rows(ratings, part, scale),
        "friedman": test,
        "friedman_sentence": sentences.sentence_of_friedman(test, part),
        "order": effects,
        "order_sentences": sentences.sentences_of_order(effects, info),
        "places": findings.place_residuals(rows),
        "reference": reference,
        "reference_sentence": sentences.sentence_of_reference(reference),
    }
    if reference and reference["missed"]:
        again = findings.compared(ratings, scale, families, resampling, without={part: reference["missed"]})
        keys = ("condition", "baseline", "n", "mean", "p", "holm")
        found["without"] = [{key: row[key] for key in keys} for row in again if row["part"] == part]
    return found


def published_ratings(part: str, latency_ms: float) -> dict[str, float | None]:
    """Return what the published ratings of one part and latency say, and what the thesis says.

    mean: of the pairs' differences, positive where the warped picture was rated better, on the
    scale of grades; p: exact, two-sided, after Holm within the part.
    """
    scale = _published_analysis()["scales"][0]
    at = [claim for claim in scale["claims"] if (claim["part"], claim["latency_ms"]) == (part, latency_ms)]
    claim = next(claim for claim in at if claim["difference"] is not None)
    place = part, claim["baseline"], claim["condition"]
    row = next(row for row in scale["comparisons"] if (row["part"], row["baseline"], row["condition"]) == place)
    (conditions,) = (found["conditions"] for found in scale["parts"] if found["part"] == part)
    means = {condition["condition"]: condition["mean"] for condition in conditions}
    off = abs(row["mean"] - claim["difference"])
    figures = {"mean": row["mean"], "p": row["holm"], "published": claim["difference"], "off": off}
    return figures | {"late": means[row["baseline"]], "warped": means[row["condition"]]}


@functools.cache
def _published_analysis() -> Row:
    found = from_csv(SHIPPED / "thesis_ratings.csv", SourceOptions(scale="grade"))
    return analyse(found, claims=load_claims(SHIPPED / "thesis_claims.toml"))
