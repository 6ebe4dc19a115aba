"""Pages and forms of a plan: pictures in their colours, and words."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.display import Command, Presenter
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.choice_dialogs import PageDialog, TextDialog
from hmdwarp.study.dialogs.dialog_panels import CONTROLLERS
from hmdwarp.study.line_console import ConsoleState, checked_answer, parse_line
from hmdwarp.study.scales import load_scale

from .sessions import BLUE, RED, picture, press


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
