"""Tables of others: delimiters, decimal commas, names of columns, directions.

What is wrong is told with its line.
"""

from __future__ import annotations

import csv
import io
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.errors import InputError
from hmdwarp.study.analysis.findings import families_for
from hmdwarp.study.analysis.full_analysis import analyse
from hmdwarp.study.analysis.long_table import Ratings, SourceOptions, from_csv, ratings_from_all

from .tables import PUBLISHED

ROWS = [
    {"participant": "7", "condition": "late", "rating": "4.5", "trial": "1"},
    {"participant": "7", "condition": "warped", "rating": "3.25", "trial": "2"},
    {"participant": "x", "condition": "warped", "rating": "", "trial": "1"},
    {"participant": "x", "condition": "late", "rating": "6", "trial": "2"},
]
PLAIN, LOW, HIGH = SourceOptions(), SourceOptions(low_is_good=True), SourceOptions(low_is_good=False)


def written(path: Path, rows: list[dict[str, object]], delimiter: str = ",", bom: bool = False) -> Path:
    """A long table."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), delimiter=delimiter, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    path.write_bytes((b"\xef\xbb\xbf" if bom else b"") + text.getvalue().encode())
    return path


@pytest.fixture
def reads(tmp_path):
    """Reads rows as a table."""
    return lambda rows, options=PLAIN: from_csv(written(tmp_path / "table.csv", rows), options)


def values(found: Ratings) -> list[float]:
    return found.rows["value"].fillna(-1).tolist()


@together("delimiter, bom", product(",;\t", [False, True]))
def test_a_table_is_read_whatever_is_between_its_columns(tmp_path, delimiter, bom):
    found = from_csv(written(tmp_path / "table.csv", ROWS, delimiter, bom))
    columns = ["participant", "condition", "value", "place", "previous"]
    assert found.rows[columns].fillna(-1).to_numpy().tolist() == [
        ["7", "late", 4.5, 1, ""],
        ["7", "warped", 3.25, 2, "late"],
        ["x", "warped", -1, 1, ""],
        ["x", "late", 6.0, 2, "warped"],
    ]
    assert found.rows["why_missing"].iloc[2] == "empty in line 4"


@together("named", ["acr", "stars"])
def test_rows_without_the_name_of_a_scale_are_not_lost(reads, named):
    row = {"condition": "late", "rating": "3"}
    found = reads([{**row, "participant": str(k), "scale": named if k % 2 else ""} for k in range(6)], LOW)
    assert len(found.rows) == 6 and found.rated_scales() == ["rating", named] and found.survey.empty


def test_a_decimal_comma_is_understood_and_noted(tmp_path):
    rows = [row | {"rating": row["rating"].replace(".", ",")} for row in ROWS]
    found = from_csv(written(tmp_path / "german.csv", rows, ";"))
    assert values(found) == [4.5, 3.25, -1, 6.0]
    assert any("3,25 was read as 3.25" in note for note in found.notes)


@together("missing", ["", "n/a", "NA", "nan", "-", ".", "None"])
def test_missing_has_many_names(reads, missing):
    assert values(reads([*ROWS[:1], {**ROWS[1], "rating": missing}, ROWS[3]])) == [4.5, -1, 6.0]


def test_names_by_case_words_of_the_scale_and_codes_are_read_as_they_are_meant(reads):
    told = [("P01", "a", "Excellent"), ("p01", "b", "poor"), ("P02", "a", "99"), ("P02", "b", "4")]
    rows = [{"participant": who, "condition": what, "rating": word} for who, what, word in told]
    found = reads(rows, SourceOptions(scale="acr", missing=("99",)))
    assert values(found) == [5, 2, -1, 4]
    assert found.rows["participant"].tolist() == ["P01", "P01", "P02", "P02"]
    assert "Names that differ by case alone are one participant: P01." in found.notes
    for options, says in ((SourceOptions(scale="acr"), "from 1 to 5"), (HIGH, "rating 'Excellent'.*--missing CODE")):
        with pytest.raises(InputError, match=says):
            reads(rows, options)


def test_repeats_are_averaged_and_noted(reads):
    found = reads([ROWS[0], {**ROWS[0], "rating": "5.5", "trial": "2"}])
    assert found.table("", "grade").to_numpy().tolist() == [[5.0]]
    assert any("more than once" in note for note in found.notes)


def test_an_ambiguous_direction_must_be_given_and_a_guess_is_noted(reads):
    rows = [{**ROWS[0], "rating": "4"}, {**ROWS[1], "rating": "5"}]
    with pytest.raises(InputError, match="--low-is-good, --high-is-good, or --scale"):
        reads(rows)
    assert reads(rows, HIGH).scale_info["rating"].sign == -1
    assert reads(rows, SourceOptions(scale="acr")).scale_info["acr"].sign == -1
    assert any("read on the scale 'grade'" in note for note in from_csv(PUBLISHED).notes)


def test_other_names_of_columns_are_to_be_said(reads):
    rows = [{"who": "1", "what": "late", "how": "6"}]
    assert reads(rows, SourceOptions({"participant": "who", "condition": "what", "rating": "how"})).conditions("")
    for columns, says in (
        ({}, r"table\.csv:1: no column named participant, rating and condition among who, what, how: name each, "
             r"as in --columns 'participant=who,rating=what,condition=how'"),
        ({"rating": "How"}, "no column 'How'"),
        ({"mos": "how"}, "--columns mos=how: expected one of participant, rating"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=says):
            reads(rows, SourceOptions(columns))


WRONG = [
    ("participant,condition,rating\n1,late,good\n", "wrong.csv:2: rating 'good'"),
    ("participant,condition,rating\n1,late,1e999\n", "wrong.csv:2: rating '1e999'"),
    ("participant,condition,rating\n,late,6\n", "wrong.csv:2: no participant"),
    ("participant,condition,rating\n1,late\n", "wrong.csv:2: 2 fields, expected 3"),
    ("participant;condition;rating\n7;late;4.5\n7;warped;3,25\n", "wrong.csv:3: rating '3,25': expected a number with"),
    ("participant,condition,scale,rating\n7,late,grade,45\n", "wrong.csv:2: rating 45: the scale 'grade' goes from 1"),
    ("participant,rating\n1,6\n", "no column named condition among participant, rating"),
    ("participant,condition,rating\n", "has no rows below its header"),
    ("", "wrong.csv: is empty: expected a table of ratings"),
    ("\ufeff \n\n", "wrong.csv: is empty: expected a table of ratings"),
    ("participant,condition,rating,trial\n1,late,6,first\n", "wrong.csv:2: place 'first'"),
    ("participant,latency_ms,warp,rating\n1,soon,none,6\n", "wrong.csv:2: latency 'soon'"),
    ('participant,condition,rating\n1,"late,6\n', "wrong.csv:"),
    ("participant,condition,rating,low_is_good\n1,late,5,true\n2,late,1,false\n", "wrong.csv:3: low_is_good 'false'"),
]


@together("text, told", WRONG)
def test_wrong_input_is_refused_with_its_line(tmp_path, text, told):
    path = tmp_path / "wrong.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        from_csv(path)
    assert told in str(error.value)
    assert "low_is_good" not in text or from_csv(path, LOW).scale_info["rating"].low_is_good


def test_pilots_and_programs_never_count_with_people(reads):
    rows = [{**ROWS[0], "origin": "person"}, {**ROWS[3], "origin": "simulated"}, {**ROWS[3], "origin": "pilot"}]
    assert reads(rows, LOW).rows["participant"].tolist() == ["7"]
    pilots = reads(rows, SourceOptions(low_is_good=True, origin="pilot"))
    assert pilots.rows["participant"].tolist() == ["x"] and any("not of people" in note for note in pilots.notes)


@given(st.binary(max_size=300))
def test_any_bytes_give_ratings_or_an_input_error(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(b"participant,condition,rating\n" + data)
    try:
        from_csv(path)
    except InputError as error:
        assert "\n" not in str(error)


def test_conditions_of_settings_are_compared_at_each_latency_or_as_requested():
    found = from_csv(PUBLISHED)
    assert found.conditions("run 1")[0] == "none, 200 ms"
    families, why = families_for(found)
    assert [len(family.comparisons) for family in families] == [3, 3]
    assert "at each latency" in why
    families, _ = families_for(found, ["run 1/none, 200 ms:none, 800 ms"])
    (only,) = families[0].comparisons
    assert (only.part, only.baseline, only.better) == ("run 1", "none, 200 ms", "none, 800 ms")
    each = "run 1/none, 200 ms:none, 400 ms", "run 1/none, 400 ms:none, 800 ms"
    rows = [analyse(found, families=asked)["scales"][0]["comparisons"] for asked in (each, each[:1], each[1:])]
    assert [(row["holm"], row["holm_of"]) for row in rows[0]] == [(row["p"], 1) for row in rows[1] + rows[2]]
    with pytest.raises(InputError, match="expected pairs of conditions"):
        families_for(found, ["a-b"])


def exported(path, participant: str, **more: str):
    """A table as a site exports it."""
    row = {"participant": participant, "session": "1", "scale": "grade", "origin": "person", **more}
    rated = [{"trial": "1", "condition": "late", "value": "4"}, {"trial": "2", "condition": "warped", "value": "2.5"}]
    return str(written(path, [{**row, **one} for one in rated]))


def test_tables_of_several_sites_are_one_study(tmp_path):
    one, two = exported(tmp_path / "berlin.csv", "k3x"), exported(tmp_path / "paris.csv", "w9q")
    options = SourceOptions()
    both = ratings_from_all([one, two], None, options)
    found = [*both.rows[["participant", "condition", "value"]].itertuples(index=False, name=None)]
    assert found == [("k3x", "late", 4.0), ("k3x", "warped", 2.5), ("w9q", "late", 4.0), ("w9q", "warped", 2.5)]
    assert both.source == "berlin.csv, paris.csv"
    assert analyse(both)["participants"] == 2
    second = exported(tmp_path / "again.csv", "k3x", session="2")
    assert analyse(ratings_from_all([one, second], None, options))["participants"] == 1
    assert ratings_from_all([one], None, options).rows.equals(from_csv(tmp_path / "berlin.csv").rows)


def test_tables_that_do_not_go_together_are_refused(tmp_path):
    one = exported(tmp_path / "berlin.csv", "k3x")
    own = exported(tmp_path / "own.csv", "w9q", scale="stars", low_is_good="true")
    turned = exported(tmp_path / "turned.csv", "k3x", scale="stars", low_is_good="false")
    for first, second, says in (
        (one, exported(tmp_path / "copy.csv", "k3x"), "has session 1 of participant 'k3x', as .*berlin.csv has"),
        (one, exported(tmp_path / "made.csv", "w9q", origin="simulated"), "of origin 'simulated', and 'person' in"),
        (one, str(tmp_path / "none.csv"), "expected a table of ratings that is there"),
        (one, "quick", "export each study first"),
        (own, turned, "scale 'stars' is another one"),
    ):
        with pytest.raises(InputError, match=says):
            ratings_from_all([first, second], None, SourceOptions())
