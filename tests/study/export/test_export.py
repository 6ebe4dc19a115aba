"""What holds for every export, of recorded studies of golden/; tables read back as they were."""

from __future__ import annotations

import csv
import io
import json
import re
import sys
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
import pytest
from commands import hmdwarp
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.base import InputError, MachineError
from hmdwarp.poses import PoseTrack
from hmdwarp.report import raw_text
from hmdwarp.study.design import Show, design_from_text, load_design, steps_of
from hmdwarp.study.export.write import (
    COLUMNS,
    FLAG,
    INTEGER,
    LONG_COLUMNS,
    MISSING,
    NUMBER,
    Column,
    ExportOptions,
    columns_for,
    csv_text,
    export,
    field_text,
    motion_json,
    motion_text,
    settings_row,
    tsv_text,
)
from hmdwarp.study.store import Store

from ..plans import text_of
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
    rates = motion_json(track, {}, {})
    assert rates["SamplingFrequency"] == pytest.approx(1e9 / np.median(steps))
    assert rates["SamplingFrequencyEffective"] == pytest.approx(399e9 / steps.sum())
    off = np.abs(steps / np.median(steps) - 1) > 0.05
    assert f"{off.mean():.1%} of the steps" in rates["SamplingDescription"] and 0 < off.mean() < 1
    assert f"longest is {steps.max() * 1e-9:.4f} s" in rates["SamplingDescription"]
    even = track.evolve(time_ns=np.arange(400) * 11_111_111, max_gap_ns=10**9)
    assert ": 0.0% of" in motion_json(even, {}, {})["SamplingDescription"]
    assert motion_text(even).splitlines()[1].startswith("0.011111\t")


HEADSET = {"runtime": "Monado", "runtime_version": "25.0.0", "headset": "Index"}


def test_a_session_resumed_elsewhere_names_what_led_the_head_then(store, design, tmp_path):
    """Interrupted at a mouse, resumed in a headset: the further trial's own."""
    cut = next(session for session in store.contents().sessions if session.status == "interrupted")
    code = next(session.code for session in store.contents().sessions if session.id == cut.id)
    session = store.resume(code, facts={"source": "openxr", "display": HEADSET})
    last = [showing for showing in store.contents().showings if showing.session == cut.id][-1]
    step = [step for step in steps_of(design, session.order, session.part) if isinstance(step, Show)][-1]
    showing = store.begin_showing(session, step, {})
    (store.traces / showing.trace).write_bytes((store.traces / last.trace).read_bytes())
    store.end_showing(session, showing, {}, complete=True)
    tree = export(store.contents(), design, tmp_path / "out").folder / f"bids/sub-{cut.sub}"
    sides = [json.loads(path.read_text("utf-8")) for path in sorted(tree.rglob("*_motion.json"))]
    named = {side["TrackingSystemName"] for side in sides}
    assert len(named) == 2 and "Index, by OpenXR runtime Monado 25.0.0" in named
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


VALUES = {
    NUMBER: st.floats(allow_nan=False, allow_infinity=False),
    INTEGER: st.integers(-(2**53), 2**53),
    FLAG: st.booleans(),
}
TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1).filter(
    lambda text: text != "n/a"
)
ROWS = st.lists(st.fixed_dictionaries({c.name: st.none() | VALUES.get(c.type, TEXTS) for c in COLUMNS}), max_size=4)


def read_table(text: str, columns: Sequence[Column], delimiter: str = ",") -> list[dict[str, Any]]:
    """Back to rows, by the types of the columns, by another reader than the program's own."""
    types = {column.name: column.type for column in columns}
    reader = csv.DictReader(io.StringIO(text, newline=""), delimiter=delimiter)
    return [{name: read_value(types[name], value) for name, value in row.items()} for row in reader]


def read_value(type_: str, text: str) -> Any:
    if text == MISSING:
        return None
    if type_ == FLAG:
        return {"true": True, "false": False}[text]
    if type_ in (NUMBER, INTEGER):
        return {NUMBER: float, INTEGER: int}[type_](text)
    begin = text[1:].lstrip()
    while begin.startswith("'"):
        begin = begin[1:].lstrip()
    blank = {*text[1 : len(text) - len(begin)]} & {"\t", "\r", "\n"}
    return text[1:] if text.startswith("'") and (blank or begin[:1] in tuple("=+-@＝＋－＠")) else text


@given(ROWS)
def test_a_table_as_csv_reads_back_as_it_was(rows):
    assert read_table(csv_text(rows, COLUMNS), COLUMNS) == rows


@given(ROWS)
def test_a_table_as_tsv_has_a_line_for_each_row_and_reads_back_but_for_white_space(rows):
    text = tsv_text(rows, COLUMNS)
    assert text.count("\n") == len(rows) + 1
    flat = [{k: (" ".join(v.split()) or None) if isinstance(v, str) else v for k, v in row.items()} for row in rows]
    for found, was in zip(read_table(text, COLUMNS, "\t"), flat, strict=True):
        assert found == was or "n/a" in was.values()  # white space around n/a makes it n/a


RUN = ["=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "\n=1", " =1", "'=1", "\uff1d1", "-", "--1"]
RUN += ["+", "=", "- blurred", "-1;=2", "-1e", "+.", "\u00a0=1", "''\t@x"]


@together("text", RUN)
def test_no_spreadsheet_runs_what_was_typed_and_it_reads_back(text):
    flat = " ".join(text.split())
    for made, delimiter, kept in ((csv_text, ",", text), (tsv_text, "\t", flat)):
        written = made([{"warp": text}], COLUMNS)
        _, cells = csv.reader(io.StringIO(written, newline=""), delimiter=delimiter)
        cell = cells[LONG_COLUMNS.index("warp")]
        assert cell.startswith("'") and cell[1:] == raw_text(cell) == kept


@together("text", ["-1", "+1.5", "-.5e-9", "-2.", "n/a", "it's", "'tis", "a=1", "1-2", "'"])
def test_numbers_and_other_texts_stay_as_they_are(text):
    assert csv_text([{"warp": text}], COLUMNS).splitlines()[1].split(",")[LONG_COLUMNS.index("warp")] == text
    assert raw_text(text) == text


def test_only_the_name_of_a_file_is_exported(tmp_path):
    (tmp_path / "delays.csv").write_text("delay_ms\n100\n", encoding="utf-8")
    text = text_of("small", ('scene = "planes"', f'scene = "planes"\ndelay_trace = "{tmp_path}/delays.csv"'))
    design = design_from_text(text, str(tmp_path / "s.toml"), checked=False)
    assert settings_row(design.parts[0].conditions[0].settings)["delay_trace"] == "delays.csv"


def test_a_table_has_jod_ratings_only_where_there_are_any():
    plain = [column.name for column in columns_for([{"measured_flip": 0.1}])]
    rated = [column.name for column in columns_for([{"measured_jod": 9.5, "measured_jod_s": 0.5}])]
    assert rated == [*plain, "measured_jod", "measured_jod_s"]
