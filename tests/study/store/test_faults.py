"""Full disks, folders that may not be written, damaged files, two at once, clocks set back.

For real, and nothing confirmed is lost.
"""

from __future__ import annotations

import functools
import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
from datetime import timedelta

import needs
import pytest

from hmdwarp.base import InputError, MachineError
from hmdwarp.study.store import COMPLETE, DATABASE, INTERRUPTED, Store

from .sessions import SetClock, answered, asks, begun, child, sql, whole


@functools.cache
def own_mounts() -> tuple[str, ...]:
    """What a program with mounts of its own is started by. Nothing of them is seen outside, and
    they go with it.
    """
    way = ("unshare", "-m") if os.geteuid() == 0 else ("unshare", "-rm")
    trial = [*way, "mount", "-t", "tmpfs", "none", "/mnt"]
    if shutil.which("unshare") and not subprocess.run(trial, capture_output=True, check=False).returncode:
        return way
    pytest.skip(needs.missing("right to mount", needs.AS_ROOT))


def test_a_full_disk_loses_nothing(tmp_path):
    """A disk of 600 kB, filled by somebody else's file in the middle of a session. Then that one
    goes away again.
    """
    code = """
import subprocess, errno
folder = Path(sys.argv[1])
folder.mkdir()
subprocess.run(["mount", "-t", "tmpfs", "-o", "size=600k", "none", str(folder)], check=True)
store, confirmed = Store(folder / "data", create=True), []
session = begun(store)
def fill():
    with (folder / "others").open("wb", buffering=0) as file:
        try:
            while file.write(bytes(4096)) == 4096: pass
        except OSError as error: assert error.errno == errno.ENOSPC
try:
    for k in range(100_000):
        store.answer(session, asks(session)[0], k, 1.0, "participant")
        confirmed.append(k)
        if k == 5: fill()
except Exception as error:
    told = [type(error).__name__, str(error)]
kept = [answer.value for answer in store.contents().answers]
(folder / "others").unlink()
store.answer(session, asks(session)[1], 7, 1.0, "participant")
store.close()
with Store(folder / "data") as again:
    again.resume("P01")
    print(json.dumps([told, confirmed, kept, [answer.value for answer in again.contents().answers]]))
"""
    (kind, message), confirmed, kept, after = json.loads(answered(code, tmp_path / "disk", before=own_mounts()))
    assert kind == "MachineError" and "no room is left" in message
    assert "everything that was confirmed is kept" in message
    assert len(confirmed) > 5 and kept == confirmed and after == [*confirmed, 7]


def test_a_disk_too_small_to_begin(tmp_path):
    """What was begun there is no store, and none that cannot be opened later."""
    code = """
import subprocess
out = []
for size in (4096, 8192, 20_000, 60_000):
    folder = Path(sys.argv[1]) / str(size)
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(folder)], check=True)
    try:
        with Store(folder / "data", create=True) as store: begun(store)
    except Exception as error: told = [type(error).__name__, str(error)]
    subprocess.run(["mount", "-o", "remount,size=2m", str(folder)], check=True)
    with Store(folder / "data", create=True) as store:
        begun(store)
        out.append([*told, len(store.contents().sessions)])
print(json.dumps(out))
"""
    for kind, message, sessions in json.loads(answered(code, tmp_path, before=own_mounts())):
        assert kind == "MachineError" and "make room" in message and str(tmp_path) in message, message
        assert sessions == 1


READ_ONLY = """
import subprocess
folder = sys.argv[1]
subprocess.run(["mount", "--bind", folder, folder], check=True)
subprocess.run(["mount", "-o", "remount,bind,ro", folder], check=True)
out = []
acts = [lambda s: len(s.contents().answers), lambda s: begun(s, "P02"), lambda s: s.resume("P01")]
for place in ("data", "new/data"):
    for act in (*acts, lambda s: s.withdraw("P01")):
        try:
            with Store(Path(folder) / place, create=True) as store: out.append(act(store))
        except Exception as error: out.append([type(error).__name__, str(error)])
print(json.dumps(out))
"""


