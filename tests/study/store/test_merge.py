"""Stores of several sites become one: nothing collides, is lost or is counted twice."""

from __future__ import annotations

import shutil
from pathlib import Path

import attrs
import pytest

from hmdwarp.errors import InputError
from hmdwarp.scenes import inputs_beside
from hmdwarp.study.export.export_rows import answer_rows, long_rows
from hmdwarp.study.store import COMPLETE, PILOT, SICK, Contents, Store, merge
from tests.study import tiny

from .sessions import TEXT, begun, design, go_through, whole

TRACE = "a head"


def site(folder: Path, *codes: str, value: float = 2.25) -> Path:
    """The store of a site where these people took part."""
    with Store(folder, create=True) as store:
        for code in codes:
            session = begun(store, code)
            go_through(store, session, value, f"{TRACE} of {code} at {folder.name}")
            store.end(session, COMPLETE)
    return folder


@pytest.fixture
def two(tmp_path) -> dict[str, Path]:
    """Two sites that used the same codes."""
    return {
        "berlin": site(tmp_path / "a", "P01", "P02", "P03", value=2.0),
        "paris": site(tmp_path / "b", "P01", "P02", value=4.0),
    }


def contents(folder: Path, **how) -> Contents:
    with Store(folder) as store:
        return store.contents(**how)


def told(found: Contents) -> dict[str, list]:
    """What was recorded of each person, by the random word, without ids."""
    of = {session.id: session for session in found.sessions}
    said: dict[str, list] = {
        session.sub: [attrs.evolve(session, id=0, code="", facts={})] for session in found.sessions
    }
    places = {one.id: place for place, one in enumerate(found.showings)}
    first = {sub: min(places[s.id] for s in found.showings if of[s.session].sub == sub) for sub in said}
    for showing in (*found.showings, *found.answers, *found.events):
        sub = of[showing.session].sub
        about = getattr(showing, "showing", None)
        place = None if about is None else places[about] - first[sub]
        plain = attrs.evolve(showing, id=0, session=0, **({"showing": place} if hasattr(showing, "showing") else {}))
        said[sub].append(plain)
    return said


def test_all_that_sites_recorded_is_there_once(two, tmp_path):
    acted = inputs_beside(two["paris"] / "traces" / contents(two["paris"]).showings[0].trace)
    acted.write_text("what somebody did")
    found = merge(two, tmp_path / "all")
    assert [(site.site, site.participants, site.sessions) for site in found] == [("berlin", 3, 3), ("paris", 2, 2)]
    merged = contents(tmp_path / "all")
    assert (tmp_path / "all" / "traces" / acted.name).read_text() == "what somebody did"
    assert told(merged) == {**told(contents(two["berlin"])), **told(contents(two["paris"]))}
    codes = ["berlin-P01", "berlin-P02", "berlin-P03", "paris-P01", "paris-P02"]
    assert [session.code for session in merged.sessions] == codes
    for showing in merged.showings:
        code = merged.session(showing.session).code
        place, name = code.split("-")
        assert (tmp_path / "all" / "traces" / showing.trace).read_text() == f"{TRACE} of {name} at {two[place].name}"
    assert (
        len(merged.answers)
        == sum(site.answers for site in found)
        == sum(len(contents(store).answers) for store in two.values())
    )


def test_tables_say_which_site_and_others_do_not(two, tmp_path):
    merge(two, tmp_path / "all")
    rows = long_rows(answer_rows(contents(tmp_path / "all"), design()))
    assert {(row["site"], row["value"]) for row in rows} == {("berlin", 2.0), ("paris", 4.0)}
    assert not any("site" in row for row in long_rows(answer_rows(contents(two["paris"]), design())))


