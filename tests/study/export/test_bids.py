"""What holds for every export, of the recorded studies of golden/."""

from __future__ import annotations

import csv
import json
import re
import sys

import attrs
import numpy as np
import pytest
from commands import hmdwarp
from together import together

from hmdwarp.errors import InputError, MachineError
from hmdwarp.poses import PoseTrack
from hmdwarp.study.design import design_from_text, load_design
from hmdwarp.study.export.export_rows import field_text
from hmdwarp.study.export.write import ExportOptions, Rates, TrackingSystem, export, motion_text
from hmdwarp.study.store import PERSON, PILOT, Store

from ..test_golden import GOLDEN, restored

RATINGS = GOLDEN / "ratings"
TEXT = (RATINGS / "study.toml").read_text(encoding="utf-8")
parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (pip install '.[study]')")


@pytest.fixture(scope="module")
def design():
    return load_design(str(RATINGS / "study.toml"))


@pytest.fixture
def store(tmp_path):
    with Store(restored(RATINGS, tmp_path / "data")) as made:
        yield made


@pytest.fixture(scope="module", params=sorted(GOLDEN.glob("*/")), ids=lambda folder: folder.name)
def made(request, tmp_path_factory):
    """What `study export` makes of a recorded study."""
    folder = tmp_path_factory.mktemp("made")
    out, data = folder / "out", restored(request.param, folder / "data")
    out.mkdir(mode=0o755)
    assert hmdwarp("study", "export", request.param / "study.toml", "--store", data, "--out", out).returncode == 0
    return out


def files(folder) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_validator_of_others_takes_every_name(made):
    why = "bids_validator is not installed (pip install bids_validator)"
    validator = pytest.importorskip("bids_validator", reason=why).BIDSValidator()
    for name in files(made / "bids"):
        assert validator.is_bids(f"/{name}"), name


def test_every_column_of_every_table_is_in_its_sidecar(made):
    tables = [path for path in made.rglob("*.tsv") if not path.name.endswith(("_motion.tsv", "_channels.tsv"))]
    assert tables
    for path in tables:
        columns, *lines = path.read_text(encoding="utf-8").splitlines()
        side = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        names = columns.split("\t")
        assert [name for name in names if name != "participant_id" and "Description" not in side.get(name, {})] == []
        assert all(line.count("\t") == len(names) - 1 and "\t\t" not in line for line in lines)


def test_no_date_code_or_remark_is_in_any_byte_and_the_export_is_for_its_owner_alone(made):
    """The stores' clocks say 2031-07-23, from 16:41 on; remarks and traces name Maria."""
    for name, data in files(made).items():
        found = re.search(rb"2031-0|\b1[67]:[0-5]\d\b|Maria|secret-of|\bP\d\b", name.encode() + b"\n" + data)
        assert found is None, (name, found)
    modes = {(path.is_dir(), path.stat().st_mode & 0o777) for path in (made, *made.rglob("*"))}
    assert modes == {(True, 0o700), (False, 0o600)}
    assert "apostrophe" in (made / "README").read_text()


def test_both_tables_say_the_same_and_parquet_can_be_searched(made):
    with (made / "ratings.csv").open(encoding="utf-8", newline="") as file:
        comma = list(csv.DictReader(file))
    table = parquet.read_table(made / "ratings.parquet")
    assert [[field_text(v) for v in row.values()] for row in table.to_pylist()] == [list(row.values()) for row in comma]
    assert table.schema.field("value").type == "double" and table.schema.field("trial").type == "int64"
    assert table.schema.field("latency_ms").metadata[b"units"] == b"ms" and table.schema.metadata[b"title"]
    group = parquet.ParquetFile(made / "ratings.parquet").metadata.row_group(0)
    assert {group.column(k).compression for k in range(group.num_columns)} == {"UNCOMPRESSED"}
    subs = {row["participant"].encode() for row in comma}
    assert all(sub in (made / "ratings.parquet").read_bytes() for sub in subs)


