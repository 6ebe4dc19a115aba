"""hmdwarp list: what there is to choose from."""

from __future__ import annotations

from typing import Annotated

import typer

KINDS = ("warps", "fills", "lenses", "scenes", "headsets", "formats", "recordings")


def list_(
    kind: Annotated[str, typer.Argument(help=f"One of {', '.join(KINDS)}.")],
    json: Annotated[bool, typer.Option("--json", help="As a JSON array of objects.")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="As a Markdown table.")] = False,
) -> None:
    """List the warps, fills, lenses, scenes, headsets, trace formats or recordings there are."""
    from ..catalogue import entries
    from ..registry import unknown_name

    if kind not in KINDS:
        raise unknown_name("list", kind, list(KINDS))
    rows = entries(kind)
    if json:
        import json as json_

        typer.echo(json_.dumps(rows, indent=2))
    elif markdown:
        typer.echo(_markdown(rows))
    else:
        _print_table(kind, rows)


def _markdown(rows: list[dict]) -> str:
    names = list(rows[0])
    lines = ["| " + " | ".join(names) + " |", "|" + " --- |" * len(names)]
    lines += ["| " + " | ".join([f"`{row['name']}`", *(str(row[n]) for n in names[1:])]) + " |" for row in rows]
    return "\n".join(lines)


def _print_table(kind: str, rows: list[dict]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=kind, title_justify="left")
    for name in rows[0]:
        table.add_column(name.replace("_", " "), no_wrap=name == "name")
    for row in rows:
        table.add_row(*(str(value) for value in row.values()))
    Console().print(table)
