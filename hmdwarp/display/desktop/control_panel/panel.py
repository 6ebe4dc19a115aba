"""The control panel: redraw schedule, place in the window, and contents."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import moderngl
from imgui_bundle import imgui, implot

from ... import Command
from ...controls import CONTROLS, Control, Status
from . import panel_style as style
from .imgui_input import ImGuiInput, NoInput
from .renderer import PanelRenderer
from .widgets import Stages, Widgets, draw_plots, right_aligned

CALM_HZ = 15.0  # redraws of the panel without input; in between the last picture is composited again
LIVELY_S = 0.4  # redrawn at every refresh after start and input: widgets need a few frames for their sizes
LONGEST_S = 0.25  # between two frames, for Dear ImGui's own blinking and delays
WINDOW = (
    imgui.WindowFlags_.no_title_bar
    | imgui.WindowFlags_.no_resize
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_collapse
    | imgui.WindowFlags_.no_nav
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.always_auto_resize
)


@attrs.define
class _Layout:
    """The panel's place in the framebuffer, as last drawn."""

    size: tuple[int, int] = (0, 0)  # (w, h) of the framebuffer in pixels
    column: int = 0  # width at the right edge
    height: int = 0  # used rows from the top
    scale: float = 0.0  # content scale


class ControlPanel:
    """Controls and plots, over the right edge of a framebuffer.

    A Dear ImGui display of its own, one column wide, so that nothing open in it reaches over the
    picture beside it. into: where it is shown. clock: running seconds.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        panel_input: ImGuiInput | NoInput,
        into: moderngl.Framebuffer,
        clock: Callable[[], float],
        controls: tuple[Control, ...] = CONTROLS,
    ) -> None:
        self._into, self._input, self._clock = into, panel_input, clock
        self._contexts = imgui.create_context(), implot.create_context()
        self._renderer = PanelRenderer(gl)
        self._widgets, self._stages = Widgets(panel_input.label, controls), Stages()
        self._layout = _Layout()
        self._painted_s, self._lively_until_s = -1.0, 0.0
        self._on, self._closed = True, False
        self._prepare(gl)

    def _prepare(self, gl: moderngl.Context) -> None:
        self._enter()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.set_log_filename("")
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        io.config_flags |= imgui.ConfigFlags_.no_mouse_cursor_change
        most = gl.info["GL_MAX_TEXTURE_SIZE"]
        imgui.get_platform_io().renderer_texture_max_width = imgui.get_platform_io().renderer_texture_max_height = most
        style.add_font()

    def _enter(self) -> None:
        imgui.set_current_context(self._contexts[0])
        implot.set_current_context(self._contexts[1])

    # --- for the window ---

    @property
    def on(self) -> bool:
        """Whether it is visible.

        While off, it draws nothing, takes no input, and forgets the mouse.
        """
        return self._on

    @on.setter
    def on(self, on: bool) -> None:
        self._on = self._input.on = on
        self._input.typing = False
        self._painted_s = -1.0  # else the old picture would flash up

    @property
    def column(self) -> int:
        """Width in framebuffer pixels at the right edge; 0 while it is off."""
        return round(style.WIDTH * self._input.scale) if self._on else 0

    @property
    def wants_mouse(self) -> bool:
        """Whether the mouse belongs to the panel: it is over it, or held down since it was."""
        if not self._on or self._input.captured:
            return False
        self._enter()
        return self._over() or imgui.get_io().want_capture_mouse

    @property
    def wants_keys(self) -> bool:
        """Whether a number is being typed into the panel; otherwise keys go to the window."""
        return self._on and self._input.typing

    def _over(self) -> bool:
        place = self._input.cursor
        return (
            place is not None
            and place[0] >= self._layout.size[0] - self._layout.column
            and 0 <= place[1] < self._layout.height
        )

    # --- a refresh ---

    def draw(self, status: Status, framebuffer_size: tuple[int, int]) -> list[Command]:
        """Composite the panel over the framebuffer, (w, h) in pixels, and return its commands.

        These include the display's own controls.
        """
        if not self._on or min(framebuffer_size) < 1:
            return []
        now_s = self._clock()
        events = self._input.take()
        begins = self._painted_s < 0  # or starts again
        if begins or events and (self._over() or self.wants_mouse or self.wants_keys or now_s < self._lively_until_s):
            self._lively_until_s = now_s + LIVELY_S
        due = (
            now_s - self._painted_s >= 1 / CALM_HZ
            or now_s < self._lively_until_s
            or framebuffer_size != self._layout.size
        )
        self._feed(events, framebuffer_size)
        commands = self._paint(status, framebuffer_size, now_s) if due else []
        x = self._layout.size[0] - self._layout.column
        self._renderer.put(
            self._into, (x, self._layout.size[1] - self._layout.height), (self._layout.column, self._layout.height)
        )
        return commands

    def _feed(self, events: list[Any], size: tuple[int, int]) -> None:
        self._enter()
        self._settle(size)
        io = imgui.get_io()
        for event in events:
            event(io)

    def _settle(self, size: tuple[int, int]) -> None:
        """Update sizes for the current window."""
        scale = self._input.scale
        if scale != self._layout.scale:
            self._layout.scale = scale
            style.apply(scale)
        self._layout.size, self._layout.column = size, min(self.column, size[0])
        self._input.left = size[0] - self._layout.column
        imgui.get_io().display_size = imgui.ImVec2(self._layout.column, size[1])

    def _paint(self, status: Status, size: tuple[int, int], now_s: float) -> list[Command]:
        imgui.get_io().delta_time = min(max(now_s - self._painted_s, 1e-4), LONGEST_S)
        self._painted_s = now_s
        imgui.new_frame()
        commands = self._lay_out(status, now_s)
        imgui.render()
        self._input.typing = imgui.get_io().want_text_input
        self._layout.height = self._renderer.paint(imgui.get_draw_data(), (self._layout.column, size[1]))
        return commands

    def _lay_out(self, status: Status, now_s: float) -> list[Command]:
        imgui.set_next_window_pos((0, 0))
        imgui.set_next_window_size_constraints((self._layout.column, 0), (self._layout.column, self._layout.size[1]))
        imgui.begin("hmdwarp", None, WINDOW)
        _header(status, self._layout.scale)
        commands = self._widgets.draw(status, self._layout.scale, now_s)
        imgui.separator()
        draw_plots(status, self._layout.scale)
        imgui.separator()
        imgui.text_disabled("stages, in ms")
        self._stages.draw(status, self._layout.scale)
        imgui.separator()
        commands += self._widgets.actions(status.values)
        imgui.end()
        return commands

    def close(self) -> None:
        """Free it, and restore the window's callbacks. Safe to call twice."""
        if self._closed:
            return
        self._closed = True
        self._input.close()
        self._enter()
        self._renderer.close()
        implot.destroy_context(self._contexts[1])
        imgui.destroy_context(self._contexts[0])


def _header(status: Status, scale: float) -> None:
    """Draw refresh rate, misses, recording, and the notice."""
    imgui.text(f"{status.rate_hz:.0f} fps")
    imgui.same_line()
    imgui.text_disabled(f"of {1e3 / status.budget_ms:.0f}, {status.budget_ms:.1f} ms each" if status.budget_ms else "")
    missed = f"{status.missed} missed"
    right_aligned(missed, style.WARN if status.missed else style.DIM)
    if status.recording:
        at, size = imgui.get_cursor_screen_pos(), imgui.get_font_size()
        imgui.get_window_draw_list().add_circle_filled(
            (at.x + 0.35 * size, at.y + 0.5 * size), 0.3 * size, style.u32(style.BAD)
        )
        imgui.dummy((0.7 * size, size))
        imgui.same_line()
        imgui.text_colored(imgui.ImVec4(*style.BAD), "recording")
    if status.notice:
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*style.WARN))
        imgui.text_wrapped(status.notice)
        imgui.pop_style_color()
    imgui.dummy((0, 2 * scale))
