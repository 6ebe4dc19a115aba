"""What is told is there, in order, once; what is asked for comes back as it was told."""

from __future__ import annotations

import os
import re
import sqlite3

import numpy as np
import pytest

from hmdwarp.errors import InputError
from hmdwarp.study.design import load_design
from hmdwarp.study.store import (
    COMPLETE,
    DATABASE,
    DECLINED,
    INTERRUPTED,
    PILOT,
    RUNNING,
    SIMULATED,
    STOPPED,
    UNCONSENTED,
    Store,
    folder_to_read,
    store_folder,
)
from hmdwarp.study.store import records as json_

from .sessions import SetClock, asks, begun, design, go_through, shows, whole


@pytest.fixture
def store(tmp_path):
    with Store(tmp_path / "data", create=True) as made:
        yield made


def test_a_whole_session_reads_back_as_stored(store, tmp_path):
    session = begun(store, facts={"gpu": "llvmpipe", "seed": 5})
    go_through(store, session, trace="time_ns\n1\n")
    store.record(session, "remark", text="ein Wörtchen")
    ended = store.end(session, COMPLETE)
    with Store(tmp_path / "data") as again:
        found = again.contents()
    assert found.name == "late" and found.sessions == (ended,) and found.withdrawn == 0
    assert (ended.code, ended.number, ended.part, ended.status, ended.origin) == ("P01", 1, "one", COMPLETE, "person")
    assert ended.plan == design().text and ended.facts == {"gpu": "llvmpipe", "seed": 5}
    assert [answer.key for answer in found.answers] == [step.key for step in asks(session)]
    assert {(answer.value, answer.seconds) for answer in found.answers} == {(2.25, 1.5)}
    shown = [(showing.key, showing.settings, showing.complete) for showing in found.showings]
    assert shown == [(step.key, step.condition.settings, True) for step in shows(session)]
    by_id = {showing.id: showing for showing in found.showings}
    assert all(by_id[answer.showing].trial == answer.trial for answer in found.answers)
    assert all((found.folder / "traces" / showing.trace).read_text() == "time_ns\n1\n" for showing in found.showings)
    kinds = [event.kind for event in found.events]
    assert kinds[0] == "begin" and kinds[-2:] == ["remark", "end"] and found.events[-2].data == {"text": "ein Wörtchen"}
    assert kinds.count("answer") == len(found.answers) and kinds.count("shown") == len(found.showings)
    assert [event.id for event in found.events] == sorted(event.id for event in found.events)


def test_names_of_traces_identify_no_one_and_are_of_traces_that_came_to_be(store):
    session = begun(store, "P17")
    paths = [store.path_for(session, step, 1).name for step in shows(session)]
    assert len(set(paths)) == len(paths)
    assert all(re.fullmatch(r"[a-z0-9]{12}_ses-1_trial-\d+_1\.csv", name) for name in paths)
    showing = store.end_showing(session, store.begin_showing(session, shows(session)[0], {}), {}, complete=False)
    assert showing.trace == "" and not showing.complete


def test_the_file_itself_refuses_a_doubled_rating(store):
    session = begun(store)
    store.answer(session, asks(session)[0], 3, 2.0, "participant")
    columns = "session, key, revision, phase, trial, scale, item, value, seconds, answered_by, at_utc"
    with pytest.raises(sqlite3.IntegrityError, match="UNIQUE"):
        store._db.execute(f"INSERT INTO answer ({columns}) SELECT {columns} FROM answer")


def test_what_no_session_can_be_told_is_a_fault_of_ours(store):
    session = begun(store)
    with pytest.raises(ValueError, match="nan"):
        store.answer(session, asks(session)[0], float("nan"), 1.0, "participant")
    for status, why in ((RUNNING, "running"), (DECLINED, "cannot end as 'declined'"), (UNCONSENTED, "'unconsented'")):
        with pytest.raises(ValueError, match=why):
            store.end(session, status)


def test_facts_take_the_numbers_of_numpy_and_no_infinity(store):
    facts = {"size": np.array([96, 120]), "rate": np.float32(90), "hole": float("nan"), "p": (1, {"q": float("inf")})}
    assert begun(store, facts=facts).facts == {"size": [96, 120], "rate": 90.0, "hole": None, "p": [1, {"q": None}]}
    with pytest.raises(TypeError, match="object"):
        json_.to_json({"what": object()})


def test_broken_terminal_input_does_not_break_a_session(store):
    session = begun(store)
    store.record(session, "remark", text="caf\udce9 \0 \N{GRINNING FACE}", **{"odd \udce9": 1})
    assert store.contents().events[-1].data == {"text": "caf? \0 \N{GRINNING FACE}", "odd ?": 1}
    assert store.end(session, STOPPED, "\udce9").why == "?"


