"""hmdwarp replay --frames: a folder of recorded frames on the command line."""

from __future__ import annotations

import json

from recorded_folders import CX, CY, FX, FY, taken, write_npz, write_numbered, write_tum

from hmdwarp.sources.sequences import FACTS


def test_the_command_replays_a_folder(command, tmp_path):
    folder = tmp_path / "taken"
    folder.mkdir()
    write_npz(folder, taken(6))
    said = ("--latency", 100, "--metrics-every", 3, "--workers", 0, "--images", 0, "--out", tmp_path / "out")
    done = command("replay", "--frames", folder, *said).done()
    assert "One eye is shown" in done.out and "PSNR" in done.out
    command("replay", "--out", tmp_path / "other").refused("no TRACE")
    command("replay", "--frames", tmp_path / "nowhere", "--out", tmp_path / "other").refused("no such file or folder")


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
