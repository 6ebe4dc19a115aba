"""Frames are sent only where something changes: head, body, deforming mesh, light, recording."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import attrs
import numpy as np
import pytest
from lit_rooms import moving_room
from recorded_folders import taken, write_npz
from replays import rows_of, run
from scipy.spatial.transform import Rotation

from hmdwarp.frames import Frame
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import download
from hmdwarp.link import GilbertElliott, LinkOptions
from hmdwarp.pipeline import Changes
from hmdwarp.scenes import Panel, Spinning, load_scene
from hmdwarp.sources.server import Server

SIZE = (96, 80)
FOV = Fov.symmetric(1.5, 1.3)
CHANGES = LinkOptions(send="changes")
NOTHING = 1e-9  # pixels: rounding of the map, far below what is seen


def trace_of(path: Path, yaw_rad_s: float = 0.0, seconds: float = 2.0) -> str:
    """A head that stands, or turns evenly."""
    times = np.arange(round(seconds * 100) + 1) / 100
    lines = (f"{t} 0 1.6 0 0 {math.sin(yaw_rad_s * t / 2)} 0 {math.cos(yaw_rad_s * t / 2)}\n" for t in times)
    path.write_text("# timestamp tx ty tz qx qy qz qw\n" + "".join(lines), encoding="utf-8")
    return str(path)


def turned(position, rotvec) -> Pose:
    return Pose(position, Rotation.from_rotvec(rotvec).as_quat())


def bounds(gpu, scene, view: View, *later: tuple[View, int], drawn=None):
    """What has changed since a frame of a view, in pixels, by a later view and how much later.
    drawn: another to draw. With the frame's depth."""
    with closing(Server(gpu, drawn or scene)) as server:
        changes, start_ns = Changes(scene), 1_000_000_000
        eye = server.draw(view, SIZE, time_ns=start_ns)
        changes.sent(Frame((eye,), start_ns))
        return [changes.moved_px([after], start_ns + ns) for after, ns in later], download(eye.inverse_depth)[::-1]


@pytest.mark.parametrize("seed", range(12))
def test_no_point_moves_farther_than_the_bound_says_and_the_bound_is_tight(gpu, seed):
    """Every pixel of the frame by its own depth, against the bound from the nearest one."""
    rng = np.random.default_rng(seed)
    scene = load_scene("spheres")
    place = scene.viewpoint.position_m
    before = View(turned(place, rng.normal(0, 0.3, 3)), FOV)
    turn, step = rng.normal(0, 0.01, 3) * (seed % 3 != 0), rng.normal(0, 0.01, 3) * (seed % 3 != 1)
    after = View(Pose(place + step, (before.pose @ turned((0, 0, 0), turn)).orientation_xyzw), FOV)
    (bound,), depth = bounds(gpu, scene, before, (after, 0))
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    pixels, depth = np.stack([x, y], axis=-1), np.maximum(depth.astype(np.float64), 0)
    moved = WarpMap.between(before, SIZE, after, SIZE).apply(pixels, depth)[0] - pixels
    farthest = float(np.linalg.norm(moved, axis=-1).max())
    # Pixel centres end half a pixel within the sides of the picture, where the bound is taken.
    assert farthest <= bound
    if not step.any():
        assert bound <= 1.1 * farthest, "without parallax it is the motion of a corner"


def test_a_head_at_rest_changes_nothing_and_the_first_frame_everything(gpu):
    scene = load_scene("room")
    view = View(scene.viewpoint, FOV)
    assert Changes(scene).moved_px([view], 0) == math.inf
    behind = View(scene.viewpoint @ turned((0, 0, 0), (0, math.pi, 0)), FOV)
    (rest, turned_away), _ = bounds(gpu, scene, view, (view, 10**9), (behind, 0))
    assert rest < NOTHING and turned_away == math.inf


@pytest.mark.parametrize("scene_name", ["workshop", "parade"])
def test_moving_bodies_count_as_changes(gpu, scene_name):
    scene = load_scene(scene_name)
    view = View(scene.viewpoint, FOV)
    found, _ = bounds(gpu, scene, view, *((view, after) for after in (0, 10_000_000, 100_000_000)))
    assert found[0] < NOTHING and found[1] == found[2] == math.inf


def test_a_panel_whose_page_turns_is_a_change(gpu):
    pages = tuple(np.full((4, 4, 3), light, np.uint8) for light in (0, 255))
    panel = Panel(pages, Pose((0.0, 0.0, -1.0)), (0.5, 0.5), seconds=0.2)
    scene, view = attrs.evolve(load_scene("planes"), panels=[panel]), View(Pose((0.0, 0.0, 0.5)), FOV)
    (same, again, other), _ = bounds(gpu, scene, view, *((view, ms * 10**6) for ms in (199, 401, 201)))
    assert same < NOTHING and again < NOTHING and other == math.inf


