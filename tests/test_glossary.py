"""Public names and pages avoid retired words; the glossary explains each term in one line."""

from __future__ import annotations

import re
from pathlib import Path

from together import together

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "hmdwarp"
GLOSSARY = ROOT / "docs" / "glossary.md"
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "recordings/README.md")]
PAGES += sorted((ROOT / "docs").glob("*.md"))

# Invented words, one a line, and the names that had them. The changelog may name what was renamed.
RETIRED_WORDS = Path(__file__).with_name("words.txt").read_text(encoding="utf-8").split()
RETIRED = re.compile(
    rf"\b(?i:{'|'.join(RETIRED_WORDS)})\b"
    r"|`(Given|Requested|Course|Stage|Watch|StepWatch|Obeying|Tidying|Room|Sitting|Desk|desk|hands|obey)`"
    r"|\b(told|took|went)\(\)|a fault of ours|nothing half-written|must not fall apart|goes on after anything"
)
QUOTED = re.compile(r"^```.*?^```|<!-- [\w -]+ -->.*?<!-- end -->|`\"nobody\"`", re.DOTALL | re.MULTILINE)


def words_of(name: str) -> list[str]:
    """Split CamelCase and snake_case into lower-case words, without digits."""
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)
    return [part.lower() for part in parts if len(part) > 1]


def is_retired(name: str) -> bool:
    return not set(words_of(name)).isdisjoint(RETIRED_WORDS)


def glossary_rows() -> list[tuple[str, str]]:
    """Return each term with its explanation."""
    found = re.findall(
        r"^- (.+?): (.+?)(?=\n- |\n\n|\n?\Z)", GLOSSARY.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    return [(term.strip("*`"), " ".join(text.split())) for term, text in found]


def public_names() -> dict[str, Path]:
    """Return modules and their names that no underscore begins, each with its file."""
    names = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        stem = path.parent.name if path.name == "__init__.py" else path.stem
        defined = re.findall(r"^(?:class|def) (\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
        names |= {name: path for name in (stem, *defined) if not name.startswith("_")}
    return names


def test_public_names_use_no_retired_words():
    guilty = {f"{path.relative_to(ROOT)}: {name}" for name, path in public_names().items() if is_retired(name)}
    assert not guilty, f"tests/words.txt lists these words as retired; docs/glossary.md has the terms: {sorted(guilty)}"


def test_each_term_is_explained_in_one_line():
    rows = glossary_rows()
    assert len(rows) > 80
    for term, text in rows:
        assert len(text.split()) < 25 and text.endswith("."), term
    terms = [term.casefold() for term, _ in rows]
    assert len(terms) == len(set(terms))


@together("page", PAGES)
def test_pages_have_no_retired_words(page):
    text = QUOTED.sub("", page.read_text(encoding="utf-8"))
    assert not [match[0] for match in RETIRED.finditer(text)]


@together("page", [*PAGES, ROOT / "CHANGELOG.md"])
def test_prose_wraps_at_100_columns_in_paragraphs_of_five_lines(page):
    text = QUOTED.sub("", page.read_text(encoding="utf-8"))
    prose = [line for line in text.splitlines() if not line.startswith(("|", "![", "    "))]
    assert [line for line in prose if len(line) > 100] == []
    for paragraph in re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.) )", "\n".join(prose)):
        assert len(paragraph.strip().splitlines()) <= 5, paragraph
