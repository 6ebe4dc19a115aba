"""Scales. The shipped ones are as published, one's own is checked line by line, scores are what the
papers say.
"""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.base import InputError, UnknownNameError
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import KEYS, QuestionDialog
from hmdwarp.study.scales import (
    FOLDER,
    KINDS,
    PREFERENCE,
    QUESTIONNAIRE,
    Scale,
    load_scale,
    scale_names,
    score_ranges,
    scored,
)

GRADE = (FOLDER / "grade.toml").read_text(encoding="utf-8")


@together("name", [name for name in scale_names() if load_scale(name).has_answers])
def test_a_shipped_scale_is_whole(name):
    scale = load_scale(name)
    assert scale.name == name and scale.kind in KINDS and len(scale.source) > 20
    assert scale.least < scale.most and scale.values()[0] == scale.least and scale.values()[-1] == scale.most
    assert {scale.least, scale.most} <= set(scale.anchors) <= set(scale.values())
    assert (scale.kind == QUESTIONNAIRE) == (len(scale.items) > 1) == bool(scale.scores)
    best, worst = (scale.least, scale.most) if scale.low_is_good else (scale.most, scale.least)
    assert scale.badness(best) == 0 and scale.badness(worst) == scale.most - scale.least


@together("name", [name for name in scale_names() if not load_scale(name).has_answers])
def test_a_questionnaire_whose_questions_have_their_own_answers(name):
    scale = load_scale(name)
    assert scale.kind in (QUESTIONNAIRE, PREFERENCE) and not scale.scores and not scale.anchors and not scale.direction
    assert scored(scale, {item.key: None for item in scale.items}) == {}
    for item in scale.items:
        own = scale.of(item)
        if item.answer == "choice":
            assert own.values() == tuple(range(1, len(item.choices) + 1))
            assert [scale.words_for(item, value, "") for value in own.values()] == list(item.choices)
        with pytest.raises(InputError, match="expected an answer"):
            scored(scale, {item.key: own.most + 1})


PUBLISHED = [
    ("grade", 1, 6, 0.25, True, "rating", {1: "very good", 6: "insufficient"}),
    ("acr", 1, 5, 1, False, "rating", {5: "excellent"}),  # ITU-T P.910
    ("dcr", 1, 5, 1, False, "rating", {5: "imperceptible"}),  # P.910 as well
    ("fms", 0, 20, 1, True, "sickness", {}),  # Keshavarz 2011
    ("misc", 0, 10, 1, True, "sickness", {}),  # Bos 2005
]


@together("name, least, most, step, low_is_good, kind, words", PUBLISHED)
def test_directions_and_ranges_as_published(name, least, most, step, low_is_good, kind, words):
    scale = load_scale(name)
    found = (scale.least, scale.most, scale.step, scale.low_is_good, scale.kind)
    assert found == (least, most, step, low_is_good, kind)
    assert words.items() <= scale.anchors.items()
    assert scale.beside_reference == (name == "dcr")
    assert name != "misc" or len(scale.anchors) == 11


# --- scores -------------------------------------------------------------------------------------


def test_the_most_that_questionnaires_can_come_to():
    """Kennedy and others 1993: all 16 items at 3 give these (21 x 9.54, 21 x 7.58, 21 x 13.92, 63 x
    3.74). Kim and others 2018: per cent of the most.
    """
    ssq = {"nausea": 200.34, "oculomotor": 159.18, "disorientation": 292.32, "total": 235.62}
    assert score_ranges(load_scale("ssq"))[1] == pytest.approx(ssq)
    vrsq = dict.fromkeys(("oculomotor", "disorientation", "total"), 100)
    assert score_ranges(load_scale("vrsq"))[1] == pytest.approx(vrsq, abs=1e-12)


def test_a_reversed_item_counts_most_for_the_lowest_answer():
    least, most = score_ranges(load_scale("ipq"))
    assert set(least.values()) == {0} and set(most.values()) == {6}
    from_one = score_ranges(attrs.evolve(load_scale("ipq"), least=1.0, most=7.0))
    assert [set(scores.values()) for scores in from_one] == [{1}, {7}]


def test_task_load_is_the_mean_of_six():
    """Raw TLX, as Hart 2006 has it: every scale from 0 to 100 in steps of 5, none weighted."""
    tlx = load_scale("nasa_tlx")
    given = dict(zip([item.key for item in tlx.items], (80, 5, 40, 25, 60, 0), strict=True))
    found = scored(tlx, given)
    assert found.pop("load") == pytest.approx(35)
    assert found == given
    assert scored(tlx, given | {"effort": None})["load"] is None


# The items of Schubert, Friedmann and Regenbrecht 2001 in their order; (-): coded the other way.
IPQ_TABLE = ["G", "SP", "SP(-)", "SP", "SP", "SP", "INV", "INV", "INV(-)", "INV", "REAL(-)", "REAL", "REAL", "REAL"]
IPQ_NAMES = {"G": "general", "SP": "spatial", "INV": "involvement", "REAL": "realism"}


