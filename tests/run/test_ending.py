"""A run ends when it has shown what was asked for, or by a signal.

After the refresh under way, with everything written.
"""

from __future__ import annotations

import gc
import os
import signal
import threading

import pytest

from hmdwarp.run import Ending, LiveOptions
from hmdwarp.run.ending import GarbageControl

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


def test_after_so_many_pictures():
    one = Ending(None, 3)
    assert [one.due(count) for count in (0, 1, 2, 3, 4)] == [False, False, False, True, True]


def test_after_so_long_from_the_first_picture_on():
    """However long the first frame was under way, and by the display's clock."""
    now = [100.0]
    one = Ending(2.0, None)
    one.now_ns = lambda: round(now[0] * 1e9)
    told = []
    for now_s, count in ((100, 0), (200, 0), (200, 1), (201.9, 2), (202, 3)):
        now[0] = float(now_s)
        told.append(one.due(count))
    assert told == [False, False, False, False, True]


def test_never_by_itself():
    assert not Ending(None, None).due(10**9)


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


def test_another_thread_has_no_signals_and_needs_none(handlers):
    done = []

    def work() -> None:
        with Ending(None, 1) as one:
            done.append(one.due(1))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [True]


# --- whole runs


def test_ctrl_c_ends_a_run_after_the_refresh_under_way(monkeypatch, handlers, tmp_path):
    """Every tick was answered by a picture, the recording and the log are whole, the display was
    closed.
    """
    display, out, recording = OffscreenDisplay(), tmp_path / "out", tmp_path / "head.csv"
    stop = lambda number: os.kill(os.getpid(), signal.SIGINT) if number == 4 else None  # noqa: E731
    result = run_on(monkeypatch, display, LiveOptions(**PLAIN, out=out, record=recording), after=stop)
    assert display.closed == 1
    assert len(display.labels) == 4
    assert result.summary["frames"] == 4
    assert len((out / "frames.csv").read_text().splitlines()) == 1 + 2 * 4
    assert sum(not line.startswith(("#", "time")) for line in recording.read_text().splitlines()) == 4
    assert handlers == []


def test_sigterm_ends_the_program_when_all_is_written(monkeypatch, handlers, tmp_path):
    display, out = OffscreenDisplay(), tmp_path / "out"
    stop = lambda number: os.kill(os.getpid(), signal.SIGTERM) if number == 2 else None  # noqa: E731
    run_on(monkeypatch, display, LiveOptions(**PLAIN, out=out), after=stop)
    assert handlers == [signal.SIGTERM]
    assert (out / "summary.json").is_file()
    assert display.closed == 1


def test_an_impatient_ctrl_c_still_closes_the_display(monkeypatch, handlers, tmp_path):
    display, recording = OffscreenDisplay(), tmp_path / "head.csv"

    def stop(number: int) -> None:
        if number == 3:
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run_on(monkeypatch, display, LiveOptions(**PLAIN, record=recording), after=stop)
    assert display.closed == 1
    assert sum(not line.startswith(("#", "time")) for line in recording.read_text().splitlines()) == 3


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
