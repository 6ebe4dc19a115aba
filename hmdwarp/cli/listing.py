"""hmdwarp list and doctor: what there is to choose from, and what this machine has."""

from __future__ import annotations

import attrs
import typer

from ..errors import InputError, unknown_name
from ..options import Declared, option
from ..registry import Row
from ._options import JSON, Said, as_json, takes
from .catalogue import KINDS, entries, headset_row

# Of one entry, where that is not the list's name without its s.
_ONE = {"lenses": "lens", "studies": "study", "axes": "axes preset"}


@attrs.frozen
class ListOptions(Declared):
    """What to list, and how. Errors: InputError for two forms at once."""

    kind: str | None = option(None, f"One of {', '.join(KINDS)}; by default these kinds are listed.", positional=True)
    name: str | None = option(None, "Show everything about this one; a headset may be a file.", positional=True)
    json: bool = option(False, "Everything, as a JSON array of objects.")
    markdown: bool = option(False, "Everything, as a Markdown table.")

    def __attrs_post_init__(self) -> None:
        if self.json and self.markdown:
            raise InputError("--json and --markdown: expected one of the two")


@takes(ListOptions)
def list_(said: Said) -> None:
    """List what there is to choose from: warps, fills, scenes, recordings, studies and more."""
    from ._show import in_columns, paragraph

    options = ListOptions.of(said)
    rows = _rows(options.kind, options.name)
    columns = list(rows[0])
    if options.json:
        typer.echo(as_json(rows))
    elif options.markdown:
        lines = [columns, ["---"] * len(columns)]
        lines += [[f"`{row['name']}`", *(row[key].replace("|", "\\|") for key in columns[1:])] for row in rows]
        typer.echo("\n".join(f"| {' | '.join(line)} |" for line in lines))
    elif options.name is not None:
        typer.echo(rows[0]["name"])
        in_columns(((key.replace("_", " "), text) for key, text in rows[0].items() if key != "name"), indent=2)
    else:
        in_columns((row["name"], row["summary"]) for row in rows)
        if rest := ", ".join(key.replace("_", " ") for key in columns[2:]):
            typer.echo()
            paragraph(f"'hmdwarp list {options.kind} NAME' tells the rest of one: {rest}.")


def _rows(kind: str | None, name: str | None) -> list[Row]:
    """Return the rows of a list, or the one of a name; of what there are lists of for no kind."""
    if kind is None:
        return [{"name": each, "summary": of.summary} for each, of in KINDS.items()]
    if kind not in KINDS:
        raise unknown_name("list", kind, list(KINDS))
    if kind == "headsets" and name is not None:
        return [headset_row(name)]  # files too
    rows = entries(kind)
    found = rows if name is None else [row for row in rows if row["name"] == name]
    if name is not None and not found:
        raise unknown_name(_ONE.get(kind, kind.removesuffix("s")), name, [row["name"] for row in rows])
    return found


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
