"""The tables and charts of a page as files for a paper: LaTeX, Markdown; SVG, PDF and PNG."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..base import PAPER_TABLES, PaperOptions, __version__
from .charts import Drawn, paper_bytes
from .output import OutputFolder
from .page import Chart, Page
from .run_texts import Cell, Table

# Width of a column and the gap between two, as in the templates of IEEE and ACM; letters of
# \footnotesize in a column.
_COLUMN_IN, _GAP_IN, _COLUMN_CHARS = 3.35, 0.3, 58
_MARKS = ". ±: 95 % interval of the mean. Bold: the best of its column, and those that tie with it. ★: on the front."
_LATEX = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"}, "\\": r"\textbackslash{}", "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}", "±": r"$\pm$", "–": "--", "−": "$-$", "×": r"$\times$", "★": r"$\star$",
    "→": r"$\to$", "°": r"$^\circ$",
}  # fmt: skip


def write_paper(out: OutputFolder, page: Page, options: PaperOptions) -> None:
    """Write tables and charts of a page, named by section and number. Errors: as OutputFolder."""
    if not options.is_wanted:
        return
    made = f"hmdwarp {__version__}: {' '.join(page.command.split())}"
    shared = f" ({', '.join(page.shared)})" if page.shared else ""
    numbers: Counter[tuple[str, type]] = Counter()
    for section in filter(None, page.sections):
        where = section.id or re.sub(r"\W+", "-", section.heading.lower()).strip("-")
        for block in _blocks(section.blocks):
            numbers[where, type(block)] += 1
            name = f"paper/{where}-{numbers[where, type(block)]}"
            if isinstance(block, Table):
                about = ": ".join(filter(None, (section.heading, block.caption or block.label))) + shared
                about += _MARKS if block.has_marks else ""
                for kind in options.tables:
                    text = block.markdown() if kind == "markdown" else _latex(block, about, Path(name).name, made)
                    out.write_text(f"{name}.{PAPER_TABLES[kind]}", text)
                continue
            for measure, drawn, words in block.versions:
                assert isinstance(drawn, Drawn)
                stem = f"{name}-{measure}" if measure else name
                wide = options.columns * (_COLUMN_IN + _GAP_IN) - _GAP_IN
                for kind in options.plots:
                    out.path(f"{stem}.{kind}").write_bytes(paper_bytes(drawn, kind, wide))
                if "latex" in options.tables and "pdf" in options.plots:
                    content = f"\\includegraphics[width=\\linewidth]{{{Path(stem).name}.pdf}}"
                    floated = _float(
                        "figure", options.columns > 1 or where == "crops", words + shared, Path(stem).name, content
                    )
                    out.write_text(f"{stem}-figure.tex", f"% {made}\n% \\graphicspath{{{{paper/}}}}\n{floated}")


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


def _latex(table: Table, about: str, name: str, made: str) -> str:
    """Return a table in the manner of booktabs; bold is the best of a column.

    A column of intervals joins the one before it: "0.066 ± 0.003". A table too wide for a column of
    the paper spans two, and one too wide for those is set smaller. A star marks the front.
    """
    joins = {at for at, (label, _) in enumerate(table.heads) if label.endswith(" ±")}
    shown, heads = [at for at in range(len(table.heads)) if at not in joins], _heads(table)
    lines, wide = [], 10 * len(joins)
    for at in shown:
        wide += 2 + max([len(heads[at]), *(len(line.cells[at].text) for line in table.lines)])
    for number, line in enumerate(table.lines):
        if line.group:
            lines += [r"\midrule"] * (number > 0)
            lines += [f"\\multicolumn{{{len(shown)}}}{{l}}{{\\emph{{{_escaped(line.group)}}}}} \\\\"]
        cells = [_cell(line.cells[at], line.cells[at + 1] if at + 1 in joins else None) for at in shown]
        lines.append(("$\\star$ " if line.is_marked else "") + " & ".join(cells) + r" \\")
    columns = "".join("l" if not table.lines or table.style_of(at) == "word" else "r" for at in shown)
    if any(heads):
        lines = [" & ".join(_escaped(heads[at]) for at in shown) + r" \\", r"\midrule", *lines]
    content = [f"\\begin{{tabular}}{{{columns}}}", r"\toprule", *lines, r"\bottomrule", r"\end{tabular}"]
    if wide > 2 * _COLUMN_CHARS:
        content = [r"\resizebox{\linewidth}{!}{%", *content[:-1], content[-1] + "}"]
    floated = _float("table", wide > _COLUMN_CHARS, about, name, "\n".join([r"\footnotesize", *content]))
    return f"% {made}\n% \\usepackage{{booktabs, graphicx}}\n{floated}"


def _cell(cell: Cell, spread: Cell | None) -> str:
    text = _escaped(cell.text)
    text = f"\\textbf{{{text}}}" if cell.style == "best" else text
    return text if spread is None or spread.text == "–" else f"{text} {_LATEX['±']} {spread.text}"


def _float(kind: str, spans: bool, about: str, name: str, content: str) -> str:
    """Return a figure or table of LaTeX. spans: whether it is as wide as two columns."""
    kind, label = kind + "*" * spans, f"{kind[:3]}:{name}"
    about = f"\\caption{{{_escaped(about)}}}\n\\label{{{label}}}"
    return f"\\begin{{{kind}}}[t]\n\\centering\n{content}\n{about}\n\\end{{{kind}}}\n"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(letter, letter) for letter in text)
