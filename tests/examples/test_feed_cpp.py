"""examples/feed_cpp, a renderer in C++ written from docs/feed.md: what it draws is right here."""

from __future__ import annotations

import subprocess
from contextlib import contextmanager
from pathlib import Path

import attrs
import needs
import numpy as np
import pytest
from replays import each_refresh, run, small

from hmdwarp import Fov, Pose, View, warp_image
from hmdwarp.base import InputError, picture_from_linear, srgb8_from_linear
from hmdwarp.gpu import download
from hmdwarp.run import replay
from hmdwarp.sources.feed import FeedOptions
from hmdwarp.sources.feed.caller import Viewer

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

SOURCE = Path(__file__).resolve().parents[2] / "examples" / "feed_cpp" / "renderer.cpp"
CENTRE, RADIUS, SUN = np.array([0, 1.4, -2]), 0.5, np.array([0.48, 0.8, 0.36])
SKY = np.array([0.25, 0.45, 0.75])
SIZE = (96, 80)
# Rounding may take a pixel that an edge crosses to its other side, in C++ or here: one in a
# thousand is far more than lie within 1e-9 of an edge.
ON_AN_EDGE = 1e-3

pytestmark = [
    needs.programs("g++"),
    pytest.mark.skipif(
        not Path("/usr/include/zmq.h").exists(),
        reason=needs.missing("libzmq", needs.APT + needs.TOOLS["packages"]["libzmq"]),
    ),
]


@pytest.fixture(scope="module")
def renderer(tmp_path_factory):
    """The renderer, built as its first lines say."""
    built = tmp_path_factory.mktemp("renderer") / "renderer"
    command = ["g++", "-O2", "-std=c++17", "-Wall", "-Wextra", "-Werror", SOURCE, "-lzmq", "-o", built]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return built


