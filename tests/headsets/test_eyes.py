"""Eyes as they are: canted, unequal, with a hidden area; and pictures that are drawn for them."""

from __future__ import annotations

import math
import re

import attrs
import numpy as np
import pytest
from client.test_multi import WALL, scene_of, square
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import poses
from worlds import read

from hmdwarp.base import InputError
from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.geometry import Fov, Hidden, Pose, guarded_eyes
from hmdwarp.headsets import Headset, HeadsetEye, headset_names, load_headset
from hmdwarp.run import needed_factors
from hmdwarp.sources.server import Server

from .bad_files import refusal

SHIPPED = headset_names()
TANGENT = st.floats(0.5, 1.9)


def turned(side: int, cant_deg: float) -> tuple[float, float, float, float]:
    half = -side * math.radians(cant_deg) / 2
    return 0, math.sin(half), 0, math.cos(half)


@st.composite
def eyes(draw, side: int) -> HeadsetEye:
    left, right, down, up = (draw(TANGENT) for _ in range(4))
    pose = Pose((side * draw(st.floats(0.026, 0.039)), 0, 0), turned(side, draw(st.floats(0, 15))))
    pose @= Pose((0, 0, 0), (0, 0, draw(st.floats(-0.05, 0.05)), 1))  # about its own axis
    corner = ((right, up), (right, up / 2), (right / 2, up))
    fov = Fov.from_tangents((-left, right, -down, up))
    return HeadsetEye(pose, fov, hidden=Hidden((corner,), fov))


MADE_UP = st.builds(
    lambda left, right: Headset("random", "made up", "made up", (64, 48), 60, (left, right)), eyes(-1), eyes(1)
)
HEADSETS = st.one_of(st.sampled_from(SHIPPED).map(load_headset), MADE_UP)


@given(HEADSETS, poses(), st.tuples(*[st.floats(-0.9, 0.9)] * 2), st.floats(0.5, 50))
def test_a_point_in_the_world_lands_where_the_eyes_own_matrices_say(headset, head, at, far):
    """A place in the picture, out to the world by the eye's matrices, and back by the pose."""
    for eye, view in zip(headset.eyes, headset.views(head), strict=True):
        left, right, down, up = eye.fov.tangents
        x, y = (
            (low + high) / 2 + share * (high - low) / 2
            for low, high, share in ((left, right, at[0]), (down, up, at[1]))
        )
        in_head = eye.head_from_eye.rotation_matrix @ (x * far, y * far, -far) + eye.head_from_eye.position_m
        in_world = head.rotation_matrix @ in_head + head.position_m
        found = view.pose.inverse().transform(in_world)
        # Positions are below 20 m and the point below 100 m away: rounding leaves 1e-13 m.
        assert -found[:2] / found[2] == pytest.approx((x, y), abs=1e-11)
        assert view.fov == eye.fov and view.head_from_eye is eye.head_from_eye


@given(HEADSETS, poses())
def test_left_and_right_exchanged_give_the_mirrored_views(headset, head):
    assert len(headset.eyes) == 2
    other = attrs.evolve(headset, eyes=tuple(eye.mirrored() for eye in headset.eyes[::-1]))
    mirror = np.diag([-1.0, 1, 1, 1])
    for eye, mirrored in zip(headset.eyes, other.eyes[::-1], strict=True):
        wanted = mirror @ eye.head_from_eye.matrix() @ mirror
        assert mirrored.head_from_eye.matrix() == pytest.approx(wanted, abs=1e-15)
        left, right, *upright = eye.fov.tangents
        assert mirrored.fov.tangents == pytest.approx([-right, -left, *upright], abs=1e-15)
        if eye.hidden:
            seen, again = (one.hidden.seen(one.fov, (40, 40)) for one in (eye, mirrored))
            assert np.mean(seen != again[:, ::-1]) < 0.01
    assert other.cants_deg == pytest.approx(headset.cants_deg[::-1])
    assert (other.across_deg, other.overlap_deg) == pytest.approx((headset.across_deg, headset.overlap_deg), abs=0.02)
    assert other.ipd_m == pytest.approx(headset.ipd_m)


@given(HEADSETS, st.floats(-12, 12), st.floats(-12, 12))
def test_a_guard_band_as_large_as_needed_holds_what_the_turned_head_sees(headset, yaw, pitch):
    """The middles of all four sides, infinitely far, lie in the views of before the turn."""
    from scipy.spatial.transform import Rotation

    turn = Pose((0, 0, 0), Rotation.from_euler("YX", (yaw, pitch), degrees=True).as_quat())
    still, moved = ((np.zeros((1, 3)), np.array([pose.orientation_xyzw])) for pose in (Pose(), turn))
    factor = float(needed_factors(headset, still, moved)[0])
    shown = headset.views(turn)
    fovs, size = guarded_eyes(headset.views(Pose()), min(factor, 30), (200, 200))
    for eye, view, fov in zip(headset.eyes, shown, fovs, strict=True):
        left, right, down, up = view.fov.tangents
        for place in ((left, 0), (right, 0), (0, down), (0, up)):
            in_world = view.pose.rotation_matrix @ (*place, -1)
            x, y, z = eye.head_from_eye.rotation_matrix.T @ in_world
            if factor > 30:  # no flat picture holds it
                continue
            edge = fov.tangents
            assert edge[0] - 1e-9 <= x / -z <= edge[1] + 1e-9
            assert edge[2] - 1e-9 <= y / -z <= edge[3] + 1e-9
    assert min(size) >= 200


