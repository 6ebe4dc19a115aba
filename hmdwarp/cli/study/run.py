"""hmdwarp study run: a session."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .._signals import Ended

if TYPE_CHECKING:
    from ...study.run.options import RunSession
    from ...study.store import Session

INTERRUPTED = 130

Study = Annotated[
    str,
    typer.Argument(help="The study: a .toml file, or the name of one that came with the program.", show_default=False),
]
Participant = Annotated[
    str, typer.Option("--participant", help="A code, never a name; new draws one.", show_default=False)
]
Part = Annotated[
    str | None, typer.Option("--part", help="Which part of the plan, where it has several.", show_default=False)
]
Resume = Annotated[
    bool, typer.Option("--resume", help="Go on with an interrupted session, at the first step that is not done.")
]
NewSession = Annotated[bool, typer.Option("--new-session", help="A further session of somebody known.")]
Pilot = Annotated[bool, typer.Option("--pilot", help="A rehearsal: kept apart from people, counted apart.")]
Simulate = Annotated[
    str | None,
    typer.Option("--simulate", help="A response model (.toml) answers in place of somebody.", show_default=False),
]
Source = Annotated[
    str, typer.Option("--source", help="openxr, desktop, offscreen (nobody looks), or auto: headset, else window.")
]
Trace = Annotated[
    str, typer.Option("--trace", help="A recorded head leads the window or the offscreen display.", show_default=False)
]
Store = Annotated[
    Path | None,
    typer.Option("--store", help="Folder for the data; by default STUDY-data beside the file.", show_default=False),
]
DeskKind = Annotated[
    str, typer.Option("--desk", help="The experimenter's: terminal, lines, none, or auto: terminal where it can be.")
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors, and a code that was drawn.")]


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
    desk: DeskKind = "auto",
    quiet: Quiet = False,
) -> None:
    """Run a session: show each condition, ask after it, store every answer before the next thing happens."""
    from ...study.run.options import RunSession

    options = RunSession(
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
        desk=desk,
    )
    _run(options, quiet)


def _run(options: RunSession, quiet: bool) -> None:
    """Leaves the program where the session was interrupted. What it left is told by then; the line for commands that leave nothing behind
    would be wrong.
    """
    from ...study.run.session import run_session

    said: list[str] = []
    ends: list[Session] = []
    status = INTERRUPTED

    def end(session: Session) -> None:
        ends.append(session)
        if quiet and options.participant.lower() == "new":
            typer.echo(session.code)

    try:
        session = run_session(options, said.append if quiet else typer.echo, told=end)
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
