"""What --record-to writes for viewers: well-formed messages, in their axes, at the run's times."""

from __future__ import annotations

import base64
import csv
import io
import json
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from replays import run
from scipy.spatial.transform import Rotation

from hmdwarp.errors import InputError, MachineError
from hmdwarp.geometry import Pose
from hmdwarp.gpu import download
from hmdwarp.headsets import load_headset
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

mcap = pytest.importorskip("mcap.reader")

ROS = Rotation.from_matrix([[0, 0, -1], [-1, 0, 0], [0, 1, 0]])  # forward, left, up of OpenXR's axes
CAMERA = Rotation.from_euler("x", 180, degrees=True)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> tuple[Path, Any]:
    folder = tmp_path_factory.mktemp("viewer")
    path = folder / "run.mcap"
    options = {
        "headset": "index",
        "latency_ms": 300.0,
        "metrics_every": 3,
        "start_s": 2.0,
        "seconds": 0.2,
        "trace": "walk",
    }
    return path, run(folder / "out", fill="pyramid", record_to=path, **options)


@pytest.fixture(scope="module")
def messages(recorded) -> dict[str, list[tuple[int, Any]]]:
    """(log time, message) of each topic."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with recorded[0].open("rb") as stream:
        for schema, channel, message in mcap.make_reader(stream).iter_messages():
            content = json.loads(message.data)
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
            assert set(content) <= set(json.loads(schema.data)["properties"]) or schema.name == "hmdwarp.Figures"
            found.setdefault(channel.topic, []).append((message.log_time, content))
    return found


def left_rows(recorded) -> list[dict[str, str]]:
    with (recorded[0].parent / "out/frames.csv").open() as stream:
        return [row for row in csv.DictReader(stream) if row["eye"] == "0"]


def place(row: dict[str, str], kind: str = "shown") -> list[float]:
    return [float(row[f"{kind}_{axis}_m"]) for axis in "xyz"]


def picture(message: dict[str, Any]) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(message["data"]))))


def test_each_refresh_has_its_head_views_and_figures(recorded, messages):
    _, result = recorded
    for eye, name in enumerate(("left", "right")):
        rows = [row for row in result.rows if row["eye"] == eye]
        told = messages[f"/{name}/figures"]
        assert [content["age_ms"] for _, content in told] == [row["age_ms"] for row in rows]
        assert {at for at, _ in told} == {at for at, _ in messages["/tf"]} == {at for at, _ in messages["/head"]}


def test_views_stand_where_the_eyes_were_in_the_axes_of_ros_and_of_cameras(recorded, messages):
    """By quaternions, where the program multiplies matrices; both round at 1e-16."""
    headset = load_headset("index")
    for row, (_, content) in zip(left_rows(recorded), messages["/tf"], strict=True):
        placed = {one["child_frame_id"]: one for one in content["transforms"]}
        assert set(placed) == {"head", "left/shown", "right/shown", "left/late", "right/late"}
        for kind in ("shown", "drawn"):
            head = Pose(place(row, kind), [float(row[f"{kind}_q{axis}"]) for axis in "xyzw"])
            for view, eye in zip(headset.views(head), ("left", "right"), strict=True):
                one = placed[f"{eye}/{'shown' if kind == 'shown' else 'late'}"]
                assert list(one["translation"].values()) == pytest.approx(
                    ROS.apply(view.pose.position_m.copy()), abs=1e-12
                )
                turned = ROS * Rotation.from_quat(view.pose.orientation_xyzw) * CAMERA
                apart = turned.inv() * Rotation.from_quat(list(one["rotation"].values()))
                assert apart.magnitude() < 1e-7  # the angle from a cosine, whose error is 1e-16


def test_a_camera_sees_along_the_tangents_of_its_view(messages):
    fov = load_headset("index").views(Pose())[0].fov
    _, camera = messages["/left/shown/camera"][0]
    k = np.reshape(camera["K"], (3, 3))
    left, right, down, up = fov.tangents
    last = camera["width"] - 0.5, camera["height"] - 0.5
    for pixel, tangent in (((-0.5, -0.5), (left, up)), (last, (right, down))):
        x, y, z = np.linalg.solve(k, [*pixel, 1.0])
        assert (x / z, -y / z) == pytest.approx(tangent, abs=1e-12)


def test_pictures_are_those_that_were_measured(recorded, messages):
    """Their PSNR is the row's, and what is white is its hole share."""
    _, result = recorded
    rows = {row["shown_ns"]: row for row in result.rows if row["eye"] == 1 and row.get("psnr_db") is not None}
    images = {name: messages[f"/right/{name}/image"] for name in ("shown", "truth", "holes")}
    assert len(rows) == len(images["shown"]) > 1
    empty = 0.0
    for row, (_, shown), (_, truth), (_, holes) in zip(rows.values(), *images.values(), strict=True):
        error = (picture(shown).astype(float) - picture(truth)) / 255
        white = picture(holes) == 255
        assert white.shape == error.shape[:2]
        seen = load_headset("index").views(Pose())[1].seen(white.shape[::-1])
        assert -10 * np.log10((error[seen] ** 2).mean()) == pytest.approx(row["psnr_db"], abs=1e-6)
        assert white[seen].mean() == pytest.approx(row["hole_share"], abs=1e-12)
        empty += white.mean()
    assert empty > 0


def test_the_late_depth_is_that_of_the_frame_the_right_way_up(recorded, messages, gpu):
    """Drawn again for the pose of the row, once for each frame. One over it rounds twice."""
    depths, rows = messages["/left/late/depth"], {int(row["shown_ns"]): row for row in left_rows(recorded)}
    at, content = depths[0]
    row = rows[at]
    head = Pose(place(row, "drawn"), [float(row[f"drawn_q{axis}"]) for axis in "xyzw"])
    with closing(Server(gpu, load_scene("planes"))) as server:
        eye = server.draw(load_headset("index").views(head)[0], (content["width"], content["height"]))
        inverse = download(eye.inverse_depth)
    found = np.frombuffer(base64.b64decode(content["data"]), "<f4").reshape(inverse.shape)
    assert np.array_equal(np.isnan(found), inverse < 0)
    assert np.allclose(1 / found[inverse > 0], inverse[inverse > 0], rtol=2**-22, atol=0)
    assert 1 <= len(depths) <= len(messages["/left/shown/image"])
    for _, content in depths:
        depth = np.frombuffer(base64.b64decode(content["data"]), "<f4").reshape(content["height"], content["width"])
        assert content["encoding"] == "32FC1" and content["step"] == 4 * content["width"]
        assert np.nanmin(depth) > 0.1  # nothing of the room is nearer


def test_the_file_is_a_head_trace(recorded):
    track = load_trace(recorded[0]).track
    assert track.position_m == pytest.approx(np.array([place(row) for row in left_rows(recorded)]))


@pytest.mark.parametrize(("name", "words"), [("run.rrd", "ends in .mcap"), ("there.mcap", "exists already")])
def test_another_kind_of_file_or_one_that_is_there_is_refused(tmp_path, name, words):
    path = tmp_path / name
    path.write_bytes(b"mine")
    with pytest.raises(InputError, match=words):
        run(tmp_path / "out", record_to=path)
    assert path.read_bytes() == b"mine"


def test_without_the_package_the_line_that_installs_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "mcap.writer", None)
    with pytest.raises(MachineError, match=r"mcap"):
        run(tmp_path / "out", record_to=tmp_path / "a.mcap")
    assert not (tmp_path / "a.mcap").exists()