@contextmanager
def listening(renderer, *words: str):
    """It, in a process of its own: its address."""
    with subprocess.Popen([renderer, "tcp://127.0.0.1:*", *words], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        yield process.stderr.readline().split()[-1].rstrip("\0")
        assert process.poll() is None, "it ended by itself"
        process.terminate()


@pytest.fixture(scope="module")
def address(renderer):
    with listening(renderer) as found:
        yield found


def analytic(view: View, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return sRGB bytes (h, w, 3) and metres along -z, by projection instead of a quadratic."""
    low_x, high_x, low_y, high_y = np.tan([view.fov.left, view.fov.right, view.fov.down, view.fov.up])
    x = low_x + (high_x - low_x) * (np.arange(size[0]) + 0.5) / size[0]
    y = high_y - (high_y - low_y) * (np.arange(size[1]) + 0.5) / size[1]
    rays = np.stack([*np.meshgrid(x, y), np.full(size[::-1], -1.0)], axis=-1)
    lengths = np.linalg.norm(rays, axis=-1)
    ways = view.pose.rotation.apply((rays / lengths[..., None]).reshape(-1, 3)).reshape(rays.shape)
    eye = view.pose.position_m
    light, reach = np.broadcast_to(SKY, rays.shape).copy(), np.full(size[::-1], np.inf)
    below = ways[..., 1] < 0
    reach[below] = eye[1] / -ways[below][:, 1]
    at = (eye + reach[below][:, None] * ways[below])[:, [0, 2]]
    odd = np.floor(at).astype(int).sum(axis=1) % 2
    haze = (64 / (64 + reach[below] ** 2))[:, None]
    light[below] = haze * np.where(odd, 0.15, 0.6)[:, None] + (1 - haze) * SKY
    along = ways @ (CENTRE - eye)
    beside = ((CENTRE - eye) ** 2).sum() - along**2
    near = along - np.sqrt(np.maximum(RADIUS**2 - beside, 0))
    ball = (beside <= RADIUS**2) & (near > 0) & (near < reach)
    reach[ball] = near[ball]
    normal = (eye + near[ball][:, None] * ways[ball] - CENTRE) / RADIUS
    light[ball] = (0.1 + 0.8 * np.maximum(normal @ SUN, 0))[:, None] * [1, 0.3, 0.2]
    return srgb8_from_linear(light), reach / lengths


def view_at(position=(0.1, 1.6, 0.3), turn=(0.05, -0.1, 0.02)) -> View:
    x, y, z = turn
    return View(Pose(position, (x, y, z, 1 - (x * x + y * y + z * z) / 2)), Fov(-0.7, 0.8, -0.75, 0.6))


@pytest.fixture
def viewer(address):
    one = Viewer(address)
    yield one
    one.close()


def test_a_frame_is_the_analytic_picture(viewer):
    view = view_at()
    frame = viewer.fetch(view, SIZE, 0)
    colour, depth_m = analytic(frame.views[0], SIZE)
    off = np.abs(frame.colours[0][..., :3].astype(int) - colour).max(axis=2)
    # A tie between two bytes may be rounded either way.
    assert (off > 1).mean() <= ON_AN_EDGE
    assert (frame.colours[0][..., 3] == 255).all()
    # As float32: within 2^-24 of its value.
    off_depth = np.abs(frame.inverse_depths[0] - 1 / depth_m)
    assert (off_depth > 1e-6 / depth_m).mean() <= ON_AN_EDGE


def test_after_motion_the_depth_is_that_of_the_new_place(viewer):
    """Warped where floor and sphere are seen from both places, it is what a ray there meets."""
    frame = viewer.fetch(view_at(), (384, 320), 0)
    shown = view_at((0.16, 1.55, 0.2), (0.07, -0.06, 0.01))
    with np.errstate(divide="ignore"):
        depth_m = 1 / frame.inverse_depths[0].astype(np.float64)
    warped = warp_image(
        frame.colours[0][..., :3], depth_m, frame.views[0], shown, warp="iterative", fill="none", depth=True
    )
    _, truth_m = analytic(shown, (384, 320))
    seen = (warped.coverage > 0) & (truth_m < 6)
    assert seen.mean() > 0.3
    off = np.abs(1 / warped.depth_m[seen] - 1 / truth_m[seen]) * truth_m[seen]
    # The floor is exact, as inverse depth is linear across a plane; the sphere is not linear within
    # a pixel: (pixel of 4e-3 rad * 2 m)^2 / (8 * 0.5 m) is 1e-5 m. Silhouettes are crossed.
    assert np.quantile(off, 0.95) < 1e-4
    assert np.median(np.abs(depth_m[seen] / truth_m[seen] - 1)) > 0.02, "the depth of the old place is another"


def test_a_still_head_sees_the_analytic_picture(address, tmp_path):
    trace = tmp_path / "still.csv"
    rows = "".join(f"{n * 10_000_000},0.1,1.6,0.3,0.05,-0.1,0,0.9937303457\n" for n in range(40))
    trace.write_text("# origin: at rest\ntime_ns,x_m,y_m,z_m,qx,qy,qz,qw\n" + rows)
    options = small(
        "nowhere", trace=str(trace), scene="server", feed=FeedOptions(connect=address), warp="iterative", seconds=0.1
    )
    found = []
    each_refresh(
        options,
        lambda setup, number, refresh: found.append([(e.view, download(e.shown.texture)) for e in refresh.eyes]),
    )
    assert found
    for view, light in found[-1]:
        colour, _ = analytic(view, SIZE)
        off = np.abs(picture_from_linear(light).astype(int) - colour).max(axis=2)
        # float32 on the GPU samples up to 1e-4 pixels beside the centre: below one step of a byte.
        assert (off > 1).mean() <= ON_AN_EDGE


def test_a_replay_is_measured_against_what_the_server_draws(address, tmp_path):
    summary = run(
        tmp_path / "out", scene="server", feed=FeedOptions(connect=address), warp="iterative", guard=1.5, seconds=0.3
    ).summary
    assert summary["scene"] == "server" and summary["measured"]["psnr_db"] > 0
    assert "The truth is what the server drew for the shown views." in summary["notes"]
    assert not any("delay-trace" in note for note in summary["notes"])
    assert summary["link"]["feed"]["malformed"] == 0


def test_a_sphere_that_swings_is_shown_where_its_velocity_takes_it(renderer, tmp_path):
    """At ten frames a second it goes several pixels from one to the next."""
    with listening(renderer, "swing") as address:
        asked = {"scene": "server", "feed": FeedOptions(connect=address), "warp": "forward", "fill": "pyramid"}
        asked |= {"guard": 1.25, "rate_hz": 10.0, "seconds": 0.8, "metrics_every": 1}
        stays = run(tmp_path / "stays", **asked).summary
        moves = run(tmp_path / "moves", effects="soft_motion", **asked).summary
    assert moves["link"]["feed"]["malformed"] == 0 and moves["link"]["layers_mbit_s"]["velocity"] > 0
    assert moves["quality"]["psnr_db"]["mean"] > stays["quality"]["psnr_db"]["mean"] + 1


def test_the_server_s_scene_needs_a_server():
    with pytest.raises(InputError, match="--connect"):
        replay(attrs.evolve(small("nowhere"), scene="server"))


def test_it_is_under_two_hundred_lines():
    assert SOURCE.read_text(encoding="utf-8").count("\n") < 200
