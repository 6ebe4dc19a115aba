"""The tables read back as they were, and no nasty value breaks them."""

from __future__ import annotations

import csv
import io
import locale
from collections.abc import Sequence
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.report import inert_text, raw_text
from hmdwarp.study.design import design_from_text
from hmdwarp.study.export.export_rows import (
    COLUMNS,
    FLAG,
    INTEGER,
    LONG_COLUMNS,
    MISSING,
    NUMBER,
    Column,
    columns_for,
    csv_text,
    field_text,
    settings_row,
    tsv_text,
)

from ..plans import text_of

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
    text = text_of("whole", ('scene = "planes"', f'scene = "planes"\ndelay_trace = "{tmp_path}/delays.csv"'))
    design = design_from_text(text, str(tmp_path / "s.toml"), checked=False)
    assert settings_row(design.parts[0].conditions[0].settings)["delay_trace"] == "delays.csv"


def test_a_table_has_jod_ratings_only_where_there_are_any():
    plain = [column.name for column in columns_for([{"measured_flip": 0.1}])]
    rated = [column.name for column in columns_for([{"measured_jod": 9.5, "measured_jod_s": 0.5}])]
    assert rated == [*plain, "measured_jod", "measured_jod_s"]
