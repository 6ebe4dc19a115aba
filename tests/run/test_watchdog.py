"""A call that never comes back ends the program with a line, after what could be saved.

One that is only slow does not.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from hmdwarp.errors import MachineError
from hmdwarp.run import Watchdog

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 600  # of a loaded machine; nothing here waits for it unless it fails


def started(body: str, tmp_path: Path) -> subprocess.Popen:
    """A Python that runs `body` with a Watchdog class at hand."""
    head = "import ctypes, os, sys, threading, time\nimport hmdwarp.run.ending as module\n"
    head += "from hmdwarp.run.ending import Watchdog\n"
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


HANGS = """
with Watchdog({limit}, {words}) as dog:
    with dog.watching('xrWaitFrame'):
        ctypes.CDLL(None).pause()
"""


def test_a_call_that_blocks_in_c_ends_the_program_with_one_line(tmp_path):
    words = "[lambda: open('saved', 'w').write('poses') and 'the recording is in saved', lambda: '']"
    status, _, error = ended(HANGS.format(limit=0.3, words=words), tmp_path)
    assert status == MachineError.exit_status == 3
    assert error == (
        "hmdwarp: the OpenXR runtime has not answered xrWaitFrame for 0.3 s: it hangs; end its service, start it "
        "again, "
        "then try once more; the recording is in saved\n"
    )
    assert (tmp_path / "saved").read_text() == "poses"


def test_last_words_that_hang_or_fail_keep_nobody(tmp_path):
    """The others are said all the same, and what was printed before is not lost."""
    words = "[lambda: ctypes.CDLL(None).pause(), lambda: 1 / 0, lambda: sys.exit(5), lambda: 'the log is in out']"
    body = "module.LAST_WORDS_S = 2\nsys.stdout.write('unflushed')\n" + HANGS.format(limit=0.2, words=words)
    status, out, error = ended(body, tmp_path)
    assert (status, out) == (3, "unflushed")
    assert error.count("\n") == 1
    assert error.endswith("once more; the log is in out\n")


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


def test_watching_a_call_makes_nothing_and_takes_no_lock():
    dog = Watchdog(5, [])
    assert dog.watching("xrWaitFrame") is dog.watching("xrWaitFrame")
    assert dog.watching("xrWaitFrame") is not dog.watching("xrEndFrame")
