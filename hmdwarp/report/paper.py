"""The tables and charts of a page as files for a paper: LaTeX, CSV, Markdown; SVG and PDF."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from ..options import PAPER_TABLES, PaperOptions
from ..resources import __version__
from .charts import Drawn, drawing
from .files import inert_text
from .output import OutputFolder
from .page import Chart, Page, Section
from .run_texts import Line, Table
from .style import PAPER_COLOURS

_LATEX = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"}, "\\": r"\textbackslash{}", "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}", "±": r"$\pm$", "–": "--", "−": "$-$", "×": r"$\times$", "★": r"$\star$",
    "→": r"$\to$", "°": r"$^\circ$",
}  # fmt: skip


def write_paper(out: OutputFolder, page: Page, options: PaperOptions) -> None:
    """Write the tables and charts of a page, named by their section and number.

    Errors: as OutputFolder.
    """
    if not options.is_wanted:
        return
    numbers: Counter[tuple[str, type]] = Counter()
    for section in filter(None, page.sections):
        where = section.id or re.sub(r"\W+", "-", section.heading.lower()).strip("-")
        for block in _blocks(section.blocks):
            numbers[where, type(block)] += 1
            name = f"paper/{where}-{numbers[where, type(block)]}"
            if isinstance(block, Table):
                for kind in options.tables:
                    out.write_text(f"{name}.{PAPER_TABLES[kind]}", _WRITERS[kind](block, section, page))
                continue
            for measure, drawn, _ in block.versions:
                for kind in options.plots:
                    assert isinstance(drawn, Drawn)
                    _save(drawn, out, f"{name}{f'-{measure}' if measure else ''}.{kind}")


def _blocks(blocks: Sequence[Any]) -> Iterator[Table | Chart]:
    """Yield the tables and charts of blocks, those inside groups, folds and articles too."""
    for block in blocks:
        if isinstance(block, Table | Chart):
            yield block
        else:
            yield from _blocks(getattr(block, "blocks", ()))


def _heads(table: Table) -> list[str]:
    """Return the head of each column with its unit; an interval is one of the column before it."""
    found: list[str] = []
    for label, unit in table.heads:
        own = f"{label} [{unit}]" if label and unit else label or unit
        found.append(f"{table.heads[len(found) - 1][0]}, {own}" if own.startswith("95 %") else own)
    return found


def _texts(line: Line) -> list[str]:
    return [cell.text for cell in line.cells]


def _about(table: Table, section: Section, page: Page) -> str:
    return ": ".join(filter(None, (section.heading, table.caption or table.label)))


def _latex(table: Table, section: Section, page: Page) -> str:
    """Return a tabular in the manner of booktabs; marked lines are bold."""
    heads = _heads(table)
    columns = "".join("l" if not table.lines or table.style_of(at) == "word" else "r" for at in range(len(heads)))
    made = f"hmdwarp {__version__}: {' '.join(page.command.split())}"
    lines = [f"% {_about(table, section, page)}".replace("\n", " "), f"% {made}", r"% \usepackage{booktabs}"]
    lines += [f"\\begin{{tabular}}{{{columns}}}", r"\toprule"]
    if any(heads):
        lines += [_row(heads), r"\midrule"]
    for number, line in enumerate(table.lines):
        if line.group:
            lines += [r"\midrule"] * (number > 0)
            lines += [f"\\multicolumn{{{len(heads)}}}{{l}}{{\\emph{{{_escaped(line.group)}}}}} \\\\"]
        lines.append(_row(_texts(line), bold=line.is_marked))
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _row(texts: Sequence[str], *, bold: bool = False) -> str:
    cells = map(_escaped, texts)
    return " & ".join(f"\\textbf{{{cell}}}" if bold and cell else cell for cell in cells) + r" \\"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(letter, letter) for letter in text)


def _csv(table: Table, section: Section, page: Page) -> str:
    """Return the table as CSV: groups are a column of their own, what was not measured is empty."""
    grouped = any(line.group for line in table.lines)
    text, group = io.StringIO(), ""
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*(["group"] if grouped else []), *_heads(table)])
    for line in table.lines:
        group = line.group or group
        cells = ["" if cell == "–" else inert_text(cell) for cell in _texts(line)]
        writer.writerow([*([inert_text(group)] if grouped else []), *cells])
    return text.getvalue()


def _markdown(table: Table, section: Section, page: Page) -> str:
    return table.markdown()


_WRITERS = {"latex": _latex, "csv": _csv, "markdown": _markdown}


def _save(drawn: Drawn, out: OutputFolder, name: str) -> None:
    """Write a chart in the colours of white paper, without a date: a run repeats byte for byte."""
    figure = drawn.figure
    data, kind = io.BytesIO(), name.rpartition(".")[2]
    date: dict[str, None] = {"Date": None} if kind == "svg" else {"CreationDate": None}
    with drawing(name):
        figure.set_dpi(72)  # of both kinds: ticks are made while drawing, and must be there to be recoloured
        figure.draw_without_rendering()
        for artist in figure.findobj():
            _recolour(artist)
            if getattr(artist, "arrow_patch", None) is not None:
                _recolour(artist.arrow_patch)
        figure.patch.set(visible=True, facecolor="white")
        figure.savefig(data, format=kind, metadata={"Creator": None, **date})
    out.path(name).write_bytes(data.getvalue())


def _recolour(artist: Any) -> None:
    from matplotlib.colors import to_hex, to_rgba_array

    for of in ("color", "facecolor", "edgecolor", "markerfacecolor", "markeredgecolor"):
        get = getattr(artist, f"get_{of}", None)
        if get is None or (of == "color" and hasattr(artist, "get_facecolor")):
            continue
        colours = to_rgba_array(get())
        mended = [(PAPER_COLOURS.get(to_hex(colour), colour[:3]), colour[3]) for colour in colours]
        if len(colours) and any(to_hex(colour) in PAPER_COLOURS for colour in colours):
            getattr(artist, f"set_{of}")(mended[0] if len(mended) == 1 else mended)
