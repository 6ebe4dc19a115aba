"""Who withdraws is gone. From what is read, from the bytes of every file, and after a kill in the
middle; the code alone stays.
"""

from __future__ import annotations

import contextlib
import signal
import struct
import sys

import pytest

from hmdwarp.base import HmdwarpError, InputError, MachineError
from hmdwarp.scenes import inputs_beside
from hmdwarp.study.store import COMPLETE, COPY, Store

from .sessions import TEXT, asks, begun, child, go_through, whole

REMARK = "Zwölf Xylophone quietschen: {}"
RATING = 3.0625 + 2.0**-30  # a double whose eight bytes are nowhere else by chance
POSE = "0.7342918{}"


def told_of(number: int) -> list[bytes]:
    """What only participant P<number> left. The remark (in the row, in the event and as JSON), the
    rating as SQLite has it, the pose.
    """
    return [REMARK.format(number).encode(), struct.pack(">d", RATING + number), POSE.format(number).encode()]


def filled(store: Store, numbers: range) -> list[str]:
    """Whole sessions with all that; the subs. A question is asked again, a session is interrupted
    and gone on with.
    """
    subs = []
    for number in numbers:
        session = begun(store, f"P{number}", facts={"headset": f"of {REMARK.format(number)}"})
        go_through(store, session, RATING + number, POSE.format(number) * 500)
        store.answer(session, asks(session)[0], 1.0, 1.0, "participant")
        for _ in range(12):
            store.record(session, "remark", text=REMARK.format(number))
        store.end(session, "interrupted", REMARK.format(number))
        store.end(store.resume(f"P{number}"), COMPLETE)
        subs.append(session.sub)
    return subs


def everything(folder) -> bytes:
    """The bytes of all files, and their names."""
    return b"\n".join(
        path.name.encode() + b":" + (path.read_bytes() if path.is_file() else b"") for path in sorted(folder.rglob("*"))
    )


