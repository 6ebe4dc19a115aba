"""What the user names, to ratings: a table, a study's store, or ratings that came with the program."""

from __future__ import annotations

from pathlib import Path

import attrs

from ...errors import InputError
from ..design.read import READY, load_design
from ..store import PERSON, PILOT, Store, store_folder
from ..store.folders import FILE
from .claims import Claims, load_claims
from .from_csv import Given, from_csv
from .from_store import from_contents
from .ratings import Ratings

_PUBLISHED = "These ratings were published, and came with the program; so did what was published about them, which is held against them."


def ratings_from(name: str, store: Path | None, given: Given) -> Ratings:
    """Ratings of a long table (a file), of a study's store (its .toml file, or a shipped one's name), or, where a shipped study has no
    store here, those published with it. Errors: InputError where there is none of them."""
    if not name.endswith(".toml") and Path(name).is_file():
        return from_csv(Path(name), given)
    if name.endswith((".csv", ".tsv", ".txt")):
        raise InputError(
            f"{name}: there is no such file: wanted a table of ratings, a study's .toml file, or a shipped study's name"
        )
    design = load_design(name, checked=False)
    folder = store_folder(design, store)
    published = READY / f"{name}_ratings.csv"
    if not (folder / FILE).exists():
        if store is None and published.is_file():
            known = attrs.evolve(given, scale=given.scale or design.scales[0].name)
            return attrs.evolve(from_csv(published, known), title=design.title)
        raise InputError(
            f"{folder}: there is no data of '{design.name}' yet: run sessions first, or say --store where they are"
        )
    with Store(folder, study=design.name) as data:
        contents = data.contents(pilot=given.origin == PILOT)
    return from_contents(contents, design, given.origin or PERSON)


def claims_for(path: Path | None, ratings: Ratings, given: Given) -> tuple[Claims | None, str]:
    """Published figures, and a sentence where nobody asked for them: the file named, else those about just these ratings, if any."""
    if path is not None:
        return load_claims(path), ""
    for table in sorted(READY.glob("*_ratings.csv")):
        claims = table.with_name(table.name.replace("_ratings.csv", "_claims.toml"))
        if claims.is_file() and _values(
            from_csv(table, attrs.evolve(given, columns={}, origin="", scale="grade"))
        ) == _values(ratings):
            return load_claims(claims), _PUBLISHED
    return None, ""


def _values(ratings: Ratings) -> set[tuple]:
    return {(row.part, row.participant, row.condition, row.value) for row in ratings.rows}
