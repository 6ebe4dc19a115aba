"""Random extreme inputs. A million warp maps on the GPU against float64, and every warp on random
extreme worlds."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import ONE_FIXTURE_FOR_ALL
from worlds import every_compared

import hmdwarp.gpu.shaders
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import Compute
from hmdwarp.resources import folder

from .setting import Setting

COUNT = 1_000_000
MAPS = 4000  # views take SciPy's time; each map is asked at 250 pixels and depths
UNIT = 2.0**-24


def random_maps(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """H (n, 3, 3), e (n, 3) and the side of the square pictures (n,). All scales of motion, turns,
    fields of view and sizes."""
    H, e, sides = np.empty((count, 3, 3)), np.empty((count, 3)), np.empty(count)
    for k in range(count):
        side = int(2 ** rng.uniform(0, 13))
        half = np.deg2rad(10 ** rng.uniform(np.log10(0.5), np.log10(85), 4))
        rendered = View(
            Pose(rng.normal(size=3) * 10 ** rng.uniform(-3, 6), rng.normal(size=4)),
            Fov(-half[0], half[1], -half[2], half[3]),
        )
        turn = np.append(rng.normal(size=3) * 10 ** rng.uniform(-10, 0.5), 1)
        step = rng.normal(size=3) * 10 ** rng.uniform(-10, 2) * (rng.uniform() > 0.1)
        shown = View(rendered.pose @ Pose(step, turn), rendered.fov)
        warp = WarpMap.between(rendered, (side, side), shown, (side, side))
        H[k], e[k], sides[k] = warp.H, warp.e, side
    return H, e, sides


def random_depths(rng: np.random.Generator, count: int) -> np.ndarray:
    """1/m: 1e-7 to 1e4, infinitely far, none at all, and what is no number."""
    depth = 10 ** rng.uniform(-7, 4, count)
    kind = rng.uniform(size=count)
    for share, value in ((0.10, 0.0), (0.13, -1.0), (0.15, np.nan), (0.17, np.inf), (0.19, 1e-40), (0.20, -np.inf)):
        depth = np.where((kind < share) & (kind >= share - 0.03), value, depth)
    return depth


def bound_and_truth(
    H: np.ndarray, e: np.ndarray, p: np.ndarray, r: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(place (n, 2), w (n,), bound (n,)). Float64 places and how far float32 may be off,
    docs/hard-cases.md has the derivation."""
    homogeneous = np.column_stack([p, np.ones(len(p))])
    with np.errstate(all="ignore"):
        terms = np.einsum("nij,nj->ni", np.abs(H), homogeneous) + np.abs(e * r[:, None])
        q = np.einsum("nij,nj->ni", H, homogeneous) + e * r[:, None]
        error = 8 * UNIT * terms
        place = q[:, :2] / q[:, 2:]
        safe = np.where(q[:, 2] > 2 * error[:, 2], q[:, 2] - error[:, 2], np.nan)
        bound = ((error[:, :2] + np.abs(place) * error[:, 2:]) / safe[:, None]).max(axis=1) + UNIT * np.abs(place).max(
            axis=1
        )
    return place, q[:, 2], np.nan_to_num(bound, nan=np.inf)


def on_the_gpu(gpu, tmp_path, monkeypatch, cases: np.ndarray) -> np.ndarray:
    """(n, 4) what the shader makes of the cases."""
    shutil.copytree(folder("shaders") / "lib", tmp_path / "lib")
    shutil.copy(__file__.replace("test_sweep.py", "sweep.comp"), tmp_path)
    monkeypatch.setattr(hmdwarp.gpu.shaders, "folder", lambda name: tmp_path)
    program = Compute(gpu.gl, "sweep.comp", {})
    given_buffer, result = gpu.gl.buffer(cases.astype(np.float32).tobytes()), gpu.gl.buffer(reserve=16 * len(cases))
    given_buffer.bind_to_storage_buffer(0)
    result.bind_to_storage_buffer(1)
    program.uniforms.set(count=len(cases))
    program.run(len(cases))
    gpu.gl.memory_barrier()
    out = np.frombuffer(result.read(), np.float32).reshape(-1, 4).astype(np.float64)
    given_buffer.release()
    result.release()
    return out


