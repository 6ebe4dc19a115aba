"""Dialogs and their panels. Nothing by a slip, nothing lost, all is where it is drawn.

No answer is chosen beforehand, every one can be in every way, and what is confirmed stays.
"""

from __future__ import annotations

from itertools import pairwise, product
from pathlib import Path

import attrs
import numpy as np
from golden_texts import assert_outcomes
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from together import together

from hmdwarp.display import MAX_HEIGHT_M, MAX_WIDTH_M, Command, Presenter
from hmdwarp.display.desktop import WindowView
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import (
    AGAIN,
    BREAK,
    CONTINUE,
    CONTROLLERS,
    KEYS,
    STOP,
    TEXT,
    WIDTH,
    ConsentDialog,
    InputHints,
    LineLayout,
    MenuDialog,
    QuestionDialog,
    QuestionPanel,
    TextDialog,
    layout_of,
    width_of,
    wrapped,
)
from hmdwarp.study.scales import Item, Scale, load_scale, number_text, scale_names

SHIPPED = [scale for scale in map(load_scale, scale_names()) if scale.has_answers]
STEPS = (0.01, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)


@st.composite
def scales(draw) -> Scale:
    """2 to 121 values from anywhere, with or without words."""
    step, first, count = draw(st.sampled_from(STEPS)), draw(st.integers(-20, 20)), draw(st.integers(2, 121))
    least = round(first * step, 9)
    values = [round(least + k * step, 9) for k in range(count)]
    words = st.text(alphabet="abcdefgh ", min_size=1, max_size=40).filter(str.strip)
    anchors = draw(st.dictionaries(st.sampled_from(values), words, max_size=6))
    return Scale("any", "Any", "rating", (Item("any", "How?"),), least, values[-1], step, True, anchors)


any_scale = st.one_of(st.sampled_from(SHIPPED), scales())


def asked_of(scale: Scale, hints: InputHints = KEYS, now_s=lambda: 0.0) -> QuestionDialog:
    """A question of its first item, after the first trial."""
    return QuestionDialog(Ask("trial/1/x", scale, scale.items[0], "trial", 1), now_s, hints)


def place_of(panel, name: str) -> tuple[float, float]:
    """The middle of that button, by trying."""
    found = [(u, v) for u in np.linspace(0, 1, 40) for v in np.linspace(0, 1, 120) if panel.button_at(u, v) == name]
    assert found, name
    return tuple(float(part) for part in np.mean(found, axis=0))


def said(*names: str | tuple[str, object]) -> list[Command]:
    """Commands by their names, or names and values."""
    return [Command(name) if isinstance(name, str) else Command(*name) for name in names]


FILE = Path(__file__).with_name("asked.txt")
LONG = "This study asks how good pictures are that come late. " * 40
CHOICES = said("left", "right", "up", "down", "confirm", "menu", "erase", ("digit", "3"), "quit")
POINTED = st.tuples(st.sampled_from(["point", "press"]), st.tuples(st.floats(0, 1), st.floats(0, 1)))
commands = st.lists(st.one_of(st.sampled_from(CHOICES), POINTED.map(lambda one: said(one)[0])), max_size=30)


@given(commands)
def test_any_input_leaves_the_menu_consistent(sent):
    menu = MenuDialog()
    for command in sent:
        before = menu.chosen
        menu.handle([command])
        assert menu.chosen in ("", CONTINUE, BREAK, AGAIN, STOP) and (not before or menu.chosen == before)
        assert 0 <= menu.panel().marked < len(menu.panel().choices)


def dialog(name: str) -> object:
    made = {
        "menu": MenuDialog,
        "consent": lambda: ConsentDialog("A short text."),
        "long consent": lambda: ConsentDialog(LONG),
    }
    if name == "words":
        scale = load_scale("comments")
        return TextDialog(Ask("after/comments/comments", scale, scale.items[0], "after"))
    return made[name]() if name in made else asked_of(load_scale(name))


def came_of(line: str) -> str:
    """What a dialog is after digits, `=value` of the console, `press:button`, or commands."""
    name, _, words = line.partition(": ")
    asked = dialog(name)
    for word in words.split():
        if word[0] in "0123456789.,":
            asked.handle(said(*(("digit", key) for key in word)))
        elif word[0] == "=":
            asked.handle(said(("answer", None if word == "=none" else float(word[1:]))))
        elif word.startswith("press:"):
            asked.handle(said(("press", place_of(asked.panel(), word[6:]))))
        else:
            asked.handle(said((word, "x") if word == "type" else word))
    states = ("value", "text", "chosen", "agreed", "refused", "confirmed", "skipped", "over", "note")
    of_panel = ("title", "heading", "typed", "skipping", "marked", "lines", "note")
    found = {name: getattr(asked, name, None) for name in states}
    found |= {f"panel.{name}": getattr(asked.panel(), name, None) for name in of_panel}
    told = {key: value for key, value in found.items() if value is not False and value not in (None, "", ())}
    return ", ".join(f"{key} {value!r}" for key, value in told.items()) or "nothing"


