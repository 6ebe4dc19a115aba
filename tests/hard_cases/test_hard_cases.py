"""Runs every hard case for every warp it applies to; docs/hard-cases.md has the table."""

from __future__ import annotations

import pytest

from . import depths, images, motions, numbers  # noqa: F401 (they file their cases)
from .registry import CASES

PAIRS = [(case, name) for case in CASES for name in case.warps]
ALONE = [case for case in CASES if not case.warps]


@pytest.mark.parametrize(("case", "name"), PAIRS, ids=[f"{case.name}-{name}" for case, name in PAIRS])
def test_warp(gpu, case, name):
    case.run(gpu, name)


@pytest.mark.parametrize("case", ALONE, ids=[case.name for case in ALONE])
def test_without_a_warp(case):
    case.run()
