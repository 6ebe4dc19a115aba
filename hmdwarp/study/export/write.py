"""Exports a study into one folder, whole or not at all: tables, a README and a BIDS data set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import attrs

from ...errors import InputError
from ...report import OutputFolder, counted
from ...resources import __version__, install_line, made_text
from ..design import Design
from ..scales import QUESTIONNAIRE, RATING, SICKNESS, Scale
from ..store import PERSON, PILOT, SIMULATED, Contents
from .bids import sidecar, write_bids
from .export_rows import (
    PREFERENCES,
    SHORT,
    Row,
    all_scales,
    answer_rows,
    declined,
    of_origin,
    pair_rows,
    preference_rows,
    revision_rows,
    score_rows,
    short_rows,
    unconsented,
)
from .table_columns import Column, columns_for, columns_in, csv_text, has_parquet, tsv_text, write_parquet

EXTRA = ("phase", "kind", "text")
OWNED = (
    *("ratings.*", "sessions/*.csv", "preferences.csv", "sickness.tsv", "questionnaires.tsv", "revisions.tsv"),
    *("remarks.csv", "columns.json", "bids/**/*"),
)
REMARKS = columns_in("remarks")


_WHOSE = {
    PERSON: ("a person", "people"),
    PILOT: ("a pilot, who tried the study out", "pilots, who tried the study out"),
    SIMULATED: ("a program that answered instead of a person", "programs that answered instead of people"),
}
_ONE = {PERSON: "person", PILOT: "pilot", SIMULATED: "simulated participant"}


@attrs.frozen(kw_only=True)
class ExportOptions:
    """What to export."""

    origin: str = PERSON  # one of store.ORIGINS
    remarks: bool = False  # free text too, which may name people
    revisions: bool = False  # also answers that were corrected later
    parquet: bool | None = None  # True: an error where it cannot be written; None: if possible
    force: bool = False  # into a folder that holds files; those of an older export go


@attrs.frozen
class Exported:
    """Result of an export."""

    folder: Path
    notes: tuple[str, ...]  # what was written, in sentences


def export(
    contents: Contents,
    design: Design,
    out: Path,
    options: ExportOptions | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Exported:
    """Export a study.

    out: a new or empty folder, unless forced: an older export may hold people who have withdrawn
    since.
    Errors: InputError for a folder that is not empty, a study without such sessions, or a plan that
    is not theirs; MachineError for a full disk, and where Parquet is required and pyarrow is
    missing.
    """
    options = options or ExportOptions()
    kept = of_origin(contents, options.origin)
    if not kept.sessions:
        raise InputError(no_sessions(contents, options.origin, "export"))
    if not options.force:
        _refuse_full(out)
    answers = answer_rows(kept, design)
    ratings = [row for row in answers if row["phase"] == "trial" and row["kind"] == RATING]
    with OutputFolder(out, owned=OWNED, last="README", force=options.force, private=True) as folder:
        notes = [_counts(kept, ratings, options.origin)]
        if changed := sum(session.plan != design.text for session in kept.sessions):
            notes.append(
                f"the study's file was changed after {counted(changed, 'session')}: each is written by the plan it "
                "ran with"
            )
        if count := declined(contents, options.origin):
            notes.append(f"{counted(count, 'person')} declined to take part: in no table")
        if count := unconsented(contents, options.origin):
            notes.append(f"{counted(count, 'person')} left before the consent was given: in no table")
        notes += _tables(folder, kept, design, answers, ratings, options)
        text = _readme(design, kept, ratings, options.origin)
        motion = write_bids(folder, kept, design, [*answers, *score_rows(kept, design)], text, progress)
        notes.append(
            f"bids/: a BIDS data set with {counted(motion.written, 'recording')} of head motion: personal data"
        )
        notes += [f"left out: {why}" for why in motion.left_out]
        folder.write_text("README", text)
    return Exported(Path(out), tuple(notes))


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
    notes = ["ratings.csv, ratings.tsv: one row for each rating"]
    short = short_rows(ratings)
    folder.write_text("ratings_short.csv", csv_text(short, SHORT))
    for session in contents.sessions:
        own = [row for row in short if (row["participant"], row["session"]) == (session.sub, session.number)]
        folder.write_text(f"sessions/{session.sub}_ses-{session.number:02d}.csv", csv_text(own, SHORT))
    notes.append(f"ratings_short.csv: the same in {len(SHORT)} columns; sessions/: the same, a file for each session")
    notes.append(_parquet(folder, ratings, columns, design, options.parquet))
    if pairs := preference_rows(pair_rows(contents, design)):
        folder.write_text("preferences.csv", csv_text(pairs, PREFERENCES))
        notes.append(f"preferences.csv: {counted(len(pairs), 'pair')} that were compared")
    sickness = [row for row in answers if row["kind"] == SICKNESS]
    questionnaires = [row for row in answers if row["kind"] == QUESTIONNAIRE] + score_rows(contents, design)
    for name, rows in (("sickness", sickness), ("questionnaires", questionnaires)):
        if rows:
            folder.write_text(f"{name}.tsv", tsv_text(rows, _short(rows)))
            notes.append(f"{name}.tsv: {counted(len(rows), 'row')}")
    if options.revisions:
        rows = revision_rows(contents, design)
        folder.write_text("revisions.tsv", tsv_text(rows, _short(rows)))
        notes.append(f"revisions.tsv: {counted(len(rows), 'answer')}, with those that were corrected later")
    if options.remarks:
        notes.append(_remarks(folder, contents))
    folder.write_json(
        "columns.json", sidecar((*columns_for(answers, EXTRA), *SHORT, *PREFERENCES), all_scales(contents, design))
    )
    return [text for text in notes if text]


def _short(rows: Sequence[Row]) -> tuple[Column, ...]:
    """Leave out the columns of what was shown: the ratings have them."""
    return tuple(c for c in columns_for(rows, EXTRA) if not c.name.startswith(("actual_", "measured_")))


def _parquet(
    folder: OutputFolder, rows: Sequence[Row], columns: Sequence[Column], design: Design, wanted: bool | None
) -> str:
    if wanted is False:
        return ""
    if wanted is None and not has_parquet():
        return f"no ratings.parquet: the package pyarrow is not installed ({install_line('study')})"
    write_parquet(folder.path("ratings.parquet"), rows, columns, design.title)
    return "ratings.parquet: the same with typed columns"


def _remarks(folder: OutputFolder, contents: Contents) -> str:
    people = {session.id: session for session in contents.sessions}
    rows = [
        {
            "participant": people[e.session].sub,
            "session": people[e.session].number,
            "step": e.key,
            "by": e.data.get("by"),
            "text": e.data.get("text"),
        }
        for e in contents.events
        if e.kind == "remark"
    ]
    # Only CSV: what people type may hold line ends, which TSV cannot represent.
    folder.write_bytes("remarks.csv", csv_text(rows, REMARKS).encode())
    return (
        f"remarks.csv: {counted(len(rows), 'remark')}, as typed: they may name people; read them before passing them on"
    )


def _refuse_full(out: Path) -> None:
    if out.is_dir() and any(out.iterdir()):
        raise InputError(
            f"{out}: exists and is not empty: an older export may hold participants who have withdrawn since; "
            "choose another folder, or replace it with --force"
        )


def _counts(contents: Contents, ratings: Sequence[Row], origin: str) -> str:
    people = len({session.sub for session in contents.sessions})
    rated = sum(row["value"] is not None for row in ratings)
    missing = f", {len(ratings) - rated} missing" if len(ratings) > rated else ""
    whose = _WHOSE[origin][people != 1]
    sessions, ratings_ = counted(len(contents.sessions), "session"), counted(rated, "rating")
    return f"{counted(people, 'participant')} ({whose}) in {sessions}, {ratings_}{missing}"


def no_sessions(contents: Contents, origin: str, verb: str) -> str:
    """Describe that there are no sessions of that origin, and what to do.

    contents: of all origins. verb: what cannot be done without them.
    """
    there = {session.origin for session in contents.sessions if session.consented} - {origin}
    run = "run one with --pilot" if origin == PILOT else "run one"
    hint = f"{run} first, or check the folder of --store"
    if PERSON in there:
        hint = f"it holds sessions of people: leave out --{origin}"
    elif there:
        other = min(there)
        hint = f"it holds {other} ones: use --{other}"
    elif none := declined(contents, origin) + unconsented(contents, origin):
        hint = f"{counted(none, 'session')} ended without the consent, and count nowhere; {hint}"
    return f"{contents.folder}: no session of a {_ONE[origin]} to {verb}: {hint}"


def _readme(design: Design, contents: Contents, ratings: Sequence[Row], origin: str) -> str:
    scales = ", ".join(_scale_text(scale) for scale in design.scales)
    conditions = "\n".join(
        f"  {part.name}: {', '.join(condition.name for condition in part.conditions)}" for part in design.parts
    )
    return f"""{design.title}

