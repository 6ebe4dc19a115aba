"""Colour sampled by a cubic: sharper, within its neighbours, and no further than the coverage."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hmdwarp.client import parse_warp
from hmdwarp.client.warp_kinds import GatherSettings
from hmdwarp.client.warps import warps
from hmdwarp.geometry import Pose

from .rendered_pictures import warped

SHARPER = [warp.name for warp in warps if issubclass(warp.Settings, GatherSettings)]
SIZE = 48


def turned(degrees: float) -> Pose:
    """A head turned about the axis between up and left."""
    half, part = math.radians(degrees) / 2, math.sqrt(0.5)
    return Pose(orientation_xyzw=(part * math.sin(half), part * math.sin(half), 0, math.cos(half)))


def waves(cycles_per_pixel: float) -> np.ndarray:
    """(h, w, 4) waves along both axes, 0.1 to 0.9."""
    y, x = np.mgrid[:SIZE, :SIZE] * 2 * math.pi * cycles_per_pixel
    picture = np.dstack([np.sin(x), np.sin(y), np.sin(x) * np.sin(y)]) * 0.4 + 0.5
    return np.dstack([picture, np.ones((SIZE, SIZE))]).astype(np.float16).astype(np.float64)


def there_and_back(gpu, spec: str, picture: np.ndarray, steps: int) -> np.ndarray:
    """The picture warped along a sway that ends where it began, each time from what was shown."""
    poses = [turned(1.5 * math.sin(2 * math.pi * k / steps)) for k in range(steps + 1)]
    for before, after in zip(poses, poses[1:], strict=False):
        picture = warped(gpu, spec, picture, np.full((SIZE, SIZE), 0.5), after, before)
    return picture


def error_db(got: np.ndarray, wanted: np.ndarray) -> float:
    """Over what a sway of 1.5 degrees leaves inside, with the reach of thirty cubics' fringes."""
    middle = np.s_[8:-8, 8:-8, :3]
    return -10 * math.log10(((got[middle] - wanted[middle]) ** 2).mean())


@pytest.mark.parametrize("name", ["rotation", "iterative"])
def test_a_picture_warped_thirty_times_stays_sharper(gpu, name):
    """A bilinear sample half way between pixels keeps cos(pi / 6) = 0.87 of waves of six pixels, a
    cubic 9/8 of that less cos(pi / 2) / 8, so 0.97: over thirty the one leaves next to nothing.
    """
    picture = waves(1 / 6)
    plain, sharp = (
        error_db(there_and_back(gpu, f"{name}:resample={kind}", picture, 30), picture)
        for kind in ("bilinear", "catmull-rom")
    )
    assert sharp > plain + 5
    assert sharp > 20


@pytest.mark.parametrize("name", [name for name in SHARPER if name != "backward"])
def test_sharp_samples_neither_ring_nor_leave_the_range(gpu, name):
    """The brightest half float beside black, and holes: no colour but between those around it."""
    picture = np.zeros((SIZE, SIZE, 4))
    picture[..., 3] = 1
    picture[10:20, :, :3] = 65504.0
    picture[:, 20:30, 1] = 65504.0
    picture[30:34, 30:34] = 0
    out = warped(gpu, f"{name}:resample=catmull-rom", picture, np.where(picture[..., 3] > 0, 0.5, -1), turned(1.3))
    assert np.isfinite(out).all()
    assert out.min() == 0 and out.max() <= 65504.0
    assert (out[out[..., 3] == 0] == 0).all()
    # Red is bright in ten rows: half a pixel beside them it is as dark as before.
    assert ((out[..., 0] > 0).any(axis=1).sum()) <= 10 + 2 + 2 * math.ceil(SIZE * math.tan(math.radians(1.3)))


@pytest.mark.parametrize("name", SHARPER)
def test_the_setting_is_known_and_left_out_at_its_default(name):
    assert parse_warp(f"{name}:resample=catmull-rom").settings.resample == "catmull-rom"
    default = warps.get(name).Settings().resample
    assert str(parse_warp(f"{name}:resample={default}")) == name
