"""Options of what a page's tables and charts are also written as."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs

from .declared import Declared, one_of, option

PAPER_TABLES, PLOTS = {"latex": "tex", "csv": "csv", "markdown": "md"}, ("svg", "pdf")
PAPER = ("paper/*.tex", "paper/*.csv", "paper/*.md", "paper/*.svg", "paper/*.pdf")


def _kinds(known: Sequence[str], flag: str) -> Any:
    check = one_of(*known)

    def each(_: object, field: attrs.Attribute[Any], value: tuple[str, ...]) -> None:
        for kind in value if isinstance(value, tuple | list) else (value,):
            check(None, field, kind)

    names = " and ".join(filter(None, (", ".join(known[:-1]), known[-1])))
    return option(
        (), f"Also write the page's {flag} as files for a paper, into paper/: {names}, with commas.", kind=str,
        default=None, valid=each, parse=lambda text: tuple(filter(None, map(str.strip, text.split(",")))), name=flag,
        metavar="KIND,..",
    )  # fmt: skip


@attrs.frozen
class PaperOptions(Declared):
    """What to write for a paper. Errors: InputError for an unknown kind."""

    tables: tuple[str, ...] = _kinds(tuple(PAPER_TABLES), "tables")
    plots: tuple[str, ...] = _kinds(PLOTS, "plots")

    @property
    def is_wanted(self) -> bool:
        """Whether anything is."""
        return bool(self.tables or self.plots)