def test_a_merged_store_is_a_store(two, tmp_path):
    """Sessions go on in it, people withdraw from it, and it is merged again."""
    merge(two, tmp_path / "all")
    taken = {session.row for session in contents(tmp_path / "all").sessions}
    with Store(tmp_path / "all") as store:
        assert begun(store, "P09").row not in taken  # of four orders, those that either site gave are held
        store.withdraw("paris-P02")
    assert "paris-P02" not in [session.code for session in contents(tmp_path / "all").sessions]
    merge({"europe": tmp_path / "all", "asia": site(tmp_path / "c", "P01")}, tmp_path / "more")
    merged = contents(tmp_path / "more")
    assert {"europe-berlin-P01", "asia-P01"} < {session.code for session in merged.sessions}
    assert {session.facts["site"] for session in merged.sessions} == {"europe-berlin", "europe-paris", "europe", "asia"}
    assert merged.withdrawn == 1
    with Store(tmp_path / "more") as store, pytest.raises(InputError, match="has withdrawn"):
        begun(store, "europe-paris-P02")


def test_a_merge_keeps_only_the_code_of_a_withdrawn_participant(two, tmp_path):
    with Store(two["paris"]) as store:
        store.withdraw("P01")
    merge(two, tmp_path / "all")
    merged = contents(tmp_path / "all")
    assert merged.withdrawn == 1 and "paris-P01" not in [session.code for session in merged.sessions]
    assert not any(b"P01 at b" in path.read_bytes() for path in (tmp_path / "all").rglob("*") if path.is_file())


def test_pilots_stay_apart_and_may_have_had_any_plan(two, tmp_path):
    with Store(two["paris"]) as store:
        other = design(TEXT.replace("latency = 800", "latency = 900"))
        store.end(store.begin(other, "one", "try", PILOT), SICK)
    merge(two, tmp_path / "all")
    assert [session.code for session in contents(tmp_path / "all", pilot=True).sessions] == ["paris-try"]


def test_a_cut_off_session_is_resumed(two, tmp_path):
    with Store(two["paris"]) as store:
        begun(store, "P03")
    merge(two, tmp_path / "all")
    with Store(tmp_path / "all") as store:
        assert store.resume("paris-P03").code == "paris-P03"


def refused(sites: dict[str, Path], out: Path) -> str:
    with pytest.raises(InputError) as found:
        merge(sites, out)
    return str(found.value)


def test_unmergeable_stores_are_refused_and_leave_nothing(two, tmp_path):
    out = tmp_path / "all"
    copy = tmp_path / "copy"
    shutil.copytree(two["berlin"], copy)
    with Store(tmp_path / "changed", create=True) as store:
        changed = design(TEXT.replace("latency = 800", "latency = 900"))
        store.end(store.begin(changed, "one", "P01", "person"), COMPLETE)
    with Store(tmp_path / "other", create=True) as store:
        store.end(store.begin(design(TEXT.replace('"late"', '"early"')), "one", "P01", "person"), COMPLETE)
    (tmp_path / "empty").mkdir()
    one = two["berlin"]
    said = {
        "two or more": {"berlin": one},
        "letters and digits": {"Köln": one, "paris": two["paris"]},
        "but for case": {"berlin": one, "Berlin": two["paris"]},
        "one folder is given for two sites": {"berlin": one, "paris": one},
        "is one a copy": {"berlin": one, "paris": copy},
        "another plan at paris than at berlin (conditions ('d' changed))": {
            "berlin": one,
            "paris": tmp_path / "changed",
        },
        "expected stores of one study": {"berlin": one, "paris": tmp_path / "other"},
        "holds no data": {"berlin": one, "paris": tmp_path / "empty"},
    }
    for words, sites in said.items():
        assert words in refused(sites, out)
        assert not out.exists()
    assert "exists" in refused(two, one)
    with Store(two["paris"]) as store:
        whole(store, "a-code-of-very-nearly-all-signs")
    assert "more than 32 signs" in refused(two, out)
    assert [path.name for path in tmp_path.iterdir() if "merging" in path.name or path == out] == []


def test_the_command(two, tmp_path):
    pairs = [f"{name}={folder}" for name, folder in two.items()]
    said = tiny.ran("study", "merge", *pairs, "--out", tmp_path / "all")
    assert "berlin: 3 participants, 3 sessions" in said and "store:" in said
    for wrong in (["berlin"], ["berlin=a", "berlin=b"]):
        done = tiny.program("study", "merge", *wrong, "--out", tmp_path / "none")
        assert done.returncode == 2 and len(done.stderr.strip().splitlines()) <= 2
