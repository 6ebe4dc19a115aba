"""The control panel: controls with their keys, plots and stages, drawn by Dear ImGui."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from statistics import fmean
from typing import Any

import glfw
import moderngl
import numpy as np
from imgui_bundle import imgui
from imgui_bundle.imgui import backends
from imgui_bundle.python_backends.glfw_backend import GlfwRenderer

from ....gpu import VERSION, drawing_into
from ... import Command
from ...controls import Control, Status
from ..window_system import WindowHandle
from . import WIDTH

_CALM_HZ = 15.0  # new frames without input; in between the last one is drawn again
_LIVELY_S = 0.4  # a new frame at every refresh after start and input: widgets need a few for their sizes
_Flags = imgui.WindowFlags_
FLAGS = _Flags.no_title_bar | _Flags.no_resize | _Flags.no_move | _Flags.no_nav | _Flags.always_auto_resize
BAD, WARN = imgui.ImVec4(1.0, 0.42, 0.36, 1.0), imgui.ImVec4(1.0, 0.76, 0.3, 1.0)
LIT, PLAIN = imgui.ImVec4(0.2, 0.45, 0.43, 1.0), imgui.ImVec4(0.9, 0.92, 0.94, 1.0)
STEP = {"latency": 10.0, "guard": 0.05}  # a slider's; a typed number (ctrl and click) is taken as it is
FORMAT = {"latency": "%.0f ms", "guard": "%.2f x"}


class _Backend(GlfwRenderer):  # type: ignore[misc]  # it has no types
    """The bundle's GLFW backend, which draws with the bundle's compiled OpenGL backend.

    Its own drawing fails in a context of EGL under X11, and leaves blending and a texture changed.
    """

    def _create_device_objects(self) -> None:
        backends.opengl3_init(VERSION)


class ControlPanel:
    """Controls and plots over the right edge of a window. label: what is printed on a key."""

    def __init__(
        self, window: WindowHandle, gl: moderngl.Context, controls: tuple[Control, ...], label: Callable[[str], str]
    ) -> None:
        self._window, self._gl, self._controls, self._label = window, gl, controls, label
        self._context = imgui.create_context()
        imgui.get_io().set_ini_filename("")
        imgui.style_colors_dark()
        _ = gl.error  # else PyOpenGL raises in what follows what went wrong before
        self._backend = _Backend(window, attach_callbacks=False)
        self.on = True  # whether it is visible; while off, it draws nothing and takes no input
        self._closed = False
        self._scale, self._height = 1.0, 0.0
        self._drawn_s, self._lively_until_s = -math.inf, glfw.get_time() + _LIVELY_S
        self._dragged: dict[str, float] = {}
        self._commands: list[Command] = []
        for setter, callback in (
            (glfw.set_key_callback, self._backend.keyboard_callback),
            (glfw.set_char_callback, self._backend.char_callback),
            (glfw.set_cursor_pos_callback, self._backend.mouse_callback),
            (glfw.set_mouse_button_callback, self._backend.mouse_button_callback),
            (glfw.set_scroll_callback, self._backend.scroll_callback),
        ):
            self._chain(setter, callback)

    def _chain(self, setter: Callable[..., Any], callback: Callable[..., None]) -> None:
        def both(*arguments: Any) -> None:
            if self.on and not self._captured:
                callback(*arguments)
                if self.wants_mouse or self.wants_keys:
                    self._lively_until_s = glfw.get_time() + _LIVELY_S
            elif not self._closed:
                self._backend.io.clear_input_keys()
                self._backend.io.clear_input_mouse()
            if before:
                before(*arguments)

        before = setter(self._window, both)

    @property
    def _captured(self) -> bool:
        return bool(glfw.get_input_mode(self._window, glfw.CURSOR) == glfw.CURSOR_DISABLED)

    @property
    def column(self) -> int:
        """Width in framebuffer pixels at the right edge; 0 while it is off."""
        return round(WIDTH * max(glfw.get_window_content_scale(self._window))) if self.on else 0

    @property
    def wants_mouse(self) -> bool:
        """Whether the mouse belongs to the panel: it is over it, or held down since it was."""
        if not self.on or self._captured:
            return False
        (x, y), right = glfw.get_cursor_pos(self._window), self._backend.io.display_size.x
        over = right - WIDTH * self._scale <= x < right and 0 <= y < self._height
        return over or bool(self._backend.io.want_capture_mouse)

    @property
    def wants_keys(self) -> bool:
        """Whether a number is being typed into the panel; otherwise keys go to the window."""
        return self.on and bool(self._backend.io.want_text_input)

    def draw(self, status: Status, framebuffer_size: tuple[int, int]) -> list[Command]:
        """Draw the panel over the window's framebuffer, (w, h) in pixels, and return its commands.

        These include the display's own controls.
        """
        if not self.on or min(framebuffer_size) < 1:
            return []
        now_s = glfw.get_time()
        if now_s < self._lively_until_s or now_s - self._drawn_s >= 1 / _CALM_HZ:
            self._drawn_s = now_s
            self._new_frame(status)
        with drawing_into(self._gl.screen):
            backends.opengl3_render_draw_data(imgui.get_draw_data())
        commands, self._commands = self._commands, []
        return commands

    def _new_frame(self, status: Status) -> None:
        backends.opengl3_new_frame()
        self._backend.process_inputs()
        io = self._backend.io
        scale = max(glfw.get_window_content_scale(self._window)) / max(io.display_framebuffer_scale.x, 1.0)
        if scale != self._scale:
            imgui.get_style().scale_all_sizes(scale / self._scale)
            imgui.get_style().font_scale_dpi = self._scale = scale
        imgui.new_frame()
        width = min(WIDTH * scale, io.display_size.x)
        imgui.set_next_window_pos((io.display_size.x - width, 0))
        imgui.set_next_window_size_constraints((width, 0), (width, io.display_size.y))
        imgui.set_next_window_bg_alpha(0.86)
        imgui.begin("hmdwarp", None, FLAGS)
        wanted = f" of {1e3 / status.budget_ms:.0f}, {status.budget_ms:.1f} ms each" if status.budget_ms else ""
        imgui.text(f"{status.rate_hz:.0f} fps{wanted},")
        imgui.same_line()
        imgui.text_colored(WARN if status.missed else PLAIN, f"{status.missed} missed")
        if status.recording:
            imgui.text_colored(BAD, "recording")
        if status.notice:
            imgui.text_wrapped(status.notice)
        self._draw_controls(status)
        for name, values, unit, least, bad in plots_of(status):
            # Holes are not counted at every refresh.
            known = np.array([value for value in values if math.isfinite(value)], np.float32)
            now = fmean(known[-15:]) if len(known) else None  # of a quarter of a second, to be readable
            text = f"{name}: -" if now is None else f"{name}: {now:.{0 if now >= 100 else 1}f} {unit}"
            imgui.push_style_color(imgui.Col_.text, BAD if now is not None and now > bad else PLAIN)
            imgui.plot_lines(f"##{name}", known, 0, text, 0.0, max([least, *known]), (-1, 36 * scale))
            imgui.pop_style_color()
        imgui.text_disabled("stages, in ms" if status.stage_ms else "stages: not measured yet")
        whole = max(status.budget_ms, sum(status.stage_ms.values())) or 1.0
        for name, took_ms in status.stage_ms.items():
            imgui.progress_bar(took_ms / whole, (-1, 0), f"{name} {took_ms:.1f}")
        self._draw_actions(status)
        self._height = imgui.get_window_height()
        imgui.end()
        imgui.render()

    def _draw_controls(self, status: Status) -> None:
        if not imgui.begin_table("controls", 3, imgui.TableFlags_.sizing_fixed_fit):
            return
        imgui.table_setup_column("name")
        imgui.table_setup_column("value", imgui.TableColumnFlags_.width_stretch)
        draws = {"choice": self._choice, "number": self._number, "switch": self._switch}
        for control in self._controls:
            if _acts(control) or control.name not in status.values or not status.offers(control):
                continue
            imgui.table_next_column()
            imgui.align_text_to_frame_padding()
            imgui.text_disabled(control.name)
            imgui.table_next_column()
            imgui.set_next_item_width(-1)
            value = status.values[control.name]
            new = draws[control.kind](control, value, status)
            if new is not None and new != value:
                self._commands.append(Command(control.name, new))
            imgui.table_next_column()
            imgui.text_disabled(self._keys_of(control))
        imgui.end_table()

    # --- a widget for each kind of control: each returns the new value, or None ---

    def _choice(self, control: Control, value: object, status: Status) -> object | None:
        choices = list(dict.fromkeys([*status.choices.get(control.name, ()), value]))
        changed, new = imgui.combo(f"##{control.name}", choices.index(value), list(map(str, choices)))
        return choices[new] if changed else None

    def _number(self, control: Control, value: object, _: Status) -> object | None:
        """Draw a slider; only latency follows the drag: other numbers may rebuild the pipeline."""
        assert isinstance(value, int | float)
        name, clamp = control.name, imgui.SliderFlags_.always_clamp
        shown = self._dragged.get(name, float(value))
        moved, now = imgui.slider_float(f"##{name}", shown, *control.span, FORMAT[name], clamp)
        if moved:
            self._dragged[name] = now if self.wants_keys else round(now / STEP[name]) * STEP[name]
        ended = not imgui.is_item_active()
        new = self._dragged.pop(name, None) if ended else self._dragged.get(name)
        return round(new, 3) if new is not None and (ended or name == "latency") else None

    def _switch(self, control: Control, value: object, _: Status) -> object | None:
        if control.name == "view":
            for state in ("both", "flat"):
                if imgui.radio_button(state, value == state):
                    return state
                imgui.same_line()
            return None
        text = value if isinstance(value, str) else "on" if value else "off"
        changed, on = imgui.checkbox(f"{text}###{control.name}", value not in ("none", False))
        return (on if isinstance(value, bool) else "auto" if on else "none") if changed else None

    def _draw_actions(self, status: Status) -> None:
        """Draw buttons for controls without a value and the display's own; what is on is lit."""
        width = (imgui.get_content_region_avail().x - imgui.get_style().item_spacing.x) / 2
        for number, control in enumerate(filter(status.offers, filter(_acts, self._controls))):
            if number % 2:
                imgui.same_line()
            lit = status.values.get(control.name) is True
            imgui.push_style_color(imgui.Col_.button, LIT if lit else imgui.get_style_color_vec4(imgui.Col_.button))
            if imgui.button(f"{control.name.replace('_', ' ')} ({self._keys_of(control)})", (width, 0)):
                self._commands.append(Command(control.name))
            imgui.pop_style_color()

    def _keys_of(self, control: Control) -> str:
        return " ".join({"Escape": "Esc"}.get(key, self._label(key)) for key in (control.back, control.key) if key)

    def close(self) -> None:
        """Free it; the window's own callbacks are still called. Safe to call twice."""
        if not self._closed:
            self._closed, self.on = True, False
            backends.opengl3_shutdown()
            imgui.destroy_context(self._context)


def _acts(control: Control) -> bool:
    return control.of_display or control.kind in ("action", "hold")


def plots_of(status: Status) -> list[tuple[str, Iterable[float], str, float, float]]:
    """Return what is plotted, from the top: name, values, unit, axis at least to, bad above."""
    budget_ms = status.budget_ms or math.inf
    holes = [100 * share for share in status.holes]
    return [
        ("all passes", status.total_ms, "ms", 1.2 * status.budget_ms or 1.0, budget_ms),
        # Any two refreshes differ a little; half a refresh late means a missed picture.
        ("between pictures", status.period_ms, "ms", 2 * status.budget_ms or 1.0, 1.5 * budget_ms),
        ("frame age at display", status.age_ms, "ms", 20.0, math.inf),
        ("pose age at submission", status.pose_age_ms, "ms", 5.0, math.inf),
        ("holes before the fill", holes, "%", 5.0, math.inf),
    ]
