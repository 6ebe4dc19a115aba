"""hmdwarp doctor: what this machine has, what is missing, and how to get it."""

from __future__ import annotations

import attrs
import typer

from ._options import JSON, Said, as_json, takes

COLOURS = {"ok": typer.colors.GREEN, "missing": typer.colors.RED, "optional": typer.colors.YELLOW}


@takes(JSON)
def doctor(said: Said) -> None:
    """Check what this machine has, what is missing, and how to get it.

    OpenGL and its timers, displays, codecs, and each extra.
    """
    from ._checks import examine, replay_can_run

    findings = examine()
    ready = replay_can_run(findings)
    if said["json"]:
        typer.echo(as_json({"replay": ready, "findings": list(map(attrs.asdict, findings))}))
    else:
        for finding in findings:
            mark = typer.style(f"{finding.state:<9}", fg=COLOURS[finding.state])
            typer.echo(f"{mark} {finding.name:<15} {finding.detail}")
            if finding.remedy:
                typer.echo(f"{'':<25} -> {finding.remedy}")
        cannot = "cannot run here: see the lines marked missing."
        typer.echo(f"'hmdwarp replay' {'can run here.' if ready else cannot}")
    if not ready:
        raise typer.Exit(3)