def test_what_comes_of_commands_is_what_came():
    """asked.txt; HMDWARP_GOLDEN=write writes it anew: look at the difference."""
    assert_outcomes(FILE, came_of)


def is_last(reading: ConsentDialog) -> bool:
    return "agree" in dict(reading.panel().choices)


def test_a_long_text_is_agreed_to_on_its_last_page_alone():
    reading, seen, pages = ConsentDialog(LONG), "", 0
    while not is_last(reading):
        seen += "".join(reading.panel().lines)
        pages += 1
        assert reading.panel().ink().shape == ConsentDialog(LONG).panel().ink().shape  # no page jumps
        reading.handle(said("confirm"))
    seen += "".join(reading.panel().lines)
    assert "".join(seen.split()) == "".join(LONG.split()) and pages >= 3
    assert reading.panel().title == f"Before we begin ({pages + 1} of {pages + 1})"
    reading.handle(said(("press", place_of(reading.panel(), "back")), "confirm"))
    assert not reading.agreed and is_last(reading)  # back, and on again
    reading.handle(said("right", "confirm"))
    assert reading.agreed


@given(commands)
def test_no_input_but_an_agreement_agrees(sent):
    reading = ConsentDialog(LONG)
    for command in sent:
        last_page = is_last(reading) or reading.panel().title == "End without taking part?"
        was = reading.agreed or reading.refused
        reading.handle([command])
        assert not (reading.agreed and reading.refused)
        assert was or last_page or not (reading.agreed or reading.refused)


GRADE = load_scale("grade")
QUESTION_KEYS = said(
    "left", "right", "up", "down", "erase", "confirm", "skip", "menu", "full_screen", "agree", "no such"
)
places = st.tuples(st.floats(0, 1), st.floats(0, 1))
anything = st.one_of(
    st.sampled_from(QUESTION_KEYS),
    st.sampled_from(list("0123456789.,")).map(lambda key: said(("digit", key))[0]),
    st.tuples(st.sampled_from(["point", "press"]), places).map(lambda one: said(one)[0]),
    st.one_of(st.floats(), st.integers(-200, 200), st.none()).map(lambda number: said(("answer", number))[0]),
)


def asked(*commands, typed: str = "") -> QuestionDialog:
    """A question of grades after these digits and commands."""
    question = asked_of(GRADE)
    question.handle(said(*(("digit", key) for key in typed), *commands))
    return question


@given(any_scale, st.lists(anything, max_size=40))
def test_any_input_gives_an_answer_of_the_scale_or_none(scale, commands):
    one, values = asked_of(scale), set(scale.values())
    for command in commands:
        before = (one.confirmed, one.skipped, one.value)
        one.handle([command])
        assert one.value is None or one.value in values
        assert not before[0] or (one.confirmed, one.skipped, one.value) == before  # confirmed once and for all
        assert one.confirmed or not one.skipped
        assert not one.confirmed or (one.value is None) == one.skipped
        assert one.question().entered == one.value


@together("scale", SHIPPED)
def test_no_answer_is_preselected_and_an_empty_one_is_not_confirmed(scale):
    one = asked_of(scale)
    assert one.value is None and one.panel().value is None
    one.handle(said("confirm"))
    assert not one.confirmed and "Choose an answer first" in one.note
    assert one.panel().note == one.note


