"""Writes everything of a study that may leave the machine into one folder, whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError
from ...report import OutputFolder, counted
from ..design import Design
from ..scales import QUESTIONNAIRE, RATING
from ..store import PERSON, Contents
from .bids import described, write_bids
from .columns import Column, columns_for
from .parquet import HOW, has_parquet, write_parquet
from .rows import Row, answer_rows, of_origin, revision_rows, scales_asked, score_rows
from .text import csv_text, tsv_text
from .words import counts_told, nobody, readme

EXTRA = ("phase", "kind")
REMARKS = (
    Column("participant", "text", "Random word for the participant"),
    Column("session", "whole", "Which sitting of the participant"),
    Column("step", "text", "Step of the session it was made in"),
    Column("by", "text", "Who made it"),
    Column("text", "text", "What was said, as it was typed"),
)


@attrs.frozen(kw_only=True)
class ExportOptions:
    """origin: whose data, one of store.ORIGINS. remarks: what was typed freely too, which may name somebody. revisions: also every answer
    that was corrected later. parquet: True for an error where it cannot be written, False for none, None for whether it can be."""

    origin: str = PERSON
    remarks: bool = False
    revisions: bool = False
    parquet: bool | None = None


@attrs.frozen
class Exported:
    """told: what was written, in sentences."""

    folder: Path
    told: tuple[str, ...]


def export(
    contents: Contents,
    design: Design,
    out: Path,
    options: ExportOptions | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Exported:
    """out: a folder that is not there, or empty: an older export may hold people who have withdrawn since.

    Errors: InputError for a folder that is not empty, a study without such sessions, or a plan that is not theirs; MachineError for a full
    disk, and where Parquet must be and pyarrow is missing.
    """
    options = options or ExportOptions()
    kept = of_origin(contents, options.origin)
    if not kept.sessions:
        raise InputError(nobody(contents, options.origin, "export"))
    _refuse_full(out)
    answers = answer_rows(kept, design)
    ratings = [row for row in answers if row["phase"] == "trial" and row["kind"] == RATING]
    with OutputFolder(out, last="README") as folder:
        told = [counts_told(kept, ratings, options.origin)]
        if changed := sum(session.plan != design.text for session in kept.sessions):
            told.append(
                f"the study's file was changed after {counted(changed, 'session')}: each is written by the plan it was run by"
            )
        told += _tables(folder, kept, design, answers, ratings, options)
        text = readme(design, kept, ratings, options.origin)
        left = write_bids(folder, kept, design, [*answers, *score_rows(kept, design)], text, progress)
        told.append(f"bids/: a BIDS data set with {counted(left.motions, 'recording')} of head motion: personal data")
        told += [f"left out: {why}" for why in left.why_not]
        folder.write_text("README", text)
    return Exported(Path(out), tuple(told))


def _tables(
    folder: OutputFolder,
    contents: Contents,
    design: Design,
    answers: Sequence[Row],
    ratings: Sequence[Row],
    options: ExportOptions,
) -> list[str]:
    columns = columns_for(ratings)
    folder.write_bytes("ratings.csv", csv_text(ratings, columns).encode())
    folder.write_text("ratings.tsv", tsv_text(ratings, columns))
    told = ["ratings.csv, ratings.tsv: one row for each rating"]
    told.append(_parquet(folder, ratings, columns, design, options.parquet))
    sickness = [row for row in answers if row["kind"] not in (RATING, QUESTIONNAIRE)]
    questionnaires = [row for row in answers if row["kind"] == QUESTIONNAIRE] + score_rows(contents, design)
    for name, rows in (("sickness", sickness), ("questionnaires", questionnaires)):
        if rows:
            folder.write_text(f"{name}.tsv", tsv_text(rows, _short(rows)))
            told.append(f"{name}.tsv: {counted(len(rows), 'row')}")
    if options.revisions:
        rows = revision_rows(contents, design)
        folder.write_text("revisions.tsv", tsv_text(rows, _short(rows)))
        told.append(f"revisions.tsv: {counted(len(rows), 'answer')}, with those that were corrected later")
    if options.remarks:
        told.append(_remarks(folder, contents))
    folder.write_json("columns.json", described(columns_for(answers, EXTRA), scales_asked(contents, design)))
    return [text for text in told if text]


def _short(rows: Sequence[Row]) -> tuple[Column, ...]:
    """Without what was shown meanwhile: the ratings have that."""
    return tuple(c for c in columns_for(rows, EXTRA) if not c.name.startswith(("actual_", "measured_")))


def _parquet(
    folder: OutputFolder, rows: Sequence[Row], columns: Sequence[Column], design: Design, wanted: bool | None
) -> str:
    if wanted is False:
        return ""
    if wanted is None and not has_parquet():
        return f"no ratings.parquet: the package pyarrow is not installed ({HOW})"
    write_parquet(folder.path("ratings.parquet"), rows, columns, design.title)
    return "ratings.parquet: the same with typed columns"


def _remarks(folder: OutputFolder, contents: Contents) -> str:
    people = {one.id: one for one in contents.sessions}
    rows = [
        {"participant": people[e.session].sub, "session": people[e.session].number, "step": e.key, **_said(e.data)}
        for e in contents.events
        if e.kind == "remark"
    ]
    # CSV alone: what people type may hold line ends, which TSV has no way to say.
    folder.write_bytes("remarks.csv", csv_text(rows, REMARKS).encode())
    return f"remarks.csv: {counted(len(rows), 'remark')}, as typed: read them before you pass them on, they may name somebody"


def _said(data: Any) -> Row:
    return {"by": data.get("by"), "text": data.get("text")}


def _refuse_full(out: Path) -> None:
    if out.is_dir() and any(out.iterdir()):
        raise InputError(
            f"{out}: is there already and not empty: an older export may hold somebody who has withdrawn since; delete it, or name "
            "another folder by --out"
        )
