"""thesis.html: the thesis's experiments beside their numbers, on a page that needs no network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .parts import CLOCK_NAMES, Cell, Line, PageTable, Tile, environment
from .words import plain

MARKS = {True: " ✓", False: " ✗", None: ""}
# CSS classes of the verdicts.
_CLASSES = {
    "holds": "holds", "holds under conditions": "conditions", "does not hold": "fails", "cannot be told": "unknown",
}  # fmt: skip


def render_thesis_page(data: Mapping[str, Any], pictures: Mapping[str, Sequence[tuple[str, str]]]) -> str:
    """Return the text of the page from the content of results.json.

    pictures: (caption, data URI or <svg> element) of each experiment's pictures, by its name. All
    text from the data is escaped.
    """
    experiments = [
        {
            **one,
            "kind": _CLASSES[one["verdict"]],
            "table": cells_table(one),
            "pictures": [pair for pair in pictures.get(one["name"], ()) if pair[1].startswith("data:")],
            "charts": [pair for pair in pictures.get(one["name"], ()) if pair[1].startswith("<svg")],
        }
        for one in data["experiments"]
    ]
    return environment().get_template("thesis.html").render(
        experiments=experiments,
        command=data.get("command") or "",
        tiles=[Tile(name, "", str(count), "of the experiments below") for name, count in data["verdicts"].items()],
        size="x".join(map(str, data["size"])),
        quick=data["quick"],
        seconds=data["seconds"],
        clock=CLOCK_NAMES.get(data["clock"], data["clock"]),
        machine=data["machine"],
        failed=data["failed"],
        version=data["hmdwarp"],
    )  # fmt: skip


def cells_table(one: Mapping[str, Any]) -> PageTable:
    """Return an experiment's numbers by setting, each marked by whether the claim holds there."""
    columns = list(dict.fromkeys(cell["column"] for cell in one["cells"]))
    rows = list(dict.fromkeys(cell["row"] for cell in one["cells"]))
    texts = {(cell["row"], cell["column"]): _cell_text(one, cell) for cell in one["cells"]}
    lines = [Line((Cell(row, False), *(Cell(texts.get((row, column), "")) for column in columns))) for row in rows]
    heads = (("setting", ""), *((column, one["unit"]) for column in columns))
    return PageTable(one["measured"], heads, tuple(lines))


def _cell_text(one: Mapping[str, Any], cell: Mapping[str, Any]) -> str:
    value = cell["value"]
    if value is None:
        return "–"
    return f"{plain(value * one['scale'], one['digits'])}{MARKS[cell['holds']]}"


def summary_markdown(results: Sequence[Mapping[str, Any]]) -> str:
    """Return the verdicts as a Markdown table, one row for each experiment.

    results: contents of results.json; an experiment that several have is that of the last.
    """
    experiments = {one["name"]: (one, data) for data in results for one in data["experiments"]}
    used = {id(data): data for _, data in experiments.values()}.values()
    runs = [f"pictures of {'x'.join(map(str, data['size']))} on {data['machine']['gl_renderer']}" for data in used]
    heads = ("claim", "the thesis", "ours", "rule", "verdict", "holds at")
    lines = [f"hmdwarp {results[0]['hmdwarp']}; {' and '.join(dict.fromkeys(runs))}.", ""]
    lines += ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    for one, _ in experiments.values():
        where = one["holds_at"] if one["verdict"] == "holds under conditions" else ""
        claim = f"{one['claim']} ({one['source']})"
        texts = (claim, one["thesis"], one["ours"] or "–", one["rule"], one["verdict"], where)
        lines.append("| " + " | ".join(text.replace("|", "/") for text in texts) + " |")
    return "\n".join(lines)
