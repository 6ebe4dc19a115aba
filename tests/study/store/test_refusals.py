"""What a store does not take: names, doubled codes, another study, a plan that became another.

Each in words that say what to do.
"""

from __future__ import annotations

import pytest
from together import together

from hmdwarp.errors import InputError
from hmdwarp.study.design import design_from_text
from hmdwarp.study.store import COMPLETE, PILOT, SIMULATED, Store
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
MENDED = TEXT.replace('name = "late"', 'name = "later"')
REFUSED = [  # what is asked of a store with one whole session, that of P01; what is said
    *((lambda store, code=code: begun(store, code), "must not be a name") for code in NAMES),
    *((lambda store, code=code: store.would_begin(design(), "one", code, "person"), "must not be") for code in NAMES),
    (lambda store: begun(store, "P10", new_session=True), "P10 is not known here: leave out --new-session"),
    (lambda store: begun(store, "new", new_session=True), "--new-session needs the code"),
    (lambda store: begun(store, "P01", origin=PILOT, new_session=True), "P01 is a person here"),
    (lambda store: begun(store, "T1", origin=SIMULATED), "must not be mixed with them"),
    (lambda store: begun(store, "P2", part="three"), r"--part three is not in late\.toml: it has one, two"),
    (lambda store: begun(store, "P2", part=None), "--part is missing"),
    (lambda store: store.begin(design(MENDED), "one", "P2", "person"), "holds the study 'late', not 'later'"),
    (lambda store: Store(store.folder, study="x"), "holds the study 'late', not 'x'"),
    (lambda store: store.would_begin(design(), "one", "P01", "person"), "is known here"),
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


@pytest.mark.parametrize("code", ["P01", "p01"])
def test_a_known_code_is_refused_with_what_can_be_done(tmp_path, code):
    with Store(tmp_path / "data", create=True) as store:
        begun(store, "P01")
    with Store(tmp_path / "data", create=True) as store:
        with pytest.raises(
            InputError, match=r"session 1 of part 'one' interrupted\): --resume resumes it, --new-session begins"
        ):
            begun(store, code)
        store.end(store.resume(code), COMPLETE)
        with pytest.raises(
            InputError, match=r"session 1 of part 'one' complete\): --new-session begins another"
        ) as error:
            begun(store, code)
        assert "--resume" not in str(error.value)
        assert len(store.contents().sessions) == 1
        assert begun(store, code, new_session=True).number == 2


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


@pytest.mark.parametrize(("was", "is_", "told"), CHANGES, ids=[told for *_, told in CHANGES])
def test_a_plan_that_means_something_else_begins_no_session(store, was, is_, told):
    whole(store, "P01")
    changed = design(TEXT.replace(was, is_, 1))
    with pytest.raises(InputError) as error:
        store.begin(changed, "one", "P02", "person")
    assert f"ran with another plan ({told})" in str(error.value) and "study of its own" in str(error.value)
    assert store.begin(changed, "one", "T1", PILOT).plan == changed.text, "rehearsals are where a plan is changed"
    assert [session.code for session in store.contents().sessions] == ["P01"], "nothing came of the refused one"


def test_harmless_changes_of_a_plan_are_kept_with_the_session(tmp_path):
    said: list[str] = []
    with Store(tmp_path / "data", create=True, say=said.append) as store:
        whole(store, "P01")
        assert not said
        mended = TEXT.replace("too late?", "too late for whom?").replace(
            "every = 2\nseconds = 1", "every = 3\nseconds = 9"
        )
        session = store.begin(design(mended), "one", "P02", "person")
        assert session.plan == mended and "both texts are kept" in said[0]
        assert store.contents().sessions[0].plan == TEXT
        before, two, after = mended.partition('name = "two"')
        other_part = before + two + after.replace('name = "a"', 'name = "z"')
        assert store.begin(design(other_part), "one", "P03", "person").plan == other_part


def test_an_interrupted_session_resumes_with_its_own_plan(tmp_path):
    with Store(tmp_path / "data", create=True) as store:
        began = begun(store)
    with Store(tmp_path / "data") as store:
        again = store.resume("P01", facts={"hmdwarp": "next"})
        assert (again.plan, again.order, again.id) == (TEXT, began.order, began.id)
        kinds = [(event.kind, event.data) for event in store.contents().events]
        assert [kind for kind, _ in kinds] == ["begin", "interrupted", "resume"] and kinds[-1][1] == {"hmdwarp": "next"}


def test_orders_made_in_another_way_are_noticed(store, monkeypatch):
    """A later version of this program may make other orders from the same file."""
    from hmdwarp.study.store import admission

    whole(store, "P01")
    made = admission.rows_for
    monkeypatch.setattr(admission, "rows_for", lambda plan, part: made(plan, part)[::-1])
    with pytest.raises(InputError, match="another plan \\(the orders\\)"):
        begun(store, "P02")


def test_meanings_of_one_text_agree():
    assert signature_changes(plan_signature(design(), "one"), plan_signature(design(), "one")) == []
    swapped = plan_signature(design(), "one")
    swapped["conditions"] = swapped["conditions"][::-1]
    assert signature_changes(plan_signature(design(), "one"), swapped) == ["conditions (in another order)"]


def test_a_plan_is_the_same_from_another_working_folder_and_when_its_folder_was_moved(tmp_path, monkeypatch):
    text = TEXT.replace("[trial]", '[common]\nscene = "mine.glb"\n[trial]')
    monkeypatch.chdir(tmp_path)
    here, there, whole_path, elsewhere = (
        plan_signature(design_from_text(text, str(path), checked=False), "one")
        for path in ("s.toml", "moved/s.toml", tmp_path / "s.toml", tmp_path.parent / "s.toml")
    )
    assert here == there == whole_path == elsewhere
    other = plan_signature(design_from_text(text.replace("mine.glb", "other/mine.glb"), "s.toml", checked=False), "one")
    assert signature_changes(here, other)


def test_the_text_agreed_to_is_known_by_its_hash(store):
    import hashlib

    begun(store)
    data = store.contents().events[0].data
    assert data["consent_version"] == "1"
    assert data["consent_sha256"] == hashlib.sha256(b"You may stop at any time.").hexdigest()


def test_a_trial_run_of_begin_changes_nothing(store):
    began = begun(store, "P01")
    store.would_begin(design(), "one", "P02", "person")
    store.would_begin(design(), "two", "P01", "person", new_session=True)
    with pytest.raises(InputError, match="another plan"):
        store.would_begin(design(TEXT.replace("latency = 200", "latency = 100")), "one", "P02", "person")
    assert store.contents().sessions == (began,)
    store.end(began, "interrupted")
    assert store.would_resume("P01").id == began.id and store.contents().sessions[0].status == "interrupted"


def test_an_impossible_place_is_refused_before_the_session(tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "paper.tex").write_text("x")
    for name, why in (
        ("file", "cannot be created"),
        ("file/below", "file is not writable"),
        ("other", "something else"),
    ):
        with Store(tmp_path / name, create=True) as store, pytest.raises(InputError, match=why):
            store.would_begin(design(), "one", "P01", "person")
    with Store(tmp_path / "a" / "b" / "c", create=True) as store:
        store.would_begin(design(), "one", "P01", "person")
        assert begun(store).number == 1