def test_the_bytes_hold_nothing_of_who_withdrew_and_all_of_the_others(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        subs = filled(store, range(5))
        before = store.contents()
        marks = {number: [*told_of(number), sub.encode()] for number, sub in enumerate(subs)}
        acted = next(store.traces.glob(f"*{subs[2]}*"))
        inputs_beside(acted).write_text("what P2 did")  # no trace, and erased with it
        marks[2].append(b"what P2 did")
        (store.traces / f".{subs[2]}_ses-1_trial-9_1.csv.a1b2.part").write_text("half a trace")
        (tmp_path / "elsewhere").write_text("mine")
        (store.traces / f"{subs[2]}_link").symlink_to(tmp_path / "elsewhere")
        size = acted.stat().st_size
        (tmp_path / "second").hardlink_to(acted)
        (tmp_path / "third").hardlink_to(tmp_path / "data" / COPY)
        (tmp_path / "data" / f".{COPY}.part").write_bytes(subs[2].encode())  # of a program that died
        data = everything(tmp_path / "data")
        assert all(mark in data for each in marks.values() for mark in each), "the test looks for what is there"
        erased = store.withdraw("P2")
        assert "1 session, " in erased.describe() and "head traces" in erased.describe()
        for when in ("while it is open", "closed"):
            data = everything(tmp_path / "data")
            assert not [mark for mark in marks[2] if mark in data], when
            store.close()
        assert not [mark for number in (0, 1, 3, 4) for mark in marks[number] if mark not in data]
    assert (tmp_path / "elsewhere").read_text() == "mine", "a link is not followed"
    assert (tmp_path / "second").read_bytes() == bytes(size), "traces are overwritten before they go"
    assert not any((tmp_path / "third").read_bytes()), "and so is the store's copy"
    with Store(tmp_path / "data") as store:
        after = store.contents()
        gone = next(session.id for session in before.sessions if session.code == "P2")
        assert after.withdrawn == 1
        assert after.sessions == tuple(session for session in before.sessions if session.id != gone)
        for name in ("answers", "showings", "events"):
            assert getattr(after, name) == tuple(row for row in getattr(before, name) if row.session != gone)
        assert len(list(store.traces.iterdir())) == len(after.showings)


def test_the_tombstone_is_the_code_alone(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        filled(store, range(1))
        store.withdraw("p0")
        assert store._db.execute("SELECT * FROM withdrawn").fetchall() == [("P0", 1)]
        for table in ("participant", "session", "answer", "showing", "event", "plan"):
            assert store._db.execute(f"SELECT count(*) FROM {table}").fetchone() == (0,)
        for act, why in (
            (store.withdraw, "has withdrawn already"),
            (store.holdings, "has withdrawn already"),
            (lambda code: begun(store, code), "codes are not reused"),
            (store.resume, "nothing to resume"),
        ):
            with pytest.raises(InputError, match=why):
                act("P0")


def test_a_reader_that_keeps_the_old_bytes_is_named_and_the_rest_goes_later(tmp_path, monkeypatch):
    monkeypatch.setattr("hmdwarp.study.store.database.BUSY_S", 0.1)
    with Store(tmp_path / "data", create=True) as store:
        subs = filled(store, range(2))
        with Store(tmp_path / "data") as reader:
            reader._db.execute("BEGIN")
            reader._db.execute("SELECT count(*) FROM answer").fetchone()
            with pytest.raises(MachineError, match="another program reads"):
                store.withdraw("P0")
            codes = [session.code for session in store.contents().sessions]
            assert codes == ["P1"], "nobody reads them any more in any case"
            reader._db.execute("ROLLBACK")
    said: list[str] = []
    with Store(tmp_path / "data", say=said.append) as store:
        assert store.withdraw("P0") is None
        assert "was interrupted" in said[0]
        assert subs[0].encode() not in everything(tmp_path / "data")


def test_a_file_that_still_holds_something_is_no_success(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        subs = filled(store, range(1))
        (tmp_path / "data" / "traces" / "notes").write_text(f"{subs[0]} was tired")
        with pytest.raises(HmdwarpError, match="notes: still holds"):
            store.withdraw("P0")


KILLED = """
import importlib
erasing = importlib.import_module("hmdwarp.study.store.erasing")
name, count = sys.argv[2], int(sys.argv[3])
real = getattr(erasing, name)
def die(*words):
    global count
    count -= 1
    if count < 0: os.kill(os.getpid(), 9)
    return real(*words)
setattr(erasing, name, die)
with Store(Path(sys.argv[1])) as store: store.withdraw("P1")
"""
MOMENTS = [
    ("_erase_traces", 0), ("overwrite", 0), ("overwrite", 2), ("_erase_rows", 0), ("_clean", 0), ("erase_copies", 0),
    ("_empty_log", 0), ("_empty_log", 1), ("_check_bytes", 0),
]  # fmt: skip


@pytest.mark.parametrize(("step", "count"), MOMENTS)
def test_killed_before_each_step(tmp_path, step, count):
    """Nobody reads them from then on, and the next one who writes finishes it."""
    folder = tmp_path / "data"
    with Store(folder, create=True) as store:
        subs = filled(store, range(3))
    process = child(KILLED, folder, step, count)
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGKILL
    with Store(folder) as store:
        assert [session.code for session in store.contents().sessions] == ["P0", "P2"]
        with contextlib.suppress(InputError):
            store.withdraw("P1")
        assert [session.code for session in store.contents().sessions] == ["P0", "P2"]
        assert store.contents().withdrawn == 1
        assert begun(store, "P7").row in range(4)
    data = everything(folder)
    assert not [mark for mark in (subs[1].encode(), *told_of(1)) if mark in data]
    assert not [mark for number in (0, 2) for mark in told_of(number) if mark not in data]


# --- as typed; what is refused, and pilots: golden/ratings


@pytest.fixture
def study(tmp_path):
    """A study's file with two participants' data beside it."""
    (tmp_path / "late.toml").write_text(TEXT, encoding="utf-8")
    with Store(tmp_path / "late-data", create=True) as store:
        for code in ("P01", "P02"):
            whole(store, code)
    return tmp_path / "late.toml"


@pytest.mark.filterwarnings(
    "ignore:This process .* is multi-threaded:DeprecationWarning"
)  # of pexpect's fork, where a test left threads
@pytest.mark.parametrize(
    ("answer", "left", "told"), [("y", ["P02"], "has withdrawn; erased"), ("n", ["P01", "P02"], "Nothing was")]
)
def test_it_asks_on_a_terminal(study, answer, left, told):
    pexpect = pytest.importorskip("pexpect")
    words = ["-m", "hmdwarp", "study", "withdraw", str(study), "p01"]
    screen = pexpect.spawn(sys.executable, words, encoding="utf-8", timeout=120, dimensions=(24, 200))
    screen.expect("Participant P01 in .*: 1 session, .*revisions included.*Exports call .*Erase it for good.*: ")
    screen.sendline(answer)
    screen.expect(told)
    screen.expect(pexpect.EOF)
    screen.close()
    with Store(study.with_name("late-data")) as store:
        assert screen.exitstatus == 0 and [session.code for session in store.contents().sessions] == left
