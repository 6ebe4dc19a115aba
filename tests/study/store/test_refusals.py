"""What a store does not take: names, doubled codes, another study, a plan that became another.

Each in words that say what to do.
"""

from __future__ import annotations

import hashlib

import pytest
from together import together

from hmdwarp.errors import InputError
from hmdwarp.study.design import design_from_text
from hmdwarp.study.store import COMPLETE, PILOT, SIMULATED, Store, admission
from hmdwarp.study.store.admission import plan_signature, signature_changes

from .sessions import TEXT, begun, design, whole


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    with Store(tmp_path_factory.mktemp("filled") / "data", create=True) as made:
        whole(made, "P01")
        yield made


@pytest.fixture
def store(tmp_path):
    with Store(tmp_path / "data", create=True) as made:
        yield made


NAMES = ["Anna Müller", "", "a" * 33, "P 1", "p.1", "../x", "P1\n", "Ä1", "-P1", "P٣"]
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


def test_of_several_interrupted_parts_one_is_named_and_of_one_none(store):
    store.end(begun(store, "P01", "one"), "interrupted")
    store.end(begun(store, "P01", "two", new_session=True), "interrupted")
    with pytest.raises(InputError, match="several parts.*--part"):
        store.resume("P01")
    assert store.resume("P01", "two").number == 2
    single = design(TEXT[: TEXT.index("[[part]]", TEXT.index('name = "one"'))])
    assert store.begin(single, None, "P02", "person").part == "one"


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
