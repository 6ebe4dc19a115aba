"""hmdwarp replay --frames: a folder of recorded frames on the command line."""

from __future__ import annotations

from recorded_folders import taken, write_npz


def test_the_command_replays_a_folder(command, tmp_path):
    folder = tmp_path / "taken"
    folder.mkdir()
    write_npz(folder, taken(6))
    said = ("--latency", 100, "--metrics-every", 3, "--workers", 0, "--images", 0, "--out", tmp_path / "out")
    done = command("replay", "--frames", folder, *said).done()
    assert "One eye is shown" in done.out and "PSNR" in done.out
    command("replay", "--out", tmp_path / "other").refused("no TRACE")
    command("replay", "--frames", tmp_path / "nowhere", "--out", tmp_path / "other").refused("no such file or folder")
