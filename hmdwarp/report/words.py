"""Numbers as papers print them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from decimal import ROUND_HALF_UP, Decimal
from typing import TYPE_CHECKING, Any

import attrs

from .. import errors

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

ALPHA = 0.05
# Words that other packages take from here too.
counted, listed = errors.counted, errors.listed


def p_text(p: float | None) -> str:
    """Return p as ".226", ".0098" or "3e-7".

    Three digits after the point, four below .01, one digit and the power of ten below .0001.
    """
    if p is None or math.isnan(p):
        return "–"
    if p < 1e-4:
        digit, _, power = f"{p:.0e}".partition("e")
        return f"{digit}e{int(power)}"
    # Exact p are dyadic fractions that often end in 5: .3125 is printed as .313, not to the even
    # digit.
    text = str(Decimal(p).quantize(Decimal("0.001" if p >= 0.01 else "0.0001"), ROUND_HALF_UP))
    return text.removeprefix("0") if p < 0.9995 else text


def p_is(p: float) -> str:
    """Return p as "p = .0098"."""
    return f"p = {p_text(p)}"


def signed(value: float | None, digits: int = 2) -> str:
    """Return "+1.30", "-0.56" or "0.00"; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0 else text


def interval(low: float | None, high: float | None, digits: int = 2) -> str:
    """Return "-0.16 .. +0.75"; a dash if an end is None."""
    return "–" if low is None or high is None else f"{signed(low, digits)} .. {signed(high, digits)}"


def plain(value: float | None, digits: int = 2) -> str:
    """Return "2.62", and "0.00" for what rounds to it from below; a dash for None."""
    if value is None or math.isnan(value):
        return "–"
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def pair_text(baseline: str, condition: str) -> str:
    """Return "forward over none, 200 ms"; a positive difference is a gain over the baseline.

    The common end of the two names is written once.
    """
    head, comma, tail = condition.rpartition(", ")
    return f"{head if comma and baseline.endswith(f', {tail}') else condition} over {baseline}"


def name_pieces(text: str) -> list[str]:
    """Split a long name where it may break: after the colon, comma or blank between its parts."""
    return re.split(r"(?<=[:, ])(?=\S)", text)


Heads = Sequence[tuple[str, str]]


@attrs.frozen
class Cell:
    """One cell of a table."""

    text: str
    # Numbers stand at the right; `word`, `tail`, `best`, `meter` are other styles.
    style: str = ""


@attrs.frozen
class Line:
    """One line of a table; the first cell is its heading."""

    cells: tuple[Cell, ...]
    # Starred and bold.
    is_marked: bool = False
    # A heading above the line, where a group of lines begins.
    group: str = ""


@attrs.frozen
class Table:
    """A table of texts."""

    caption: str
    # (label, unit) of each column.
    heads: Heads
    lines: Sequence[Line]
    has_marks: bool = False
    # Two columns without heads, as narrow as they can be.
    is_pairs: bool = False
    style: str = ""
    # What a table without a caption is called.
    label: str = ""

    @classmethod
    def of(
        cls, caption: str, heads: Heads, lines: Iterable[Sequence[str]], words: int | Sequence[int] = 1, **more: Any
    ) -> Table:
        """Make a table of texts. words: the columns of words, or how many of the first are."""
        worded = range(words) if isinstance(words, int) else words
        made = [
            Line(tuple(Cell(text, "word" if number in worded else "") for number, text in enumerate(texts)))
            for texts in lines
        ]
        return cls(caption, tuple(heads), made, **more)

    def style_of(self, column: int) -> str:
        """Return the style of a column's head: as its cells, if they are words or tails."""
        style = self.lines[0].cells[column].style if self.lines else ""
        return style if style in ("word", "tail") else ""

    def markdown(self) -> str:
        """Return the table as Markdown, without its caption; it ends with a line feed."""
        heads = [" ".join(filter(None, head)) for head in self.heads]
        rule = ["---" if not self.lines or self.style_of(n) == "word" else "---:" for n in range(len(heads))]
        return markdown([heads, rule, *([cell.text for cell in line.cells] for line in self.lines)])


def markdown(lines: Iterable[Sequence[str]]) -> str:
    """Return lines of cells as a Markdown table; each ends with a line feed."""
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def terminal_table(
    heads: Iterable[str] = (), lines: Iterable[Iterable[str]] = (), *, words: int = 1, **options: Any
) -> TerminalTable:
    """Return a table for the terminal in the look of all of them.

    words: so many columns from the left hold words, which may wrap; the others hold numbers.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(
        **{"padding": (0, 1, 0, 0)} | options,
        title_justify="left",
        caption_justify="left",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
    )
    for number, head in enumerate(heads):
        table.add_column(head, justify="left" if number < words else "right", no_wrap=number >= words)
    for line in lines:
        table.add_row(*map(Text, line))
    return table
