"""Finds the ratings that the command line names: a table, a study's store, or published ratings."""

from __future__ import annotations

from pathlib import Path

import attrs

from ...errors import InputError
from ..design import SHIPPED, load_design
from ..scales import RATING
from ..store import DATABASE, PERSON, PILOT, Store, folder_to_read, store_folder
from .claims import Claims, load_claims
from .ratings import Ratings
from .store_ratings import from_contents
from .table_ratings import SourceOptions, from_csv

_PUBLISHED = (
    "These published ratings ship with hmdwarp; so do the figures published with them, which are compared with them."
)


def ratings_from(name: str, store: Path | None, options: SourceOptions) -> Ratings:
    """Return the ratings of a long table (a file) or of a study's store.

    A study is its .toml file, or a shipped one's name; a shipped study without a store stands for
    the ratings published with it. Errors: InputError where there is none of them.
    """
    if not name.endswith(".toml") and Path(name).is_file():
        return from_csv(Path(name), options)
    if name.endswith((".csv", ".tsv", ".txt")):
        raise InputError(
            f"{name}: no such file: expected a table of ratings, a study's .toml file, or a shipped study's name"
        )
    design = load_design(name, checked=False)
    origin = options.origin or PERSON
    published = SHIPPED / f"{name}_ratings.csv"
    if store is None and published.is_file() and not (store_folder(design, None, origin) / DATABASE).exists():
        known = attrs.evolve(
            options, scale=options.scale or next(one.name for one in design.scales if one.kind == RATING)
        )
        return attrs.evolve(from_csv(published, known), title=design.title)
    with Store(folder_to_read(design, store, origin), study=design.name) as data:
        contents = data.contents(pilot=origin == PILOT)
    return from_contents(contents, design, origin)


def claims_for(path: Path | None, ratings: Ratings, options: SourceOptions) -> tuple[Claims | None, str]:
    """Return the published figures to compare with, and a note if the user did not name them.

    They are those of the file, else those shipped for exactly these ratings, if any.
    """
    if path is not None:
        return load_claims(path), ""
    for table in sorted(SHIPPED.glob("*_ratings.csv")):
        claims = table.with_name(table.name.replace("_ratings.csv", "_claims.toml"))
        as_shipped = attrs.evolve(options, columns={}, origin="", scale="grade")
        if claims.is_file() and _values(from_csv(table, as_shipped)) == _values(ratings):
            return load_claims(claims), _PUBLISHED
    return None, ""


def _values(ratings: Ratings) -> set[tuple]:
    return {(row.part, row.participant, row.condition, row.value) for row in ratings.rows}
