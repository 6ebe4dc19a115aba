"""What a run is measured by: truth of rolling displays, whole pictures, the oracle, the gaze."""

from __future__ import annotations

import itertools
import json
import math

import attrs
import numpy as np
import pytest
from eyes import with_eyes
from hypothesis import given
from hypothesis import strategies as st
from replays import refreshed, run, small
from scipy.spatial.transform import Rotation
from strategies import FOVS, poses, vectors

from hmdwarp.client import PassInputs, build_plan
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import download
from hmdwarp.metrics import Compared
from hmdwarp.poses import synthesise, write_synthetic
from hmdwarp.run import draw_truth, set_up_replay
from hmdwarp.run.measuring import (
    MOST_BANDS,
    NEAR_DEG,
    PIXELS_PER_BAND,
    NearGaze,
    WholePictures,
    bands_of,
    from_late,
    is_measured,
    near_gaze,
)
from hmdwarp.scenes import load_scene, scenes
from hmdwarp.sources.server import Server

FOV = Fov(-0.8, 0.7, -0.6, 0.9)
SIZE = (48, 37)


def turned(pose: Pose, radians: float, step=(0.0, 0.0, 0.0)) -> Pose:
    return Pose(pose.position_m + step, (pose.rotation * Rotation.from_rotvec((0, radians, 0))).as_quat())


@pytest.fixture(scope="module")
def server(gpu):
    made = Server(gpu, load_scene("planes"))
    yield made
    made.close()


def truth(server: Server, first: View, last: View | None):
    return draw_truth(server, PassInputs(None, first, shown_last=last), SIZE)  # type: ignore[arg-type]


def test_a_head_that_rests_sees_the_picture_drawn_at_once(server):
    view = View(server.scene.viewpoint, FOV)
    whole = server.draw(view, SIZE)
    for last in (None, view):
        found = truth(server, view, last)
        assert np.array_equal(found.colour, download(whole.colour))
        assert np.array_equal(found.inverse_depth, download(whole.inverse_depth))
    server.pool(SIZE).release(whole.colour)


@pytest.mark.parametrize("degrees", [1.0, 6.0, 40.0])
def test_each_band_is_that_part_of_the_picture_of_its_instant(server, degrees):
    """Against whole pictures drawn for each row's instant.

    A row lies within half a band of its own, half of PIXELS_PER_BAND away.
    """
    first = View(server.scene.viewpoint, FOV)
    last = View(turned(first.pose, math.radians(degrees)), FOV)
    found = truth(server, first, last)
    ends = np.cumsum([0, *(rows for _, rows in bands_of(first, last, SIZE))])
    for top, bottom in zip(ends[:-1], ends[1:], strict=True):
        whole = server.draw(View(first.pose.towards(last.pose, (top + bottom) / 2 / SIZE[1]), FOV), SIZE)
        colour, depth = download(whole.colour)[top:bottom], download(whole.inverse_depth)[top:bottom]
        server.pool(SIZE).release(whole.colour)
        # The band's own projection rounds anew, so that a pixel centre on an edge may fall to its
        # other side.
        assert np.isclose(found.inverse_depth[top:bottom], depth, rtol=1e-5).mean() > 0.99
        same = np.isclose(found.colour[top:bottom].astype(float), colour.astype(float), atol=0.01).all(axis=-1)
        assert same.mean() > 0.98


def test_no_texture_stays_out(server):
    first = View(server.scene.viewpoint, FOV)
    for degrees in (0.5, 3, 20):
        truth(server, first, View(turned(first.pose, math.radians(degrees)), FOV))
    assert all(pool.live == 0 for pool in server._pools.values())


