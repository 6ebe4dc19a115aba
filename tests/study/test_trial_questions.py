"""Questions with answers of their own after each trial, beside a rating: from plan to analysis."""

from __future__ import annotations

import csv

import pytest

from hmdwarp.errors import InputError
from hmdwarp.study.design import load_design

from . import tiny

WHY = """title = "Why"
kind = "questionnaire"
source = "this test"
[[item]]
key = "worst"
text = "What disturbed you most?"
answer = "choice"
choices = ["nothing", "black borders", "shaking"]
[[item]]
key = "words"
text = "In your own words?"
answer = "text"
"""
MORE = '[[item]]\nkey = "age{0}"\ntext = "How old are you?"\nanswer = "number"\nleast = 16\nmost = 99\n'


@pytest.fixture
def study(tmp_path):
    """Its file, the model of its people, and the folder of both."""
    file, model = tiny.write(tmp_path)
    file.write_text(file.read_text().replace('scales = ["grade"]', 'scales = ["grade", "why.toml"]'))
    (tmp_path / "why.toml").write_text(WHY)
    return file, model, tmp_path


def test_questions_after_trials_are_stored_and_exported_and_are_no_ratings(study):
    file, model, folder = study
    tiny.ran(*tiny.session(file, model, "P1", "--quiet"))
    tiny.ran("study", "export", file, "--out", folder / "made", "--simulated", "--quiet")
    tiny.ran("study", "analyse", file, "--out", folder / "analysis", "--simulated", "--quiet")
    (answers,) = (folder / "made").glob("bids/sub-*/ses-01/beh/*_beh.tsv")
    with answers.open(encoding="utf-8", newline="") as table:
        rows = [row for row in csv.DictReader(table, delimiter="\t") if row["scale"] == "why"]
    assert [(row["trial"], row["item"]) for row in rows] == [
        (str(n), k) for n in range(1, 5) for k in ("worst", "words")
    ]
    assert all(row["text"] in ("nothing", "black borders", "shaking") for row in rows if row["item"] == "worst")
    with (folder / "made" / "ratings.csv").open(encoding="utf-8", newline="") as table:
        assert [row["scale"] for row in csv.DictReader(table)] == ["grade"] * 4


def test_a_plan_takes_three_at_most_and_no_scores(study):
    file, _, folder = study
    (folder / "why.toml").write_text(WHY + MORE.format(1))
    assert [len(scale.items) for scale in load_design(str(file)).scales] == [1, 3]
    (folder / "why.toml").write_text(WHY + MORE.format(1) + MORE.format(2))
    with pytest.raises(InputError, match=r"has 'why.toml', a questionnaire of 4 items: .*3 questions at most"):
        load_design(str(file))
