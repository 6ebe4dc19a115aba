"""How a run ends: when it has shown what was asked for, by a signal, or by a call that hangs."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import textwrap
import time
from contextlib import nullcontext
from pathlib import Path

import pytest

from hmdwarp.base import MachineError
from hmdwarp.run import Ending, LiveOptions
from hmdwarp.run.live_run import GarbageControl

from .offscreen import OffscreenDisplay, run_on

ASKING = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
PLAIN = {"scene": "planes", "headset": "rift-dk1", "latency_ms": 0, "fill": "none"}


@pytest.fixture
def handlers():
    """As a program has them, whatever the test runner does; and as they were afterwards."""
    before = {number: signal.getsignal(number) for number in ASKING}
    came: list[int] = []
    for number in ASKING:
        signal.signal(number, lambda number, _: came.append(number))
    yield came
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_run_ends_after_so_many_pictures_or_so_long_from_the_first_one_on():
    """However long the first frame was under way, and by the display's clock."""
    by_count, by_time, now = Ending(None, 3), Ending(2.0, None), [100.0]
    assert [by_count.due(count) for count in (0, 1, 2, 3, 4)] == [False, False, False, True, True]
    by_time.now_ns = lambda: round(now[0] * 1e9)
    told = []
    for now[0], count in ((100.0, 0), (200.0, 0), (200.0, 1), (201.9, 2), (202.0, 3)):
        told.append(by_time.due(count))
    assert told == [False, False, False, False, True] and not Ending(None, None).due(10**9)


@pytest.mark.parametrize("number", ASKING)
def test_a_signal_asks_and_is_handed_on_at_the_end(handlers, number):
    """Ctrl-C is the usual way to end a run.

    Who sends another one expects the program to end by it.
    """
    with Ending(None, None) as one:
        assert not one.due(5)
        signal.raise_signal(number)
        assert one.asked == number
        assert one.due(5)
        assert handlers == []
    assert handlers == ([] if number == signal.SIGINT else [number])
    signal.raise_signal(number)
    assert handlers[-1] == number  # the handlers of before are back


def test_the_second_one_interrupts_at_once(handlers):
    with Ending(None, None):
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)


def test_nohup_is_obeyed(handlers):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with Ending(None, None) as one:
        signal.raise_signal(signal.SIGHUP)
        assert one.asked is None


# --- whole runs


@pytest.mark.parametrize("signals", [[signal.SIGINT], [signal.SIGTERM], [signal.SIGINT] * 2], ids=str)
def test_a_signal_ends_a_run_after_the_refresh_under_way(monkeypatch, handlers, tmp_path, signals):
    """Every tick got a picture, recording and log are whole, the display was closed; who
    sends another one than Ctrl-C gets it.
    """
    display, out, recording = OffscreenDisplay(), tmp_path / "out", tmp_path / "head.csv"

    def stop(number: int) -> None:
        for one in signals if number == 4 else ():
            os.kill(os.getpid(), one)

    options = LiveOptions(**PLAIN, out=out, record=recording)
    with pytest.raises(KeyboardInterrupt) if len(signals) > 1 else nullcontext():
        result = run_on(monkeypatch, display, options, after=stop)
        assert len(display.labels) == 4 == result.summary["frames"]
    assert display.closed == 1 and len((out / "frames.csv").read_text().splitlines()) == 1 + 2 * 4
    assert sum(not line.startswith(("#", "time")) for line in recording.read_text().splitlines()) == 4
    assert handlers == [one for one in signals if one != signal.SIGINT]


def test_garbage_is_frozen_for_a_run_unless_the_program_has_frozen_its_own(monkeypatch):
    """These tests have: what is frozen when they begin stays so."""
    monkeypatch.setattr(gc, "get_freeze_count", gc.get_freeze_count.__wrapped__)
    frozen = gc.get_freeze_count()
    with GarbageControl():
        assert gc.get_freeze_count() == frozen > 0 and not gc.isenabled()
    assert gc.get_freeze_count() == frozen and gc.isenabled()
    gc.unfreeze()
    try:
        with GarbageControl():
            assert gc.get_freeze_count() > 0
        assert gc.get_freeze_count() == 0
    finally:
        gc.freeze()


ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 600  # of a loaded machine; nothing here waits for it unless it fails


