"""After a withdrawal the export holds nothing of that person, whichever way it is looked at."""

import numpy as np
import pytest

from hmdwarp.poses import load_trace
from hmdwarp.study.export.export_rows import field_text
from hmdwarp.study.export.write import export


def bytes_of(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_no_byte_of_a_withdrawn_participant_remains_and_the_rest_is_as_before(store, design, tmp_path):
    contents = store.contents()
    session = next(session for session in contents.sessions if session.code == "Gamma-3")
    traces = [
        load_trace(store.traces / showing.trace).track for showing in contents.showings if showing.session == session.id
    ]
    numbers = {field_text(float(value)).encode() for track in traces for value in track.position_m.ravel()}
    assert len(numbers) == 4 * 40 * 3
    marks = {session.sub.encode(), *numbers}
    before = bytes_of(export(contents, design, tmp_path / "before").folder)
    assert all(mark in b"".join(before.values()) for mark in marks)

    store.withdraw("Gamma-3")
    after = bytes_of(export(store.contents(), design, tmp_path / "after").folder)
    for name, data in after.items():
        assert [mark for mark in marks if mark in data] == [], name
    assert b'"Count": 1' in after["bids/participants.json"]
    # But for the count, nothing tells that there was anybody: the rest is as it was.
    assert set(after) == {name for name in before if session.sub not in name}
    changed = {name for name in after if after[name] != before[name]}
    tables = {"bids/participants.tsv", "ratings.csv"}
    assert changed <= tables | {"README", "bids/README", "bids/participants.json", "ratings.parquet"}
    for name in tables:
        kept = [line for line in before[name].splitlines() if session.sub.encode() not in line]
        assert after[name].splitlines() == kept


def test_parquet_holds_nothing_that_a_search_for_bytes_does_not_see(store, design, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (pip install '.[study]')")
    out = export(store.contents(), design, tmp_path / "out").folder
    about = parquet.ParquetFile(out / "ratings.parquet").metadata
    groups = [about.row_group(0).column(k) for k in range(about.num_columns)]
    assert {group.compression for group in groups} == {"UNCOMPRESSED"}
    subs = {session.sub.encode() for session in store.contents().sessions}
    assert np.all([sub in (out / "ratings.parquet").read_bytes() for sub in subs])
