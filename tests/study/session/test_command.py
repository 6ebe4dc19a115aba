"""hmdwarp study run as a program: exit statuses, what is printed where, and signals."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest
from commands import hmdwarp

from .. import tiny
from .sessions import contents

PATIENCE_S = 600
REHEARSAL = ("--source", "offscreen", "--trace", "walk", "--pilot", "--console", "lines")


@contextmanager
def begun(path: Path):
    """The program, which is ended in any case, and a function that types a line."""
    command = [sys.executable, "-m", "hmdwarp", "study", "run", str(path), "--participant", "P1", *REHEARSAL]
    pipe = subprocess.PIPE
    program = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
    watchdog = threading.Timer(PATIENCE_S, program.kill)
    watchdog.start()
    try:
        yield program, lambda line: (program.stdin.write(f"{line}\n"), program.stdin.flush())
    finally:
        watchdog.cancel()
        program.kill()
        program.communicate()


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_in_mid_trial(path, number, status):
    text = path.read_text(encoding="utf-8").replace('"48x60"', '"24x30"')
    path.write_text(text.replace("seconds = 0.1", "seconds = 3600"), encoding="utf-8")  # nobody sees the end of it
    with begun(path) as (program, types):
        for line in program.stderr:
            if "about to begin: waiting" in line:
                types("continue")
            if "trial 1 of 2: showing" in line:
                break
        while not contents(path, pilot=True).showings and program.poll() is None:
            time.sleep(0.05)
        program.send_signal(number)
        out, err = program.communicate()
    assert program.returncode == status
    name = signal.Signals(number).name
    assert f"participant P1 (pilot), session 1, part main: interrupted: ended by {name}" in out
    command = f"hmdwarp study run {path} --participant P1 --resume --pilot --source offscreen --trace walk"
    assert f"resume with: {command}" in out
    assert "Traceback" not in err
    assert "nothing unfinished" not in err  # something unfinished is there, and is to be gone on with
    stored = contents(path, pilot=True)
    assert stored.sessions[0].status == "interrupted"
    assert [showing.complete for showing in stored.showings] == [False]


def test_a_session_answered_at_the_console_line_by_line(path):
    """By an experimenter who types what the participant says, as each question comes."""
    typed = {"about to begin: waiting": ["continue"], "console: asked: ": ["answer 3,25", "skip"]}
    with begun(path) as (program, types):
        for line in program.stderr:
            for what, lines in typed.items():
                if what in line:
                    types(lines.pop(0))
        out = program.stdout.read()
        assert program.wait(PATIENCE_S) == 0
    assert out.startswith("participant P1 (pilot), session 1, part main: complete\n")
    assert "2 answers, 1 of them about trials" in out
    given = [(answer.value, answer.by) for answer in contents(path, pilot=True).answers]
    assert given == [(3.25, "experimenter"), (None, "experimenter")]


def test_a_quiet_session_prints_nothing(tmp_path):
    done = hmdwarp(*tiny.session(*tiny.write(tmp_path), "P1", "--quiet"))
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_without_a_runtime_a_window_is_named(path):
    """Options that contradict each other are refused in golden/ratings."""
    done = hmdwarp("study", "run", path, "--participant", "P1", "--source", "openxr")
    assert done.returncode == 3 and "or take a window: --source desktop" in done.stderr
    assert not path.with_name("small-data").exists()