def started(body: str, tmp_path: Path) -> subprocess.Popen:
    """A Python that runs `body` with a Watchdog class at hand."""
    head = "import ctypes, os, sys, threading, time\nimport hmdwarp.run.live_run as module\n"
    head += "from hmdwarp.run.live_run import Watchdog\n"
    path = tmp_path / "program.py"
    path.write_text(head + textwrap.dedent(body), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [sys.executable, str(path)], stdin=pipe, stdout=pipe, stderr=pipe, text=True, cwd=tmp_path, env=environment
    )


def ended(body: str, tmp_path: Path) -> tuple[int, str, str]:
    """(exit status, stdout, stderr) of such a Python, which must end by itself."""
    program = started(body, tmp_path)
    try:
        out, error = program.communicate(timeout=PATIENCE_S)
    finally:
        program.kill()
    return program.returncode, out, error


def test_a_call_that_blocks_in_c_ends_the_program_with_one_line(tmp_path):
    """Last words that hang or fail keep nobody: the others are said all the same."""
    body = """
        module.LAST_WORDS_S = 2
        sys.stdout.write("unflushed")
        last = [
            lambda: ctypes.CDLL(None).pause(), lambda: 1 / 0, lambda: sys.exit(5), lambda: "",
            lambda: open("saved", "w").write("poses") and "the recording is in saved",
        ]
        with Watchdog(0.3, last) as dog:
            with dog.watching("xrWaitFrame"):
                ctypes.CDLL(None).pause()
        """
    status, out, error = ended(body, tmp_path)
    assert status == MachineError.exit_status == 3 and out == "unflushed"
    assert error == (
        "hmdwarp: the OpenXR runtime has not answered xrWaitFrame for 0.3 s: it hangs; end its service, start it "
        "again, then try once more; the recording is in saved\n"
    )
    assert (tmp_path / "saved").read_text() == "poses"


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no SIGSTOP on this system")
def test_a_peer_that_is_stopped_is_noticed(tmp_path):
    """As a runtime's service: it answers, is stopped (SIGSTOP) and answers no more."""
    peer = subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    body = f"""
        def calls(numbers):
            for number in numbers:
                with dog.watching("xrLocateViews"):
                    os.write(there, b"x")
                    os.read(back, 1)
                print(number, flush=True)

        with Watchdog(600, []) as dog:
            ends = ((0, os.O_WRONLY), (1, os.O_RDONLY))
            there, back = (os.open(f"/proc/{peer.pid}/fd/{{n}}", flags) for n, flags in ends)
            calls(range(50))
        with Watchdog(0.5, []) as dog:
            calls(range(10**9))
        """
    program = started(body, tmp_path)
    try:
        for _ in range(50):
            assert program.stdout.readline()
        peer.send_signal(signal.SIGSTOP)
        program.stdout.read()
        error = program.stderr.read()
        assert program.wait(PATIENCE_S) == 3
        assert "has not answered xrLocateViews for 0.5 s" in error
    finally:
        peer.send_signal(signal.SIGCONT)
        for process in (peer, program):
            process.kill()
            process.communicate()


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no SIGSTOP on this system")
def test_a_program_that_was_stopped_itself_goes_on(tmp_path):
    """Stopped in the middle of a call for longer than the limit.

    The call had no chance to come back.

    A call takes 0.1 s, the limit is 1 s, it is stopped for 2 s.
    """
    body = """
        with Watchdog(1.0, []) as dog:
            print("ready", flush=True)
            for _ in range(10):
                with dog.watching("xrWaitFrame"):
                    time.sleep(0.1)
            print("done", flush=True)
        """
    program = started(body, tmp_path)
    try:
        assert program.stdout.readline() == "ready\n"
        program.send_signal(signal.SIGSTOP)
        time.sleep(2)
        program.send_signal(signal.SIGCONT)
        out, error = program.communicate(timeout=PATIENCE_S)
    finally:
        program.kill()
    assert (program.returncode, out, error) == (0, "done\n", "")


def test_many_calls_that_come_back_are_no_hang(tmp_path):
    """Together they take twice as long as one may.

    A call within a call, an error and a call of the same name again included.
    """
    body = """
        with Watchdog(0.8, []) as dog:
            with dog.watching("outer"):
                for _ in range(12):
                    with dog.watching("outer"), dog.watching("inner"):
                        time.sleep(0.15)
            try:
                with dog.watching("xrEndFrame"):
                    raise ValueError
            except ValueError:
                pass
            time.sleep(1.2)  # nothing is under way
        print(threading.active_count())
        """
    assert ended(body, tmp_path) == (0, "1\n", "")