def test_rates_tell_how_uneven_samples_are():
    steps = np.random.default_rng(1).integers(10_500_000, 11_700_000, 399)
    track = PoseTrack(np.concatenate([[0], np.cumsum(steps)]), np.zeros((400, 3)), np.tile([0.0, 0, 0, 1], (400, 1)))
    rates = Rates.of(track)
    assert rates.nominal_hz == pytest.approx(1e9 / np.median(steps))
    assert rates.effective_hz == pytest.approx(399e9 / steps.sum())
    # Steps are even between 10.5 and 11.7 ms: one tenth of that range lies more than 0.555 ms from
    # its middle, half of it on either side.
    assert 0.02 < rates.uneven < 0.15
    even = track.evolve(time_ns=np.arange(400) * 11_111_111, max_gap_ns=10**9)
    assert Rates.of(even).uneven == 0 and "0.0%" in Rates.of(even).describe()
    assert motion_text(even).splitlines()[1].startswith("0.011111\t")


HEADSET = {"runtime": "Monado", "runtime_version": "25.0.0", "headset": "Index"}
REPLAYED = "head trace, replayed"
LED = [  # facts of a session; label, name, model
    ({"source": "desktop", "headset": "rift-dk1"}, ("mouse", "mouse and keyboard of a desktop window", "")),
    ({"source": "desktop", "headset": "rift-dk1", "trace": "secret.csv"}, ("trace", REPLAYED, "")),
    (
        {"source": "offscreen", "trace": "secret.csv", "trace_axes": "unity (..), assumed"},
        ("trace", f"{REPLAYED}; its axes: unity (..), assumed", ""),
    ),
    (
        {"source": "openxr", "headset": "Index", "display": HEADSET},
        ("hmd", "Index, by OpenXR runtime Monado 25.0.0", "Index"),
    ),
    ({"headset": "rift-dk1"}, ("unknown", "not recorded", "")),
]


@together("facts, wanted", LED)
def test_the_tracking_system_is_named_not_the_emulated_headset(facts, wanted):
    assert attrs.astuple(TrackingSystem.of(facts)) == wanted


def test_a_session_resumed_elsewhere_names_what_led_the_head_then(store, design, tmp_path):
    """Interrupted at a mouse, resumed in a headset: the further trial's own."""
    cut = next(session for session in store.contents().sessions if session.status == "interrupted")
    code = next(session.code for session in store.contents().sessions if session.id == cut.id)
    session = store.resume(code, facts={"source": "openxr", "display": HEADSET})
    last = [showing for showing in store.contents().showings if showing.session == cut.id][-1]
    from hmdwarp.study.design import Show, steps_of

    step = [step for step in steps_of(design, session.order, session.part) if isinstance(step, Show)][-1]
    showing = store.begin_showing(session, step, {})
    (store.traces / showing.trace).write_bytes((store.traces / last.trace).read_bytes())
    store.end_showing(session, showing, {}, complete=True)
    tree = export(store.contents(), design, tmp_path / "out").folder / f"bids/sub-{cut.sub}"
    sides = [json.loads(path.read_text("utf-8")) for path in sorted(tree.rglob("*_motion.json"))]
    named = {side["TrackingSystemName"] for side in sides}
    assert len(named) == 2 and LED[3][1][1] in named
    assert {side["ManufacturersModelName"] for side in sides} == {"n/a", "Index"}


