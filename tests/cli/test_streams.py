"""Standard output that is closed or full, what is written, what is overwritten, what is told."""

from __future__ import annotations

import html
import os
import re
import resource
import shlex
import subprocess
from pathlib import Path

import pytest

from hmdwarp.base import folder
from hmdwarp.cli import _show
from hmdwarp.poses import load_trace

from .conftest import PROGRAM, ROOT, complaints

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
LISTS = [["list", "warps"], ["--help"], ["trace", "info", "still"]]  # a table, click's own, lines
SMALL = ["--scene", "planes", "--headset", "rift-dk1", "--size", "48x40"]
TINY = [*SMALL, "--seconds", "0.1", "--workers", "0", "--quiet"]
REPLAY = ["replay", "still", *TINY[:-1], "--images", "0", "--out"]


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


@pytest.mark.parametrize(
    ("closed", "arguments"), [(">&-", LISTS[0]), ("2>&-", LISTS[0]), (ALL := ">&- 2>&- <&-", LISTS[0]), (ALL, REPLAY)]
)
def test_closed_streams(closed, arguments, tmp_path):
    arguments = [*arguments, str(tmp_path / "out")] if arguments == REPLAY else arguments
    done = ended("sh", "-c", f'"$@" {closed}', "sh", *PROGRAM, *arguments)
    assert done.returncode == 0, done
    assert "Traceback" not in done.stderr and "Error" not in done.stderr
    if arguments[0] == "replay":
        assert (tmp_path / "out" / "summary.json").exists()


def test_a_replay_prints_table_notes_and_page_which_has_the_command(command, tmp_path):
    """A trace that had to be moved into the scene is not moved silently."""
    out, trace = tmp_path / "it's here", tmp_path / "far.txt"
    rows = "".join(f"{i / 50} 100 1.6 0 0 0 0 1\n" for i in range(51))
    trace.write_text("# timestamp tx ty tz qx qy qz qw\n" + rows, encoding="utf-8")
    typed = ["replay", str(trace), *REPLAY[2:], str(out)]
    told = command(*typed).done().out
    for wanted in ("PSNR", "SSIM", "FLIP", "Holes", "iterative", "none", "Time, warp"):
        assert wanted in told, wanted
    assert "note: The trace does not fit scene 'planes': its positions were shifted by" in told
    assert "wall clock" in told or "GPU timers" in told
    assert told.splitlines()[-1] == f"report: {out / 'report.html'}"
    assert max(map(len, told.partition("openxr (")[0].splitlines()[:-1])) <= 80
    assert shlex.join(["hmdwarp", *typed]) in html.unescape((out / "report.html").read_text(encoding="utf-8"))


def test_a_terminal_and_a_folder_s_name_that_lack_characters_give_question_marks(tmp_path):
    """Names of files are bytes, and need not be UTF-8; the report and the last line hold one."""
    environment, out = {**ENVIRONMENT, "PYTHONIOENCODING": "latin-1"}, os.fsencode(tmp_path) + b"/n\xff"
    trace = tmp_path / "st\u2026.csv"  # an ellipsis, which it lacks
    trace.write_bytes((folder("recordings") / "still.csv").read_bytes())
    arguments = [str(trace) if argument == "still" else argument for argument in REPLAY]
    done = subprocess.run([*PROGRAM, *arguments, out], capture_output=True, env=environment, check=False)
    assert done.returncode == 0 and not complaints(done.stderr)
    assert b"PSNR" in done.stdout and b"st? at 200 ms" in done.stdout
    assert done.stdout.splitlines()[-1].endswith(b"/n?/report.html")
    assert b"/n?" in Path(os.fsdecode(out), "report.html").read_bytes()


