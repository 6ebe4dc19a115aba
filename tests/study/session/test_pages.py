"""Pages of a plan: instructions, ready, thanks; as a text or as a picture, in its colours."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from hmdwarp.display import Command, Presenter
from hmdwarp.errors import InputError
from hmdwarp.study.design import load_design
from hmdwarp.study.dialogs.choice_dialogs import PageDialog
from hmdwarp.study.dialogs.dialog_panels import MessagePanel

from .sessions import Person, closing, contents, run, study

PAGES = """
[instructions]
title = "What you will do"
file = "instructions.png"
[ready]
text = "Put the headset on."
[thanks]
file = "thanks.txt"
"""
RED, BLUE = (220, 40, 40), (30, 60, 200)


def picture(path, size=(900, 600)):
    """Red on the left, blue on the right."""
    half = np.zeros((size[1], size[0], 3), np.uint8)
    half[:, : size[0] // 2], half[:, size[0] // 2 :] = RED, BLUE
    Image.fromarray(half).save(path)


@pytest.fixture
def path(tmp_path):
    picture(tmp_path / "instructions.png")
    (tmp_path / "thanks.txt").write_text("Please go back to the desk.\n", encoding="utf-8")
    made = study(tmp_path)
    made.write_text(made.read_text(encoding="utf-8") + PAGES, encoding="utf-8")
    return made


class Reader(Person):
    """Goes on wherever a page or the end can be confirmed."""

    def _usual(self, panel):
        if isinstance(panel, MessagePanel) and panel.title in ("What you will do", "Thank you"):
            return (Command("confirm"),)
        return super()._usual(panel)


def test_a_session_shows_them_in_their_places(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, Reader())
    assert ran.error is None and ran.session.status == "complete"
    panels = [panel for panel in ran.display.panels if isinstance(panel, MessagePanel)]
    assert [panel.title for panel in panels[:3]] == ["What you will do", "Ready?", "Trial 1 of 2"]
    assert panels[0].picture.endswith("instructions.png") and panels[0].choices == (("done", "go on"),)
    assert panels[1].lines == ("Put the headset on.",) and "Move the mouse to look around" in panels[1].hint
    assert panels[-1].lines == ("Please go back to the desk.",)
    assert ("finished", "instructions") in [(event.kind, event.key) for event in contents(path).events]


def test_a_resumed_session_does_not_repeat_the_instructions(monkeypatch, gpu, path):
    ran = run(monkeypatch, gpu, path, Reader(), at={1: closing()})
    assert ran.session.status == "interrupted"
    ran = run(monkeypatch, gpu, path, Reader(), resume=True)
    titles = [getattr(panel, "title", "") for panel in ran.display.panels]
    assert ran.session.status == "complete" and "What you will do" not in titles and titles[0] == "Ready?"


def test_a_picture_keeps_its_colours_on_the_display(gpu, tmp_path):
    picture(tmp_path / "p.png")
    panel = PageDialog("Look", picture=str(tmp_path / "p.png")).panel()
    ink = panel.ink()
    assert ink.shape == (panel.height(), 680, 3)
    with gpu.current():
        presenter = Presenter(gpu)
        size = ink.shape[1::-1]
        texture = gpu.gl.texture((1000, 1000), 4)
        framebuffer = gpu.gl.framebuffer([texture])
        presenter.show(None, framebuffer, (0, 0, 1000, 1000), hardware_srgb=False, notice=presenter.notice(panel))
        data = framebuffer.read(components=3)
        presenter.close()
        for resource in (framebuffer, texture):
            resource.release()
    shown = np.frombuffer(data, np.uint8).reshape(1000, 1000, 3)
    for across, wanted in ((0.3, RED), (0.7, BLUE)):
        x, y = round(500 + (across - 0.5) * size[0]), 500
        # The ground's own light adds 0.008 where a picture is dark: 6 steps at 40.
        assert np.abs(shown[y, x].astype(int) - wanted).max() <= 8, (shown[y, x], wanted)


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ('[ready]\ntext = "a"\nfile = "b.txt"', "needs either text, or file"),
        ("[thanks]", "needs either text, or file"),
        ('[instructions]\nfile = "none.png"', "none.png: no such file"),
        ('[instructions]\nfile = "small.png"', "no picture"),
        ('[instructions]\nfile = "none.txt"', "none.txt"),
        ('[instructions]\ntext = "a"\npages = 3', "pages"),
    ],
)
def test_unreadable_pages_are_refused_with_their_line(tmp_path, table, told):
    made = study(tmp_path)
    (tmp_path / "small.png").write_text("no picture at all", encoding="utf-8")
    made.write_text(f"{made.read_text(encoding='utf-8')}{table}\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_design(str(made))
    assert told in str(error.value) and f"{made}:" in str(error.value)
    if "none" in table:
        assert load_design(str(made), checked=False).instructions is not None  # an export goes on without it
