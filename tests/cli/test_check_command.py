"""hmdwarp check and hmdwarp headset."""

from __future__ import annotations

import json
from pathlib import Path

import attrs
import numpy as np
import pytest
from depth_camera import DepthCamera
from headsets.test_lens_models import hmdq_json, vive_json
from PIL import Image
from wrong_frames import MISREADINGS, Recording, hand_held, right_frames

from hmdwarp.check import StatedFrame
from hmdwarp.headsets import load_headset
from hmdwarp.scenes import scenes
from hmdwarp.sources.server import Server

CAMERA = DepthCamera(noise=0.001, near_m=0.2, far_m=8.0, edge_gaps=0.3)


@pytest.fixture(scope="module")
def recording(gpu) -> Recording:
    server = Server(gpu, scenes.get("room").build())
    made = Recording.of(server, hand_held(np.random.default_rng(2)), CAMERA)
    server.close()
    return made


def write(folder: Path, frames: list[StatedFrame]) -> Path:
    folder.mkdir(exist_ok=True)
    for number, one in enumerate(frames):
        fov, pose = one.view.fov, one.view.pose
        np.savez(
            folder / f"{number:03}.npz", colour=one.colour, depth_m=one.depth,
            fov=(fov.left, fov.right, fov.down, fov.up), position_m=pose.position_m,
            orientation_xyzw=pose.orientation_xyzw, time_ns=one.time_ns,
        )  # fmt: skip
    return folder


def test_a_folder_read_wrong_is_named_with_the_line_that_mends_it(command, recording, tmp_path):
    rng = np.random.default_rng(3)
    frames = MISREADINGS["world to eye"][0](right_frames(recording, CAMERA, rng), rng)
    done = command("check", write(tmp_path / "frames", frames)).done()
    assert done.out.startswith("wrong: pose.")
    assert "pose = pose.inverse()" in done.out and "cannot be told" in done.out
    data = json.loads(command("check", tmp_path / "frames", "--json").done().out)
    assert data["verdict"] == "wrong" and data["agreement"] > 0.8 > data["agreement_stated"]
    assert [convention["name"] for convention in data["conventions"] if not convention["as_stated"]] == ["direction"]


def test_two_folders_are_two_eyes(command, recording, tmp_path):
    frames = right_frames(recording, CAMERA, np.random.default_rng(4), stereo=True)
    left, right = (write(tmp_path / name, frames[eye::2]) for eye, name in enumerate(("left", "right")))
    assert "as named" in command("check", left, right).done().out
    wrong = MISREADINGS["eyes swapped"][0](frames, np.random.default_rng(4))
    left, right = (write(tmp_path / name, wrong[eye::2]) for eye, name in enumerate(("wrong-left", "wrong-right")))
    swapped = command("check", left, right).done().out
    assert swapped.startswith("wrong: eyes.") and "left, right = right, left" in swapped


def test_frames_that_cannot_be_checked_are_refused(command, recording, tmp_path):
    frames = right_frames(recording, CAMERA, np.random.default_rng(5), stereo=True)
    left, right = write(tmp_path / "left", frames[::2]), write(tmp_path / "right", frames[1:8:2])
    command("check", left, right).refused("12 frames", "4: expected one of each eye")
    command("check", left, right, left).refused("expected a folder, or two")
    command("check", write(tmp_path / "one", frames[:1])).refused("two or more")
    command("check", tmp_path / "none").refused("none", "no such file or folder")


@pytest.mark.parametrize("name", ["index", "rift-dk1", "vive.json"])
def test_a_picture_of_a_headset(command, tmp_path, name):
    if name.endswith("json"):
        name = str(tmp_path / name)
        (tmp_path / "vive.json").write_text(json.dumps(vive_json()))
    out = tmp_path / "shown.png"
    command("headset", "show", name, "--out", out).done()
    picture = np.asarray(Image.open(out).convert("RGB"))
    # White paper, the left eye's blue and the right eye's orange.
    for colour in ((255, 255, 255), (11, 99, 197), (194, 65, 12)):
        assert (np.abs(picture.astype(int) - colour).max(axis=-1) < 8).sum() > 100
    command("headset", "show", name, "--out", out).refused("exists already")
    command("headset", "show", name, "--out", tmp_path / "shown.jpg").refused("expected a .png file")


def test_an_export_becomes_a_file_of_the_same_eyes(command, tmp_path):
    (tmp_path / "mine.json").write_text(json.dumps(hmdq_json()))
    command("headset", "from-hmdq", tmp_path / "mine.json", "--out", tmp_path / "mine.toml").done()
    before, after = (load_headset(str(tmp_path / f"mine.{kind}")) for kind in ("json", "toml"))
    for one, other in zip(before.eyes, after.eyes, strict=True):
        assert other.head_from_eye.isclose(one.head_from_eye, 1e-12)
        assert other.fov.tangents == pytest.approx(one.fov.tangents) and other.hidden == one.hidden
    assert attrs.evolve(after, eyes=before.eyes) == before
    command("headset", "from-hmdq", tmp_path / "mine.json", "--out", tmp_path / "mine.txt").refused("a .toml file")
    listed = [
        json.loads(command("list", "headsets", tmp_path / f"mine.{kind}", "--json").done().out)
        for kind in ("json", "toml")
    ]
    assert listed[0] == listed[1] and listed[0][0]["eye_size"] == "x".join(map(str, before.eye_size_px))
    command("list", "headsets", "no.toml").refused("no.toml")
