"""The pages that hold generated tables: README.md and docs/*.md, with markers around each table."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = (ROOT / "README.md", *sorted(DOCS.glob("*.md")))


def replace(name: str, text: str) -> None:
    """Write `text` between the markers <!-- name --> and <!-- end -->.

    Raises: SystemExit for a name that no page has.
    """
    pattern = _between(name)
    for path in PAGES:
        page = path.read_text(encoding="utf-8")
        if pattern.search(page):
            path.write_text(
                pattern.sub(lambda m: m.group(1) + text.rstrip() + "\n" + m.group(3), page), encoding="utf-8"
            )
            return
    raise SystemExit(f"no page has the markers <!-- {name} --> .. <!-- end -->")


def rows_of(name: str) -> list[dict[str, str]]:
    """Return the rows of the Markdown table between the markers, keyed by column.

    Raises: SystemExit for a name that no page has.
    """
    head, _, *lines = (_cells(line) for line in text_of(name).splitlines() if line.startswith("|"))
    return [dict(zip(head, cells, strict=True)) for cells in lines]


def text_of(name: str) -> str:
    """Return what stands between the markers. Raises: SystemExit for a name that no page has."""
    pattern = _between(name)
    for path in PAGES:
        found = pattern.search(path.read_text(encoding="utf-8"))
        if found:
            return found.group(2)
    raise SystemExit(f"no page has the markers <!-- {name} --> .. <!-- end -->")


def _between(name: str) -> re.Pattern[str]:
    return re.compile(rf"(<!-- {name} -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]
