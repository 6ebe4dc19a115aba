"""Pages and forms of a plan: pictures in their colours, words, and what of them is refused."""

from __future__ import annotations

import numpy as np
import pytest
from together import together

from hmdwarp.display import Command, Presenter
from hmdwarp.errors import InputError
from hmdwarp.study.console.line_console import ConsoleState, checked_answer, parse_line
from hmdwarp.study.design import Ask, load_design
from hmdwarp.study.dialogs.choice_dialogs import PageDialog, TextDialog
from hmdwarp.study.dialogs.dialog_panels import CONTROLLERS
from hmdwarp.study.scales import load_scale

from ..refusals import check_refused, table
from .sessions import BLUE, RED, picture, press, study
from .test_transcripts import SCRIPTS


def test_a_picture_keeps_its_colours_on_the_display(gpu, tmp_path):
    picture(tmp_path / "p.png")
    panel = PageDialog("Look", picture=str(tmp_path / "p.png")).panel()
    ink = panel.ink()
    assert ink.shape == (panel.height(), 680, 3)
    with gpu.current():
        presenter = Presenter(gpu)
        texture = gpu.gl.texture((1000, 1000), 4)
        framebuffer = gpu.gl.framebuffer([texture])
        presenter.show(None, framebuffer, (0, 0, 1000, 1000), hardware_srgb=False, notice=presenter.notice(panel))
        shown = np.frombuffer(framebuffer.read(components=3), np.uint8).reshape(1000, 1000, 3)
        presenter.close()
        for resource in (framebuffer, texture):
            resource.release()
    for across, wanted in ((0.3, RED), (0.7, BLUE)):
        x, y = round(500 + (across - 0.5) * ink.shape[1]), 500
        # The ground's own light adds 0.008 where a picture is dark: 6 steps at 40.
        assert np.abs(shown[y, x].astype(int) - wanted).max() <= 8, (shown[y, x], wanted)


UNREADABLE = [
    ('[ready]\ntext = "a"\nfile = "b.txt"', "needs either text, or file"),
    ("[thanks]", "needs either text, or file"),
    ('[instructions]\nfile = "none.png"', "none.png: no such file"),
    ('[instructions]\nfile = "small.png"', "no picture"),
    ('[instructions]\nfile = "none.txt"', "none.txt"),
    ('[instructions]\ntext = "a"\npages = 3', "pages"),
]


@together("page, told", UNREADABLE)
def test_unreadable_pages_are_refused_with_their_line(tmp_path, page, told):
    made = study(tmp_path)
    (tmp_path / "small.png").write_text("no picture at all", encoding="utf-8")
    made.write_text(f"{made.read_text(encoding='utf-8')}{page}\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_design(str(made))
    assert told in str(error.value) and f"{made}:" in str(error.value)
    if "none" in page:
        assert load_design(str(made), checked=False).instructions is not None  # an export goes on without it


WRONG = r"""
choices = ["left", "right", "both"] -> choices = ["left"] => 2 to 12 different texts
choices = ["left", "right", "both"] -> choices = ["left", "left"] => 2 to 12 different texts
answer = "text" -> answer = "words" => answer
most = 99 -> most = 3 => expected more than
answer = "text" ->  => answer @ ⏎title
kind = "questionnaire" -> kind = "rating" => is for kind questionnaire @ answer
answer = "text" -> answer = "text"⏎»choices = ["a", "b"] => choices
"""


@together("entry", table(WRONG))
def test_an_impossible_question_is_refused_with_its_line(tmp_path, entry):
    file, form = tmp_path / "form.toml", "\n" + SCRIPTS["form"]["files"]["form.toml"]
    check_refused(entry, form, lambda wrong: file.write_text(wrong, encoding="utf-8") and load_scale(str(file)), file)


def dialog(*hints) -> TextDialog:
    scale = load_scale("comments")
    return TextDialog(Ask("after/comments/comments", scale, scale.items[0], "after"), *hints)


def test_an_empty_answer_is_not_confirmed_and_no_answer_is_a_choice():
    asked = dialog()
    asked.handle([Command("confirm"), Command("type", " "), Command("confirm")])
    assert not asked.over and "no answer" in asked.panel().note
    asked.handle([press(asked.panel(), "none")])
    assert asked.over and asked.text == ""


def test_in_a_headset_the_words_are_said():
    asked = dialog(CONTROLLERS)
    assert not asked.panel().takes_text and "Say it aloud" in " ".join(asked.panel().lines)
    question = asked.question()
    assert question.in_words and checked_answer(" too dark ", question) == "too dark"
    state = ConsoleState(phase="asking", question=question)
    assert parse_line("answer 7 of them", state) == ("answer", "7 of them")
    with pytest.raises(ValueError, match="in words"):
        parse_line("answer", state)