@given(st.lists(st.integers(0, 6), min_size=14, max_size=14))
def test_an_ipq_against_the_published_table(answers):
    """Means of each factor's items, reversed ones counted from the other end."""
    scale = load_scale("ipq")
    counted = [6 - value if code.endswith("(-)") else value for code, value in zip(IPQ_TABLE, answers, strict=True)]
    wanted = {
        name: np.mean([value for code, value in zip(IPQ_TABLE, counted, strict=True) if code.startswith(short)])
        for short, name in IPQ_NAMES.items()
    }
    assert scored(scale, dict(zip([item.key for item in scale.items], answers, strict=True))) == pytest.approx(wanted)


def test_items_with_words_of_their_own(tmp_path):
    scale = load_scale("ipq")
    assert scale.of(scale.items[0]).anchors == {0: "not at all", 6: "very much"}
    assert scale.of(scale.items[1]).anchors == scale.anchors
    assert scale.items[10].described.endswith("(0 = completely real; 6 = not real at all; reversed)")
    asked = QuestionDialog(Ask("after/ipq/aware", scale, scale.items[6], "after"), lambda: 0.0, KEYS).question()
    assert asked.anchors == ((0, "extremely aware"), (3, "moderately aware"), (6, "not aware at all"))
    text = (FOLDER / "ipq.toml").read_text(encoding="utf-8")
    with pytest.raises(InputError, match="has no word for 6"):
        load_text(tmp_path, text.replace('6 = "very much"\n', ""))
    with pytest.raises(InputError, match="unknown key item.reversed"):
        load_text(tmp_path, GRADE + "reversed = true\n")


# The published table of Kennedy and others, a line for each item: in which of N, O, D it counts.
SSQ_TABLE = ["NO", "O", "O", "O", "OD", "N", "N", "ND", "NO", "D", "OD", "D", "D", "D", "N", "N"]
WEIGHTS = {"N": 9.54, "O": 7.58, "D": 13.92}
NAMES = {"N": "nausea", "O": "oculomotor", "D": "disorientation"}


@given(st.lists(st.integers(0, 3), min_size=16, max_size=16))
def test_an_ssq_against_the_published_table(answers):
    """By matrix product over the table, not by the lists of numbers the file has."""
    scale = load_scale("ssq")
    table = np.array([[letter in row for letter in "NOD"] for row in SSQ_TABLE])
    sums = np.array(answers) @ table
    wanted = {NAMES[letter]: sums[k] * WEIGHTS[letter] for k, letter in enumerate("NOD")} | {"total": sums.sum() * 3.74}
    assert scored(scale, dict(zip([item.key for item in scale.items], answers, strict=True))) == pytest.approx(wanted)


@given(st.lists(st.integers(0, 3), min_size=9, max_size=9))
def test_a_vrsq_by_hand(answers):
    scale = load_scale("vrsq")
    oculomotor, disorientation = sum(answers[:4]) / 12 * 100, sum(answers[4:]) / 15 * 100
    wanted = {"oculomotor": oculomotor, "disorientation": disorientation, "total": (oculomotor + disorientation) / 2}
    assert scored(scale, dict(zip([item.key for item in scale.items], answers, strict=True))) == pytest.approx(wanted)


def test_a_missing_answer_empties_its_own_scores_alone():
    scale = load_scale("ssq")
    answers: dict[str, float | None] = {item.key: 1 for item in scale.items}
    answers["sweating"] = None  # in N alone
    wanted = {"nausea": None, "oculomotor": pytest.approx(53.06), "disorientation": pytest.approx(97.44), "total": None}
    assert scored(scale, answers) == wanted
    del answers["sweating"]
    assert scored(scale, answers)["nausea"] is None
    assert set(scored(scale, {}).values()) == {None}
    assert scored(load_scale("grade"), {"grade": 2}) == {}


def test_answers_that_cannot_be_are_refused():
    with pytest.raises(UnknownNameError, match="unknown item of scale 'ssq' 'nausia': did you mean 'nausea'"):
        scored(load_scale("ssq"), {"nausia": 1})
    with pytest.raises(InputError, match="scale 'ssq', item 'nausea': 4: expected an answer from 0 to 3"):
        scored(load_scale("ssq"), {"nausea": 4})


# --- files --------------------------------------------------------------------------------------


def load_text(folder: Path, text: str | bytes) -> Scale:
    path = folder / "mine.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_scale(str(path))


def test_one_s_own_file_unknown_names_and_absent_files(tmp_path):
    assert load_text(tmp_path, GRADE).name == "mine"
    (tmp_path / "folder.toml").mkdir()
    for name, says in (
        ("grades", "unknown scale 'grades': did you mean 'grade'"),
        (str(tmp_path / "none.toml"), r"none\.toml: no such file: expected a \.toml file"),
        (str(tmp_path / "folder.toml"), "is a directory"),
    ):
        with pytest.raises((UnknownNameError, InputError), match=says):
            load_scale(name)
