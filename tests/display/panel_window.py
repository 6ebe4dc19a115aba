"""A window with nothing in it but the panel, for tests that lead it with a real mouse and keyboard.

Python -m display.panel_window.

Prints one JSON object a line: where the window is, what was asked for, what the window itself
heard, whether the panel wanted the mouse. A line on its standard input: "end", "off", "on",
"catch", "free" (the mouse), "close" (the panel alone), or "where" for the pixels that the latency
slider's grab covers, counted from the top left.
"""

from __future__ import annotations

import json
import os
import selectors
import sys

import glfw
import moderngl
import numpy as np

from hmdwarp.display import Status
from hmdwarp.display.desktop.control_panel import make_control_panel

SIZE = (640, 760)


def tell(**known: object) -> None:
    print(json.dumps(known), flush=True)


def opened():
    assert glfw.init()
    for hint, value in (
        (glfw.CONTEXT_VERSION_MAJOR, 4),
        (glfw.CONTEXT_VERSION_MINOR, 3),
        (glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE),
    ):
        glfw.window_hint(hint, value)
    window = glfw.create_window(*SIZE, "panel", None, None)
    glfw.make_context_current(window)
    glfw.set_window_pos(window, 0, 0)
    return window


class Heard:
    """The window's own callbacks: what they hear, with a panel that has chained them."""

    def __init__(self, window) -> None:
        self.panel = None
        glfw.set_key_callback(
            window, lambda _, key, __, action, ___: tell(key=key, action=action, wanted=self.wants("wants_keys"))
        )
        glfw.set_mouse_button_callback(
            window, lambda _, button, action, __: tell(click=action, wanted=self.wants("wants_mouse"))
        )

    def wants(self, what: str) -> bool | None:
        return getattr(self.panel, what) if self.panel is not None else None


def grab_of(screen: moderngl.Framebuffer, size: tuple[int, int]) -> list[int] | None:
    """The middle of the topmost thing of the accent's colour, (x, y) from the top left."""
    w, h = size
    top = np.frombuffer(screen.read(viewport=(0, 0, w, h), components=3), np.uint8).reshape(h, w, 3)[h - h // 3 :]
    rows, columns = (np.abs(top.astype(int) - (76, 194, 178)).max(axis=2) < 12).nonzero()
    if not len(rows):
        return None
    first = rows.max()  # row 0 is the bottom
    near = rows > first - 10
    return [int(columns[near].mean()), int(h // 3 - 1 - rows[near].mean())]


def main() -> None:
    window = opened()
    gl = moderngl.create_context(require=430)
    heard = Heard(window)
    heard.panel = panel = make_control_panel(window, gl)
    status = Status(
        values={"latency": 200.0, "warp": "forward", "guard": 1.0},
        choices={"warp": ("forward", "mesh")},
        budget_ms=16.7,
    )
    inputs = selectors.DefaultSelector()
    inputs.register(sys.stdin, selectors.EVENT_READ)
    os.set_blocking(sys.stdin.fileno(), False)
    tell(scale=panel._input.scale)
    while not glfw.window_should_close(window):
        glfw.poll_events()
        size = glfw.get_framebuffer_size(window)
        gl.screen.use()
        gl.clear(0.5, 0.5, 0.5)
        for command in panel.draw(status, size) if heard.panel is not None else ():
            tell(control=command.control, value=command.value)
            status.values[command.control] = command.value
        glfw.swap_buffers(window)
        for line in (sys.stdin.read() or "").split() if inputs.select(0.01) else ():
            if line == "end":
                glfw.set_window_should_close(window, True)
            elif line in ("on", "off"):
                panel.on = line == "on"
            elif line in ("catch", "free"):
                glfw.set_input_mode(
                    window, glfw.CURSOR, glfw.CURSOR_DISABLED if line == "catch" else glfw.CURSOR_NORMAL
                )
            elif line == "close":
                panel.close()
                heard.panel = None
            tell(done=line, grab=grab_of(gl.screen, size), column=panel._layout.column)
    panel.close()
    glfw.terminate()


if __name__ == "__main__":
    main()
