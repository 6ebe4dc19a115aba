"""What a laboratory does to a session, through the real command: two at once, an end by signal.

Each time one clear line, nothing lost, and the session can be resumed.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import suppress
from datetime import timedelta
from pathlib import Path

import needs
import pytest

from hmdwarp.errors import InputError
from hmdwarp.study.design import Show, load_design, steps_of
from hmdwarp.study.store import INTERRUPTED, SIMULATED, Store

from . import tiny
from .killing import Cold, Killed, Nursery, faults, live
from .store.sessions import SetClock

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
            if any(showing.key == key for showing in opened.contents().showings):
                return
        time.sleep(0.05)
    raise AssertionError("no trial began")


def long_study(folder: Path) -> tuple[Path, Path]:
    """Trials of ten minutes, which nobody waits for."""
    study, model = tiny.write(folder)
    study.write_text(tiny.STUDY.replace("[trial]\nseconds = 0.2", "[trial]\nseconds = 600"))
    return study, model


def run_second(arguments: list[str], on_a_terminal: bool) -> tuple[int | None, str]:
    """Run a session; its exit status, and what it says."""
    arguments = ["lines" if word == "none" and on_a_terminal else word for word in arguments]
    if not on_a_terminal:
        done = tiny.program(*arguments)
        return done.returncode, done.stderr
    terminals = pytest.importorskip("tests.study.console.terminals", reason="needs pexpect and pyte")
    with terminals.Terminal([*tiny.PROGRAM, *arguments], (200, 24)) as terminal:
        before = terminal.modes()
        status = terminal.ended()
        assert terminal.modes() == before
        return status, terminal.text().strip() + "\n"


@pytest.mark.parametrize("on_a_terminal", [False, True])
def test_two_sessions_at_once_and_an_end_by_signal(on_a_terminal, tmp_path):
    """The second is refused with who holds the study; the first does not notice.

    Ended in the middle of a trial it is gone on with. on_a_terminal: whether the second one is.
    """
    study, model = long_study(tmp_path)
    data = tmp_path / "tiny-simulated-data"
    words = tiny.session(study, model, "one")
    first = started(words)
    try:
        until_showing(data, first)
        status, said = run_second(tiny.session(study, model, "two"), on_a_terminal)
        assert status in (2, 3)
        assert str(first.pid) in said and (said.count("\n") == 1 or on_a_terminal)
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
    assert [(session.code, session.status) for session in contents.sessions] == [("one", "interrupted")]
    assert [showing.complete for showing in contents.showings if showing.key == "trial/1"] == [False]
    assert [answer.key for answer in contents.answers] == ["practice/fms/fms"]


def test_a_session_is_resumed_on_a_day_before_it_began(tmp_path):
    """As after a machine's clock was mended: no onset is negative, and it is told."""
    study, model = tiny.write(tmp_path)
    tiny.ran(*tiny.session(study, model, "other"))
    with Store(tmp_path / "tiny-simulated-data", clock=SetClock()) as store:
        store._clock.instant += timedelta(days=365 * 70)
        design = load_design(str(study))
        session = store.begin(design, None, "one", SIMULATED)
        step = next(step for step in steps_of(design, session.order, session.part) if not isinstance(step, Show))
        store.finish_step(session, step.key)
        store.end(session, INTERRUPTED)
    said = tiny.program(*tiny.session(study, model, "one", "--resume"))
    assert said.returncode == 0, said.stderr
    assert "set back by" in said.stdout and "onsets count" in said.stdout
    with Store(tmp_path / "tiny-simulated-data") as store:
        contents = store.contents()
    mine = {session.id for session in contents.sessions if session.code == "one"}
    onsets = [showing.actual.get("onset_s") for showing in contents.showings if showing.session in mine]
    onsets = [onset for onset in onsets if onset is not None]  # a machine with other work shows no picture in 0.2 s
    assert onsets and 0 <= min(onsets) <= max(onsets) < 1000 and onsets == sorted(onsets)


@pytest.fixture
def nursery() -> Iterator[Nursery]:
    with Nursery() as made:
        yield made


@pytest.fixture
def small_disk(tmp_path) -> Iterator[Path]:
    """A disk of its own, of 64 KiB."""
    place = tmp_path / "disk"
    place.mkdir()
    if os.geteuid() != 0 or not shutil.which("mount"):
        pytest.skip(needs.missing("right to mount", needs.AS_ROOT))
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(place)], check=False, capture_output=True, text=True
    )
    if done.returncode:
        pytest.skip(needs.missing("right to mount", done.stderr.strip()))
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


@pytest.mark.slow(20)
def test_a_disk_that_is_full_in_mid_session(small_disk, nursery, tmp_path):
    """Half as much again each time.

    Every stop is told in one line, and in the end nothing that was confirmed is missing.
    """
    study, model = tiny.write(tmp_path)
    session = tiny.session(study, model, "person-1", "--store", str(small_disk / "data"))
    killed = Killed(tmp_path, 0, 0, codes=["person-1"], place=small_disk / "data")
    stops: list[str] = []
    for size_k in (96, 144, 216, 324, 486, 729, 1094, 1640, 8000, 8000):
        # The first is started as anybody starts it, the others have everything imported already.
        one = live(nursery if stops else Cold, [*session, *(["--resume"] if killed.status() else [])])
        killed.told += one.told
        if one.status == 0:
            break
        assert one.status == 3 and len(one.said.splitlines()) == 1, one.said
        assert "room" in one.said, one.said
        stops.append(one.said)
        subprocess.run(["mount", "-o", f"remount,size={size_k}k", str(small_disk)], check=True)
    assert len(stops) > 2 and any("--resume" in stop for stop in stops)
    assert faults(killed) == []


@pytest.mark.slow(15)
def test_a_folder_that_may_not_be_written(tmp_path):
    """Of what is there nothing is changed; what may be read may be exported."""
    study, model = tiny.write(tmp_path)
    data = tmp_path / "tiny-simulated-data"
    tiny.ran(*tiny.session(study, model, "one"))
    if (
        os.geteuid() != 0
        or subprocess.run(["mount", "--bind", data, data], check=False, capture_output=True).returncode
    ):
        pytest.skip(needs.missing("right to mount", needs.AS_ROOT))
    try:
        subprocess.run(["mount", "-o", "remount,ro,bind", data, data], check=True)
        before = (data / "study.sqlite3").read_bytes()
        done = tiny.program(*tiny.session(study, model, "two"))
        assert done.returncode in (2, 3) and done.stderr.count("\n") == 1 and str(data) in done.stderr
        assert (data / "study.sqlite3").read_bytes() == before
        tiny.ran("study", "export", study, "--out", tmp_path / "export", "--simulated", "--quiet")
    finally:
        subprocess.run(["umount", "-l", data], check=True)
