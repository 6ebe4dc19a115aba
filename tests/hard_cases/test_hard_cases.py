"""Runs every hard case for every warp it applies to; docs/hard-cases.md has the table."""

from __future__ import annotations

from pathlib import Path

import pytest

from . import all_cases  # noqa: F401 (files them)
from .registry import CASES, CHOICES, markdown


@pytest.mark.parametrize("name", CHOICES)
def test_warp(gpu, name):
    for case in CASES:
        if name in case.warps:
            try:
                case.run(gpu, name)
            except Exception as error:
                error.add_note(f"case {case.name}: expected {case.wants}. A warp that means to differ is named there")
                raise


def test_the_table_in_the_docs_is_that_of_the_cases():
    """`make docs OPTIONS=hard-cases` writes it."""
    docs = Path(__file__).resolve().parents[2] / "docs" / "hard-cases.md"
    assert markdown() in docs.read_text(encoding="utf-8")
