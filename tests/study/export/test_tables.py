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
from hmdwarp.study.analysis.long_table import from_csv
from hmdwarp.study.design import Ask, Show, design_from_text, load_design, steps_of
from hmdwarp.study.export.export_rows import answer_rows, long_rows
from hmdwarp.study.export.table_columns import (
    COLUMNS,
    FLAG,
    INTEGER,
    LONG_COLUMNS,
    NUMBER,
    columns_for,
    csv_text,
    field_text,
    tsv_text,
)
from hmdwarp.study.export.write import ExportOptions, export
from hmdwarp.study.store import PILOT, Store

from ..made_up import LATE_OR_WARPED as TEXT
from .conftest import Day, sit
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


def test_one_row_for_each_rating_and_for_each_that_is_missing(store, design):
    store.withdraw("Gamma-3")
    contents = store.contents()
    rows = long_rows(answer_rows(contents, design))
    subs = {session.code: session.sub for session in contents.sessions}
    assert len(rows) == 2 * 3 and all(row["kind"] == "rating" for row in rows)
    of = {(row["participant"], row["trial"]): row for row in rows}
    revised = of[subs["Alpha-1"], 1]
    assert (revised["value"], revised["revision"], revised["seconds_to_answer"], revised["why_missing"]) == (
        1.0,
        2,
        0.5,
        None,
    )
    assert revised["actual_latency_ms_median"] == 402.5 and revised["presentation"] == 1
    silent, stopped = of[subs["Alpha-1"], 2], of[subs["Beta-2"], 3]
    assert (silent["value"], silent["why_missing"]) == (None, "cannot say")
    assert (stopped["value"], stopped["why_missing"], stopped["status"]) == (None, "session stopped", "stopped")


def test_a_row_has_its_condition_and_the_one_before(store, design):
    for session in store.contents().sessions:
        rows = [row for row in long_rows(answer_rows(store.contents(), design)) if row["participant"] == session.sub]
        names = [row["condition"] for row in rows]
        assert names == list(session.order[0]) and [row["previous"] for row in rows] == [None, *names[:-1]]
        for row in rows:
            late = row["condition"] != "reference"
            assert row["latency_ms"] == (400 if late else 0) and row["reference"] == (not late)
            assert row.get("guard") == (1.5 if row["condition"] == "warped" else None)
            assert row["fill"] == (
                "memory+pyramid" if row["condition"] == "warped" else "none"
            )  # the default of a live run
    assert [c.name for c in columns_for(rows)] == [*LONG_COLUMNS[:19], "guard", *LONG_COLUMNS[19:]]


def test_a_row_says_how_its_pictures_were_measured(store, design, tmp_path):
    showing = next(showing for showing in store.contents().showings if showing.trial)
    store.measured(showing.id, {"flip": 0.25, "refreshes": 5, "every": 10, "size": "48x60"})
    out = export(store.contents(), design, tmp_path / "out").folder
    (row,) = [row for row in read(out / "ratings.csv", ",") if row["measured_flip"] != "n/a"]
    assert (row["measured_flip"], row["measured_every"], row["measured_size"]) == ("0.25", "10", "48x60")


def test_the_block_of_a_trial_changes_at_each_planned_break(tmp_path):
    design = design_from_text(TEXT.replace("[practice]", "[breaks]\nevery = 2\nseconds = 1\n[practice]"), "late.toml")
    with Store(tmp_path / "data", create=True, clock=Day()) as store:
        sit(store, design, "P1")
        rows = answer_rows(store.contents(), design)
    blocks = {row["trial"]: row["block"] for row in rows if row["trial"] is not None}
    assert blocks == {0: 0, 1: 1, 2: 1, 3: 2}


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