WALK = folder("recordings") / "walk.csv"
ONCE = ("--warp", "none", "--fill", "none", "--instants", "1", "--rounds", "1")
RATINGS = "participant,condition,rating\n" + "".join(
    f"{who},{what},{who % 3 + 1}\n" for who in range(6) for what in "ab"
)
# Arguments before --out, and a file of the folder that each writes.
FOLDERS = {
    "replay": (["replay", "still", "--against", "", *TINY], "report.html"),
    "bench": (["bench", "still", *ONCE, *TINY], "bench.html"),
    "live": (["live", "--source", "offscreen", "--trace", "walk", "--pictures", "2", "--quiet", *SMALL], "frames.csv"),
    "analyse": (["study", "analyse", "ratings.csv", "--scale", "acr", "--quiet"], "tables/missing.csv"),
}
FILES = {
    "synth": ["trace", "synth", "walk", "--seconds", "0.1", "--out"],
    "convert": ["trace", "convert", WALK],
    "record": ["record", "--source", "synthetic", "--seconds", "0.1", "--quiet", "--out"],
    "live --record": [*FOLDERS["live"][0], "--record"],
}


@pytest.fixture(autouse=True)
def working_folder(tmp_path, monkeypatch):
    place = tmp_path / "here"
    place.mkdir()
    (place / "ratings.csv").write_text(RATINGS)
    monkeypatch.chdir(place)
    return place


@pytest.fixture
def others(tmp_path):
    """others(name): a folder with a file of another program, where that command writes one."""

    def make(name):
        out = tmp_path / "out"
        (out / FOLDERS[name][1]).parent.mkdir(parents=True)
        (out / FOLDERS[name][1]).write_text("precious")
        (out / "mine.txt").write_text("mine")
        return out

    return make


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_with_a_file_of_others_is_refused_and_then_forced(name, command, others):
    (arguments, written), out = FOLDERS[name], others(name)
    command(*arguments, "--out", out).refused(written, "--force")
    assert (out / written).read_text() == "precious" and not list(out.glob(".*"))
    if name != "bench":  # which takes long
        assert command(*arguments, "--out", out, "--force").status == 0
        assert (out / "mine.txt").read_text() == "mine"
        assert not (out / written).exists() or (out / written).read_text() != "precious"


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_refused_and_then_forced(name, command, tmp_path):
    out = tmp_path / "out.csv"
    out.write_text("precious")
    command(*FILES[name], out).refused("out.csv exists already", "--force")
    assert out.read_text() == "precious"
    assert command(*FILES[name], out, "--force").status == 0
    assert len(load_trace(out).track) > 1


def test_record_says_what_a_full_disk_has_taken(program, tmp_path):
    out = tmp_path / "walk.csv"
    done = program(
        *("record", "--source", "synthetic", "--kind", "walk", "--out", out),
        env={"PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)),  # written in several parts
    )
    track = load_trace(out).track
    assert done.status == 3 and "make room" in done.err, done
    assert f"{out}: {len(track)} poses; left out: " in done.err
    assert re.search(r"left out: \d+ lost, as the disk did not take them\n", done.err), done


@pytest.mark.parametrize(
    ("steps", "told"),
    [
        # Of how many, and when: the first step has warming up in it.
        ([], "still preparing"),
        ([(0.0, 1, 61)], "1 of 61"),
        ([(120.0, 1, 61), (130.0, 11, 61)], "11 of 61, about 50 s to go"),
        ([(0.0, 1, 1001), (1.2, 2, 1001)], "2 of 1001, about 20 min to go"),
        ([(0.0, 1, 2), (1.0, 2, 2)], "2 of 2; the last pictures are measured, then the results are written"),
    ],
)
def test_an_estimate_comes_from_the_steps_after_the_first(steps, told):
    assert _show.progress_line("refreshes", steps) == f"refreshes: {told}"


def test_a_replay_tells_its_progress_without_a_terminal(command, quick, monkeypatch):
    monkeypatch.setattr(_show, "LINE_EVERY_S", 0.001)
    done = command("replay", "still", *(word for word in quick if word != "--quiet")).done()
    told = done.err.splitlines()
    assert "preparing scene 'planes', OpenGL and metrics; then 6 refreshes of 'still'" in told
    assert any(line.startswith("refreshes: ") for line in told)


def test_quiet_tells_nothing(command, quick, monkeypatch):
    monkeypatch.setattr(_show, "LINE_EVERY_S", 0.001)
    assert command("replay", "still", *quick).err == ""
