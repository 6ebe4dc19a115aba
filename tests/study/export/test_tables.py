"""The tables.

What they hold, that they read back as they were, and that no nasty value breaks them.
"""

import csv
import io
import json
import locale

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.errors import InputError, MachineError
from hmdwarp.report import inert_text, raw_text
from hmdwarp.study.design import design_from_text, load_design
from hmdwarp.study.export.export_rows import (
    COLUMNS,
    FLAG,
    INTEGER,
    LONG_COLUMNS,
    NUMBER,
    csv_text,
    field_text,
    tsv_text,
)
from hmdwarp.study.export.write import ExportOptions, export
from hmdwarp.study.store import PILOT

from ..made_up import LATE_OR_WARPED as TEXT
from .reading import read_table

VALUES = {
    NUMBER: st.floats(allow_nan=False, allow_infinity=False),
    INTEGER: st.integers(-(2**53), 2**53),
    FLAG: st.booleans(),
}
TEXTS = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), min_size=1).filter(
    lambda text: text != "n/a"
)
ROW = st.fixed_dictionaries({c.name: st.none() | VALUES.get(c.type, TEXTS) for c in COLUMNS})


@given(st.lists(ROW, max_size=4))
def test_a_table_as_csv_reads_back_as_it_was(rows):
    assert read_table(csv_text(rows, COLUMNS), COLUMNS) == rows


@given(st.lists(ROW, max_size=4))
def test_a_table_as_tsv_has_a_line_for_each_row_and_reads_back_but_for_white_space(rows):
    text = tsv_text(rows, COLUMNS)
    assert text.count("\n") == len(rows) + 1
    flat = [{k: (" ".join(v.split()) or None) if isinstance(v, str) else v for k, v in row.items()} for row in rows]
    kept = [row for row in flat if "n/a" not in row.values()]  # white space around n/a makes it n/a
    assert [
        row for row, was in zip(read_table(text, COLUMNS, "\t"), flat, strict=True) if "n/a" not in was.values()
    ] == kept


@pytest.mark.parametrize(
    "text",
    [
        *(
            "=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "\n=1", " =1", "'=1", "\uff1d1", "-",
            "--1", "+",
        ),
        *("=", "- blurred", "-1;=2", "-1e", "+.", "\u00a0=1", "''\t@x"),
    ],
)  # fmt: skip
def test_no_spreadsheet_runs_what_was_typed_and_it_reads_back(text):
    flat = " ".join(text.split())
    for made, delimiter, kept in ((csv_text, ",", text), (tsv_text, "\t", flat)):
        written = made([{"warp": text}], COLUMNS)
        _, cells = csv.reader(io.StringIO(written, newline=""), delimiter=delimiter)
        cell = cells[LONG_COLUMNS.index("warp")]
        assert cell.startswith("'") and cell[1:] == raw_text(cell) == kept


@pytest.mark.parametrize("text", ["-1", "+1.5", "-.5e-9", "-2.", "n/a", "it's", "'tis", "a=1", "1-2", "'"])
def test_numbers_and_other_texts_stay_as_they_are(text):
    assert csv_text([{"warp": text}], COLUMNS).splitlines()[1].split(",")[LONG_COLUMNS.index("warp")] == text
    assert raw_text(text) == text


@given(st.text(st.sampled_from("'=+-@ \t\r1a＝"), max_size=6))
def test_a_text_made_inert_has_one_text_that_it_comes_from(text):
    assert raw_text(inert_text(text)) == text


def test_points_are_points_whatever_the_locale():
    before = locale.setlocale(locale.LC_ALL)
    try:
        for name in ("de_DE.UTF-8", "de_DE", "C"):
            try:
                locale.setlocale(locale.LC_ALL, name)
            except locale.Error:
                continue
            assert [field_text(value) for value in (1.25, 2.0, -0.5, 1e-9)] == ["1.25", "2", "-0.5", "1e-09"]
            assert [field_text(value) for value in (None, "", True, False)] == ["n/a", "n/a", "true", "false"]
    finally:
        locale.setlocale(locale.LC_ALL, before)


def test_only_the_name_of_a_file_is_exported(tmp_path):
    (tmp_path / "delays.csv").write_text("delay_ms\n100\n", encoding="utf-8")
    text = TEXT.replace('scene = "planes"', f'scene = "planes"\ndelay_trace = "{tmp_path}/delays.csv"')
    from hmdwarp.study.export.export_rows import settings_row

    row = settings_row(design_from_text(text, str(tmp_path / "s.toml"), checked=False).parts[0].conditions[0].settings)
    assert row["delay_trace"] == "delays.csv"


def answers(out):
    """The files of all answers of each session."""
    return sorted(out.glob("bids/sub-*/ses-*/beh/*_beh.tsv"))


def read(path, delimiter):
    return list(csv.DictReader(io.StringIO(path.read_bytes().decode(), newline=""), delimiter=delimiter))


