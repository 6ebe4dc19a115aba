"""What goes wrong with a runtime, and what is left of a live run then.

A clear line, the recording, and the headset again if it can be.
"""

from __future__ import annotations

import csv
import json
import re
import signal

import pytest

from hmdwarp.poses import load_trace
from hmdwarp.report import validate_summary

from .live_runs import Here, Program, quick
from .monado import UNSEEN, WOBBLING

pytestmark = pytest.mark.usefixtures("no_screen")


def test_a_run_whose_service_is_not_started_says_so(runtime, tmp_path):
    runtime(WOBBLING, UNSEEN)
    with Program(tmp_path) as program:
        status, told = program.ended()
    assert status == 3 and "service does not answer" in told and "Traceback" not in told
    assert not program.recording.exists()


ENDS = {  # what it is started with, how it may end, what it says
    "killed": (("--reconnect", "0.5"), (3,), "went away"),
    "hangs": (("--hang", "10"), (3,), "hmdwarp: .*has not answered"),
    "SIGINT": ((), (0,), ""),
    "SIGTERM": ((), (-signal.SIGTERM, 128 + signal.SIGTERM), ""),
}


@pytest.mark.parametrize("what", ENDS)
def test_whatever_ends_it_everything_is_written(wobbling, tmp_path, what):
    options, statuses, words = ENDS[what]
    with Program(tmp_path, "--out", str(out := tmp_path / "out"), *options) as program:
        program.until_recorded(5)
        if what.startswith("SIG"):
            program.send(signal.Signals[what])
        else:
            wobbling.kill() if what == "killed" else wobbling.process.send(signal.SIGSTOP)
        status, told = program.ended()
    if what == "hangs":
        wobbling.process.send(signal.SIGCONT)
    assert status in statuses and re.search(words, told)
    assert "Traceback" not in told and told.count("has not answered") == (what == "hangs")
    trace = load_trace(str(program.recording))
    # A busy machine may make it slow, and slow for a moment: the rate and gaps are the machine's,
    # every other defect would be the recording's.
    assert {defect.kind for defect in trace.defects} <= {"rate-implausible", "gap"}
    summary = json.loads((out / "summary.json").read_text())
    validate_summary(summary)
    if what.startswith("SIG"):
        assert summary["frames"] == trace.track.time_ns.size
        with (out / "frames.csv").open(newline="") as file:
            assert len(list(csv.DictReader(file))) == 2 * summary["frames"]
        assert "</html>" in (out / "report.html").read_text()


def test_a_service_that_hangs_for_a_moment_is_waited_for(wobbling, tmp_path):
    with Program(tmp_path, "--hang", "60") as program:
        program.until_recorded(5)
        wobbling.process.send(signal.SIGSTOP)
        before = program.recorded()
        wobbling.process.send(signal.SIGCONT)
        program.until_recorded(before + 20)
        program.send(signal.SIGINT)
        assert program.ended()[0] == 0


def test_another_program_takes_the_headset_for_a_while(wobbling, tmp_path):
    """Monado shows the newest of two programs.

    The other one's session is not visible any more, and is again when the newer one is gone, if
    only by being killed.
    """
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    with Program(tmp_path / "first") as first:
        first.until_recorded(5)
        with Program(tmp_path / "second") as second:
            second.until_recorded(5)
            before = first.recorded()
            second.until_recorded(45)  # two seconds later
            # What was on its way to the disk, for half a second at most, may still have come: 10
            # pictures.
            assert first.recorded() <= before + 10
            before = first.recorded()
        first.until_recorded(before + 20)
        first.send(signal.SIGINT)
        assert first.ended()[0] == 0


def test_a_restarted_service_goes_on_with_the_same_run(wobbling, monkeypatch, tmp_path):
    here, recording, gpus = Here(monkeypatch), tmp_path / "head.csv", set()

    def after(number: int) -> None:
        gpus.add(here.display.gpu)
        if number in (4, 8):
            wobbling.kill()

    def said(text: str) -> None:
        if "waiting up to" in text:
            wobbling.start()

    result = here.run(quick(pictures=12, record=recording, out=tmp_path / "out"), after, said)
    assert here.said.count("it is back") == 2 and result.summary["frames"] == 12
    assert len(gpus) == 1  # what was compiled and loaded is still there
    assert load_trace(str(recording)).track.time_ns.size == 12
    with (tmp_path / "out" / "frames.csv").open(newline="") as file:
        assert [int(row["frame"]) for row in csv.DictReader(file)] == [number for number in range(12) for _ in "LR"]