def test_a_million_warp_maps(gpu, tmp_path, monkeypatch):
    """No NaN or Inf anywhere; within the bound wherever the map is defined. Coverage 0 wherever it
    is not."""
    rng = np.random.default_rng(20261121)
    H, e, sides = (np.repeat(part, COUNT // MAPS, axis=0) for part in random_maps(rng, MAPS))
    p = (np.floor(rng.uniform(size=(COUNT, 2)) * sides[:, None])) + 0.5
    r = random_depths(rng, COUNT)
    with np.errstate(over="ignore"):
        cases = np.concatenate(
            [np.concatenate([H, e[..., None]], axis=2).reshape(COUNT, 12), p, r[:, None], sides[:, None]], axis=1
        )
        r = r.astype(np.float32).astype(np.float64)
    got = on_the_gpu(gpu, tmp_path, monkeypatch, cases)
    place, w, bound = bound_and_truth(H, e, p, r)
    assert np.isfinite(got).all()
    with np.errstate(invalid="ignore"):
        has_depth = np.isfinite(r) & (r >= 0)
        from_border = np.minimum(place, sides[:, None] - place).min(axis=1)
        inside = has_depth & (w > 0) & (from_border >= 0)
        sure = ~has_depth | (np.isfinite(bound) & (np.abs(from_border) > bound)) | ((w < 0) & np.isfinite(bound))
    defined = got[:, 3] == 1
    assert np.array_equal(defined[sure], inside[sure]), "coverage where there is none, or none where there is"
    both = defined & inside & np.isfinite(bound)
    error = np.abs(got[both, :2] - place[both]).max(axis=1)
    assert (error <= bound[both]).all(), f"worst {np.max(error / bound[both])} times the bound"
    # The sweep is worth something: many maps are defined, the bound is not empty, and not a hundred
    # times too wide.
    assert both.sum() > COUNT // 10
    assert np.median(bound[both] / sides[both]) < 1e-4
    assert (error / bound[both]).max() > 0.01
    assert sure.mean() > 0.9


EXTREME = st.sampled_from([0.0, 1e-9, 1e-3, 0.05, 1.0, 30.0])


def random_world(
    gpu, seed: int, step: tuple, turn: float, nearest: float, sides: tuple, size: tuple[int, int]
) -> Setting:
    """step: metres on each axis, turn: the most of the quaternion's three, both with random signs.
    nearest: 1/m, what depths are cut off at, mostly; sides: degrees of the field of view."""
    rng = np.random.default_rng(seed)
    depth = np.abs(random_depths(rng, size[0] * size[1]).reshape(size[::-1]))
    depth = np.where(depth > 1e-4, np.minimum(depth, 1.0) * nearest, depth) if rng.uniform() < 0.7 else depth
    left, right, down, up = np.deg2rad(sides)
    fov = Fov(-left, right, -down, up)
    sign = rng.choice([-1, 1], 6)
    rendered = View(Pose(rng.normal(size=3), rng.normal(size=4)), fov)
    shown = View(rendered.pose @ Pose(sign[:3] * step, (*(sign[3:] * turn * rng.uniform(0, 1, 3)), 1)), fov)
    return Setting(gpu, depth, shown, rendered=rendered)


# Defaults, variants and baselines; of the other words mesh:cut=vertex still has a pixel in one of
# 200 such worlds that its twin does not mark as undecided though rounding decides it. The hard
# cases and the contract hold for it.
@pytest.mark.parametrize("name", every_compared())
@settings(max_examples=12, suppress_health_check=ONE_FIXTURE_FOR_ALL)
@given(
    seed=st.integers(0, 2**32 - 1),
    step=st.tuples(EXTREME, EXTREME, EXTREME),
    turn=EXTREME,
    nearest=st.sampled_from([1e-6, 0.3, 2.0, 1e3]),
    sides=st.tuples(st.integers(10, 85), st.integers(10, 85), st.integers(10, 85), st.integers(10, 85)),
    size=st.sampled_from([(23, 17), (8, 31), (1, 5)]),
)
def test_every_warp_on_random_extreme_worlds(gpu, name, seed, step, turn, nearest, sides, size):
    """What Setting.pictures checks. Finite, coverage 0 or 1 and right where decided, colours within
    the bound and within what went in."""
    for picture in random_world(gpu, seed, step, turn, nearest, sides, size).pictures(name):
        assert picture.colour.shape[:2] == size[::-1]


# Worlds that a warp or its twin once failed on, as above: surfaces nearer than the depth buffer
# knows (31), slivers (239) and folded pieces (the last), seams at a seventeenth of the size (174),
# a triangle edge on (692), a row between quarters (55), seeds behind the rendered eye (500216), and
# a large cell beside what is turned away (900612).
FAILED_ONCE = [
    (16, (1.0, 0.0, 0.0), 0.001, 2.0, (28, 11, 36, 40), (23, 17)),
    (31, (0.0, 0.0, 0.0), 0.001, 1000.0, (76, 43, 60, 61), (8, 31)),
    (55, (1.0, 1e-09, 0.0), 1e-09, 1000.0, (28, 53, 14, 53), (23, 17)),
    (174, (0.0, 0.001, 1.0), 30.0, 1000.0, (25, 70, 66, 45), (8, 31)),
    (239, (1.0, 0.001, 1e-09), 0.0, 2.0, (58, 66, 15, 55), (23, 17)),
    (692, (1e-09, 0.0, 0.001), 0.05, 1000.0, (38, 10, 21, 15), (8, 31)),
    (500216, (0.0, 0.001, 1e-09), 1.0, 0.3, (70, 30, 50, 39), (8, 31)),
    (900612, (1e-09, 0.05, 1.0), 0.001, 0.3, (27, 24, 21, 67), (23, 17)),
    (1404217271, (1.0, 0.0, 0.0), 0.05, 2.0, (69, 19, 48, 84), (23, 17)),
]


@pytest.mark.parametrize("name", ["iterative", "mesh", "mesh_adaptive", "mesh_adaptive:tolerance=0", "search"])
def test_worlds_that_failed_once(gpu, name):
    for drawn in FAILED_ONCE:
        assert list(random_world(gpu, *drawn).pictures(name))