Study "{design.name}", exported by hmdwarp {__version__} ({made_text()}): {_counts(contents, ratings, origin)}.
Asked after each trial: {scales}.
Conditions, by part of the study:
{conditions}

ratings.csv, ratings.tsv, and ratings.parquet where pyarrow is installed: the same table with one
row per rating, missing ones included, and what was shown. ratings_short.csv: the columns that an
analysis needs first, with onset, duration and block of each trial; sessions/ has the same, one file
for each session. ppid is the participant, as UXF and similar programs name the column. If the study
has them: sickness.tsv, sickness between the trials, and questionnaires.tsv, answers and scores
before and after the session; preferences.csv, which of two conditions was preferred.
columns.json: meaning, units and values of each column. bids/: the same as a BIDS data set, with the
motion of the heads.
In bids/ authors, licence and institution are left for you to fill in.
Missing values are n/a, in Parquet null. Numbers have decimal points. Of corrected answers the last
one counts. A text that begins with = + - or @ (blanks, apostrophes, a tab or a line end before it
count as well) and is no number has an apostrophe put before it, so that no spreadsheet runs it:
take that one off for the text as it was typed, as 'hmdwarp study analyse' does. Parquet has it as
typed.

Privacy: participants are random words, which cannot be traced back from this folder. It holds no
date and no time of day: instants count from the beginning of a session, which BIDS writes as
1925-01-01. Head motion is personal data all the same: minutes of it identify a person among
hundreds. Give the folder bids/ only to recipients to whom the participants agreed. Participants who
withdraw later must be erased here too, by hand: delete this folder and export again.
"""


def _scale_text(scale: Scale) -> str:
    if not scale.has_answers:
        return scale.name
    return f"{scale.name} ({scale.least:g} to {scale.most:g}, {'low' if scale.low_is_good else 'high'} is good)"
