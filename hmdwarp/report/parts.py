"""The parts that all pages share: tiles, tables, charts, and the environment of their templates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import attrs

from .words import name_pieces

if TYPE_CHECKING:
    from jinja2 import Environment

CLOCK_NAMES = {"gpu": "GPU timer queries", "wall": "wall clock around finished GPU work"}


def environment() -> Environment:
    """Make the templates' environment: it escapes everything, and a missing name is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("hmdwarp.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["pieces"] = name_pieces
    return made


@attrs.frozen
class Tile:
    """A figure in large type."""

    label: str
    unit: str
    text: str
    note: str
    # The compared run's figure.
    baseline: str | None = None


@attrs.frozen
class Chart:
    """A heading over an <svg> element."""

    heading: str
    svg: str


@attrs.frozen
class Cell:
    """One cell of a table."""

    text: str
    is_number: bool = True


@attrs.frozen
class Line:
    """One line of a table; the first cell is its heading."""

    cells: tuple[Cell, ...]
    # Starred and bold.
    is_marked: bool = False

    @classmethod
    def of(cls, texts: Sequence[str], words: int = 1) -> Line:
        """Make a line whose first `words` cells are words, the others numbers."""
        return cls(tuple(Cell(text, number >= words) for number, text in enumerate(texts)))


@attrs.frozen
class PageTable:
    """A table of the page."""

    caption: str
    # (label, unit) of each column.
    heads: tuple[tuple[str, str], ...]
    lines: tuple[Line, ...]
    has_marks: bool = False

    @classmethod
    def of(
        cls, caption: str, heads: Sequence[tuple[str, str]], lines: Sequence[Sequence[str]], words: int = 1
    ) -> PageTable:
        """Make a table of texts; the first `words` columns hold words, the others numbers."""
        return cls(caption, tuple(heads), tuple(Line.of(texts, words) for texts in lines))


@attrs.frozen
class PageChart:
    """A chart in one or more versions."""

    heading: str
    # (measure, svg, what it says in words)
    versions: tuple[tuple[str, str, str], ...]
    table: PageTable | None = None

    @classmethod
    def of(cls, heading: str, svg: str, words: str, table: PageTable | None = None) -> PageChart:
        """Make a chart of one version; words: the chart for readers who cannot see it."""
        return cls(heading, (("", svg, words),), table)
