"""The pages that hold generated tables: README.md and docs/*.md, with markers around each table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = (ROOT / "README.md", *sorted(DOCS.glob("*.md")))


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]], texts: int = 1) -> str:
    """Return a Markdown table whose first columns are texts and whose others are numbers."""
    lines = [heads, *rows]
    written = [f"| {' | '.join(line)} |" for line in lines]
    return "\n".join([written[0], "|" + " --- |" * texts + " ---: |" * (len(heads) - texts), *written[1:]])


def replace(name: str, text: str) -> None:
    """Write `text` between the markers <!-- name --> and <!-- end -->. Raises: SystemExit."""
    path, found = _found(name)
    page = path.read_text(encoding="utf-8")
    path.write_text(page[: found.start(1)] + text.rstrip() + "\n" + page[found.end(1) :], encoding="utf-8")


def text_of(name: str) -> str:
    """Return what stands between the markers. Raises: SystemExit for a name that no page has."""
    return _found(name)[1][1]


def lines_of(name: str) -> list[list[str]]:
    """Return the cells of each line of the Markdown table between the markers."""
    lines = [line for line in text_of(name).splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip().removeprefix("|").removesuffix("|").split("|")] for line in lines]


def rows_of(name: str) -> list[dict[str, str]]:
    """Return the rows of the Markdown table between the markers, keyed by column."""
    head, _, *lines = lines_of(name)
    return [dict(zip(head, cells, strict=True)) for cells in lines]


def _found(name: str) -> tuple[Path, re.Match[str]]:
    pattern = re.compile(rf"<!-- {re.escape(name)} -->\n(.*?)<!-- end -->", re.DOTALL)
    for path in PAGES:
        if found := pattern.search(path.read_text(encoding="utf-8")):
            return path, found
    raise SystemExit(f"no page has the markers <!-- {name} --> .. <!-- end -->")
