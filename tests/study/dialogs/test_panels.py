"""Panels.

What is drawn where pointing finds it, nothing beyond the paper, nothing that jumps, and soon done.
"""

from __future__ import annotations

from itertools import pairwise, product

import attrs
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from together import together

from hmdwarp.display import MAX_HEIGHT_M, MAX_WIDTH_M, Notices
from hmdwarp.display.desktop import window_view
from hmdwarp.display.present import KEPT
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset
from hmdwarp.study.dialogs.choice_dialogs import ConsentDialog, MenuDialog
from hmdwarp.study.dialogs.dialog_panels import (
    CONTROLLERS,
    KEYS,
    PAD,
    TEXT,
    WIDTH,
    Button,
    Canvas,
    LineLayout,
    QuestionPanel,
    ScaleForm,
    layout_of,
    message_panel,
    trial_panel,
    width_of,
    wrapped,
)

from .made_scales import SHIPPED, any_scale, asked_of, place_of, said

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


def test_numbers_at_the_line_do_not_touch():
    scales = [(1, 6, 0.25), (0, 20, 1), (0, 100, 1), (0, 1, 0.01), (0, 10000, 1), (-3, 3, 1), (0, 7, 0.1), (0, 97, 1)]
    for least, most, step in scales:
        layout = layout_of(ScaleForm(float(least), float(most), float(step)))
        xs = sorted(width_of(f"{label:g}", 24) / 2 + 36 for label in layout._labels)
        assert {float(least), float(most)} <= set(layout._labels), "both ends have their numbers"
        apart = (WIDTH - 2 * PAD - 72) / max(len(layout._labels) - 1, 1)
        assert apart > 2 * (xs[-1] - 36)
        assert len(layout._ticks) <= 121


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


def test_the_buttons_of_a_panel_are_where_they_are_drawn():
    asked = asked_of(SHIPPED[0])
    asked.handle(said(("press", place_of(asked.panel(), "skip"))))
    assert asked.panel().skipping and not asked.confirmed
    asked.handle(said(("press", place_of(asked.panel(), "back"))))
    assert not asked.panel().skipping
    asked.handle(said("skip"))
    asked.handle(said(("press", place_of(asked.panel(), "yes"))))
    assert asked.skipped


def test_a_button_s_text_keeps_clear_of_its_edges():
    """By 8 pixels on each side: a smaller size is taken instead."""
    text = "End the session"
    for px in (28, 24):
        for spare in (0, 8, 15, 16):
            right = 10 + width_of(text, px) + spare
            inks = []
            for written in (text, ""):
                canvas = Canvas(60)
                Button("stop", written, 10, 2, right).draw(canvas, marked=False)
                inks.append(canvas.ink().copy())
            at = np.flatnonzero((inks[0] != inks[1]).any(axis=0))
            assert len(at) and at.min() >= 10 + 7 and at.max() <= right - 7


def test_a_press_on_the_scale_answers():
    scale = next(scale for scale in SHIPPED if scale.name == "grade")
    asked, (x, y) = asked_of(scale), marker_of(scale, 4.25)
    place = ((x + 0.5) / WIDTH, 1 - (y + 0.5) / asked.panel().height())
    asked.handle(said(("point", place)))
    assert (asked.value, asked.confirmed) == (4.25, False)
    asked.handle(said(("press", place)))
    assert (asked.value, asked.confirmed) == (4.25, True)


def test_a_panel_lies_in_the_middle_and_a_text_at_the_bottom(gpu):
    notices, size = Notices(gpu.gl), (600, 800)
    try:
        panel, text = notices.of(panel_of(SHIPPED[0])), notices.of("tracking lost")
        middle = panel.uv_from_pixel(size, None) @ (300, 400, 1)
        assert np.allclose(middle, (0.5, 0.5, 1), atol=1 / panel.ink.height)  # to the pixel
        assert (text.uv_from_pixel(size, None) @ (300, 400, 1))[1] > 1  # above it
        eye = window_view("both", load_headset("rift-dk1"), None).eyes.views(Pose((0, 1.6, 0)))[0]
        tall = notices.of(panel_of(next(scale for scale in SHIPPED if scale.name == "misc")))
        for notice in (panel, tall):
            corners = [notice.uv_from_pixel((640, 800), eye) @ (x, y, 1) for x in (0, 640) for y in (0, 800)]
            uv = np.array([corner[:2] / corner[2] for corner in corners])
            assert uv.min(axis=0).max() < 0 and uv.max(axis=0).min() > 1, "an eye sees all of it"
    finally:
        notices.close()


def test_a_marker_that_moves_leaves_no_textures_behind(gpu):
    """A hundred panels; no more than KEPT stay."""
    notices, asked = Notices(gpu.gl), asked_of(next(scale for scale in SHIPPED if scale.name == "slider"))
    try:
        asked.handle(said("left"))
        for number in range(100):
            asked.handle(said("right" if number < 40 else "left"))
            panel = asked.panel()
            assert panel == asked.panel() and hash(panel) == hash(asked.panel())
            assert notices.of(panel) is notices.of(asked.panel())
        assert len(notices._kept) == KEPT
    finally:
        notices.close()


@given(st.sampled_from([40, 200, 636]), st.text(alphabet="ab cdefg\n", max_size=200))
def test_wrapped_text_fits_and_loses_nothing(width, text):
    rows = wrapped(text, TEXT, width)
    assert all(width_of(row, TEXT) <= width or len(row) == 1 for row in rows)
    assert "".join("".join(rows).split()) == "".join(text.split())


def test_cards_are_drawn():
    message = message_panel("A title", "some text " * 30, "a hint")
    for made in (message, trial_panel(3, 12), trial_panel(0, 12), MenuDialog().panel(), ConsentDialog("x").panel()):
        ink = made.ink()
        assert ink.shape == (made.height(), WIDTH) and ink.max() == 255
        assert hash(made) == hash(attrs.evolve(made))
    assert not trial_panel(3, 12).pointed and MenuDialog().panel().pointed
    assert trial_panel(3, 12).title == "Trial 3 of 12"
