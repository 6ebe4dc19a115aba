"""Standard output that is closed, full, or not read to its end; what is printed where."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from hmdwarp.resources import folder

from .conftest import PROGRAM, ROOT, complaints

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
LISTS = [["list", "warps"], ["--help"], ["trace", "info", "still"]]  # a table, click's own, lines
REPLAY = [
    "replay",
    "still",
    "--scene",
    "planes",
    "--headset",
    "rift-dk1",
    "--size",
    "48x40",
    "--seconds",
    "0.1",
    "--workers",
    "0",
    "--out",
]


def ended(*command: str, stdout: object = subprocess.PIPE) -> subprocess.CompletedProcess:
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, check=False)


@pytest.mark.parametrize("arguments", LISTS, ids=" ".join)
def test_a_reader_that_has_gone_is_no_fault(arguments):
    """As `| head -0` does: the pipe is closed before anything is printed."""
    reading, writing = os.pipe()
    os.close(reading)
    done = ended(*PROGRAM, *arguments, stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("arguments", LISTS[:2], ids=" ".join)
def test_a_full_disk_behind_standard_output_is_told(arguments):
    if not os.path.exists("/dev/full"):  # noqa: PTH110 (a device, not a file of ours)
        pytest.skip("no /dev/full here")
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = ended(*PROGRAM, *arguments, stdout=full)
    assert done.returncode == 3
    assert re.fullmatch("hmdwarp: cannot print.*No space left.*\n", done.stderr)


@pytest.mark.parametrize("arguments", [*LISTS, REPLAY], ids=" ".join)
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&- <&-"])
def test_closed_streams(arguments, closed, tmp_path):
    arguments = [*arguments, str(tmp_path / "out")] if arguments == REPLAY else arguments
    done = ended("sh", "-c", f'"$@" {closed}', "sh", *PROGRAM, *arguments)
    assert done.returncode == 0, done
    assert "Traceback" not in done.stderr and "Error" not in done.stderr
    if arguments[0] == "replay":
        assert (tmp_path / "out" / "summary.json").exists()


def test_a_replay_prints_its_table_and_names_its_page(command, tmp_path):
    done = command(*REPLAY, tmp_path / "out").done()
    for wanted in ("PSNR", "SSIM", "FLIP", "Holes", "iterative", "none", "Time, warp"):
        assert wanted in done.out, wanted
    assert "wall clock" in done.out or "GPU timers" in done.out
    assert done.out.splitlines()[-1] == f"report: {tmp_path / 'out' / 'report.html'}"
    assert max(map(len, done.out.splitlines()[:-1])) <= 80


def test_notes_are_printed(command, tmp_path):
    """A trace that had to be moved into the scene is not moved silently."""
    rows = "".join(f"{i / 50} 100 1.6 0 0 0 0 1\n" for i in range(51))
    (tmp_path / "far.txt").write_text("# timestamp tx ty tz qx qy qz qw\n" + rows, encoding="utf-8")
    done = command("replay", tmp_path / "far.txt", *REPLAY[2:], tmp_path / "out").done()
    assert "note: The trace does not fit scene 'planes': its positions were shifted by" in done.out


def test_the_command_in_the_report_can_be_typed_again(command, tmp_path):
    import shlex

    out = tmp_path / "it's here"
    command(*REPLAY, out, "--quiet").done()
    page = (out / "report.html").read_text(encoding="utf-8")
    import html

    assert shlex.join(["hmdwarp", *REPLAY, str(out), "--quiet"]) in html.unescape(page)


def test_a_terminal_without_the_table_s_characters_gets_question_marks(tmp_path):
    environment = {**ENVIRONMENT, "PYTHONIOENCODING": "latin-1"}
    trace = tmp_path / "st\u2026.csv"  # an ellipsis, which it lacks
    trace.write_bytes((folder("recordings") / "still.csv").read_bytes())
    arguments = [str(trace) if argument == "still" else argument for argument in REPLAY]
    out = str(tmp_path / "out")
    done = subprocess.run([*PROGRAM, *arguments, out], capture_output=True, env=environment, check=False)
    assert done.returncode == 0 and not complaints(done.stderr)
    assert b"PSNR" in done.stdout and b"st? at 200 ms" in done.stdout


def test_a_folder_whose_name_is_no_text(tmp_path):
    """Names of files are bytes, and need not be UTF-8.

    The command in the report and the last line printed hold this one.
    """
    out = os.fsencode(tmp_path) + b"/n\xff"
    done = subprocess.run([*PROGRAM, *REPLAY, out], capture_output=True, env=ENVIRONMENT, check=False)
    assert done.returncode == 0 and not complaints(done.stderr)
    assert done.stdout.splitlines()[-1].endswith(b"/n?/report.html")
    assert b"/n?" in Path(os.fsdecode(out), "report.html").read_bytes()
