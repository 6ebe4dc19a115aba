"""Options on the command line: guard bands, network, scene files, recorded frames; what is told."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
import trimesh
from recorded_folders import CX, CY, FX, FY, taken, write_numbered, write_tum

from hmdwarp.sources.sequences import FACTS

SMALL = ("--headset", "flat-90", "--latency", "200", "--rate", "30")


def summary(quick: list[str]) -> dict:
    return json.loads((Path(quick[-1]) / "summary.json").read_text())


def test_wide_goes_before_the_other_fills_and_closes_the_border(command, quick):
    """The head has turned away from the rendered picture.

    The wide one holds what has come into sight.
    """
    usual = ("replay", "fast-turns", *quick, *SMALL, "--guard", "1", "--start", "3", "--fill", "none")
    command(*usual).done()
    without = summary(quick)
    command(*usual[:-1], "wide").done()
    found = summary(quick)
    assert found["fill"] == "wide"
    # 150 x 140 degrees, with a quarter of the pixels of a tangent on each axis. Whole pixels are up
    # to one row and column more, 3 % of 90 x 55.
    wide, own = (
        [math.tan(math.radians(angle / 2)) for angle in fov] for fov in ((150, 140), without["rendered"]["fov_deg"])
    )
    assert without["rendered"]["pixels"] == 1
    assert found["rendered"]["pixels"] == pytest.approx(1 + math.prod(wide) / math.prod(own) / 16, rel=0.03)
    assert without["quality"]["border_share"]["mean"] > 0.05, "there is a border to close"
    assert found["filled"]["wide"] > 0.8 * found["quality"]["border_share"]["mean"]
    assert found["quality"]["psnr_db"]["mean"] > without["quality"]["psnr_db"]["mean"] + 3


def test_plan_tells_how_many_pixels_and_which_field_of_view_result(command):
    usual = ("plan", "--scene", "planes", "--headset", "flat-90", "--size", "1280x800")
    told = " ".join(command(*usual, "--guard", "1.25x1.125").done().out.split())
    assert "1600x900, 1.41 times the pixels, 102.7 x 96.7 degrees" in told


@pytest.fixture
def scene(tmp_path):
    """A room whose middle is at (104, 51.5, 203)."""
    path = tmp_path / "far.glb"
    room = trimesh.creation.box(bounds=[(100, 50, 200), (108, 53, 206)])
    room.invert()
    room.export(path)
    return path


def test_plan_tells_what_was_noticed(command, scene):
    done = command("plan", "--scene", scene, "--warp", "none", "--fill", "none").done()
    assert "note: far.glb: seen from 104,51.6,203 of the file, which is at (0, 1.6, 0)" in " ".join(done.out.split())
    done = command("plan", "--scene", scene, "--viewpoint", "102,51.6,203", "--warp", "none", "--fill", "none").done()
    assert "note: far.glb" not in done.out
    for option, wrong, message in (
        ("--viewpoint", "door", "viewpoint 'door': the file has no cameras; expected X,Y,Z[,YAW]"),
        ("--viewpoint", "1,2", "viewpoint '1,2': expected X,Y,Z or X,Y,Z,YAW"),
        ("--animation", "run", "animation 'run': the file has no animations; expected none"),
    ):
        command("plan", "--scene", scene, option, wrong).refused(message)


def test_what_is_assumed_of_frames_is_printed_and_kept(command, tmp_path):
    """Another camera in the form of TUM: its numbers are the user's, the layout's are refused."""
    folder = tmp_path / "taken"
    write_tum(folder, taken(6))
    run = ("replay", "--frames", folder, "--latency", 100, "--metrics-every", 5, "--workers", 0, "--images", 0)
    remedy = "--intrinsics FX,FY,CX,CY --depth-scale METRES"
    command(*run, "--out", tmp_path / "out").refused("pictures of 36x24", remedy)
    stated = ("--intrinsics", f"{FX},{FY},{CX},{CY}", "--depth-scale", 0.0002, "--layout", "tum")
    command(*run, *stated, "--out", tmp_path / "out").done()
    kept = {
        assumption["what"]: assumption
        for assumption in json.loads((tmp_path / "out" / "summary.json").read_text())["assumptions"]
    }
    assert kept["intrinsics"] == {
        "what": "intrinsics", "value": "40,42,17.3,11.1 px", "by": "user", "option": "--intrinsics",
    }  # fmt: skip
    assert kept["camera axes"]["by"] == "format" and set(FACTS) <= set(kept)

    write_numbered(tmp_path / "numbered", taken(6))
    run = ("plan", "--frames", tmp_path / "numbered", "--intrinsics", f"{FX},{FY},{CX},{CY}", "--depth-scale", 0.001)
    found = command(*run).done()
    assert "Assumed (not stated in the files)" in found.out and "frame clock 30 frames per second" in " ".join(
        found.out.split()
    )