def test_both_tables_say_the_same(store, design, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (pip install '.[study]')")
    out = export(store.contents(), design, tmp_path / "out").folder
    comma = read(out / "ratings.csv", ",")
    table = parquet.read_table(out / "ratings.parquet")
    assert [[field_text(v) for v in row.values()] for row in table.to_pylist()] == [list(row.values()) for row in comma]
    assert table.schema.field("value").type == "double" and table.schema.field("trial").type == "int64"
    assert (
        table.schema.field("latency_ms").metadata[b"units"] == b"ms"
        and table.schema.metadata[b"title"] == b"Does a warp help?"
    )


def test_without_pyarrow_the_rest_is_written_and_the_words_say_so(store, design, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    made = export(store.contents(), design, tmp_path / "out")
    assert not (made.folder / "ratings.parquet").exists() and (made.folder / "ratings.csv").exists()
    assert any("pip install '.[study]'" in text for text in made.notes)
    with pytest.raises(MachineError, match="pyarrow"):
        export(store.contents(), design, tmp_path / "other", ExportOptions(parquet=True))
    assert not (tmp_path / "other").exists()


def test_no_remark_leaves_the_store(store, design, tmp_path):
    assert any("Maria" in str(event.data) for event in store.contents().events)
    made = export(store.contents(), design, tmp_path / "plain").folder
    assert all(b"Maria" not in path.read_bytes() for path in made.rglob("*") if path.is_file())


def test_people_pilots_and_programs_never_stand_in_one_table(store, design, tmp_path):
    pilots = export(store.contents(pilot=True), design, tmp_path / "pilots", ExportOptions(origin=PILOT)).folder
    assert {row["origin"] for row in read(pilots / "ratings.csv", ",")} == {"pilot"}
    people = export(store.contents(), design, tmp_path / "people").folder
    assert {row["origin"] for row in read(people / "ratings.csv", ",")} == {"person"}
    mixed = attrs.evolve(store.contents(), sessions=(*store.contents().sessions, *store.contents(pilot=True).sessions))
    export(mixed, design, tmp_path / "mixed")
    assert (tmp_path / "mixed/ratings.csv").read_bytes() == (people / "ratings.csv").read_bytes()


def test_a_forced_export_removes_files_of_withdrawn_participants(store, design, tmp_path):
    """Those of older versions too, which wrote more."""
    first = store.contents().sessions[0]
    out = export(store.contents(), design, tmp_path / "out").folder
    (out / "sessions").mkdir()
    for name in ("ratings.tsv", "ratings_short.csv", f"sessions/{first.sub}_ses-01.csv", "remarks.csv", "sickness.tsv"):
        (out / name).write_text(first.sub, encoding="utf-8")
    store.withdraw(first.code)
    export(store.contents(), design, out, ExportOptions(force=True))
    files = [path for path in out.rglob("*") if path.is_file()]
    assert not [path for path in files if first.sub in path.name or first.sub.encode() in path.read_bytes()]


def test_another_plan_is_refused(store, design, tmp_path):
    other = design_from_text(TEXT.replace('name = "warped"', 'name = "renamed"'), "late.toml")
    with pytest.raises(InputError, match="this plan lacks"):
        export(store.contents(), other, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_plan_that_only_an_older_version_reads_is_refused_with_that_version(store, design, tmp_path):
    contents = store.contents()
    old = attrs.evolve(contents.sessions[0], plan=f"{TEXT}\n[gone]\ncount = 3\n", facts={"hmdwarp": "0.2.0"})
    with pytest.raises(InputError, match=r"unknown key .*gone.*export it with hmdwarp 0\.2\.0, which ran it"):
        export(attrs.evolve(contents, sessions=(old, *contents.sessions[1:])), design, tmp_path / "out")
    (tmp_path / "old.toml").write_text(old.plan, encoding="utf-8")
    with pytest.raises(InputError, match=r"old\.toml:.*gone.*hmdwarp 0\.2 ran with this plan"):
        load_design(str(tmp_path / "old.toml"), checked=False)


def test_a_plan_that_was_changed_later_does_not_change_what_was_shown_and_asked(store, design, tmp_path):
    before = export(store.contents(), design, tmp_path / "before").folder
    text = TEXT.replace("latency = 400", "latency = 700").replace('"grade"', '"acr"').replace('"vrsq"', '"ssq"')
    made = export(store.contents(), design_from_text(text, "late.toml"), tmp_path / "after")
    assert (before / "ratings.csv").read_bytes() == (made.folder / "ratings.csv").read_bytes()
    assert [path.read_bytes() for path in answers(before)] == [path.read_bytes() for path in answers(made.folder)]
    told = json.loads((made.folder / "columns.json").read_text(encoding="utf-8"))
    assert told["scale"]["Levels"]["grade"].startswith("School grade") and "changed after 3 sessions" in " ".join(
        made.notes
    )