def test_without_pyarrow_the_rest_is_written_and_the_words_say_so(store, design, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    made = export(store.contents(), design, tmp_path / "out")
    assert not (made.folder / "ratings.parquet").exists() and (made.folder / "ratings.csv").exists()
    assert any("pip install '.[study]'" in text for text in made.notes)
    with pytest.raises(MachineError, match="pyarrow"):
        export(store.contents(), design, tmp_path / "other", ExportOptions(parquet=True))
    assert not (tmp_path / "other").exists()


def test_people_and_pilots_never_stand_in_one_table(store, design, tmp_path):
    found = {}
    mixed = attrs.evolve(store.contents(), sessions=(*store.contents().sessions, *store.contents(pilot=True).sessions))
    for contents, origin in ((store.contents(pilot=True), PILOT), (store.contents(), PERSON), (mixed, PERSON)):
        out = export(contents, design, tmp_path / str(len(found)), ExportOptions(origin=origin)).folder
        found[len(found)] = (out / "ratings.csv").read_text(encoding="utf-8")
        with (out / "ratings.csv").open(encoding="utf-8", newline="") as file:
            assert {row["origin"] for row in csv.DictReader(file)} == {origin}
    assert found[1] == found[2] != found[0]


def test_no_byte_of_a_withdrawn_participant_remains_and_the_rest_is_as_before(store, design, tmp_path):
    """A forced export removes older versions' files too, which wrote more."""
    session = next(session for session in store.contents().sessions if session.code == "P5")
    mark, out = session.sub.encode(), tmp_path / "out"
    before = files(export(store.contents(), design, out).folder)
    assert mark in b"".join(before.values())
    (out / "sessions").mkdir()
    for name in ("ratings.tsv", "ratings_short.csv", f"sessions/{session.sub}_ses-01.csv", "remarks.csv"):
        (out / name).write_text(session.sub, encoding="utf-8")
    store.withdraw("P5")
    after = files(export(store.contents(), design, out, ExportOptions(force=True)).folder)
    assert not [name for name, data in after.items() if mark in name.encode() + data]
    # But for the count, nothing tells that there was anybody: the rest is as it was.
    assert set(after) == {name for name in before if session.sub not in name}
    tables = {"bids/participants.tsv", "ratings.csv"}
    changed = {name for name in after if after[name] != before[name]}
    assert changed <= tables | {"README", "bids/README", "bids/participants.json", "ratings.parquet"}
    for name in tables:
        kept = [line for line in before[name].splitlines() if mark not in line]
        assert after[name].splitlines() == kept
    assert b'"Count": 1' in after["bids/participants.json"]


def test_another_plan_is_refused(store, design, tmp_path):
    contents = store.contents()
    other = design_from_text(TEXT.replace('"warped"', '"renamed"'), "late.toml")
    with pytest.raises(InputError, match="this plan lacks"):
        export(contents, other, tmp_path / "out")
    old = attrs.evolve(contents.sessions[0], plan=f"{TEXT}\n[gone]\ncount = 3\n", facts={"hmdwarp": "0.2.0"})
    with pytest.raises(InputError, match=r"unknown key .*gone.*export it with hmdwarp 0\.2\.0, which ran it"):
        export(attrs.evolve(contents, sessions=(old, *contents.sessions[1:])), design, tmp_path / "out")
    (tmp_path / "old.toml").write_text(old.plan, encoding="utf-8")
    with pytest.raises(InputError, match=r"old\.toml:.*gone.*hmdwarp 0\.2 ran with this plan"):
        load_design(str(tmp_path / "old.toml"), checked=False)
    assert not (tmp_path / "out").exists()


def test_a_plan_that_was_changed_later_does_not_change_what_was_shown_and_asked(store, design, tmp_path):
    before = files(export(store.contents(), design, tmp_path / "before").folder)
    text = TEXT.replace("latency = 400", "latency = 700").replace('"grade"', '"acr"').replace('"vrsq"', '"ssq"')
    made = export(store.contents(), design_from_text(text, "late.toml"), tmp_path / "after")
    after = files(made.folder)
    for name in before:
        assert before[name] == after[name] or not name.endswith(("ratings.csv", "_beh.tsv")), name
    told = json.loads(after["columns.json"])
    assert told["scale"]["Levels"]["grade"].startswith("School grade")
    assert "changed after" in " ".join(made.notes)
