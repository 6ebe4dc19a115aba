"""Command `hmdwarp study run`: a session."""

from __future__ import annotations

import sys

import attrs
import typer

from ...study import store
from ...study.session import SessionOptions
from .._options import QUIET, Said, takes
from .._signals import Ended

INTERRUPTED = 130


@takes(SessionOptions, attrs.evolve(QUIET, help="Print nothing but errors and a drawn code."))
def run(said: Said) -> None:
    """Run a session: show each condition, ask about it, store every answer at once."""
    _run(SessionOptions.of(said), said["quiet"])


def _run(options: SessionOptions, quiet: bool) -> None:
    """Run it, and exit with a status of its own where the session was interrupted.

    The closing words are printed by then; the usual "nothing unfinished is left" would be wrong.
    """
    from ...study.session import run_session

    said: list[str] = []
    ends: list[store.Session] = []
    status = INTERRUPTED

    def end(session: store.Session) -> None:
        ends.append(session)
        if quiet and options.participant.lower() == "new":
            typer.echo(session.code)

    try:
        session = run_session(options, said.append if quiet else typer.echo, quiet=quiet, on_end=end)
        if session.status != "interrupted":
            return
    except (KeyboardInterrupt, Ended) as error:
        if not ends:
            raise
        if isinstance(error, Ended):
            status = 128 + error.args[0]
    if quiet:
        typer.echo(f"hmdwarp: session interrupted: {ends[0].why}; what was answered is stored, {said[-1]}", err=True)
    sys.exit(status)