def test_a_folder_that_may_only_be_read_is_read(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        whole(store, "P01")
        count = len(store.contents().answers)
    found, *refused = json.loads(answered(READ_ONLY, tmp_path, before=own_mounts()))
    assert found == count
    for number, (kind, message) in enumerate(refused):
        told = ["cannot", "choose another folder"] if number < 3 else [str(tmp_path / "new" / "data")]
        assert kind == "InputError" and all(each in message for each in told), message


def test_a_cut_off_session_on_a_read_only_disk_is_not_read_by_halves(tmp_path):
    """What is in the log beside the file would be missed. A copy is asked for, and the copy has it
    all.
    """
    code = """
with Store(Path(sys.argv[1]) / "data", create=True) as store:
    session = begun(store)
    for ask in asks(session): store.answer(session, ask, 2, 1.0, "participant")
    os._exit(0)
"""
    answered(code, tmp_path)
    (tmp_path / "data" / f"{DATABASE}-shm").unlink()  # readers make it anew where they may
    (kind, message), *_ = json.loads(answered(READ_ONLY, tmp_path, before=own_mounts()))
    assert kind == "MachineError" and "copy the folder" in message
    shutil.copytree(tmp_path / "data", tmp_path / "copy")
    with Store(tmp_path / "copy") as copy:
        assert len(copy.contents().answers) == len(asks(copy.contents().sessions[0]))


# --- files that are something else


def test_a_program_that_died_while_it_made_the_store(tmp_path):
    """An empty file, or an empty database: begun anew."""
    (tmp_path / DATABASE).touch()
    with Store(tmp_path, create=True) as store:
        begun(store)
    other = tmp_path / "other"
    other.mkdir()
    sql(other / DATABASE, "PRAGMA journal_mode = WAL")
    assert (other / DATABASE).stat().st_size
    with pytest.raises(InputError, match="holds no data of a study"):
        Store(other)
    with Store(other, create=True) as store:
        begun(store)


# --- two at once


def test_two_programs_at_once(tmp_path):
    """The second is told who the first is; when that one is killed, nothing is in the way."""
    code = """
store = Store(Path(sys.argv[1]), create=True)
begun(store)
null = subprocess.DEVNULL
helper = subprocess.Popen(["sleep", "3600"], stdin=null, stdout=null, stderr=null)
print(helper.pid, flush=True)
sys.stdin.read()
"""
    process = child(code, tmp_path / "data", stdin=subprocess.PIPE)
    helper = int(process.stdout.readline())
    acts = [lambda s: begun(s, "P02"), lambda s: s.resume("P01"), lambda s: s.withdraw("P01")]
    try:
        for act in (*acts, lambda s: s.measured(1, {})):
            with Store(tmp_path / "data", create=True) as store, pytest.raises(MachineError) as error:
                act(store)
            since = rf"since \d\d:\d\d on \d{{4}}-\d\d-\d\d, process {process.pid} on .+"
            assert re.search(rf"a session of this study is running already \({since}\)", str(error.value))
        with Store(tmp_path / "data") as store:
            assert store.contents().sessions[0].status == "running"
    finally:
        process.kill()
        process.communicate()
    with Store(tmp_path / "data") as store:
        assert store.resume("P01").status == "running"
        assert [event.kind for event in store.contents().events] == ["begin", "interrupted", "resume"]
        with Store(tmp_path / "data", create=True) as two, pytest.raises(MachineError, match="running already"):
            begun(two, "P02")  # in one program as well
    os.kill(helper, signal.SIGKILL)  # it lived on, and held nothing


def test_another_program_in_the_database_is_awaited_then_named(tmp_path, monkeypatch):
    monkeypatch.setattr("hmdwarp.study.store.database.BUSY_S", 0.05)
    with Store(tmp_path / "data", create=True) as store:
        session = begun(store)
        other = sqlite3.connect(tmp_path / "data" / DATABASE, isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(MachineError, match="another program holds it"):
            store.answer(session, asks(session)[0], 2, 1.0, "participant")
        other.close()
        assert store.answer(session, asks(session)[0], 2, 1.0, "participant").revision == 1


# --- time


def test_a_clock_set_back_is_reported_once_and_changes_no_order(tmp_path):
    said: list[str] = []
    clock = SetClock()
    with Store(tmp_path / "data", create=True, say=said.append, clock=clock) as store:
        session = begun(store)
        # It goes on by a second at each look: less than BACK_S, as where the network corrects it.
        clock.instant -= timedelta(seconds=1.6)
        store.answer(session, asks(session)[0], 2, 1.0, "participant")
        assert not said
        clock.instant -= timedelta(hours=2)
        for ask in asks(session)[1:4]:
            store.answer(session, ask, 3, 1.0, "participant")
        ended = store.end(session, COMPLETE)
        found = store.contents()
    assert len(said) == 1 and "set back by" in said[0] and "nothing is lost" in said[0]
    (back,) = [event for event in found.events if event.kind == "clock"]
    assert 7100 < back.data["back_s"] < 7200 and back.at_utc < back.data["before"]
    assert [answer.key for answer in found.answers] == [ask.key for ask in asks(session)[:4]]
    assert [event.mono_ns for event in found.events] == sorted(event.mono_ns for event in found.events)
    assert ended.ended_utc < ended.started_utc, "as the clock said; nothing is computed from it"


def test_what_passed_counts_by_the_steady_clock_within_a_run_and_never_backwards(tmp_path):
    clock, said = SetClock(), []
    with Store(tmp_path / "data", create=True, say=said.append, clock=clock) as store:
        session = begun(store)
        for ask, jump in zip(asks(session), (timedelta(hours=-2), timedelta(days=3), timedelta()), strict=False):
            clock.instant += jump
            store.answer(session, ask, 2, 1.0, "participant")
        assert store.passed_s(session) == 3.0  # a second an entry
        store.end(session, INTERRUPTED)
        clock.instant += timedelta(minutes=5)
        session = store.resume("P01")
        passed_s = store.passed_s(session)
        assert 304 < passed_s < 310 and not any("onsets" in line for line in said)
        store.end(session, INTERRUPTED)
        clock.instant -= timedelta(days=1)
        session = store.resume("P01")
        assert store.passed_s(session) == passed_s + 1 and "onsets count" in said[-1]


# --- the disk itself


@needs.programs("strace")
def test_an_answer_is_synced_before_the_call_returns(tmp_path):
    """Seen by what the program asks the system for. Between any two lines it prints there is a sync
    of the log.
    """
    trace = tmp_path / "calls"
    code = """
store = Store(Path(sys.argv[1]), create=True)
session = begun(store)
showing = store.begin_showing(session, shows(session)[0], {})
(store.traces / showing.trace).write_text("pose")
store.end_showing(session, showing, {}, True)
os.write(1, b"one ")
for ask in asks(session)[:5]:
    store.answer(session, ask, 2, 1.0, "participant")
    os.write(1, b"one ")
"""
    watched = ("strace", "-f", "-y", "-e", "trace=write,fsync,fdatasync", "-o", str(trace))
    if subprocess.run([*watched, "true"], capture_output=True, check=False).returncode:
        pytest.skip("strace may not look here")
    answered(code, tmp_path / "data", before=watched)
    parts = trace.read_text().split('"one "')
    assert len(parts) == 7
    for between in parts[1:-1]:
        synced = [line for line in between.splitlines() if "sync(" in line and f"{DATABASE}-wal" in line]
        assert synced, between
    creation = [line for line in parts[0].splitlines() if "fsync(" in line]
    synced = [line.split("<")[1].split(">")[0] for line in creation]
    folders = {str(path) for path in (tmp_path, tmp_path / "data", tmp_path / "data" / "traces")}
    assert folders <= set(synced), "what is new in folders too"
    trace = [path for path in synced if path.endswith("_trial-0_1.csv")]
    assert trace, "a head's trace, before its showing is said to be complete"
