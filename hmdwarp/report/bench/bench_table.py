"""The table to decide from, for the terminal and as Markdown: cost and gain of each method."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...metrics import JOD, LEAST_INSTANTS, PRIMARY, metrics_in_order
from ..words import markdown, name_pieces, terminal_table
from .rows import COLUMNS, Case, Row, cases, column, common, measure_label

if TYPE_CHECKING:
    from rich.table import Table

_RANKS = {metric.name: metric.bench_rank for metric in metrics_in_order() if metric.bench_rank is not None}
_SPREAD = f"{PRIMARY}_spread"
_RANKED = [column for name in _RANKS for column in ((name, _SPREAD) if name == PRIMARY else (name,))]
DECISION = ("warp", "fill", "total_ms", "total_ms_p95", *_RANKED, "mismatch")
_HEADS = {"total_ms": "ms", "total_ms_p95": "p95", "mismatch": "mis%", _SPREAD: "±"}
_OPTIONAL = {
    "total_ms_p95": 1,
    _SPREAD: 3.5,
    "mismatch": 3,
    **{name: rank for name, rank in _RANKS.items() if rank < math.inf},
}
# Columns that go where the terminal is narrow, the least important first.
_DROPPED_FIRST = sorted(_OPTIONAL, key=_OPTIONAL.__getitem__)
_GAP = 2  # between two columns
_LEAST_TEXT = 10  # width of the column of warps, however narrow the terminal is
MARK = "*"


def decision(rows: Iterable[Row]) -> list[str]:
    """Return the columns to decide from: DECISION, and JOD where any row was rated."""
    return [*DECISION, *([JOD.name] if any("jod" in row for row in rows) else [])]


def bench_table(rows: Iterable[Row], *, width: int = 100) -> Table:
    """Return all rows, case by case, the least error first; `*` marks the Pareto front.

    width: of the terminal. Names of warps with settings are folded between their parts. Then
    columns are left out, the least important first, until the rest fits; numbers are never cut.
    """
    from rich.text import Text

    rows = list(rows)
    groups = cases(rows)
    heading = groups[0].label if len(groups) == 1 else f"{len(groups)} cases"
    names, warp_width = _that_fit(groups, width)
    title, caption = Text(", ".join([heading, *common(rows)])), Text(_caption(rows, names))
    table = terminal_table(title=title, caption=caption, padding=(0, 1, 0, 0))
    table.add_column(" ", no_wrap=True, width=len(MARK))
    for name in names:
        width = warp_width if name == "warp" else _width(name, groups)
        table.add_column(_head(name), justify="right" if column(name).is_number else "left", width=width, no_wrap=True)
    for group in groups:
        if len(groups) > 1:
            table.add_section()
            table.add_row("", Text(_folded(group.label, warp_width), style="bold"))
        best = {id(row) for row in group.held(PRIMARY)}
        for row in group.ordered(PRIMARY):
            marked = id(row) in best
            texts = {name: column(name).text(row) for name in names}
            texts["warp"] = _folded(texts["warp"], warp_width)
            cells = (Text(text, style="bold" if marked else "") for text in texts.values())
            table.add_row(Text(MARK if marked else "", style="bold green"), *cells)
    return table


def _head(name: str) -> str:
    figure = column(name).figure
    return _HEADS.get(name, figure.label + ("%" if figure.unit == "%" else ""))


def _width(name: str, groups: Sequence[Case]) -> int:
    return max(map(_cells, [_head(name), *(column(name).text(row) for group in groups for row in group.rows)]))


def _cells(text: str) -> int:
    from rich.cells import cell_len

    return max(map(cell_len, text.split("\n")))


def _folded(text: str, width: int) -> str:
    """Break the text between its pieces into lines of at most `width` cells if the pieces allow."""
    lines = [""]
    for piece in name_pieces(text):
        if _cells((lines[-1] + piece).rstrip()) <= width or not lines[-1]:
            lines[-1] += piece
        else:
            lines.append(piece)
    return "\n".join(line.rstrip() for line in lines)


def _that_fit(groups: Sequence[Case], width: int) -> tuple[list[str], int]:
    """Return the columns that fit, and the width of the warp's name."""
    names = decision(row for group in groups for row in group.rows)
    labels = [group.label for group in groups] if len(groups) > 1 else []
    texts = [_head("warp"), *labels, *(column("warp").text(row) for group in groups for row in group.rows)]
    least = max(_cells(piece.rstrip()) for text in texts for piece in name_pieces(text))

    def room() -> int:
        others = [len(MARK), *(_width(name, groups) for name in names if name != "warp")]
        return width - sum(others) - _GAP * len(others)

    for name in _DROPPED_FIRST:
        if room() >= least:
            break
        names.remove(name)
    return names, max(min(room(), max(map(_cells, texts))), _LEAST_TEXT)


def _caption(rows: Sequence[Row], names: Sequence[str]) -> str:
    clocks = sorted({{"gpu": "GPU timers", "wall": "wall clock"}.get(row.get("clock", ""), "?") for row in rows})
    lines = [f"ordered by {measure_label(PRIMARY)}; {marked_how(rows)}"]
    if _SPREAD in names:
        lines.append("±: 95 % interval of the mean")
    lines += [f"ms: median per eye, {', '.join(clocks)}"]
    if "mismatch" in names:
        lines[-1] += "; mis%: hole for one eye only"
    left_out = [_head(name) for name in decision(rows) if name not in names]
    if left_out:
        lines.append(f"columns hidden (terminal too narrow): {', '.join(left_out)}")
    return "\n".join(lines)


def marked_how(rows: Iterable[Row], mark: str = MARK) -> str:
    """Return what the mark says, or why no row has one."""
    if all(row["quality"][PRIMARY].get("interval") is None for row in rows):
        return f"no {mark}: intervals need {LEAST_INSTANTS} instants"
    return f"{mark}: no other is both quicker and better, for sure (95 %)"


def choice_terms(choice: Mapping[str, Any]) -> str:
    """Return the basis of a choice's figures: 'at 1280x800, means over 2 cases'."""
    sizes = " and ".join(f"{width}x{height}" for width, height in choice["sizes"])
    return f"at {sizes}" + (f", means over {choice['cases']} cases" if choice["cases"] > 1 else "")


def markdown_table(rows: Iterable[Row], columns: Sequence[str] = (), *, mark: str | None = None) -> str:
    """Return a Markdown table of the rows in their order, one line each; it ends with a line feed.

    columns: names of COLUMNS, by default those to decide from. mark: a metric; rows on the Pareto
    front of it and time get bold names, if their lead holds. Warps and fills are set as code.
    Errors: HmdwarpError for an unknown column.
    """
    rows = list(rows)
    chosen = [column(name) for name in columns or decision(rows)]
    best = {id(row) for case in cases(rows) for row in case.held(mark)} if mark else set()
    heads = [f"{c.figure.label} {c.figure.unit}".strip() for c in chosen]
    lines = [heads, ["---:" if c.is_number else "---" for c in chosen]]
    lines += [[_markdown_cell(c.figure.name, c.text(row), id(row) in best) for c in chosen] for row in rows]
    return markdown(lines)


def _markdown_cell(name: str, text: str, bold: bool) -> str:
    text = " ".join(text.replace("|", "\\|").split())
    if name in ("warp", "fill"):
        spec, space, system = text.replace("`", chr(39)).partition(" (")
        spec = f"**`{spec}`**" if bold and name == "warp" else f"`{spec}`"
        return spec + space + system
    return text if COLUMNS[name].is_number else text.replace("<", "&lt;")
