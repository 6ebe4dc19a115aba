"""What a laboratory does to a session, through the real command: two at once, an end by signal.

Each time one clear line, nothing lost, and the session can be resumed.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import needs
import pytest

from hmdwarp.study.design import Show, load_design, steps_of
from hmdwarp.study.store import INTERRUPTED, SIMULATED, Store

from . import tiny
from .killing import Cold, Killed, Nursery, faults, live
from .store.sessions import SetClock

pytestmark = pytest.mark.slow


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