@given(any_scale, st.data())
def test_every_value_can_be_stepped_to_typed_and_answered_at_once(scale, data):
    values = scale.values()
    wanted, one = data.draw(st.sampled_from(values)), asked_of(scale)
    one.handle(said("right"))
    assert one.value == values[len(values) // 2]
    one.handle(said(*["left"] * len(values)))
    assert one.value == values[0]  # and no further
    one.handle(said(*["right"] * values.index(wanted), "confirm"))
    answered, typed = asked_of(scale), asked_of(scale)
    answered.handle(said(("answer", wanted)))  # console and respondents
    point = data.draw(st.sampled_from(".,"))
    typed.handle(said(*(("digit", point if key == "." else key) for key in number_text(wanted)), "confirm"))
    for each in (one, answered, typed)[: 3 if wanted >= 0 else 2]:  # digits have no sign
        assert (each.value, each.confirmed, each.skipped) == (wanted, True, False)


def test_a_note_goes_after_a_while():
    now = [0.0]
    one = asked_of(load_scale("acr"), now_s=lambda: now[0])
    one.handle(said("confirm"))
    for now[0], there in ((0.0, True), (4.9, True), (5.1, False)):
        assert bool(one.note) == there


def test_a_mouse_that_is_pushed_does_not_change_what_was_typed_and_a_click_does():
    panel = asked().panel()
    there = next(
        (u / 100, v / 100) for u in range(5, 96, 5) for v in range(5, 96, 5) if panel.value_at(u / 100, v / 100) == 4.0
    )
    one = asked(("point", there), typed="2")
    assert one.value == 2.0
    one.handle(said("erase", ("point", there)))
    assert one.value == 4.0
    one.handle(said(("digit", "2"), ("press", there)))
    assert one.confirmed and one.value == 4.0


EVERY = together("scale", SHIPPED)


def panel_of(scale, value=None, hints=KEYS) -> QuestionPanel:
    return attrs.evolve(asked_of(scale, hints).panel(), value=value)


def marker_of(scale, value) -> tuple[float, float]:
    """(x, y) of where the marker is in the panel's picture, from the picture alone. What is there
    that is not there without a value.
    """
    plain, marked = (panel_of(scale, at).ink().astype(int) for at in (None, value))
    assert plain.shape == marked.shape
    new = marked - plain > 0
    if isinstance(layout_of(panel_of(scale).form), LineLayout):
        # Under the number stands a triangle: the widest thing whose rows shrink to a point.
        labels, count = ndimage.label(marked - plain > 200)
        boxes = ndimage.find_objects(labels)
        lowest = max(boxes, key=lambda box: box[0].stop)
        tip = np.flatnonzero(new[lowest[0].stop - 2])
        return float(tip.mean()), float(lowest[0].stop - 2)
    rows, columns = np.nonzero(new)
    return float(columns.mean()), float((rows.min() + rows.max()) / 2)


@EVERY
def test_pointing_finds_what_is_drawn(scale):
    values = scale.values()
    panel = panel_of(scale)
    for value in {values[0], values[1], values[len(values) // 2], values[-2], values[-1]}:
        x, y = marker_of(scale, value)
        assert panel.value_at((x + 0.5) / WIDTH, 1 - (y + 0.5) / panel.height()) == value


@together("scale, hints", product(SHIPPED, [KEYS, CONTROLLERS]))
def test_panels_cut_nothing_off_and_do_not_jump(scale, hints):
    noted = attrs.evolve(panel_of(scale, None, hints), note="3.2 is no answer here: expected 1 to 6 in steps of 0.25")
    inks = [panel.ink() for panel in (noted, *(panel_of(scale, at, hints) for at in (None, scale.least, scale.most)))]
    assert len({ink.shape for ink in inks}) == 1
    for ink in inks[1:]:
        assert ink.dtype == np.uint8 and ink.shape[1] == WIDTH
        assert not any(edge.any() for edge in (ink[0], ink[-1], ink[:, 0], ink[:, -1]))
    height = inks[0].shape[0]  # all of it is seen at full size in a headset; Notice._in_head: 0.056 m for 38 pixels
    assert WIDTH * 0.056 / 38 <= MAX_WIDTH_M and height * 0.056 / 38 <= MAX_HEIGHT_M


@settings(max_examples=60)
@given(any_scale, st.floats(0, 1), st.floats(0, 1))
def test_every_scale_is_drawn_and_pointed_at(scale, u, v):
    panel = panel_of(scale, scale.values()[0])
    ink = panel.ink()
    assert ink.shape == (panel.height(), WIDTH) and ink.max() == 255
    assert panel.value_at(u, v) in (None, *scale.values())
    assert attrs.evolve(panel, skipping=True).value_at(u, v) is None
    assert panel.button_at(u, v) in ("", "skip")


def test_words_do_not_overlap():
    for scale in SHIPPED:
        layout = layout_of(panel_of(scale).form)
        if isinstance(layout, LineLayout):
            for row in (0, 1):
                placed = [button for button in layout._placed if button.row == row]
                halves = [max(width_of(line, 24) for line in button.lines) / 2 for button in placed]
                for (a, half_a), (b, half_b) in pairwise(zip(placed, halves, strict=True)):
                    assert b.x - half_b - (a.x + half_a) > 4
            assert {button.value for button in layout._placed} == set(scale.anchors)


def test_a_panel_lies_in_the_middle_and_a_text_at_the_bottom(gpu):
    presenter, size = Presenter(gpu), (600, 800)
    try:
        panel, text = presenter.notice(panel_of(SHIPPED[0])), presenter.notice("tracking lost")
        middle = panel.uv_from_pixel(size, None) @ (300, 400, 1)
        assert np.allclose(middle, (0.5, 0.5, 1), atol=1 / panel.ink.height)  # to the pixel
        assert (text.uv_from_pixel(size, None) @ (300, 400, 1))[1] > 1  # above it
        eye = WindowView("both", load_headset("rift-dk1"), None).eyes.views(Pose((0, 1.6, 0)))[0]
        tall = presenter.notice(panel_of(next(scale for scale in SHIPPED if scale.name == "misc")))
        for notice in (panel, tall):
            corners = [notice.uv_from_pixel((640, 800), eye) @ (x, y, 1) for x in (0, 640) for y in (0, 800)]
            uv = np.array([corner[:2] / corner[2] for corner in corners])
            assert uv.min(axis=0).max() < 0 and uv.max(axis=0).min() > 1, "an eye sees all of it"
    finally:
        presenter.close()


@given(st.sampled_from([40, 200, 636]), st.text(alphabet="ab cdefg\n", max_size=200))
def test_wrapped_text_fits_and_loses_nothing(width, text):
    rows = wrapped(text, TEXT, width)
    assert all(width_of(row, TEXT) <= width or len(row) == 1 for row in rows)
    assert "".join("".join(rows).split()) == "".join(text.split())
