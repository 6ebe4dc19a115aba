"""Signals in mid-replay and mid-recording: one line, and what was recorded is whole."""

from __future__ import annotations

import os
import signal
import subprocess
import time

import numpy as np
import pytest
from display.virtual_screen import VirtualScreen, needs_a_screen

from hmdwarp.poses import load_trace, synthesise

from .conftest import PROGRAM, ROOT, complaints

TIMEOUT_S = 90  # so that a replay that never starts fails instead of hanging


def wait_for(condition) -> None:
    end = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


@pytest.fixture
def replaying(tmp_path):
    """A replay of 24 s with video, that has begun to write."""
    out = tmp_path / "out"
    (out / "images").mkdir(parents=True)
    (out / "summary.json").write_text('{"hmdwarp": "0"}', encoding="utf-8")
    options = [
        "--scene", "planes", "--size", "64x48", "--metrics-every", "1", "--workers", "2", "--against", "none",
        "--video", "--out", str(out),
    ]  # fmt: skip
    process = subprocess.Popen(
        [*PROGRAM, "replay", "walk", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, start_new_session=True,
    )  # fmt: skip
    try:
        wait_for(lambda: list(out.glob(".partial-*/*replay.mp4*")) or process.poll() is not None)
        assert process.poll() is None, process.communicate()
        yield process, out
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ("kill", "number", "status", "told"),
    [
        (os.kill, signal.SIGINT, 130, "interrupted"),
        (os.killpg, signal.SIGINT, 130, "interrupted"),  # its whole group, as the terminal does
        (os.kill, signal.SIGTERM, 143, "ended by SIGTERM"),
        (os.killpg, signal.SIGHUP, 129, "ended by SIGHUP"),
    ],
)
def test_a_signal_leaves_nothing_behind(kill, number, status, told, replaying):
    process, out = replaying
    kill(process.pid, number)
    printed, complaint = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == status
    assert printed == ""
    assert complaints(complaint) == [f"hmdwarp: {told}; nothing unfinished was left behind"]
    assert sorted(p.relative_to(out).as_posix() for p in out.rglob("*")) == ["images", "summary.json"]
    assert (out / "summary.json").read_text(encoding="utf-8") == '{"hmdwarp": "0"}'


def test_killed_at_once_leaves_no_final_names(replaying):
    """SIGKILL cannot be answered: only hidden files are left."""
    process, out = replaying
    process.kill()
    process.communicate(timeout=TIMEOUT_S)
    assert sorted(p.name for p in out.iterdir() if not p.name.startswith(".partial-")) == ["images", "summary.json"]


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_a_signal_whose_exception_was_lost_comes_again(name):
    """Python drops what a handler raises while a destructor runs; the run must end all the same."""
    code = f"""
import os, signal, time
from hmdwarp.cli import _signals
class Thing:
    def __del__(self):
        os.kill(os.getpid(), signal.{name})
        for _ in range(100): pass
_signals.end_cleanly()
Thing()
try:
    while True: time.sleep(0.01)
except (_signals.Ended, KeyboardInterrupt) as error:
    print("ended by", *error.args)
"""
    done = subprocess.run(
        [PROGRAM[0], "-c", code], capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    number = f" {int(signal.SIGTERM)}" if name == "SIGTERM" else ""
    assert (done.stdout, done.stderr) == (f"ended by{number}\n", "")


def program(*arguments: object, **environment: str) -> subprocess.Popen:
    settings = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    command = [*PROGRAM, "record", *map(str, arguments)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=settings, start_new_session=True
    )


def until_rows(path, count: int, process: subprocess.Popen) -> None:
    wait_for(lambda: path.is_file() and path.read_text().count("\n") >= 6 + count or process.poll() is not None)
    assert process.poll() is None, process.communicate()


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
        _, err = process.communicate(timeout=TIMEOUT_S)
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
            _, err = process.communicate(timeout=TIMEOUT_S)
        finally:
            process.kill()
    assert process.returncode == 0, err
    track = load_trace(out).track
    assert f"{out}: {len(track)} poses" in err
    assert track.origin.startswith("hmdwarp live, display 'window'")
    forward = track.position_m[0, 2] - track.position_m[-1, 2]
    assert forward > 0.05  # -z is forward
