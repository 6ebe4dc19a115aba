"""hmdwarp study withdraw: erase a participant."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer


def withdraw(
    study: Annotated[
        str, typer.Argument(metavar="STUDY", help="The study's file (.toml), or the name of a shipped one.")
    ],
    code: Annotated[str, typer.Argument(metavar="CODE", help="The participant's code.")],
    store: Annotated[
        Path | None, typer.Option("--store", help="The folder of the study's data, if not the usual one.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
) -> None:
    """Erase all ratings, events and head traces of a participant, for good; an empty mark stays, so that the code is not used again."""
    from ...errors import InputError
    from ...study.store import Store
    from ...study.withdraw import BEYOND, holdings, was_cut_off
    from ...study.withdraw import withdraw as go

    folder, name = _where(study, store)
    with Store(folder, study=name, say=typer.echo) as opened:
        if not yes and not was_cut_off(opened, code):
            if not sys.stdin.isatty():
                raise InputError(
                    f"withdrawing {code} cannot be undone: say --yes, or use a terminal, where it is asked"
                )
            found = holdings(opened, code)
            typer.echo(f"{folder} holds of participant {found.code}: {found.words()}.")
            if not typer.confirm("Erase it for good?"):
                typer.echo("Nothing was erased.")
                return
        erased = go(opened, code)
        known, told = (code, "the rest of it") if erased is None else (erased.code, erased.words())
    typer.echo(
        f"Participant {known} has withdrawn; erased: {told}. The code stays marked, and their order is free. {BEYOND}"
    )


def _where(study: str, store: Path | None) -> tuple[Path, str | None]:
    """The folder and the study's name. A file that has become wrong must not keep anybody from withdrawing: --store is enough then."""
    from ...errors import InputError
    from ...study.design.read import load_design
    from ...study.store import store_folder

    try:
        design = load_design(study, checked=False)
    except InputError:
        if store is None:
            raise
        return store, None
    return store_folder(design, store), design.name