@given(HEADSETS, st.floats(0.052, 0.078))
def test_any_pupil_distance_moves_both_eyes_alike_and_turns_none(headset, ipd_m):
    moved = headset.with_ipd(ipd_m)
    assert moved.ipd_m == pytest.approx(ipd_m, abs=1e-15)
    for before, after in zip(headset.eyes, moved.eyes, strict=True):
        assert after.fov == before.fov
        assert after.head_from_eye.orientation_xyzw == pytest.approx(before.head_from_eye.orientation_xyzw, abs=1e-15)
    middles = [sum(eye.head_from_eye.position_m for eye in h.eyes) for h in (headset, moved)]
    assert middles[0] == pytest.approx(middles[1], abs=1e-15)


def test_a_pupil_distance_outside_the_range_is_one_line():
    assert load_headset("flat-90:ipd=70").ipd_m == pytest.approx(0.07)
    assert load_headset("flat-90:ipd=70").name == "flat-90:ipd=70"
    for wrong in ("flat-90:ipd=51", "flat-90:ipd=78.1"):
        with pytest.raises(InputError, match="flat-90' can be set to 52 to 78 mm"):
            load_headset(wrong)
    with pytest.raises(InputError, match="expected NAME:ipd= and millimetres"):
        load_headset("flat-90:ipd=wide")


CANTED = """
name = "mine"
summary = "canted, unequal eyes"
source = "made up"
[panel]
eye_size_px = [64, 48]
refresh_hz = 60
[eyes]
ipd_m = 0.06
[eyes.left]
tangents = [-1.2, 1.0, -1.1, 0.9]
cant_deg = 5
hidden = [[[-1.2, 0.9], [-1.2, 0.4], [-0.6, 0.9]]]
[eyes.right]
tangents = [-1.0, 1.3, -1.1, 0.9]
cant_deg = 7
offset_m = [0.001, 0.002, 0.003]
"""


def load(folder, text: str) -> Headset:
    path = folder / "mine.toml"
    path.write_text(text)
    return load_headset(str(path))


def test_a_file_of_two_eyes(tmp_path):
    left, right = load(tmp_path, CANTED).eyes
    assert right.head_from_eye.position_m == pytest.approx((0.031, 0.002, 0.003))
    # The left eye's view direction, -z, points outwards: to the left.
    assert -left.head_from_eye.rotation_matrix[:, 2] == pytest.approx(
        (-math.sin(math.radians(5)), 0, -math.cos(math.radians(5)))
    )
    assert load(tmp_path, CANTED).cants_deg == pytest.approx((5, 7))
    # A triangle with legs of 0.6 and 0.5 in a view of 2.2 x 2.0, counted in 512 columns.
    assert left.hidden_share == pytest.approx(0.15 / 4.4, abs=2e-3) and right.hidden_share == 0
    seen = left.hidden.seen(left.fov, (22, 20))
    assert not seen[-1, 0] and seen[0].all() and seen[:, -1].all()


CORNER, HIDDEN = "[[-1.2, 0.9], [-1.2, 0.4], [-0.6, 0.9]]", "hidden is no list of polygons"


@pytest.mark.parametrize(
    ("found", "put", "says"),
    [
        ("cant_deg = 5", "cant_deg = -30", "the left eye is turned inwards by 30 degrees: expected at most 10"),
        ("cant_deg = 7", "cant_deg = 31", "the right eye is turned outwards by 31 degrees"),
        ("tangents = [-1.2, 1.0,", "tangents = [-1.2, -0.9,", "no direction in common: they lie .* degrees apart"),
        ("tangents = [-1.2, 1.0,", "tangents = [1.2, 1.0,", "left < right"),
        ("[eyes.right]", 'right = "same"\n[eyes.other]', "right is 'same': expected \"mirrored\", or a table"),
        (f"[{CORNER}]", "[[[-1.2, 0.9], [-1.2, 0.4]]]", HIDDEN),
        (f"[{CORNER}]", "7", HIDDEN),
        (CORNER, "[[-2, -2], [2, -2], [2, 2], [-2, 2]]", "hidden area covers 100% of the view"),
        (CORNER, "[[-2, -0.05], [2, -0.05], [2, 0.05], [-2, 0.05]]", "all of the view at eye level"),
        (f"hidden = [{CORNER}]", "hidden_share = 0.1\nseen_deg = [-9, 9, -9, 9]", "seen_deg and hidden_share 0.1"),
        ("ipd_m = 0.06", "ipd_m = 60", "eyes.ipd_m is 60"),
    ],
)
def test_a_bad_eye_is_one_line(tmp_path, found, put, says):
    text = CANTED.replace(found, put, 1)
    if "right = " in put:
        text = text.replace('right = "same"\n', "").replace("ipd_m = 0.06\n", 'ipd_m = 0.06\nright = "same"\n')
    assert text != CANTED and re.search(says, refusal(tmp_path, text))


# --- what is drawn, warped and guarded for them ---------------------------------------------------


SIZE = (67, 53)


@pytest.mark.parametrize("warp", ["rotation", "iterative", "forward"])
@given(headset=MADE_UP)
@settings(max_examples=4)
def test_an_unmoved_head_sees_what_was_drawn_whatever_the_eyes(gpu, warp, headset):
    server = Server(gpu, scene_of(square(1.5, (0.1, -0.2), 0.4, 0.6), WALL))
    client = Compensator(gpu, build_plan((), warp, "none", "none", client_geometry=True), None, SIZE, SIZE, hides=True)
    for view in headset.views(Pose((0.1, 0, 0))):
        rendered = server.draw(view, SIZE)
        shown = read(client.run(PassInputs(rendered, view)).shown.texture)
        seen = view.hidden.seen(view.fov, SIZE)
        assert np.array_equal(shown[seen], read(rendered.colour)[seen]) and 0.3 < seen.mean() < 1
    client.close()
    server.close()
