"""Every command and every line of Python in README.md runs, in the order of the page."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import needs
import pytest
from display.virtual_screen import VirtualScreen

ROOT = Path(__file__).resolve().parents[1]
BLOCKS = re.findall(r"```(sh|shell|python)\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
LIVE = [line for kind, text in BLOCKS if kind == "shell" for line in text.strip().splitlines()]
COMMANDS = [line for kind, text in BLOCKS if kind == "sh" for line in text.strip().splitlines()]


def run(command: list[str], folder: Path) -> None:
    """As a user would, with the console script first in PATH."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"


@pytest.mark.slow
def test_the_page_runs_from_top_to_bottom(tmp_path):
    for kind, text in BLOCKS:
        if kind == "python":
            run([sys.executable, "-c", text], tmp_path)
        elif kind == "shell":  # live: needs a screen, and somebody to end it
            continue
        elif not text.startswith("make "):
            run(["sh", "-ec", text], tmp_path)
    assert (tmp_path / "out/walk/report.html").is_file()
    assert (tmp_path / "out/turn/replay.mp4").stat().st_size > 10_000
    assert (tmp_path / "out/bench/bench.json").is_file()
    assert (tmp_path / "out/auto/report.html").is_file()
    assert (tmp_path / "mine.csv").is_file()
    assert (tmp_path / "out/tables/ratings.csv").is_file()
    assert (tmp_path / "out/thesis/report.html").is_file()
    assert (tmp_path / "warped.png").is_file()


@pytest.mark.slow
@needs.programs("Xvfb")
@pytest.mark.parametrize("command", LIVE)
def test_the_live_commands_open_a_window(command, tmp_path):
    small = " --frames 3 --size 96x120 --scene planes"  # of an option given twice the last counts
    kept = tmp_path / "screen"
    kept.mkdir()
    with VirtualScreen(kept) as screen:
        run(["env", f"DISPLAY={screen.display}", "sh", "-ec", command + small], tmp_path)


def test_there_are_the_two_commands_and_fourteen_examples():
    assert [c for c in COMMANDS if c.startswith("make ")] == ["make replay", "make test"]
    assert sum(c.startswith("hmdwarp ") and "warp frame.npz" not in c for c in COMMANDS) == 14
    assert len(LIVE) == 3


@pytest.mark.slow
def test_make_replay_does_the_main_job(tmp_path):
    # All of the recording takes minutes; a third of a second of it takes the same way.
    run(
        ["make", "-C", str(ROOT), "replay", "SECONDS=0.3", f"OUT={tmp_path / 'out'}", "OPTIONS=--size 160x200"],
        tmp_path,
    )
    assert (tmp_path / "out/report.html").is_file()


def test_make_test_is_what_ci_runs():
    told = subprocess.run(["make", "-n", "-C", str(ROOT), "test"], capture_output=True, text=True, check=True).stdout
    assert "-m pytest" in told
    assert "make --no-print-directory test" in (ROOT / ".ci/run").read_text(encoding="utf-8")


def test_every_picture_and_page_it_points_to_is_there():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (ROOT / target).is_file(), target
