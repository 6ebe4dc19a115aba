"""Warp "auto" of a Warper: the most accurate level within a budget, down and up again."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from bench_files import AMPLE_MS, a_bench, a_row

from hmdwarp import Fov, InputError, Pose, View, Warper, warp_image
from hmdwarp.client import PassInputs, parse_fills, parse_warp
from hmdwarp.frames import EyeImage
from hmdwarp.gpu import COLOUR, SCALAR, allocate
from hmdwarp.image import usable_fills, usable_warps
from hmdwarp.image.usable import LEVELS, AutoCompensator, plans_of_levels

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
def test_it_is_the_chosen_level_bit_for_bit(tmp_path, fill, gpu):
    """The best of a bench within an ample budget; levels that need a server are left out."""
    rows = [a_row("none", "none", 1.0, 0.3), a_row("iterative", fill, 2.0, 0.1), a_row("model", "none", 3.0, 0.05)]
    bench = a_bench(tmp_path / "bench.json", rows)
    with (
        Warper(SIZE, warp="auto", budget_ms=AMPLE_MS, bench=bench, gpu=gpu) as chosen,
        Warper(SIZE, fill=fill, gpu=gpu) as named,
    ):
        for eye in (0, 1, 0):
            one, other = (warper.warp(*picture(), LATE, NOW, eye=eye) for warper in (chosen, named))
            assert np.array_equal(one.colour, other.colour) and one.hole_share == other.hole_share
        assert str(chosen.plan.choice) == "iterative" and chosen.changes == ()
        assert set(one.time_ms) == set(other.time_ms)
    alone = warp_image(*picture(), LATE, NOW, "auto", budget_ms=AMPLE_MS, bench=bench, gpu=gpu)
    assert "auto" in alone.time_ms and np.array_equal(alone.colour, named_first(fill, gpu))


def named_first(fill: str, gpu) -> np.ndarray:
    return warp_image(*picture(), LATE, NOW, "iterative", fill, gpu=gpu).colour


def test_it_goes_down_where_pictures_take_too_long_and_up_where_there_is_room(gpu):
    """Both eyes together, by the slower one: the second never has another level than the first."""
    textures = allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR)
    auto = AutoCompensator(gpu, plans_of_levels(None, "none", False, AMPLE_MS), SIZE, SIZE, AMPLE_MS)
    inputs = PassInputs(EyeImage(LATE, *textures), NOW, 0)
    auto.run(inputs)
    best = str(auto.plan.choice), str(auto.plan.fill)
    taken = []
    for ms in (*[2 * AMPLE_MS] * 20, *[AMPLE_MS / 1e6] * 200):
        for eye in (0, 1):
            auto.run(attrs.evolve(inputs, eye=eye))
            taken.append((str(auto.plan.choice), str(auto.plan.fill)))
            auto.record(eye, {"upload": 9 * AMPLE_MS, "warp": eye * ms / 2, "fill": eye * ms / 2})
    assert taken[0] == taken[-1] == best and len(set(taken)) > 1 and len(auto.changes) >= 2
    assert taken[1::2] == taken[::2]
    auto.close()
    for texture in textures:
        texture.release()


def test_what_it_cannot_do_is_said(tmp_path, gpu):
    bench = a_bench(tmp_path / "bench.json", [a_row("model", "none", 3.0, 0.05)])
    with pytest.raises(InputError, match="enough for none of its levels"):
        Warper(SIZE, warp="auto", budget_ms=5.0, bench=bench, gpu=gpu)
    with Warper(SIZE, warp="auto", budget_ms=AMPLE_MS, gpu=gpu) as warper:
        textures = allocate(gpu.gl, SIZE, COLOUR), allocate(gpu.gl, SIZE, SCALAR)
        with pytest.raises(InputError, match="name a warp for textures"):
            warper.warp_textures(*textures, LATE, NOW)
        for texture in textures:
            texture.release()
