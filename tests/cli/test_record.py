"""hmdwarp record as its users run it.

Synthetic motion, a window, and what it says where it cannot.
"""

from __future__ import annotations

import os
import signal
import subprocess
import time

import numpy as np
import pytest
from display.virtual_screen import VirtualScreen, needs_a_screen

from hmdwarp.poses import load_trace, synthesise

from .conftest import PROGRAM, ROOT

LONG_S = 90.0  # against hanging


def program(*arguments: object, **environment: str) -> subprocess.Popen:
    settings = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    command = [*PROGRAM, "record", *map(str, arguments)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=settings, start_new_session=True
    )


def until_rows(path, count: int, process: subprocess.Popen) -> None:
    end = time.monotonic() + LONG_S
    while not path.is_file() or path.read_text().count("\n") < 6 + count:
        assert process.poll() is None and time.monotonic() < end, process.communicate()
        time.sleep(0.05)


def test_a_made_up_head_takes_its_time_and_is_what_synth_makes(tmp_path, command):
    out = tmp_path / "walk.csv"
    began = time.monotonic()
    done = command(
        "record", "--source", "synthetic", "--kind", "walk", "--seconds", "0.5", "--rate", "60", "--out", out
    )
    assert time.monotonic() - began >= 0.5
    assert done.status == 0 and done.out == ""
    assert (
        done.err
        == f"recording synthetic motion 'walk' to {out} (0.5 s, Ctrl-C ends sooner)\n{out}: 31 poses, 0.500 s\n"
    )
    track, meant = load_trace(out).track, synthesise("walk", seconds=0.5, rate_hz=60)
    assert (track.time_ns == meant.time_ns).all() and (track.position_m == meant.position_m).all()
    # The writer has sign and length as they came; both are unit to the last bits.
    assert np.abs(track.orientation_xyzw - meant.orientation_xyzw).max() < 1e-15
    assert track.origin == "hmdwarp record, synthetic motion 'walk'"


@pytest.mark.parametrize("number, status", [(signal.SIGINT, 0), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_ends_it_with_everything_written(tmp_path, number, status):
    process = program("--source", "synthetic", "--out", tmp_path / "a.csv")
    try:
        until_rows(tmp_path / "a.csv", 20, process)
        process.send_signal(number)
        _, err = process.communicate(timeout=LONG_S)
    finally:
        process.kill()
    assert process.returncode == status
    track = load_trace(tmp_path / "a.csv").track
    assert f"{tmp_path / 'a.csv'}: {len(track)} poses, {track.duration_ns * 1e-9:.3f} s\n" in err
    assert len(track) < 30 * 90  # synthetic motion would have gone on for 30 s


@needs_a_screen
def test_a_window_records_who_moves_in_it(tmp_path):
    out = tmp_path / "walk.csv"
    with VirtualScreen(tmp_path, (640, 480)) as screen:
        process = program("--source", "desktop", "--scene", "planes", "--out", out, **screen.environment)
        try:
            until_rows(out, 10, process)
            screen.do("mousemove", 320, 240, "click", 1)
            screen.do("keydown", "w")
            rows = out.read_text().count("\n")
            until_rows(out, rows + 20, process)
            screen.do("keyup", "w")
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=LONG_S)
        finally:
            process.kill()
    assert process.returncode == 0, err
    track = load_trace(out).track
    assert f"{out}: {len(track)} poses" in err
    assert track.origin.startswith("hmdwarp live, window '")
    forward = track.position_m[0, 2] - track.position_m[-1, 2]
    assert forward > 0.05  # -z is forward
