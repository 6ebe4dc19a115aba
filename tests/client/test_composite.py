"""The thesis's composite as it is written, with what is wrong with it: `relight` is the better."""

from __future__ import annotations

import numpy as np
import pytest
from reference.composite import Composited, composite
from scipy.spatial.transform import Rotation

from hmdwarp.client import build_plan, parse_fills
from hmdwarp.client.fills.composite import LEAST_MOVE, OFFSETS, frame_seed, random_offsets
from hmdwarp.geometry import Pose, View

from .modelled import SIZE, VIEW, Shown

SMALL = (75, 56)
# The eye was 25 cm further to the left, and turned by 3 degrees: nothing that is not sky moved to
# the right.
LEFT = View(Pose(VIEW.pose.position_m - (0.25, 0, 0), Rotation.from_rotvec((0, np.deg2rad(3), 0)).as_quat()), VIEW.fov)
STORED = 2.0**-10  # what is stored as a half float is truncated: 2^-10 of it


def asked(shown: Shown, text: str, shown_ns: int = 0) -> Composited:
    (choice,) = parse_fills(text)
    chosen = choice.settings
    unlit, depth = shown.of_model(lit=False)
    offsets = random_offsets(chosen.seed, chosen.radius * shown.size[0])
    seed = frame_seed(chosen.seed, shown_ns, 0)
    views = shown.rendered, VIEW
    return Composited(
        *views, shown.colour, shown.shown_depth, unlit, depth, offsets, seed, chosen, least_move=LEAST_MOVE
    )


def holes_like(size, seed: int = 3) -> np.ndarray:
    """Cracks everywhere and a wide hole in the middle."""
    y, x = np.mgrid[: size[1], : size[0]]
    wide = (np.abs(x - size[0] / 2) < size[0] / 6) & (np.abs(y - size[1] / 2) < size[1] / 5)
    return wide | (np.random.default_rng(seed).uniform(size=size[::-1]) < 0.2)


@pytest.mark.parametrize("scene", ["planes", "spheres"])
@pytest.mark.parametrize("rendered", [VIEW, LEFT], ids=["still", "moved"])
@pytest.mark.parametrize("average", ["mean", "median"])
def test_composite_equals_its_twin(gpu, scene, rendered, average):
    shown = Shown(gpu, scene, (0.6, 0.9, 1.4), SMALL, holes_like(SMALL), rendered=rendered)
    text = f"composite:average={average},radius=0.1,seed=7"
    wanted, wanted_depth = composite(asked(shown, text, shown_ns=123))
    got, depth = shown.fill(text, shown_ns=123)
    off = np.abs(got - wanted).max(axis=-1) / (wanted.max(axis=-1) + 1e-3)
    # Truncated once, after a mean of half floats in float32. Which places agree, and on which side
    # of the move they lie, is rounding's to say where two numbers are as good as equal.
    assert (off <= STORED + 1e-5).mean() > 0.99
    assert (got[..., 3] == wanted[..., 3]).mean() > 0.995
    same = (got[..., 3] > 0) & (wanted[..., 3] > 0)
    assert np.array_equal(depth[same], wanted_depth[same])
    assert (depth[got[..., 3] == 0] == -1).all()
    assert 0 < (wanted[..., 3] == 0).mean() < shown.holes.mean()


@pytest.mark.parametrize("size", [(1, 1), (1, 37), (37, 1)], ids=str)
def test_the_smallest_pictures_equal_the_twin(gpu, size):
    shown = Shown(gpu, "planes", size=size, holes=np.arange(size[0] * size[1]).reshape(size[::-1]) % 3 == 0)
    got, wanted = shown.fill("composite")[0], composite(asked(shown, "composite"))[0]
    assert np.array_equal(got[..., 3], wanted[..., 3])
    assert np.abs(got - wanted).max() <= STORED * wanted.max() + 1e-5


def turned(degrees: float) -> View:
    return View(Pose(VIEW.pose.position_m, Rotation.from_rotvec((0, np.deg2rad(degrees), 0)).as_quat()), VIEW.fov)


def moved(metres: float) -> View:
    """By a little over half as much upwards: at right angles to it there is no pixel."""
    return View(Pose(VIEW.pose.position_m + (metres, 0.6180339 * metres, 0)), VIEW.fov)


@pytest.mark.parametrize(
    "rendered",
    [turned(90), turned(180), moved(1e6), turned(0.1)],
    ids=["90", "180", "a million metres", "a fifth of a pixel"],
)
def test_moves_that_lead_nowhere_leave_both_sides(gpu, rendered):
    """Rendered behind the eye there is no move, and one below half a pixel has no side.

    At right angles and from far away the twin knows.
    """
    shown = Shown(gpu, "planes", size=SMALL, holes=holes_like(SMALL), rendered=rendered)
    got, wanted = shown.fill("composite")[0], composite(asked(shown, "composite"))[0]
    assert np.isfinite(got).all()
    assert (np.abs(got - wanted).max(axis=-1) <= STORED * wanted.max(axis=-1) + 1e-5).mean() > 0.99


def test_a_pixel_that_finds_no_light_stays_a_hole(gpu):
    shown = Shown(gpu, "planes", holes=np.ones(SIZE[::-1], bool))
    shown.shown_depth[:] = -1
    got, depth = shown.fill("composite")
    assert not got.any()
    assert (depth == -1).all()


def test_every_frame_draws_other_places_and_every_run_the_same(gpu):
    shown = Shown(gpu, "spheres", holes=holes_like(SIZE))
    first, again, next_frame = (shown.fill("composite", shown_ns=ns)[0] for ns in (0, 0, 16_666_667))
    assert np.array_equal(first, again)
    both = shown.holes & (first[..., 3] > 0) & (next_frame[..., 3] > 0)
    assert (first != next_frame)[both].any(axis=-1).mean() > 0.5
    assert not np.array_equal(first, shown.fill("composite:seed=1")[0])


def test_without_depth_it_fills_the_same(gpu):
    shown = Shown(gpu, "spheres", holes=holes_like(SIZE), rendered=LEFT)
    assert np.array_equal(shown.fill("composite", depth=False)[0], shown.fill("composite")[0])


def test_it_asks_for_no_warped_depth_but_hands_its_own_on():
    plan = build_plan((), "rotation", "interpolate+composite", "none", client_geometry=True)
    assert not plan.makes_shown_depth
    assert "rendered.inverse_depth" not in plan.layers
    assert plan.reads("client.model")
    assert build_plan((), "forward", "composite+stretch", "none", client_geometry=True).makes_shown_depth


def test_offsets_are_spread_evenly_over_the_disc():
    offsets = random_offsets(5, 40)
    assert offsets.shape == (OFFSETS, 2)
    away = np.hypot(*offsets.T)
    # The median of the radius of a disc is 1 / sqrt 2 of it; of 4096 it is known to 0.8 % (one
    # standard error: 0.5 / sqrt 4096).
    assert np.median(away) == pytest.approx(40 / np.sqrt(2), rel=0.04)
    assert away.max() <= 41
    assert np.abs(offsets.mean(axis=0)).max() < 4 * 20 / np.sqrt(OFFSETS)
    assert frame_seed(0, -1, 0) != frame_seed(0, -1, 1)
