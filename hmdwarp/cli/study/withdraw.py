"""hmdwarp study withdraw: erase a participant."""

from __future__ import annotations

import sys
from pathlib import Path

import attrs
import typer

from ...options import Declared, option
from .._options import Said, takes
from ._options import pilot_field, simulated_field, store_field, store_of, study_field


@attrs.frozen
class WithdrawOptions(Declared):
    """Who withdraws from which study."""

    study: str = study_field()
    code: str = option(attrs.NOTHING, "The participant's code.", positional=True, metavar="CODE")
    store: Path | None = store_field()
    pilot: bool = pilot_field()
    simulated: bool = simulated_field()
    yes: bool = option(False, "Erase without confirmation.")


@takes(WithdrawOptions)
def withdraw(said: Said) -> None:
    """Erase all ratings, events and head traces of a participant; the code stays reserved."""
    from ...errors import InputError
    from ...study.store import BEYOND, Store

    options = WithdrawOptions.of(said)
    code = options.code
    folder, design = store_of(options)
    with Store(folder, study=None if design is None else design.name, say=typer.echo) as opened:
        if not options.yes and not opened.finish_withdrawal(code):
            if not sys.stdin.isatty():
                raise InputError(f"withdrawing {code} cannot be undone: use --yes, or a terminal for the confirmation")
            found = opened.holdings(code)
            typer.echo(f"{folder} holds of participant {found.code}: {found.describe()}.")
            if not typer.confirm("Erase it for good?"):
                typer.echo("Nothing was erased.")
                return
        erased = opened.withdraw(code)
        known, amount = (code, "the rest of it") if erased is None else (erased.code, erased.describe())
    typer.echo(
        f"Participant {known} has withdrawn; erased: {amount}. The code stays marked, and their order is free. {BEYOND}"
    )
