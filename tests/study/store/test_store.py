"""What is told is there, in order, once, as it was told; and what a store does not take.

Names, doubled codes, another study, a plan that became another: each in words that say what to do.
"""

from __future__ import annotations

import hashlib
import os
import re

import numpy as np
import pytest
from together import together

from hmdwarp.base import InputError
from hmdwarp.study.design import design_from_text, load_design
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
    admission,
    folder_to_read,
    store_folder,
)
from hmdwarp.study.store import records as json_
from hmdwarp.study.store.admission import plan_signature, signature_changes

from .sessions import TEXT, SetClock, asks, begun, design, go_through, shows, whole


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
    """No code, no clock and no chance. The same codes in another order of coming get the same rows
    by place; who comes again keeps a name that follows from nothing.
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


def test_an_interrupted_session_keeps_its_order(store):
    sessions = [store.end(begun(store, code), INTERRUPTED) for code in ("P1", "P2", "P3", "P4")]
    assert sorted(session.row for session in sessions) == [0, 1, 2, 3]


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


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    with Store(tmp_path_factory.mktemp("filled") / "data", create=True) as made:
        whole(made, "P01")
        yield made


NAMES = ["Anna Müller", "", "a" * 33, "P 1", "p.1", "../x", "P1\n", "Ä1", "-P1", "P٣", "P\udcff"]
REFUSED = [  # what is asked of a store with one whole session, that of P01; what is said
    *((lambda store, code=code: begun(store, code), "must not be a name") for code in NAMES),
    *((lambda store, code=code: store.would_begin(design(), "one", code, "person"), "must not be") for code in NAMES),
    (lambda store: begun(store, "P10", new_session=True), "P10 is not known here: leave out --new-session"),
    (lambda store: begun(store, "new", new_session=True), "--new-session needs the code"),
    (lambda store: begun(store, "P01", origin=PILOT, new_session=True), "P01 is a person here"),
    (lambda store: begun(store, "T1", origin=SIMULATED), "must not be mixed with them"),
    (lambda store: begun(store, "P2", part="three"), r"--part three is not in late\.toml: it has one, two"),
    (lambda store: begun(store, "P2", part=None), "--part is missing"),
    (
        lambda store: store.begin(design(TEXT.replace('"late"', '"later"')), "one", "P2", "person"),
        "holds the study 'late', not 'later'",
    ),
    (lambda store: Store(store.folder, study="x"), "holds the study 'late', not 'x'"),
    (lambda store: store.would_begin(design(), "one", "P01", "person"), "is known here"),
    (
        lambda store: begun(store, "p01"),
        r"session 1 of part 'one' complete\): --new-session begins another one; a diff",
    ),
    (lambda store: store.resume("P02"), "not known"),
    (lambda store: store.resume("P01"), "no interrupted session"),
    (lambda store: store.resume("a b"), "must not be a name"),
    (lambda store: store.withdraw("P9"), "P9 is not known here"),
]


@together("act, why", REFUSED)
def test_refusals_change_nothing(filled, act, why):
    before = filled.contents()
    with pytest.raises(InputError, match=why):
        act(filled)
    assert filled.contents() == before


def test_what_a_new_store_refuses_leaves_nothing_behind(store):
    for code, why in ((NAMES[0], "must not be a name"), ("P01", "leave out --new-session")):
        with pytest.raises(InputError, match=why):
            begun(store, code, new_session=True)
    with pytest.raises(InputError, match="holds no data of a study"):
        store.resume("P01")
    store.would_begin(design(), "one", "new", "person")
    store.would_begin(design(), "one", "P01", "person")
    assert not store.folder.exists()


def test_new_draws_a_code_that_is_read_without_doubt(store):
    codes = [begun(store, word).code for word in ("new", "NEW", "new")]
    assert len(set(codes)) == 3 and all(len(code) == 5 and not set(code) & set("0O1IL2Z5S9") for code in codes)


def test_a_known_code_is_refused_with_what_can_be_done(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        begun(store, "P01")
    with Store(tmp_path / "data", create=True) as store:
        told = r"session 1 of part 'one' interrupted\): --resume resumes it, --new-session begins"
        with pytest.raises(InputError, match=told):
            begun(store, "p01")
        store.end(store.resume("p01", facts={"hmdwarp": "next"}), COMPLETE)
        begin, interrupted, resume, _ = [(event.kind, event.data) for event in store.contents().events]
        assert (interrupted[0], resume) == ("interrupted", ("resume", {"hmdwarp": "next"}))
        consent = hashlib.sha256(b"You may stop at any time.").hexdigest()
        assert (begin[1]["consent_version"], begin[1]["consent_sha256"]) == ("1", consent)


CHANGES = [
    ("latency = 200", "latency = 250", "conditions ('b' changed)"),
    ('name = "d"', 'name = "e"', "conditions ('e' is new, 'd' is gone)"),
    ("seconds = 2\n", "seconds = 3\n", "seconds"),
    ("seed = 5", "seed = 6", "seed"),
    ('scales = ["grade"]', 'scales = ["acr"]', "scales"),
    ("[practice]\nseconds = 1", "[practice]\nseconds = 2", "practice"),
    ("stop_at = 15", "stop_at = 12", "sickness"),
    ("seconds = 2\n", 'seconds = 2\norder = "random"\n', "order"),
]


def test_a_plan_that_means_something_else_begins_no_session(store):
    whole(store, "P01")
    for number, (was, is_, told) in enumerate(CHANGES):
        changed = design(TEXT.replace(was, is_, 1))
        for begin in (store.begin, store.would_begin):
            with pytest.raises(InputError) as error:
                begin(changed, "one", "P02", "person")
            assert f"ran with another plan ({told})" in str(error.value) and "study of its own" in str(error.value)
        # Rehearsals are where a plan is changed.
        assert store.begin(changed, "one", f"T{number}", PILOT).plan == changed.text
    assert [session.code for session in store.contents().sessions] == ["P01"], "nothing came of the refused ones"


def test_harmless_changes_of_a_plan_are_kept_with_the_session(tmp_path):
    said: list[str] = []
    with Store(tmp_path / "data", create=True, say=said.append) as store:
        whole(store, "P01")
        assert not said
        mended = TEXT.replace("too late?", "too late for whom?").replace("[breaks]\nevery = 2", "[breaks]\nevery = 3")
        session = store.begin(design(mended), "one", "P02", "person")
        assert session.plan == mended and "both texts are kept" in said[0]
        assert store.contents().sessions[0].plan == TEXT
        before, two, after = mended.partition('name = "two"')
        other_part = before + two + after.replace('name = "a"', 'name = "z"')
        assert store.begin(design(other_part), "one", "P03", "person").plan == other_part


def test_orders_made_in_another_way_are_noticed(store, monkeypatch):
    """A later version of this program may make other orders from the same file."""
    whole(store, "P01")
    made = admission.rows_for
    monkeypatch.setattr(admission, "rows_for", lambda plan, part: made(plan, part)[::-1])
    with pytest.raises(InputError, match="another plan \\(the orders\\)"):
        begun(store, "P02")


def test_a_plan_is_the_same_from_another_working_folder_and_when_its_folder_was_moved(tmp_path, monkeypatch):
    text = TEXT.replace("[trial]", '[common]\nscene = "mine.glb"\n[trial]')
    monkeypatch.chdir(tmp_path)
    here, there, whole_path, elsewhere = (
        plan_signature(design_from_text(text, str(path), checked=False), "one")
        for path in ("s.toml", "moved/s.toml", tmp_path / "s.toml", tmp_path.parent / "s.toml")
    )
    assert here == there == whole_path == elsewhere and signature_changes(here, there) == []
    other = plan_signature(design_from_text(text.replace("mine.glb", "other/mine.glb"), "s.toml", checked=False), "one")
    assert signature_changes(here, other)
    swapped = {**here, "conditions": here["conditions"][::-1]}
    assert signature_changes(here, swapped) == ["conditions (in another order)"]


def test_an_impossible_place_is_refused_before_the_session(tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "paper.tex").write_text("x")
    for name, why in (("file", "cannot be created"), ("file/x", "file is not writable"), ("other", "something else")):
        with Store(tmp_path / name, create=True) as store, pytest.raises(InputError, match=why):
            store.would_begin(design(), "one", "P01", "person")
    with Store(tmp_path / "a" / "b" / "c", create=True) as store:
        store.would_begin(design(), "one", "P01", "person")
        assert begun(store).number == 1
