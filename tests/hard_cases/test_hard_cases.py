"""Runs every hard case for every warp it applies to; docs/hard-cases.md has the table."""

from __future__ import annotations

from pathlib import Path

import pytest

from . import all_cases  # noqa: F401 (files them)
from .registry import CASES, markdown

PAIRS = [(case, name) for case in CASES for name in case.warps]
ALONE = [case for case in CASES if not case.warps]


@pytest.mark.parametrize(("case", "name"), PAIRS, ids=[f"{case.name}-{name}" for case, name in PAIRS])
def test_warp(gpu, case, name):
    case.run(gpu, name)


@pytest.mark.parametrize("case", ALONE, ids=[case.name for case in ALONE])
def test_without_a_warp(case):
    case.run()


def test_the_table_in_the_docs_is_that_of_the_cases():
    """`make docs OPTIONS=hard-cases` writes it."""
    docs = Path(__file__).resolve().parents[2] / "docs" / "hard-cases.md"
    assert markdown() in docs.read_text(encoding="utf-8")
