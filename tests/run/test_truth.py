"""The truth of a display that lights up row by row.

Bands that fit together to the whole picture, each for its own instant.
"""

from __future__ import annotations

import json
import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from replays import run, small
from scipy.spatial.transform import Rotation
from strategies import FOVS, poses, vectors

from hmdwarp.client import PassInputs
from hmdwarp.errors import InputError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.pipeline import build_plan_for
from hmdwarp.run import draw_truth, set_up_replay
from hmdwarp.run.truth import MOST_BANDS, PIXELS_PER_BAND, bands_of, is_measured
from hmdwarp.scenes import load_scene
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
        assert (
            np.isclose(found.colour[top:bottom].astype(float), colour.astype(float), atol=0.01).all(axis=-1).mean()
            > 0.98
        )


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
    turns = [
        (a.pose.rotation.inv() * b.pose.rotation).magnitude() for (a, _), (b, _) in zip(bands, bands[1:], strict=False)
    ]
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


def test_a_warp_without_scanout_shows_the_middle_and_says_so(tmp_path):
    summary = figures(tmp_path, warp="forward", scanout_ms=16.0)
    assert any("warp 'forward' shows all rows as in its middle" in note for note in summary["notes"])


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


def test_fused_and_scanned_out_together(tmp_path):
    summary = figures(tmp_path, headset="rift-dk1", lens="radial", fused=True, scanout_ms=10.0, seconds=0.1)
    assert summary["quality"]["psnr_db"]["mean"] > 15
    assert len([note for note in summary["notes"] if "one pass" in note or "scans out" in note]) == 2


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"lens": "none", "headset": "flat-90"}, "nothing to look through"),
        ({"fill": "interpolate"}, "a fill needs the picture between warp and lens"),
        ({"warp": "forward"}, "only gather warps can"),
    ],
)
def test_warps_that_cannot_be_fused_are_refused_in_one_line(options, told):
    asked = small(**{"warp": "rotation", "headset": "rift-dk1", "lens": "radial", "fused": True, **options})
    with pytest.raises(InputError, match=told) as refused, set_up_replay(asked):
        pass
    assert "\n" not in str(refused.value)


def test_the_plan_tells_of_both():
    from hmdwarp.headsets import load_headset

    asked = small(warp="rotation", headset="rift-dk1", lens="radial", fused=True, scanout_ms=8.0)
    plan = build_plan_for(asked, load_headset("rift-dk1"), load_scene("planes"))
    assert plan.fused
    assert plan.scanout
    (step,) = plan.steps
    assert "fused with the lens" in step.reason
    assert "every row" in step.reason
    assert dict(plan.left_out)["lens"].startswith("warp 'rotation' looks through the lens itself")
    cannot = build_plan_for(
        attrs.evolve(asked, warp="forward", fused=False), load_headset("rift-dk1"), load_scene("planes")
    )
    assert not cannot.scanout
    assert "cannot follow" in dict(cannot.left_out)["scan-out"]


@pytest.mark.parametrize("every", [2, 5, 10])
@pytest.mark.parametrize("period", [2, 3, 4, 5])
def test_measured_refreshes_are_in_step_with_no_period(every, period):
    """Or every tenth could be of one kind, such as those that show an older frame."""
    measured = [number for number in range(1200) if is_measured(number, every)]
    assert measured[0] == 0 and len(measured) in (1200 // every, 1200 // every - 1)
    assert [number // every for number in measured] == list(range(len(measured)))
    shares = [sum(number % period == phase for number in measured) / len(measured) for phase in range(period)]
    assert max(abs(share - 1 / period) for share in shares) < 0.05
