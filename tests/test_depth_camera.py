"""The depth camera of the tests has the faults that it is given, and no others."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from depth_camera import DepthCamera

from hmdwarp.geometry import Pose
from hmdwarp.scenes import scenes
from hmdwarp.sources.server import Server

CLEAN = DepthCamera(size=(48, 36))


@pytest.fixture(scope="module")
def frame_of(gpu):
    server = Server(gpu, scenes.get("room").build())
    tail = np.array([0.0, np.sin(0.2), 0.0, np.cos(0.2)])

    def record(moving: bool = False, **faults):
        def pose(time_ns):
            return Pose((time_ns / 1e9 if moving else 0.0, 1.6, 0.0), tail)

        return attrs.evolve(CLEAN, **faults).record(server, pose, [0], np.random.default_rng(0))[0]

    yield record
    server.close()


def test_without_faults_it_measures_the_truth(frame_of):
    frame = frame_of()
    assert frame.colour.shape == (36, 48, 3) and frame.colour.dtype == np.uint8
    np.testing.assert_allclose(frame.depth_m, np.where(np.isinf(frame.truth_m), 0, frame.truth_m), rtol=1e-12)


def test_noise_grows_with_the_distance_squared(frame_of):
    """1728 pixels: the deviation is known within 4 / sqrt(2 * 1728) = 7 %."""
    frame = frame_of(noise=0.002)
    seen = np.isfinite(frame.truth_m)
    errors = (frame.depth_m - frame.truth_m)[seen] / frame.truth_m[seen] ** 2
    assert np.std(errors) == pytest.approx(0.002, rel=0.1)


def test_pixels_out_of_range_or_at_an_edge_have_no_depth(frame_of):
    far = frame_of(far_m=3.0)
    assert np.array_equal(far.depth_m == 0, far.truth_m > 3.0) and (far.depth_m == 0).any()
    edges = frame_of(edge_gaps=1.0).depth_m == 0
    assert 0 < edges.mean() < 0.6  # books and leaves at 48 pixels


def test_depth_is_shifted_against_colour(frame_of):
    shifted, clean = frame_of(shift=(3.0, -2.0)), frame_of()
    np.testing.assert_allclose(shifted.depth_m[:-2, 3:], clean.depth_m[2:, :-3], rtol=1e-3)
    assert np.array_equal(shifted.colour, clean.colour)


def test_rows_are_read_one_after_the_other(frame_of):
    """Still, nothing changes. Moving, the middle of the picture is of the stamped instant."""
    assert np.array_equal(frame_of(readout_ns=10**8).truth_m, frame_of().truth_m)
    rolled, clean = frame_of(moving=True, readout_ns=10**8, bands=9), frame_of(moving=True)
    same = (rolled.truth_m == clean.truth_m).all(axis=1)
    assert same[16:20].all() and not same[:4].all() and not same[-4:].all()