def test_scores_are_those_of_the_scale_and_empty_where_answers_are_missing(store, design, tmp_path):
    out = export(store.contents(), design, tmp_path / "out").folder
    rows = [row | {"participant": path.name[4:].split("_")[0]} for path in answers(out) for row in read(path, "\t")]
    rows = [row for row in rows if row["kind"] in ("questionnaire", "score")]
    vrsq = design.before[0]
    for session in store.contents().sessions:
        for phase in ("before", "after"):
            mine = [row for row in rows if row["participant"] == session.sub and row["phase"] == phase]
            values = {row["item"]: row["value"] for row in mine if row["kind"] == "questionnaire"}
            scores = {row["item"]: row["value"] for row in mine if row["kind"] == "score"}
            assert list(values) == [item.key for item in vrsq.items] and list(scores) == [
                score.name for score in vrsq.scores
            ]
            if session.status == "stopped" and phase == "after":
                assert set(values.values()) | set(scores.values()) == {"n/a"}
                continue
            # VRSQ by its paper: items 1 to 4 are oculomotor (of 12), 5 to 9 disorientation (of 15),
            # both in percent; total: their mean.
            given = [float(value) for value in values.values()]
            wanted = 100 * sum(given[:4]) / 12, 100 * sum(given[4:]) / 15
            assert [float(scores[score.name]) for score in vrsq.scores] == pytest.approx([*wanted, sum(wanted) / 2])


def test_every_column_is_described(store, design, tmp_path):
    out = export(store.contents(), design, tmp_path / "out").folder
    told = json.loads((out / "columns.json").read_text(encoding="utf-8"))
    rows = [row for path in answers(out) for row in read(path, "\t")]
    for column in (*read(out / "ratings.csv", ",")[0], *rows[0]):
        assert told[column]["Description"]
    for row in (row for row in rows if row["kind"] == "sickness"):
        assert row["scale"] in told["scale"]["Levels"] and row["item"] in told["item"]["Levels"]
        assert row["status"] in told["status"]["Levels"] and row["phase"] in told["phase"]["Levels"]


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


def test_an_older_export_is_not_written_over(store, design, tmp_path):
    out = export(store.contents(), design, tmp_path / "out").folder
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    with pytest.raises(InputError, match="withdrawn since"):
        export(store.contents(), design, out)
    assert before == {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}


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


def test_the_table_says_whose_ratings_they_are(store, design, tmp_path):
    out = export(store.contents(pilot=True), design, tmp_path / "out", ExportOptions(origin=PILOT)).folder
    columns = json.loads((out / "columns.json").read_text(encoding="utf-8"))
    assert set(columns["origin"]["Levels"]) == {"person", "pilot", "simulated"}
    found = from_csv(out / "ratings.csv")
    said = "These ratings are of origin 'pilot', not of people taking part in the study."
    assert (found.origin, found.notes[0]) == (PILOT, said)
    assert {row["origin"] for row in read(out / "bids" / "participants.tsv", "\t")} == {PILOT}


def test_times_are_written_to_the_nanosecond_that_was_measured(tmp_path, design):
    """A clock of nanoseconds, times 1e-9: floats show digits that nobody measured."""
    with Store(tmp_path / "data", create=True, clock=Day()) as store:
        session = store.begin(design, None, "P1", "person")
        steps = steps_of(design, session.order, session.part)
        trial = next(step for step in steps if isinstance(step, Show) and step.trial == 1)
        ask = next(step for step in steps if isinstance(step, Ask) and step.about == trial.key)
        actual = {"seconds": 0.30000000600000004, "latency_ms_median": 66.66666700000001, "hole_share_mean": 1 / 3}
        showing = store.end_showing(
            session, store.begin_showing(session, trial, {}, recorded=False), actual, complete=True
        )
        store.answer(session, ask, 2.0, 1.6500000330000002, "participant", showing)
        out = export(store.contents(), design, tmp_path / "out").folder
    row = read(out / "ratings.csv", ",")[0]
    assert (row["seconds_to_answer"], row["actual_seconds"]) == ("1.650000033", "0.300000006")
    assert (row["actual_latency_ms_median"], row["actual_hole_share_mean"]) == ("66.666667", "0.3333333333333333")
