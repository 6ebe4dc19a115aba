"""What stands beside the tables, for who opens the folder in ten years."""

from __future__ import annotations

from collections.abc import Sequence

from ...report import counted
from ...version import __version__
from ..design import Design
from ..scales import Scale
from ..store import PERSON, PILOT, SIMULATED, Contents
from .rows import Row

_WHOSE = {
    PERSON: ("a person", "people"),
    PILOT: ("a pilot, who tried the study out", "pilots, who tried the study out"),
    SIMULATED: ("a program that answered instead of a person", "programs that answered instead of people"),
}
_ONE = {PERSON: "person", PILOT: "pilot", SIMULATED: "simulated participant"}


def counts_told(contents: Contents, ratings: Sequence[Row], origin: str) -> str:
    """How many there are of everything."""
    people = len({one.sub for one in contents.sessions})
    given = sum(row["value"] is not None for row in ratings)
    missing = f", {len(ratings) - given} missing" if len(ratings) > given else ""
    whose = _WHOSE[origin][people != 1]
    return f"{counted(people, 'participant')} ({whose}) in {counted(len(contents.sessions), 'session')}, {counted(given, 'rating')}{missing}"


def nobody(contents: Contents, origin: str, verb: str) -> str:
    """That there are no sessions of that origin, and what to do. contents: of all that were asked for. verb: what is not done with them."""
    there = {one.origin for one in contents.sessions} - {origin}
    run = "run one with --pilot" if origin == PILOT else "run one"
    hint = f"{run} first, or see whether --store is the right folder"
    if PERSON in there:
        hint = f"it holds sessions of people: leave --{origin} away"
    elif there:
        other = min(there)
        hint = f"it holds {other} ones: say --{other}"
    return f"{contents.folder}: no session of a {_ONE[origin]} to {verb}: {hint}"


def readme(design: Design, contents: Contents, ratings: Sequence[Row], origin: str) -> str:
    """For the root of the folder and of the BIDS tree."""
    scales = ", ".join(_asked(scale) for scale in design.scales)
    conditions = "\n".join(f"  {part.name}: {', '.join(one.name for one in part.conditions)}" for part in design.parts)
    return f"""{design.title}

Study "{design.name}", exported by hmdwarp {__version__}: {counts_told(contents, ratings, origin)}.
Asked after each trial: {scales}.
Conditions, by part of the study:
{conditions}

ratings.csv, ratings.tsv: one row for each rating, missing ones among them, with what was shown. The same twice, and a third time as
ratings.parquet where that was written. Where they were asked: sickness.tsv, how sick people felt between the trials, and
questionnaires.tsv, answers and scores before and after.
columns.json: what each column is, its units and its values. bids/: the same as a BIDS data set, with the motion of the heads.
Missing is n/a, in Parquet null. Numbers have decimal points. Of answers that were corrected the last one counts.

Privacy: participants are random words, which nothing here leads back from. No date and no time of day is in here: instants count from
the beginning of a session, which BIDS writes as 1925-01-01. Head motion is personal data all the same: it can tell a person from
hundreds of others within minutes. Give the folder bids/ only to whom the participants agreed to. Who withdraws later must be erased
here too, by hand: delete this folder and export again.
"""


def _asked(scale: Scale) -> str:
    return f"{scale.name} ({scale.least:g} to {scale.most:g}, {'low' if scale.low_is_good else 'high'} is good)"