@given(poses(), vectors(st.floats(-0.02, 0.02)), st.floats(0, 0.3), FOVS, st.integers(1, 900), st.integers(1, 900))
def test_bands_cover_all_rows_and_keep_their_pixel_centres(pose, step, angle, fov, wide, high):
    first, last = View(pose, fov), View(turned(pose, angle, step), fov)
    bands = list(bands_of(first, last, (wide, high)))
    assert sum(rows for _, rows in bands) == high
    assert all(rows > 0 for _, rows in bands)
    assert len(bands) <= min(MOST_BANDS, high)
    # Each top row first.
    whole = np.concatenate([view.rays((wide, rows))[::-1] for view, rows in bands])
    assert np.abs(whole - first.rays((wide, high))[::-1]).max() <= 1e-12 * np.abs(whole).max()
    turns = [a.pose.angle_to(b.pose) for (a, _), (b, _) in itertools.pairwise(bands)]
    if 1 < len(bands) < min(MOST_BANDS, high):
        per_radian = math.degrees(1) * fov.pixels_per_degree((wide, high))
        # Bands differ by a row at most, and there is less than one row's turn between a rounded end
        # and an even one.
        assert max(turns) * per_radian <= PIXELS_PER_BAND * (1 + 2 * len(bands) / high) + 1e-9


# --- whole replays

TURNING = {
    "trace": "fast-turns", "warp": "rotation", "start_s": 1.0, "seconds": 0.5, "latency_ms": 33.0, "guard": 1.5,
    "metrics_every": 3,
}  # fmt: skip


def figures(folder, **options) -> dict:
    return run(folder, **{**TURNING, **options}).summary


def test_following_the_scan_out_is_better_than_showing_its_middle(tmp_path):
    """On the same rolling display; the gain is what half a scan-out of head motion costs."""
    follows = figures(tmp_path / "a", scanout_ms=16.0)
    middle = figures(tmp_path / "b", scanout_ms=16.0, follow_scanout=False)
    flip, psnr = ([found["quality"][name]["mean"] for found in (follows, middle)] for name in ("flip", "psnr_db"))
    assert flip[0] < 0.9 * flip[1]
    assert psnr[0] > psnr[1] + 0.5
    assert any("follows it row by row" in note for note in follows["notes"])
    assert any("shows all rows as in its middle" in note for note in middle["notes"])


def test_a_fused_run_is_measured_before_the_lens_and_shows_what_it_made(tmp_path):
    """The same figures as in two passes, because quality is what the eye sees before the lens.

    The time is that of one pass.
    """
    options = {"headset": "rift-dk1", "lens": "radial", "seconds": 0.2, "images": 1}
    fused, separate = (figures(tmp_path / name, fused=name == "fused", **options) for name in ("fused", "separate"))
    assert fused["quality"] == separate["quality"]
    assert fused["time_ms"]["lens"]["median"] == 0 < separate["time_ms"]["lens"]["median"]
    assert fused["time_ms"]["warp"]["median"] > 0
    assert any("Warp and lens are one pass" in note for note in fused["notes"])
    assert json.loads((tmp_path / "fused" / "summary.json").read_text(encoding="utf-8"))["lens"] == "radial"


