"""What a laboratory does to a session, through the real command: two at once, an end by signal.

Each time one clear line, nothing lost, and the session can be resumed.
"""

from __future__ import annotations

import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import pytest

from hmdwarp.errors import InputError
from hmdwarp.study.store import Store

from . import tiny

pytestmark = pytest.mark.slow


def started(arguments: list[str]) -> subprocess.Popen:
    return subprocess.Popen(
        [*tiny.PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tiny.ROOT
    )


def until_showing(store: Path, process: subprocess.Popen, key: str = "trial/1") -> None:
    """A trial is under way, as somebody who reads the store sees it."""
    until = time.monotonic() + tiny.PATIENCE_S
    while time.monotonic() < until:
        assert process.poll() is None, process.communicate()
        with suppress(InputError), Store(store) as opened:  # the store is not there yet, or being made
            if any(one.key == key for one in opened.contents().showings):
                return
        time.sleep(0.05)
    raise AssertionError("no trial began")


def long_study(folder: Path) -> tuple[Path, Path]:
    """Trials of ten minutes, which nobody waits for."""
    study, model = tiny.write(folder)
    study.write_text(tiny.STUDY.replace("[trial]\nseconds = 0.2", "[trial]\nseconds = 600"))
    return study, model


def test_two_sessions_at_once_and_an_end_by_signal(tmp_path):
    """The second is refused with who holds the study; the first does not notice.

    Ended in the middle of a trial it is gone on with.
    """
    study, model = long_study(tmp_path)
    data = tmp_path / "tiny-simulated-data"
    first = started(tiny.session(study, model, "one"))
    try:
        until_showing(data, first)
        second = tiny.program(*tiny.session(study, model, "two"))
        assert second.returncode in (2, 3)
        assert second.stderr.count("\n") == 1 and str(first.pid) in second.stderr
        assert first.poll() is None
        first.send_signal(signal.SIGTERM)
        said, wrong = first.communicate(timeout=tiny.PATIENCE_S)
    finally:
        first.kill()
        first.communicate()
    assert first.returncode == 128 + signal.SIGTERM
    assert "--resume" in said + wrong
    with Store(data) as store:
        contents = store.contents()
    assert [(one.code, one.status) for one in contents.sessions] == [("one", "interrupted")]
    assert [one.complete for one in contents.showings if one.key == "trial/1"] == [False]
    assert [one.key for one in contents.answers] == ["practice/fms/fms"]
