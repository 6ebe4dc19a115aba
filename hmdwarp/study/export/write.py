"""Exports a study into one folder, whole or not at all: tables, a README and a BIDS data set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import attrs

from ...errors import InputError
from ...report import OutputFolder, counted
from ...resources import __version__, install_line, made_text
from ..design import Design
from ..scales import Scale
from ..store import PERSON, PILOT, SIMULATED, Contents
from .bids import sidecar, write_bids
from .export_rows import Row, all_scales, answer_rows, declined, long_rows, of_origin, score_rows, unconsented
from .table_columns import columns_for, csv_text, has_parquet, write_parquet

# Older versions wrote some of them; a forced export removes what they hold of withdrawn people.
OWNED = (
    *("ratings.*", "ratings_short.csv", "sessions/*.csv", "preferences.csv", "sickness.tsv", "questionnaires.tsv"),
    *("revisions.tsv", "remarks.csv", "columns.json", "bids/**/*"),
)


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
    ratings = long_rows(answers)
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
        notes += _tables(folder, kept, design, answers, ratings, options.parquet)
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
    parquet: bool | None,
) -> list[str]:
    columns = columns_for(ratings)
    folder.write_bytes("ratings.csv", csv_text(ratings, columns).encode())
    described = columns_for(answers, ("phase", "kind", "text"))
    folder.write_json("columns.json", sidecar(described, all_scales(contents, design)))
    notes = ["ratings.csv: one row for each rating"]
    if parquet is None and not has_parquet():
        return [*notes, f"no ratings.parquet: the package pyarrow is not installed ({install_line('study')})"]
    if parquet is not False:
        write_parquet(folder.path("ratings.parquet"), ratings, columns, design.title)
        notes.append("ratings.parquet: the same with typed columns")
    return notes


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

ratings.csv, and ratings.parquet where pyarrow is installed: the same table with one row per rating,
missing ones included, and what was shown. columns.json: meaning, units and values of each column.
bids/: a BIDS data set with all answers, those between the trials and to questionnaires included, and
the motion of the heads.
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
