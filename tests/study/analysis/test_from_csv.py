"""Tables of others: any bytes, several sites. What is read, and what is refused: tables/."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.study.analysis.findings import families_for
from hmdwarp.study.analysis.full_analysis import analyse
from hmdwarp.study.analysis.long_table import SourceOptions, from_csv, ratings_from_all

from .tables import PUBLISHED


def written(path: Path, rows: list[dict[str, object]], delimiter: str = ",", bom: bool = False) -> Path:
    """A long table."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), delimiter=delimiter, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    path.write_bytes((b"\xef\xbb\xbf" if bom else b"") + text.getvalue().encode())
    return path


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
