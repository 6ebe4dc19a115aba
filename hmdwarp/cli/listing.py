"""hmdwarp list: what there is to choose from."""

from __future__ import annotations

from typing import Annotated

import typer

KINDS = (
    "warps",
    "fills",
    "effects",
    "lenses",
    "scenes",
    "headsets",
    "formats",
    "recordings",
    "scales",
    "studies",
    "options",
)


def list_(
    kind: Annotated[str, typer.Argument(help=f"One of {', '.join(KINDS)}.")],
    name: Annotated[str | None, typer.Argument(help="Tell everything about this one.", show_default=False)] = None,
    json: Annotated[bool, typer.Option("--json", help="Everything, as a JSON array of objects.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="Everything, as a Markdown table.")] = False,
) -> None:
    """List what there is to choose from: warps, fills, scenes, recordings, studies and more."""
    from ..errors import InputError
    from ..registry import unknown_name

    if kind not in KINDS:
        raise unknown_name("list", kind, list(KINDS))
    if json and markdown:
        raise InputError("--json and --markdown: expected one of the two")
    rows = _rows(kind, name)
    if json:
        import json as json_

        typer.echo(json_.dumps(rows, indent=2, ensure_ascii=False))
    elif markdown:
        typer.echo(_markdown(rows))
    elif name is not None:
        _print_all_of(rows[0])
    else:
        _print_summaries(kind, rows)


def _rows(kind: str, name: str | None) -> list[dict[str, str]]:
    from ..registry import unknown_name
    from .catalogue import entries

    rows = entries(kind)
    if name is None:
        return rows
    chosen = [row for row in rows if row["name"] == name]
    if not chosen:
        raise unknown_name(
            {"lenses": "lens", "studies": "study"}.get(kind, kind.removesuffix("s")),
            name,
            [row["name"] for row in rows],
        )
    return chosen


def _markdown(rows: list[dict[str, str]]) -> str:
    names = list(rows[0])
    lines = ["| " + " | ".join(names) + " |", "|" + " --- |" * len(names)]
    lines += [
        "| " + " | ".join([f"`{row['name']}`", *(row[n].replace("|", "\\|") for n in names[1:])]) + " |" for row in rows
    ]
    return "\n".join(lines)


def _print_summaries(kind: str, rows: list[dict[str, str]]) -> None:
    from ._show import in_columns, paragraph

    in_columns((row["name"], row["summary"]) for row in rows)
    rest = ", ".join(key.replace("_", " ") for key in list(rows[0])[2:])
    typer.echo()
    paragraph(f"'hmdwarp list {kind} NAME' tells the rest of one: {rest}.")


def _print_all_of(row: dict[str, str]) -> None:
    from ._show import in_columns

    typer.echo(row["name"])
    in_columns(((key.replace("_", " "), text) for key, text in row.items() if key != "name"), indent=2)
