"""Warp "auto" of a Warper: the most accurate level within a budget, timed on the first picture."""

from __future__ import annotations

import numpy as np
import pytest
from bench_files import AMPLE_MS

from hmdwarp import Fov, Pose, View, Warper, warp_image
from hmdwarp.client import parse_fills, parse_warp
from hmdwarp.image import usable_fills, usable_warps
from hmdwarp.image.usable import LEVELS
from hmdwarp.pipeline.governor import QualityLevel

SIZE = (48, 32)
FOV = Fov.symmetric(1.2, 0.95)
LATE, NOW = View(Pose(), FOV), View(Pose((0.1, 0, 0)), FOV)


def picture() -> tuple[np.ndarray, np.ndarray]:
    colour = np.random.default_rng(1).integers(0, 256, (32, 48, 3), np.uint8)
    return colour, np.where(np.arange(48) < 20, np.float32(1), np.float32(3)) * np.ones((32, 1), np.float32)


def test_levels_are_usable_and_each_takes_longer_and_errs_less():
    for level in LEVELS:
        assert parse_warp(level.warp).entry.name in usable_warps()
        assert {choice.entry.name for choice in parse_fills(level.fill)} <= set(usable_fills())
    assert all(a.total_ms < b.total_ms and a.error > b.error for a, b in zip(LEVELS, LEVELS[1:], strict=False))


@pytest.mark.parametrize("fill", ["pyramid", "memory+pyramid"])
def test_it_is_the_chosen_level_bit_for_bit(monkeypatch, fill, gpu):
    """The best within an ample budget."""
    chains = ("none", "none"), ("iterative", "none"), ("iterative", fill)
    levels = [QualityLevel(*chain, 1.0 + k, 0.3 - 0.1 * k) for k, chain in enumerate(chains)]
    monkeypatch.setattr("hmdwarp.image.warper.LEVELS", levels)
    auto = {"warp": "auto", "budget_ms": AMPLE_MS, "gpu": gpu}
    with Warper(SIZE, **auto) as chosen, Warper(SIZE, fill=fill, gpu=gpu) as named:
        for eye in (0, 1, 0):
            one, other = (warper.warp(*picture(), LATE, NOW, eye=eye) for warper in (chosen, named))
            assert np.array_equal(one.colour, other.colour) and one.hole_share == other.hole_share
        assert str(chosen.plan.choice) == "iterative"
        assert set(one.time_ms) == set(other.time_ms)
    alone = warp_image(*picture(), LATE, NOW, **auto)
    named_alone = warp_image(*picture(), LATE, NOW, "iterative", fill, gpu=gpu)
    assert "auto" in alone.time_ms and np.array_equal(alone.colour, named_alone.colour)
