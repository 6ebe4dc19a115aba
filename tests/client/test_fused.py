"""Warps that look through the lens themselves. Against their float64 twins behind the lens's own
twin, and against the two passes."""

from __future__ import annotations

import numpy as np
import pytest
from panels import in_two_passes, panel_of, world_before
from reference.fused import fused
from scipy import ndimage
from worlds import World, assert_equals_twin, twin_of

from hmdwarp.client import parse_warp
from hmdwarp.client.warps import warps
from hmdwarp.geometry import face_views
from hmdwarp.geometry.cube import FACES
from hmdwarp.headsets import headset_names, load_headset

WITH_LENS = [name for name in headset_names() if load_headset(name).lens]
FUSING = [name for name in warps.names() if warps.get(name).fuses]
# Their twins answer for any direction.
WITH_TWIN_AT_PLACES = [*(name for name in FUSING if name != "iterative"), "rotation:edge=clamp"]
SIZES = [
    ((67, 53), (61, 83)),
    ((64, 64), (101, 37)),
    ((129, 2), (31, 27)),
    ((1, 1), (9, 7)),
    ((40, 50), (1, 1)),
]  # shown, panel


@pytest.mark.parametrize("name", WITH_TWIN_AT_PLACES)
@pytest.mark.parametrize("headset", WITH_LENS)
def test_equals_the_lens_twin_before_the_warps_twin(gpu, name, headset):
    for number, (size, panel_size) in enumerate(SIZES):
        eye, chosen = number % 2, load_headset(headset)
        world = world_before(gpu, chosen, eye, 11 + eye, size)
        got = panel_of(gpu, world, name, chosen, eye, panel_size)
        choice = parse_warp(name)
        wanted = fused(world.asked(choice.settings), twin_of(choice.entry.name), chosen, eye, panel_size)
        # Three looks per pixel, each of which may be a close call: three times the 10 % that a
        # single look is allowed.
        assert_equals_twin(got, wanted, 0.7)


def smooth_cube(world: World, side: int) -> np.ndarray:
    """What the cube holds if the colour of a direction is its own coordinates."""
    out = np.zeros((2 * side, 3 * side, 4))
    for face, view in zip(FACES, face_views(world.rendered_view, side), strict=True):
        direction = view.rays((side, side)) @ view.pose.rotation.as_matrix().T
        colour = 0.5 + 0.3 * direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        cell = np.s_[face.row * side : (face.row + 1) * side, face.column * side : (face.column + 1) * side]
        out[cell] = np.dstack([colour, np.ones((side, side))])
    return out.astype(np.float16).astype(np.float64)


@pytest.mark.parametrize("name", FUSING)
@pytest.mark.parametrize("headset", WITH_LENS)
def test_fused_and_in_two_passes_show_the_same(gpu, name, headset):
    """A smooth picture without holes after a small motion. What two resamples blur, one does not,
    and that is little here."""
    chosen, size, panel_size = load_headset(headset), (96, 80), (90, 100)
    world = world_before(gpu, chosen, 0, 3, size)
    y, x = np.mgrid[: size[1], : size[0]] / 40
    smooth = np.dstack([0.5 + 0.3 * np.sin(x), 0.5 + 0.3 * np.cos(y + x), 0.5 + 0.3 * np.sin(y), np.ones_like(x)])
    world.colour, world.inverse_depth = smooth.astype(np.float16).astype(np.float64), np.full(size[::-1], 0.3)
    world.client = world._client_depth()
    world.upload(gpu)
    if "rendered.cube" in warps.get(name).reads:
        world.cube = smooth_cube(world, max(size) + 2)
    got, two = (make(gpu, world, name, chosen, 0, panel_size) for make in (panel_of, in_two_passes))
    assert np.isfinite(got).all()
    assert set(np.unique(got[..., 3])) <= {0.0, 1.0}
    # Beside a hole the lens pass mixes its black in; all colours of the picture are above 0.15.
    covered = (
        (got[..., 3] == 1) & (two[..., 3] == 1) & (got[..., :3] > 0.1).all(axis=-1) & (two[..., :3] > 0.1).all(axis=-1)
    )
    everywhere = ndimage.binary_erosion(covered, iterations=2)
    assert everywhere.mean() > 0.3
    difference = np.abs(got - two)[everywhere].max(axis=-1)
    # The second derivative of the picture is 0.3 / 40^2, at most 3 x 3 times that after the map: a
    # linear resample leaves an eighth of it.
    assert np.quantile(difference, 0.98) <= 0.01
    # Coverage may part only where a footprint meets an edge of the picture.
    assert (got[..., 3] != (two[..., 3] > 0)).mean() < 0.06
