"""Golden texts: what a test compares its text with; HMDWARP_GOLDEN=write writes it anew."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Callable
from pathlib import Path

_NOT_WORDS = re.compile(r"<(style|script|svg)\b.*?</\1>", re.DOTALL)


def assert_text(text: str, expected: Path) -> None:
    """Compare with a file, or write it."""
    if os.environ.get("HMDWARP_GOLDEN") == "write":
        expected.write_text(text, encoding="utf-8")
    assert text.splitlines() == expected.read_text(encoding="utf-8").splitlines()


def assert_outcomes(expected: Path, came_of: Callable[[str], object]) -> None:
    """Compare what comes of each line before its ` => ` with what stands behind it."""
    asked = [line.partition(" => ")[0] for line in expected.read_text(encoding="utf-8").splitlines()]
    found = [line if line.startswith("#") else f"{line} => {came_of(line)}" for line in asked]
    assert_text("\n".join(found) + "\n", expected)


def words_of(page: str) -> str:
    """Return the words of a page, those of each of its elements in a line; charts are left out."""
    words = re.sub("<[^>]*>", "\n", _NOT_WORDS.sub("", page.replace("<wbr>", "")))
    return re.sub(r"\s*\n\s*", "\n", html.unescape(words)).strip()