def test_declining_is_a_status_and_may_be_revoked(store):
    session = begun(store, "P1")
    store.record(session, "refused", "consent", by="participant")
    assert store.end(session, DECLINED).status == DECLINED
    with pytest.raises(InputError, match="session 1 of part 'one' declined"):
        begun(store, "P1")
    session = begun(store, "P1", new_session=True)
    store.record(session, "refused", "consent", by="participant")
    store.end(session, INTERRUPTED)  # the program died before it could end the session
    session = store.resume("P1")
    store.finish_step(session, "consent")  # agreed, in the second run
    assert store.end(session, STOPPED).status == STOPPED
    # Older versions had no such status: the session ended as stopped, with the same journal.
    store._db.execute("UPDATE session SET status = 'stopped'")
    assert [session.status for session in store.contents().sessions] == [DECLINED, STOPPED]
    assert store._db.execute("SELECT DISTINCT status FROM session").fetchall() == [("stopped",)]


# --- who gets which order, and what name


def test_the_plan_alone_decides_the_orders_and_names_are_drawn(tmp_path):
    """No code, no clock and no chance.

    The same codes in another order of coming get the same rows by place; who comes again keeps a
    name that follows from nothing.
    """
    rows, subs = [], []
    for names in (["P1", "P2", "P3", "P4", "P5"], ["Z9", "x", "P1", "M-3", "q_4"]):
        with Store(tmp_path / names[0], create=True, clock=SetClock()) as store:
            sessions = [whole(store, name) for name in names]
            assert begun(store, names[0], "two", new_session=True).sub == sessions[0].sub
        rows.append([session.row for session in sessions])
        subs += [session.sub for session in sessions]
    assert rows[0] == rows[1]
    assert len(set(subs)) == 10 and all(re.fullmatch("[a-z0-9]{12}", sub) for sub in subs)


# --- measuring, reading


def test_measured_figures_are_added_and_free_the_lock(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        whole(store, "P01")
    with Store(tmp_path / "data") as store:
        showing = store.contents().showings[2]
        store.measured(showing.id, {"flicker": np.float64(0.25)})
        store.measured(showing.id, {"flicker": 0.5})
        assert store.contents().showings[2].measured == {"flicker": 0.5} and store.contents().showings[1].measured == {}
        with Store(tmp_path / "data") as other:
            begun(other, "P02")
        with pytest.raises(KeyError):
            store.measured(10_000, {})


def test_reading_asks_as_few_questions_of_many_sessions_as_of_one(store):
    counts = []
    for sessions in (1, 20):
        for k in range(sessions):
            whole(store, f"P{sessions}-{k}")
        asked: list[str] = []
        store._db.set_trace_callback(asked.append)
        store.contents()
        store._db.set_trace_callback(None)
        counts.append(len(asked))
    assert counts[0] == counts[1] < 12


# --- where


def test_data_lie_next_to_the_study_file_and_rehearsals_apart(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert store_folder(design(path="some/late.toml"), None).as_posix() == "some/late-data"
    assert store_folder(design(path="some/late.toml"), tmp_path / "x") == tmp_path / "x"
    assert store_folder(load_design("quick"), None).as_posix() == "quick-data"
    study = design(path=str(tmp_path / "late.toml"))
    assert store_folder(study, None, PILOT) == tmp_path / "late-pilot-data"
    for origin in (SIMULATED, "person"):  # neither stands in the other's way
        with Store(store_folder(study, None, origin), create=True) as store:
            whole(store, "P1", origin=origin)
    assert folder_to_read(study, None, SIMULATED) == tmp_path / "late-simulated-data"
    says = r"no data, pilot, of 'late' yet: .*late-data is read without --pilot; .*is read with --simulated"
    with pytest.raises(InputError, match=says):
        folder_to_read(study, None, PILOT)


def test_the_folder_and_all_in_it_are_their_owner_s_alone_also_where_they_were_there_before(tmp_path):
    data = tmp_path / "data"
    mask = os.umask(0)
    try:
        (data / "traces").mkdir(parents=True)
        with Store(data, create=True) as store:
            session = begun(store)
            showing = store.begin_showing(session, shows(session)[0], {})
            (store.traces / showing.trace).write_text("pose")
            store.end_showing(session, showing, {}, True)
            modes = {path.name: path.stat().st_mode & 0o777 for path in (data, *data.rglob("*"))}
            assert modes.pop("data") == modes.pop("traces") == 0o700
            assert {f"{DATABASE}-wal", f"{DATABASE}-shm", DATABASE, "lock", showing.trace} == {*modes}
            assert {*modes.values()} == {0o600}
        for path in (data, *data.rglob("*")):
            path.chmod(0o777)
        with Store(data) as store:
            store.resume("P01")
            assert not [path for path in (data, *data.rglob("*")) if path.stat().st_mode & 0o077]
    finally:
        os.umask(mask)
