"""hmdwarp list: what there is to choose from."""

from __future__ import annotations

import attrs
import typer

from ..errors import InputError
from ..options import Declared, option
from ._options import Said, as_json, takes

KINDS = {
    "strategies": "What crosses the link, and what the client does with it.",
    "warps": "Move a late picture to the newest head pose.",
    "fills": "Close the holes that a warp leaves.",
    "repairs": "Mend depth as cameras give it, before the warp.",
    "metrics": "What is measured of each picture.",
    "effects": "What a scene may call for beside plain surfaces: mirrors, moving bodies, glass, overlays.",
    "lenses": "Correct the lens of a headset.",
    "scenes": "What is rendered, beside files of your own.",
    "headsets": "Displays that can be emulated.",
    "clients": "Devices that warp, with what each can do.",
    "axes": "Axes of head traces, by the software that writes them.",
    "formats": "Formats of head traces.",
    "layouts": "Layouts of recorded frames.",
    "layers": "What a frame holds beside its picture.",
    "predictors": "Foretell the head's pose.",
    "codecs": "Encode and decode what crosses the link.",
    "delays": "How the latency varies from frame to frame.",
    "recordings": "Head traces that are part of the package.",
    "scales": "What a study asks.",
    "studies": "Plans of studies that are part of the package.",
    "options": "Every option, with its limits, its default and the commands that take it.",
}


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
    from ..errors import unknown_name

    options = ListOptions.of(said)
    if options.kind is None:
        rows = [{"name": name, "summary": summary} for name, summary in KINDS.items()]
    elif options.kind in KINDS:
        rows = _rows(options.kind, options.name)
    else:
        raise unknown_name("list", options.kind, list(KINDS))
    if options.json:
        typer.echo(as_json(rows))
    elif options.markdown:
        typer.echo(_markdown(rows))
    elif options.name is not None:
        _print_all_of(rows[0])
    else:
        _print_summaries(options.kind, rows)


def _rows(kind: str, name: str | None) -> list[dict[str, str]]:
    from ..errors import unknown_name
    from .catalogue import entries, headset_row

    if kind == "headsets" and name is not None:
        return [headset_row(name)]  # files too
    rows = entries(kind)
    if name is None:
        return rows
    chosen = [row for row in rows if row["name"] == name]
    if not chosen:
        raise unknown_name(
            {"lenses": "lens", "studies": "study", "axes": "axes preset"}.get(kind, kind.removesuffix("s")),
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


def _print_summaries(kind: str | None, rows: list[dict[str, str]]) -> None:
    from ._show import in_columns, paragraph

    in_columns((row["name"], row["summary"]) for row in rows)
    if kind is None:
        return
    rest = ", ".join(key.replace("_", " ") for key in list(rows[0])[2:])
    if not rest:
        return
    typer.echo()
    paragraph(f"'hmdwarp list {kind} NAME' tells the rest of one: {rest}.")


def _print_all_of(row: dict[str, str]) -> None:
    from ._show import in_columns

    typer.echo(row["name"])
    in_columns(((key.replace("_", " "), text) for key, text in row.items() if key != "name"), indent=2)
