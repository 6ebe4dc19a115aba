"""Scales and questions for the tests of asking: the shipped ones, and any others there could be."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from hmdwarp.display import Command
from hmdwarp.study.design import Ask
from hmdwarp.study.dialogs.dialog_panels import KEYS, InputHints, QuestionDialog
from hmdwarp.study.scales import Item, Scale, load_scale, scale_names

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
