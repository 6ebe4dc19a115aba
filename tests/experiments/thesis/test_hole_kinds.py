"""Holes are told apart by where their true surface was; shares, edges and streams are counted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.experiments.thesis.experiment import RATE_HZ, Motion, PictureRun, StreamRun
from hmdwarp.experiments.thesis.run_figures import Thoroughness, false_edges, holes_of, look, seam, stream
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import border_holes

FOV = Fov.symmetric(np.deg2rad(90), np.deg2rad(70))
SIZE, SHAPE = (24, 16), (16, 24)


def view(x: float = 0.0, y: float = 0.0, turned_deg: float = 0.0) -> View:
    half = np.deg2rad(turned_deg) / 2
    return View(Pose(position_m=(x, y, 0), orientation_xyzw=(0, np.sin(half), 0, np.cos(half))), FOV)


def test_an_unmoved_head_has_cracks_where_the_frame_has_the_surface():
    depth = np.full(SHAPE, 0.5)
    nearer = depth.copy()
    nearer[:4] = 2.0  # in the late frame something stood before the top rows
    coverage = np.ones(SHAPE)
    coverage[2:6, 3] = 0
    border, cracks = holes_of(coverage, depth, view(), view(), nearer)
    assert np.argwhere(cracks).tolist() == [[4, 3], [5, 3]] and not border.any()


@given(st.integers(0, 2**32 - 1), st.floats(-0.6, 0.6), st.floats(-0.4, 0.4), st.floats(-40, 40), st.integers(8, 40))
def test_the_kinds_share_all_holes_and_the_border_is_that_of_the_metric(seed, x, y, turned, width):
    rng = np.random.default_rng(seed)
    coverage = rng.integers(0, 2, SHAPE)
    depth, frame = rng.uniform(0, 3, SHAPE), rng.uniform(0, 3, (16, width))
    shown, rendered = view(x, y, turned), view()
    border, cracks = holes_of(coverage, depth, shown, rendered, frame)
    assert not (border & cracks).any() and not (border | cracks)[coverage != 0].any()
    # Alike but for a ray that meets the very edge, which belongs to the one and not to the other.
    share = border_holes(coverage, depth, shown, rendered, (width, 16)).mean()
    assert border.mean() == pytest.approx(share, abs=1 / coverage.size)


def test_holes_of_the_last_row_and_column_are_told_apart_too():
    """And a ray that meets the very edge belongs to the border: pixels end there."""
    depth, frame = np.full(SHAPE, 0.5), np.full(SHAPE, 0.5)
    frame[0], frame[:, -1] = 2.0, 2.0
    border, cracks = holes_of(np.zeros(SHAPE), depth, view(), view(), frame)
    expected = np.zeros(SHAPE, bool)
    expected[0] = expected[:, -1] = True
    assert not border.any() and (cracks == ~expected).all()
    left, right, *_ = FOV.tangents
    moved = view((right - left) / SIZE[0] * 2.5)  # 2.5 pixels of a surface at 2 m are 1.25
    border, _ = holes_of(np.zeros(SHAPE), depth, moved, view(), frame)
    assert border[:, -1:].all() and not border[:, :-1].any()


def test_a_seam_is_the_false_step_between_filled_and_warped():
    truth = np.zeros((4, 6, 3), np.uint8)
    truth[:, 3:] = 100  # a true step, which is no seam
    filled = np.zeros((4, 6), bool)
    filled[:, 3:] = True
    assert seam(truth, truth, filled, ~filled) == 0.0
    shown = truth.copy()
    shown[:, 3:] += 51
    assert seam(shown, truth, filled, ~filled) == pytest.approx(51 / 255)
    assert seam(shown, truth, filled, np.zeros_like(filled)) is None


def test_false_edges_are_those_that_the_truth_has_not_within_a_pixel():
    truth = np.zeros((6, 12, 3), np.uint8)
    truth[:, 6:] = 200
    beside, doubled = np.roll(truth, 1, axis=1), truth.copy()
    beside[:, :6] = 0  # the same edge, a pixel to the right
    doubled[:, 9:] = 90  # the true edge, and another
    doubled[-1] = truth[-1]  # not in the last row
    assert false_edges(truth, truth) == false_edges(beside, truth) == 0.0
    # Of the last row's 6 edges across one is true; down, its 3 columns differ from the row above.
    assert false_edges(doubled, truth) == pytest.approx((5 + 3) / (6 + 5 + 3))
    assert false_edges(np.zeros_like(truth), truth) is None
    corner = np.zeros_like(truth)
    corner[-1, -1] = 200  # in the last row and column alone
    assert false_edges(corner, corner) == 0.0 and false_edges(corner, truth) == 1.0


def test_shares_of_holes_are_parts_of_each_other(tmp_path):
    motion = Motion("rotate", 60.0)
    late, bare, filled = runs = [
        PictureRun(motion=motion, latency_ms=400.0, scene="spheres", **{"warp": warp, "fill": fill})
        for warp, fill in (("none", "none"), ("forward", "none"), ("forward", "interpolate"))
    ]
    found = {looked.run: looked.figures for looked in look(runs, Thoroughness((48, 30), 2, 1), tmp_path)}
    # The late picture is the late picture: it gains nothing, and has no holes.
    assert found[late]["gain_db"] == 0.0 == found[late]["hole_share"]
    one = found[bare]
    assert one["hole_share"] == pytest.approx(one["border_share"] + one["inner_share"])
    assert one["border_share"] > 0.01 and one["inner_share"] > one["crack_share"] > 0
    # Nothing is filled, so all that was a hole is left.
    assert one["empty_share"] == one["hole_share"] and one["seam"] is None
    assert one["inner_left_share"] == one["inner_share"] and one["cracks_left_share"] == one["crack_share"]
    other = found[filled]
    assert all(other[name] == one[name] for name in ("hole_share", "inner_share"))
    assert other["cracks_left_share"] <= other["inner_left_share"] < one["inner_share"]


@pytest.mark.parametrize(("server_hz", "lost"), [(None, 0.0), (120.0, 0.5)])
def test_a_stream_is_that_of_one_eye_at_the_servers_rate(server_hz, lost):
    how = {"size": (48, 32), "scene": "planes", "latency_ms": 50.0, "server_hz": server_hz}
    runs = StreamRun(codec="h264", **how), StreamRun(codec="none", depth="video", **how)
    coded, bare = (stream(each, 1.0, 0.25)[0] for each in runs)
    # Four halves a pixel, and at each refresh as many frames as the rates' ratio.
    per_eye = 48 * 32 * 8 * 8 * (server_hz or RATE_HZ) / 1e6
    # A frame more or less at the ends of the 20 refreshes or more that it lasts.
    assert bare["mbit_s"] == bare["full_size_mbit_s"] == pytest.approx(per_eye, rel=0.05)
    assert bare["mbit_s"] == pytest.approx(sum(value for name, value in bare.items() if name == "colour_mbit_s"))
    for each in (coded, bare):
        assert each["never_shown_share"] == pytest.approx(lost, abs=0.05)
