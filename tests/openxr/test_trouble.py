"""What goes wrong with a runtime, and what is left of a live run then.

A clear line, the recording, and the headset again if it can be.
"""

from __future__ import annotations

import csv
import json
import signal

import pytest

from hmdwarp.errors import MachineError
from hmdwarp.poses import load_trace
from hmdwarp.report import validate_summary

from .live_runs import Here, Program, quick
from .monado import REMOTE, UNSEEN, WOBBLING

pytestmark = pytest.mark.usefixtures("no_screen")


@pytest.fixture
def here(monkeypatch) -> Here:
    return Here(monkeypatch)


def test_no_runtime(monkeypatch, tmp_path):
    monkeypatch.setenv("XR_RUNTIME_JSON", str(tmp_path / "nowhere.json"))
    with Program(tmp_path) as program:
        assert program.status() == 3
        assert "no OpenXR runtime: XR_RUNTIME_JSON names" in program.said
        assert "nowhere.json" in program.said
        assert not program.recording.exists()


def test_service_down(runtime, tmp_path):
    runtime(WOBBLING, UNSEEN)
    with Program(tmp_path) as program:
        assert program.status() == 3
        assert "the OpenXR runtime's service does not answer" in program.said
        assert "Traceback" not in program.said


def test_a_second_instance_in_one_process(monado, here):
    import xr

    first = xr.create_instance(xr.InstanceCreateInfo())
    try:
        with pytest.raises(MachineError, match="has no room for another program"):
            here.run(quick(pictures=1))
    finally:
        xr.destroy_instance(first)
    assert here.run(quick(pictures=1)).summary["frames"] == 1  # nothing of the failed one is left


def test_frames_that_nobody_sees_are_handed_over_empty(monado, here, monkeypatch):
    """Monado's first frame is not to be rendered."""
    from hmdwarp.display.openxr.runtime import FrameCalls

    seen, ended = [], FrameCalls.end

    def end(frames: FrameCalls, *layers: object) -> None:
        seen.append((bool(frames.state.should_render), bool(layers)))
        ended(frames, *layers)

    monkeypatch.setattr(FrameCalls, "end", end)
    here.run(quick(pictures=3))
    assert seen[0] == (False, False)
    assert sum(layered for _, layered in seen) == 3
    assert all(rendered for rendered, layered in seen if layered)


def test_another_program_takes_the_headset_for_a_while(runtime, tmp_path):
    """Monado shows the newest of two programs.

    The other one's session is not visible any more, and is again when the newer one ends.
    """
    runtime(WOBBLING, UNSEEN).start()
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
            second.send(signal.SIGINT)
            assert second.status() == 0
        first.until_recorded(before + 20)
        first.send(signal.SIGINT)
        assert first.status() == 0


def test_a_killed_service_is_noticed_at_the_next_refresh(monado, here, tmp_path):
    """A refresh is 50 ms here, so that is within the second that may pass."""
    recording = tmp_path / "head.csv"
    with pytest.raises(MachineError, match="went away.*it has not come back within 0.2 s"):
        here.run(quick(record=recording, reconnect_s=0.2), after=lambda number: monado.kill() if number == 5 else None)
    # One more picture may have been on its way into the compositor.
    assert load_trace(str(recording)).track.time_ns.size in (5, 6)
    assert any("waiting up to 0.2 s" in text for text in here.said)


def test_a_restarted_service_goes_on_with_the_same_run(runtime, here, tmp_path):
    monado = runtime(WOBBLING, UNSEEN)
    monado.start()
    recording, gpus = tmp_path / "head.csv", set()

    def after(number: int) -> None:
        gpus.add(here.watched.gpu)
        if number in (4, 8):
            monado.kill()

    def said(text: str) -> None:
        if "waiting up to" in text:
            monado.start()

    result = here.run(quick(pictures=12, record=recording, out=tmp_path / "out"), after, said)
    assert len([text for text in here.said if text == "it is back"]) == 2
    assert result.summary["frames"] == 12
    assert len(gpus) == 1  # what was compiled and loaded is still there
    assert load_trace(str(recording)).track.time_ns.size == 12
    with (tmp_path / "out" / "frames.csv").open(newline="") as file:
        assert [int(row["frame"]) for row in csv.DictReader(file)] == [number for number in range(12) for _ in "LR"]


def test_a_killed_service_ends_the_program_with_a_line(runtime, tmp_path):
    monado = runtime(WOBBLING, UNSEEN)
    monado.start()
    with Program(tmp_path, "--reconnect", "0.5") as program:
        program.until_recorded(5)
        monado.kill()
        assert program.status() == 3
        assert "went away" in program.said
        assert "Traceback" not in program.said
        assert program.recorded() >= 5


def test_a_service_that_hangs_is_given_up(runtime, tmp_path):
    monado = runtime(WOBBLING, UNSEEN)
    monado.start()
    with Program(tmp_path, "--hang", "10", "--out", str(tmp_path / "out")) as program:
        program.until_recorded(5)
        monado.pause()
        assert program.status() == 3
        lines = [line for line in program.said.splitlines() if "has not answered" in line]
        assert len(lines) == 1 and "hmdwarp: " in lines[0]
        whole_recording(program)
        validate_summary(json.loads((tmp_path / "out" / "summary.json").read_text()))
    monado.resume()


def test_a_service_that_hangs_for_a_moment_is_waited_for(runtime, tmp_path):
    monado = runtime(WOBBLING, UNSEEN)
    monado.start()
    with Program(tmp_path, "--hang", "60") as program:
        program.until_recorded(5)
        monado.pause()
        before = program.recorded()
        monado.resume()
        program.until_recorded(before + 20)
        program.send(signal.SIGINT)
        assert program.status() == 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_with_everything_written(runtime, tmp_path, number):
    runtime(WOBBLING, UNSEEN).start()
    out = tmp_path / "out"
    with Program(tmp_path, "--out", str(out)) as program:
        program.until_recorded(5)
        program.send(number)
        assert program.status() in ((0,) if number == signal.SIGINT else (-number, 128 + number))
        rows = whole_recording(program)
        summary = json.loads((out / "summary.json").read_text())
        validate_summary(summary)
        assert summary["frames"] == rows
        with (out / "frames.csv").open(newline="") as file:
            assert len(list(csv.DictReader(file))) == 2 * rows
        assert "</html>" in (out / "report.html").read_text()


def test_the_service_takes_the_next_program(runtime, tmp_path):
    """Nothing of a run that was ended keeps the headset."""
    runtime(REMOTE, UNSEEN).start()
    for number in (signal.SIGKILL, signal.SIGINT):
        folder = tmp_path / number.name
        folder.mkdir()
        with Program(folder) as program:
            program.until_recorded(3)
            program.send(number)
            assert program.status() == (0 if number == signal.SIGINT else -number)


def whole_recording(program: Program) -> int:
    """How many poses are in a recording that is whole.

    A busy machine may make it slow, and slow for a moment: the rate and gaps are the machine's,
    every other defect would be the recording's.
    """
    trace = load_trace(str(program.recording))
    assert {defect.kind for defect in trace.defects} <= {"rate-implausible", "gap"}
    return trace.track.time_ns.size
