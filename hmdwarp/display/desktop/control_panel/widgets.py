"""The controls of a run as widgets, each with its key next to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import attrs
from imgui_bundle import imgui

from ... import Command
from ...controls import CONTROLS, Control, Status
from . import panel_style as style

LABEL, KEY = 60.0, 50.0  # widths of the columns, at a content scale of 1
STEP = {"latency": 10.0, "guard": 0.05}  # a slider's; a typed number (ctrl and click) is taken as it is
FORMAT = {"latency": "%.0f ms", "guard": "%.2f x"}
STATES = {
    "view": (("both", "both eyes"), ("flat", "one flat view"))
}  # switches between two states, neither of which is off
PATIENCE_S = 0.5  # how long a requested value is shown before the run's own is shown again
ACTIONS = ("recentre", "full_screen", "vsync", "help", "panel", "quit")
LIT = ("full_screen", "vsync", "help")  # actions drawn lit while on; the panel itself is on wherever it is visible
LABELS = {
    "recentre": "recentre",
    "full_screen": "full screen",
    "vsync": "vsync",
    "help": "help",
    "panel": "hide",
    "quit": "end",
}


@attrs.define
class _Requested:
    """A value that the run has not adopted yet."""

    value: object
    until_s: float


# Draws one control with its value; returns the new value, None for no change.
Widget = Callable[[Control, object, Status], object | None]


class Widgets:
    """Widgets for some controls, which turn input into commands.

    label: returns what is printed on a key.
    """

    def __init__(self, label: Callable[[str], str], controls: tuple[Control, ...] = CONTROLS) -> None:
        self._label, self._controls = label, controls
        self._requested: dict[str, _Requested] = {}
        self._commands: list[Command] = []
        self._dragged: dict[str, float] = {}
        self._by_kind: dict[str, Widget] = {"choice": self._choice, "number": self._number, "switch": self._switch}

    def draw(self, status: Status, scale: float, now_s: float) -> list[Command]:
        """Draw the rows of controls that change the run; return the requests.

        now_s: on any running clock.
        """
        self._forget(status, now_s)
        if imgui.begin_table("controls", 3, imgui.TableFlags_.sizing_fixed_fit):
            imgui.table_setup_column("what", imgui.TableColumnFlags_.width_fixed, LABEL * scale)
            imgui.table_setup_column("value", imgui.TableColumnFlags_.width_stretch)
            imgui.table_setup_column("key", imgui.TableColumnFlags_.width_fixed, KEY * scale)
            for control in self._controls:
                if not control.of_display and control.name in status.values:
                    self._row(control, status, now_s)
            imgui.end_table()
        commands, self._commands = self._commands, []
        return commands

    def _row(self, control: Control, status: Status, now_s: float) -> None:
        imgui.table_next_row()
        imgui.table_next_column()
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(control.name)
        imgui.table_next_column()
        imgui.set_next_item_width(-1)
        requested = self._requested.get(control.name)
        value = requested.value if requested else status.values[control.name]
        new = self._by_kind[control.kind](control, value, status)
        if new is not None:
            self._requested[control.name] = _Requested(new, now_s + PATIENCE_S)
            self._commands.append(Command(control.name, new))
        imgui.table_next_column()
        keycap(keys_of(control, self._label))

    def _forget(self, status: Status, now_s: float) -> None:
        done = [
            name for name, one in self._requested.items() if now_s > one.until_s or status.values.get(name) == one.value
        ]
        for name in done:
            del self._requested[name]

    # --- one widget for each kind of control ---

    def _choice(self, control: Control, value: object, status: Status) -> object | None:
        new = None
        if imgui.begin_combo(f"##{control.name}", str(value), imgui.ComboFlags_.height_large):
            for choice in status.choices.get(control.name, ()):
                chosen, _ = imgui.selectable(str(choice), choice == value)
                if choice == value:
                    imgui.set_item_default_focus()
                elif chosen:
                    new = choice
            imgui.end_combo()
        return new

    def _number(self, control: Control, value: object, _: Status) -> object | None:
        """Draw a slider.

        Latency follows the drag; any other number is applied on release, because it may rebuild the
        pipeline.
        """
        name, follows = control.name, control.name == "latency"
        if not isinstance(value, int | float):
            imgui.text(str(value))
            return None
        shown = self._dragged.get(name, float(value))
        moved, now = imgui.slider_float(
            f"##{name}", shown, *control.span, FORMAT.get(name, "%g"), imgui.SliderFlags_.always_clamp
        )
        if moved:
            typed = imgui.get_io().want_text_input
            self._dragged[name] = now if typed else round(now / STEP[name]) * STEP[name]
        if not imgui.is_item_active() and not moved and name not in self._dragged:
            return None
        new = self._dragged.get(name, float(value))
        ended = not imgui.is_item_active()
        if ended:
            self._dragged.pop(name, None)
        new = round(new, 3)
        return new if (follows or ended) and new != value else None

    def _switch(self, control: Control, value: object, _: Status) -> object | None:
        states = STATES.get(control.name)
        if states is None:
            changed, on = imgui.checkbox(f"##{control.name}", value not in ("none", False))
            imgui.same_line()
            imgui.align_text_to_frame_padding()
            imgui.text(str(value) if isinstance(value, str) else ("on" if value else "off"))
            return (on if isinstance(value, bool) else "auto" if on else "none") if changed else None
        width = (imgui.get_content_region_avail().x - imgui.get_style().item_spacing.x) / len(states)
        new = None
        for number, (state, text) in enumerate(states):
            if number:
                imgui.same_line()
            if button(f"{text}##{control.name}", width, lit=state == value) and state != value:
                new = state
        return new

    def actions(self, values: Mapping[str, object]) -> list[Command]:
        """Draw buttons for the controls of the display. values: which of its switches are on."""
        commands, across = [], 2
        width = (imgui.get_content_region_avail().x - (across - 1) * imgui.get_style().item_spacing.x) / across
        for number, control in enumerate(
            control for name in ACTIONS for control in self._controls if control.name == name
        ):
            if number % across:
                imgui.same_line()
            at = imgui.get_cursor_screen_pos()
            if button(f"##{control.name}", width, lit=values.get(control.name) is True and control.name in LIT):
                commands.append(Command(control.name))
            _caption(at, width, LABELS[control.name], keys_of(control, self._label))
        return commands


def _caption(at: imgui.ImVec2, width: float, text: str, key: str) -> None:
    """Draw text at the left of a button, its key dim at the right."""
    padding = imgui.get_style().frame_padding
    draw = imgui.get_window_draw_list()
    draw.add_text((at.x + padding.x, at.y + padding.y), style.u32(style.TEXT), text)
    right = at.x + width - padding.x - imgui.calc_text_size(key).x
    draw.add_text((right, at.y + padding.y), style.u32(style.DIM), key)


def button(text: str, width: float, lit: bool) -> bool:
    """Draw a button that may be lit; return whether it was pressed."""
    if lit:
        imgui.push_style_color(imgui.Col_.button, imgui.get_style_color_vec4(imgui.Col_.button_active))
    pressed = imgui.button(text, (width, 0))
    if lit:
        imgui.pop_style_color()
    return pressed


def keys_of(control: Control, label: Callable[[str], str]) -> str:
    """Return its keys in a few letters, the one for a step back first."""
    keys = [{"Escape": "Esc"}.get(key, label(key)) for key in (control.back, control.key) if key]
    return " ".join(keys)


def keycap(text: str) -> None:
    """Draw a key as on a keyboard, one box for each word, right-aligned."""
    pad = imgui.get_style().frame_padding
    words = text.split()
    gap = pad.x * 0.5
    widths = [max(imgui.calc_text_size(word).x + 1.6 * pad.x, imgui.get_text_line_height()) for word in words]
    height = imgui.get_frame_height()
    at = imgui.get_cursor_screen_pos()
    x = at.x + imgui.get_content_region_avail().x - sum(widths) - gap * (len(words) - 1)
    draw = imgui.get_window_draw_list()
    for word, width in zip(words, widths, strict=True):
        top, bottom = at.y + pad.y * 0.4, at.y + height - pad.y * 0.4
        draw.add_rect_filled((x, top), (x + width, bottom), style.u32((1, 1, 1, 0.07)), pad.x * 0.5)
        middle = x + (width - imgui.calc_text_size(word).x) / 2
        draw.add_text((middle, at.y + pad.y), style.u32(style.DIM), word)
        x += width + gap
    imgui.dummy((0, height))
