"""Command `hmdwarp study run`: a session."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .._signals import Ended

if TYPE_CHECKING:
    from ...study.session import SessionOptions
    from ...study.store import Session

INTERRUPTED = 130

Study = Annotated[
    str,
    typer.Argument(help="Study: a .toml file, or the name of a shipped one.", show_default=False),
]
Participant = Annotated[
    str, typer.Option("--participant", help="Participant's code, never a name; new draws one.", show_default=False)
]
Part = Annotated[str | None, typer.Option("--part", help="Part of the plan, where it has several.", show_default=False)]
Resume = Annotated[bool, typer.Option("--resume", help="Continue an interrupted session at its first undone step.")]
NewSession = Annotated[bool, typer.Option("--new-session", help="Begin a further session of a known participant.")]
Pilot = Annotated[bool, typer.Option("--pilot", help="Rehearse: keep the session apart from people.")]
Simulate = Annotated[
    str | None,
    typer.Option("--simulate", help="Response model (.toml) that answers in place of a person.", show_default=False),
]
Source = Annotated[
    str, typer.Option("--source", help="openxr, desktop, offscreen (no display), or auto: headset, else window.")
]
Trace = Annotated[
    str,
    typer.Option("--trace", help="Recorded head that leads the window or the offscreen display.", show_default=False),
]
Store = Annotated[
    Path | None,
    typer.Option("--store", help="Folder for the data; by default STUDY-data beside the file.", show_default=False),
]
ConsoleKind = Annotated[
    str, typer.Option("--console", help="Experimenter's console: terminal, lines, none; auto: terminal if possible.")
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors and a drawn code.")]


def run(
    study: Study,
    participant: Participant,
    part: Part = None,
    resume: Resume = False,
    new_session: NewSession = False,
    pilot: Pilot = False,
    simulate: Simulate = None,
    source: Source = "auto",
    trace: Trace = "",
    store: Store = None,
    console: ConsoleKind = "auto",
    quiet: Quiet = False,
) -> None:
    """Run a session: show each condition, ask about it, store every answer at once."""
    from ...study.session import SessionOptions

    options = SessionOptions(
        study=study,
        participant=participant,
        part=part,
        resume=resume,
        new_session=new_session,
        pilot=pilot,
        simulate=simulate,
        source=source,
        trace=trace,
        store=store,
        console=console,
    )
    _run(options, quiet)


def _run(options: SessionOptions, quiet: bool) -> None:
    """Run it, and exit with a status of its own where the session was interrupted.

    The closing words are said by then; the usual line "nothing unfinished is left" would be wrong.
    """
    from ...study.session import run_session

    said: list[str] = []
    ends: list[Session] = []
    status = INTERRUPTED

    def end(session: Session) -> None:
        ends.append(session)
        if quiet and options.participant.lower() == "new":
            typer.echo(session.code)

    try:
        session = run_session(options, said.append if quiet else typer.echo, on_end=end)
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