def test_light_counts_where_it_moves():
    """A spot's place stays, and what it lights does not; light that is stopped stays."""
    scene, sun = load_scene("lantern"), load_scene("sunroom")
    spot = attrs.evolve(scene.lamps[0], motion=Spinning(scene.viewpoint, (1, 0, 0), 1e-3), cone=(0.3, 0.5))
    lamps = [attrs.evolve(scene, lamps=[lamp]) for lamp in (spot, attrs.evolve(spot, cone=None))]
    found = [Changes(each) for each in (*lamps, attrs.evolve(sun, light_ns=0), sun)]
    assert [changes.state_at(0)[-2:] == changes.state_at(10**9)[-2:] for changes in found] == [False, True, True, False]


@pytest.mark.parametrize("origin", [(3.0, 0.0, -2.0), (0.0, -1.0, 0.0)])
def test_another_origin_of_the_scene_changes_nothing(gpu, origin):
    """Bodies, lamps, shadows, light between surfaces and what deforms stay where they are."""
    scene, time_ns = moving_room(), 300_000_000

    def from_there(mesh):
        if mesh.body:
            return mesh
        waves = mesh.deformation and attrs.evolve(mesh.deformation, rest=mesh.deformation.rest - origin)
        return attrs.evolve(mesh, positions=mesh.positions - np.array(origin, np.float32), deformation=waves)

    other = attrs.evolve(scene, meshes=map(from_there, scene.meshes), origin_m=origin)
    view, shown = View(Pose((0, 1.6, 1.2)), FOV), []
    for each in (scene, other):
        with closing(Server(gpu, each)) as server:
            picture = server.draw(view, SIZE, time_ns=time_ns)
            shown.append([download(one).astype(float) for one in (picture.colour, picture.inverse_depth)])
    # Positions are float32, so that an edge may fall into the next pixel; halves are 2^-10 apart.
    for one, there in zip(*shown, strict=True):
        assert (np.abs(one - there) > 4e-3).mean() < 5e-3


# --- whole runs ---


def test_a_still_head_sends_once_and_sees_the_same(tmp_path):
    options = {"trace": trace_of(tmp_path / "still.txt"), "latency_ms": 50.0, "seconds": 1.0}
    all_, changes = (
        run(tmp_path / name, network=LinkOptions(send=name), **options).summary for name in ("all", "changes")
    )
    frames = changes["link"]["frames"]
    assert (frames["drawn"], frames["shown"], frames["unchanged"]) == (1, 1, 62)
    assert changes["quality"] == all_["quality"]
    assert changes["link"]["mbit_s"] == pytest.approx(all_["link"]["mbit_s"] / 63)
    # It asks as often, whatever it gets.
    assert changes["link"]["up_mbit_s"] == all_["link"]["up_mbit_s"] > 0
    assert float(rows_of(tmp_path / "changes")[-1]["age_ms"]) == pytest.approx(50 + 59 * 1000 / 60, abs=0.01)


@pytest.mark.parametrize(
    ("yaw_rad_s", "scene", "least", "most"),
    [
        # flat-90 at 96x80: half a pixel is 0.5 / 96 rad in a corner along x, 3 refreshes of this.
        (0.1, "planes", 11, 39),
        (1.0, "planes", 63, 63),
        # One frame of 54 was sent while a patch of sun crossed the floor.
        (0.0, "sunroom", 63, 63),
        (0.0, "room", 1, 1),
    ],
)
def test_frames_are_sent_when_half_a_pixel_has_passed_or_light_has_moved(tmp_path, yaw_rad_s, scene, least, most):
    options = {"trace": trace_of(tmp_path / "head.txt", yaw_rad_s), "scene": scene, "latency_ms": 50.0, "seconds": 1.0}
    frames = run(tmp_path / "out", network=CHANGES, **options).summary["link"]["frames"]
    assert least <= frames["drawn"] <= most and frames["drawn"] + frames["unchanged"] == 63


def test_a_camera_at_rest_before_what_moves_sends_each_of_its_frames(tmp_path):
    """Recorded frames have no scene, and their head stands where the camera does."""
    frames = [attrs.evolve(frame, pose=Pose((0, 1.6, 0))) for frame in taken(6)]
    (tmp_path / "recorded").mkdir()
    write_npz(tmp_path / "recorded", frames)
    options = {"trace": "", "frames": str(tmp_path / "recorded"), "latency_ms": 50.0, "size": None}
    found = run(tmp_path / "out", network=CHANGES, **options).summary["link"]["frames"]
    assert found["drawn"] >= 5


def test_a_lost_frame_is_sent_again_when_the_server_hears_of_it(tmp_path):
    network = LinkOptions(send="changes", loss=GilbertElliott(1, 0.5, 1, 0.9), seed=1)
    options = {"trace": trace_of(tmp_path / "still.txt", seconds=8.0), "latency_ms": 50.0, "seconds": 4.0}
    frames = run(tmp_path / "out", network=network, **options).summary["link"]["frames"]
    assert frames["lost"] >= 1 and frames["shown"] == 1
    assert frames["drawn"] == frames["lost"] + 1, "each loss is answered once, and what has arrived by none"