@pytest.mark.parametrize("every", [2, 5, 10])
@pytest.mark.parametrize("period", [2, 3, 4, 5])
def test_measured_refreshes_are_in_step_with_no_period(every, period):
    """Or every tenth could be of one kind, such as those that show an older frame."""
    measured = [number for number in range(1200) if is_measured(number, every)]
    assert measured[0] == 0 and len(measured) in (1200 // every, 1200 // every - 1)
    assert [number // every for number in measured] == list(range(len(measured)))
    shares = [sum(number % period == phase for number in measured) / len(measured) for phase in range(period)]
    assert max(abs(share - 1 / period) for share in shares) < 0.05


SIZE_ORACLE, WALL = (40, 30), 0.5  # 2 m away
FOV_ORACLE = Fov.symmetric(1.2, 0.9)


def test_a_wall_seen_from_beside_is_shown_exactly_where_the_late_frame_saw_it():
    """A picture that is linear across the wall is sampled exactly between its pixels."""
    shown, rendered = View(Pose((0.1, 0, 0)), FOV_ORACLE), View(Pose(), FOV_ORACLE)
    x = np.broadcast_to(np.arange(SIZE_ORACLE[0]) + 0.5, SIZE_ORACLE[::-1])
    late = np.repeat(x[..., None], 3, axis=2)
    wall = np.full(SIZE_ORACLE[::-1], WALL)
    colour, seen = from_late(WarpMap.between(shown, SIZE_ORACLE, rendered, SIZE_ORACLE), wall, late, wall)
    left, right, _, _ = FOV_ORACLE.tangents
    moved = 0.1 * WALL * SIZE_ORACLE[0] / (right - left)  # pixels
    inside = x + moved <= SIZE_ORACLE[0] - 0.5
    assert seen[inside].all() and not seen[~inside].any() and not inside.all()
    assert colour[inside][:, 0] == pytest.approx((x + moved)[inside])


def test_what_stood_behind_something_nearer_was_not_seen():
    here = View(Pose(), FOV_ORACLE)
    wall = np.full(SIZE_ORACLE[::-1], WALL)
    late_depth = wall.copy()
    late_depth[10:20, 5:15] = 2 * WALL
    late = np.zeros((*SIZE_ORACLE[::-1], 3))
    _, seen = from_late(WarpMap.between(here, SIZE_ORACLE, here, SIZE_ORACLE), wall, late, late_depth)
    inner = seen[1:-1, 1:-1]
    assert np.array_equal(~inner, late_depth[1:-1, 1:-1] == 2 * WALL)


SIZE_NEAR_GAZE = (60, 48)
AHEAD = View(Pose(), Fov.symmetric(math.radians(60), math.radians(50)))


def looking_left(degrees: float) -> View:
    yaw = math.radians(degrees)
    return attrs.evolve(AHEAD, gaze=(-math.sin(yaw), 0.0, -math.cos(yaw)))


def test_pixels_near_the_gaze_are_those_within_five_degrees():
    """Against angles by another route; for an eye that is canted the gaze turns back."""
    canted = Pose((0.03, 0, 0), Rotation.from_euler("y", 10, degrees=True).as_quat())
    for view in (looking_left(12), attrs.evolve(looking_left(12), head_from_eye=canted)):
        found = near_gaze(view, SIZE_NEAR_GAZE)
        flat = view.head_from_eye.rotation.apply(view.rays(SIZE_NEAR_GAZE).reshape(-1, 3))
        rays = flat.reshape(*SIZE_NEAR_GAZE[::-1], 3)
        angles = np.degrees(np.arctan2(np.linalg.norm(np.cross(rays, view.gaze), axis=-1), rays @ view.gaze))
        assert np.array_equal(found, angles <= NEAR_DEG) and 20 < found.sum() < 200


def test_an_error_counts_where_the_eye_looks_alone():
    truth = np.full((*SIZE_NEAR_GAZE[::-1], 3), 100, np.uint8)
    shown = truth.copy()
    shown[near_gaze(looking_left(12), SIZE_NEAR_GAZE)[::-1]] = 90
    for degrees, psnr_db in ((12, 20 * math.log10(255 / 10)), (-12, 100)):
        near = NearGaze()
        near.add(Compared(shown, truth, AHEAD), looking_left(degrees), looking_left(12))
        assert near.entry()["gaze"]["psnr_db"] == pytest.approx(psnr_db)
    assert NearGaze().entry() == {}


def test_the_gaze_is_off_by_what_eyes_and_head_have_moved():
    """The head turned by 7 degrees to the left and the eyes by 5 to the right: 2 in the world. One
    that a frame lacks is not taken for straight ahead, unless that is how frames are drawn.
    """
    head = Pose((0, 0, 0), Rotation.from_euler("y", 7, degrees=True).as_quat())
    blank, shown = np.zeros((*SIZE_NEAR_GAZE[::-1], 3), np.uint8), attrs.evolve(looking_left(-2), pose=head)
    for looks_ahead, rendered, off in ((False, looking_left(3), 2.0), (False, AHEAD, None), (True, AHEAD, 5.0)):
        near = NearGaze(looks_ahead)
        near.add(Compared(blank, blank, AHEAD), shown, rendered)
        found = near.entry()["gaze"]["off_deg"]
        assert (found and pytest.approx(found)) == (off and {"p50": off, "p95": off})


def test_a_predicted_head_has_the_gaze_of_the_head_that_is_held(tmp_path, gpu):
    """Prediction turns the head; the eyes rest in the world, as they do for a fovea."""
    with (tmp_path / "eyes.csv").open("w", encoding="utf-8") as file:
        write_synthetic(with_eyes(synthesise("look-around", seconds=2)), file)
    usual = {"gpu": gpu, "trace": str(tmp_path / "eyes.csv"), "latency_ms": 100.0, "rate_hz": 50.0, "force": True}
    off = [
        run(tmp_path / "out", **usual, **how).summary["gaze"]["off_deg"]
        for how in ({"predict": "none"}, {"predict": "cautious"}, {"predict": "cautious", "fovea_deg": 40.0})
    ]
    # Each refresh lies on a sample, so that all know the same.
    assert off[0]["p95"] > 0.5 and off[1] == pytest.approx(off[0], abs=1e-4)
    assert off[2] == pytest.approx(off[0], abs=1e-4)


CALLING = [name for name in scenes.names() if scenes.get(name).effects]
PLAN = build_plan((), "none", "none", "none", client_geometry=True)


@pytest.mark.parametrize("scene", CALLING)
def test_none_beside_another_warp_is_none_alone(scene):
    asked = {"scene": scene, "latency_ms": 50.0}
    with set_up_replay(small(warp="none", **asked)) as setup:
        alone = [download(eye.panel.texture) for eye in refreshed(setup).eyes]
    with set_up_replay(small(warp="forward", **asked)) as setup:
        refresh, whole, beside = refreshed(setup), WholePictures(setup.server), setup.compensator(PLAN)
        for _ in range(2):  # again, from what is held
            inputs = whole.inputs(setup.loop, refresh, PLAN)
            pictures = [download(beside.run(eye_inputs).panel.texture) for eye_inputs in inputs]
            # Drawn twice, a GPU may blend with another last bit: 2^-10 of a stored half float.
            off = max(np.abs(a.astype(float) - b).max() for a, b in zip(pictures, alone, strict=True))
            assert off <= (0 if setup.target.gpu.is_software else 2.0**-10)
        # The run's own plan gets what was sent.
        own = whole.inputs(setup.loop, refresh, setup.plans[0])
        assert all(one.rendered is sent.rendered for one, sent in zip(own, refresh.inputs, strict=True))
        whole.close()


@pytest.mark.parametrize("warp", ["model", "model:arrives=progressive", "points", "irradiance", "photons"])
def test_a_picture_that_no_plan_reads_is_not_drawn_and_shows_the_same(warp):
    asked = small(scene="lantern", latency_ms=50.0, warp=warp, fill="none", effects="none")
    with set_up_replay(asked) as setup:
        drawn = refreshed(setup)
        assert not any(eye.left_out for eye in drawn.frame.eyes)
        expected = [download(eye.panel.texture) for eye in drawn.eyes]
        late = [download(eye.colour) for eye in drawn.frame.eyes]
    with set_up_replay(asked, alone=True) as setup:
        refresh, whole = refreshed(setup), WholePictures(setup.server)
        for eye, wanted in zip(refresh.eyes, expected, strict=True):
            assert np.array_equal(download(eye.panel.texture), wanted)
        for eye in refresh.frame.eyes:
            assert eye.left_out
            # Holes all over, should anything read it.
            assert not download(eye.colour).any() and (download(eye.inverse_depth) == -1).all()
        beside = setup.compensator(PLAN)
        for one, colour in zip(whole.inputs(setup.loop, refresh, PLAN), late, strict=True):
            assert np.array_equal(download(one.rendered.colour), colour)
            assert download(beside.run(one).panel.texture)[..., 3].any()
        whole.close()
