"""The controls of a run as widgets, each with its key next to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import fmean

import attrs
import numpy as np
from imgui_bundle import imgui, implot

from ... import Command
from ...controls import CONTROLS, KEPT, Control, Status
from . import panel_style as style

LABEL, KEY = 60.0, 50.0  # widths of the columns, at a content scale of 1
STEP = {"latency": 10.0, "guard": 0.05}  # a slider's; a typed number (ctrl and click) is taken as it is
FORMAT = {"latency": "%.0f ms", "guard": "%.2f x"}
STATES = {
    "view": (("both", "both eyes"), ("flat", "one flat view"))
}  # switches between two states, neither of which is off
PATIENCE_S = 0.5  # how long a requested value is shown before the run's own is shown again
ACTING = ("action", "hold")  # kinds of controls that have no value
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
        self._by_kind |= dict.fromkeys(ACTING, self._act)

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
                if not control.of_display and (control.name in status.values or control.kind in ACTING):
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
        value = requested.value if requested else status.values.get(control.name)
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

    def _act(self, control: Control, _: object, __: Status) -> object | None:
        if button(f"{control.name}##acts", -1, lit=False):
            self._commands.append(Command(control.name))
        return None

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


HEIGHT = 34.0  # of a plot, at a content scale of 1
CALM = 15  # refreshes averaged in a printed number: a quarter of a second, to be readable
BARE = implot.Flags_.canvas_only | implot.Flags_.no_inputs | implot.Flags_.no_frame
AXIS = implot.AxisFlags_.no_decorations


@attrs.frozen
class Plot:
    """One line over the last refreshes."""

    name: str
    values: Sequence[float]
    unit: str = "ms"
    limit: float | None = None  # value of a horizontal line, None for none
    names_limit: bool = False  # whether the number includes the limit
    over: float = math.inf  # above this the number is highlighted as bad
    least: float = 1.0  # lowest top of the axis, so that noise does not fill the plot


def plots_of(status: Status) -> list[Plot]:
    """Return what is plotted, from the top."""
    budget = status.budget_ms or None
    bad = budget or math.inf
    latency = status.values.get("latency")
    holes = [100 * share for share in status.holes]
    return [
        Plot("all passes", status.total_ms, limit=budget, names_limit=True, over=bad, least=1.2 * (budget or 1.0)),
        # Any two refreshes differ a little; half a refresh late means a missed picture.
        Plot("between pictures", status.period_ms, limit=budget, over=1.5 * bad, least=2 * (budget or 1.0)),
        Plot(
            "frame age at display",
            status.age_ms,
            limit=latency if isinstance(latency, int | float) and latency else None,
            least=20.0,
        ),
        Plot("pose age at hand-over", status.pose_age_ms, least=5.0),
        Plot("holes before the fill", holes, unit="%", least=5.0),
    ]


def draw_plots(status: Status, scale: float) -> None:
    """Draw all of them, one under the other."""
    for plot in plots_of(status):
        values = np.fromiter(plot.values, np.float64, len(plot.values))
        # fmax ignores NaN; a tenth more keeps the line off the edge.
        top = ceiling(1.1 * max(float(np.fmax.reduce(values, initial=plot.least)), plot.limit or 0.0))
        now = calm(plot.values)
        imgui.text_disabled(plot.name)
        imgui.same_line()
        imgui.text_colored(imgui.ImVec4(*style.FAINT), f"0 to {top:g}")
        right_aligned(number_text(now, plot), style.BAD if now is not None and now > plot.over else style.TEXT)
        _draw(plot, values, top, scale)


def _draw(plot: Plot, values: np.ndarray, top: float, scale: float) -> None:
    if not implot.begin_plot(f"##{plot.name}", (-1, HEIGHT * scale), BARE):
        return
    implot.setup_axes("", "", AXIS, AXIS)
    implot.setup_axes_limits(0, KEPT - 1, 0, top, implot.Cond_.always)
    if plot.limit is not None:
        flags = int(implot.InfLinesFlags_.horizontal)
        implot.plot_inf_lines("limit", np.array([plot.limit]), implot.Spec(line_color=style.LIMIT, flags=flags))
    known = np.isfinite(values)  # holes are not counted at every refresh; a NaN would become a corner of the drawing
    if known.any():
        at = np.arange(KEPT - len(values), KEPT, dtype=np.float64)[known]  # the newest at the right edge
        implot.plot_shaded("area", at, values[known], 0, implot.Spec(fill_color=style.ACCENT, fill_alpha=0.22))
        implot.plot_line("line", at, values[known], implot.Spec(line_color=style.ACCENT, line_weight=1.4 * scale))
    implot.end_plot()


def calm(values: Iterable[float]) -> float | None:
    """Return the mean of the last few numbers; None for none."""
    last = [value for value in list(values)[-CALM:] if not math.isnan(value)]
    return fmean(last) if last else None


def number_text(value: float | None, plot: Plot) -> str:
    """Return a number and its unit, in about three figures; "-" for none."""
    limit = f" of {plot.limit:.1f}" if plot.names_limit and plot.limit else ""
    return "-" if value is None else f"{value:.{0 if abs(value) >= 100 else 1}f}{limit} {plot.unit}"


def ceiling(most: float) -> float:
    """Return the next round number: it keeps the axis steady while values change."""
    if not (math.isfinite(most) and most > 0):
        return 1.0
    ten = 10.0 ** math.floor(math.log10(most))
    return next(ten * step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12) if ten * step >= most * (1 - 1e-9))


def right_aligned(text: str, colour: style.Rgba) -> None:
    """Draw at the right end of the current line."""
    imgui.same_line()
    room = imgui.get_content_region_avail().x - imgui.calc_text_size(text).x
    imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + max(room, 0.0))
    imgui.text_colored(imgui.ImVec4(*colour), text)


class Stages:
    """The stages of the last refresh, end to end in one bar against the budget, with their times.

    A stage keeps its colour.
    """

    def __init__(self) -> None:
        self._order: list[str] = []
        self._calm: dict[str, float] = {}

    def draw(self, status: Status, scale: float) -> None:
        """Draw both eyes' times."""
        self._take(status.stage_ms)
        if not self._calm:
            imgui.text_disabled("not measured yet")
            return
        self._bar(status.budget_ms, scale)
        self._legend()

    def _take(self, stage_ms: dict[str, float]) -> None:
        """Drop stages that are gone; change the others slowly, so that they can be read."""
        self._order += [name for name in stage_ms if name not in self._order]
        self._calm = {name: took + 0.7 * (self._calm.get(name, took) - took) for name, took in stage_ms.items()}

    def _colour(self, name: str) -> style.Rgba:
        return style.STAGES[self._order.index(name) % len(style.STAGES)]

    def _bar(self, budget_ms: float, scale: float) -> None:
        total = sum(self._calm.values())
        width, height = imgui.get_content_region_avail().x, 14.0 * scale
        whole = max(total, budget_ms * 1.04) or 1.0
        at = imgui.get_cursor_screen_pos()
        draw = imgui.get_window_draw_list()
        draw.add_rect_filled((at.x, at.y), (at.x + width, at.y + height), style.u32((1, 1, 1, 0.06)), 3 * scale)
        x = at.x
        for name in self._shown():
            wide = width * self._calm[name] / whole
            draw.add_rect_filled((x, at.y), (x + wide, at.y + height), style.u32(self._colour(name)))
            x += wide
        if budget_ms:
            x = at.x + width * budget_ms / whole
            draw.add_line((x, at.y - 3 * scale), (x, at.y + height + 3 * scale), style.u32(style.WARN), 1.5 * scale)
        imgui.dummy((width, height + 3 * scale))

    def _shown(self) -> list[str]:
        return [name for name in self._order if name in self._calm]

    def _legend(self) -> None:
        if not imgui.begin_table("stages", 2, imgui.TableFlags_.sizing_stretch_same | imgui.TableFlags_.pad_outer_x):
            return
        for name in self._shown():
            imgui.table_next_column()
            at, size = imgui.get_cursor_screen_pos(), imgui.get_font_size()
            square = (at.x, at.y + 0.28 * size), (at.x + 0.55 * size, at.y + 0.83 * size)
            imgui.get_window_draw_list().add_rect_filled(*square, style.u32(self._colour(name)), 0.12 * size)
            imgui.dummy((0.55 * size, size))
            imgui.same_line()
            imgui.text_disabled(name)
            right_aligned(f"{self._calm[name]:.1f}", style.TEXT)
        imgui.end_table()
