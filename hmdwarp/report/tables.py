"""Tables of texts: for a page, as Markdown, and for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

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


def terminal_table(**options: Any) -> TerminalTable:
    """Return an empty table for the terminal in the look of all of them."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    return Table(
        **options, title_justify="left", caption_justify="left", box=SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
