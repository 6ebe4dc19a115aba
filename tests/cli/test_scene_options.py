"""Options of scene files are there wherever --scene is, reach the picture, and notes are told."""

from __future__ import annotations

import json

import pytest
from scenes.glb import boxes, cube

from hmdwarp.options import PICTURE, options_of
from hmdwarp.scenes import SceneOptions
from hmdwarp.study.design import KINDS
from hmdwarp.study.design.definitions import check_settings

NAMES = {"scene_scale", "scene_up", "viewpoint", "animation"}
TINY = ("--headset", "rift-dk1", "--size", "40x50", "--lens", "none", "--effects", "none")


@pytest.fixture
def scene(tmp_path):
    """A room whose middle is at (104, 51.5, 203)."""
    path = tmp_path / "far.glb"
    path.write_bytes(boxes(cube((100, 50, 200), (108, 53, 206), inwards=True)).data())
    return path


def test_a_study_may_set_them(scene):
    assert set(KINDS) >= NAMES and {option.study for option in options_of(SceneOptions)} == {PICTURE}
    settings = {
        "scene": str(scene), "viewpoint": "102,51.6,203,90", "scene_scale": 1, "animation": "none", "warp": "none",
    }  # fmt: skip
    scenes: dict = {}
    options = check_settings(settings, scenes)
    assert options.scene_options == SceneOptions(viewpoint="102,51.6,203,90", animation="none")
    check_settings(settings | {"viewpoint": "103,51.6,203"}, scenes)
    assert len(scenes) == 2  # one for each way to see the file


def test_plan_tells_what_was_noticed(command, scene):
    done = command("plan", "--scene", scene, "--warp", "none", "--fill", "none").done()
    assert "note: far.glb: seen from 104,51.6,203 of the file, which is at (0, 1.6, 0)" in " ".join(done.out.split())
    done = command("plan", "--scene", scene, "--viewpoint", "102,51.6,203", "--warp", "none", "--fill", "none").done()
    assert "note:" not in done.out


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (("--viewpoint", "door"), "viewpoint 'door': the file has no cameras; expected X,Y,Z[,YAW]"),
        (("--viewpoint", "1,2"), "viewpoint '1,2': expected X,Y,Z or X,Y,Z,YAW"),
        (("--animation", "run"), "animation 'run': the file has no animations; expected none"),
        (("--scene-up", "x"), "up 'x': expected y or z"),
        (("--scene-scale", "0"), "scene-scale 0: expected a number of at least 1e-06"),
    ],
)
def test_an_unknown_name_in_a_file_is_refused_with_the_known_ones(command, scene, said, message):
    failed = command("plan", "--scene", scene, *said)
    assert failed.status == 2
    assert message in " ".join(failed.err.split())


def test_a_replay_shows_what_is_seen_from_there(command, scene, tmp_path):
    def summary(name, *more):
        out = tmp_path / name
        run = (
            "replay", "still", "--scene", scene, "--warp", "none", "--fill", "none", "--seconds",
            "0.02", "--start", "1",
        )  # fmt: skip
        command(*run, *TINY, "--latency", "0", "--against", "", "--images", "1", "--out", out, *more).done()
        pictures = [path.read_bytes() for path in sorted((out / "images").iterdir())]
        return json.loads((out / "summary.json").read_text(encoding="utf-8"))["notes"], pictures

    notes, free = summary("free")
    assert any("seen from 104,51.6,203" in note for note in notes)
    notes, other = summary("other", "--viewpoint", "101,51.6,203,20")
    assert not any("seen from" in note for note in notes) and other != free
