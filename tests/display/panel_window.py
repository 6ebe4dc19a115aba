"""A window with nothing in it but the panel, for tests that lead it with a real mouse and keyboard.

python -m display.panel_window, led by programs.Led.

Tells what was asked for, what the window itself heard, whether the panel wanted it. A line on its
standard input: "end", "off", "on", "catch", "free" (the mouse), "close" (the panel alone), or
"where" for the middle of each widget and of the latency slider's grab, counted from the top left.
"""

from __future__ import annotations

import glfw
import moderngl
import numpy as np

from hmdwarp.display import CONTROLS, Status
from hmdwarp.display.desktop.control_panel import installed

assert installed()
from imgui_bundle import imgui  # noqa: E402

from hmdwarp.display.desktop.control_panel import panel as module  # noqa: E402
from hmdwarp.display.desktop.window_input import label  # noqa: E402

from .programs import lines_now, tell  # noqa: E402

SIZE = (640, 760)


def listens(window, wants) -> None:
    """The window's own callbacks: what they hear, with a panel that has chained them."""

    def key(_: object, key: int, __: int, action: int, ___: int) -> None:
        tell(key=key, action=action, wanted=wants("keys"))

    glfw.set_key_callback(window, key)
    glfw.set_mouse_button_callback(window, lambda _, __, action, ___: tell(click=action, wanted=wants("mouse")))


def grab_of(screen: moderngl.Framebuffer, size: tuple[int, int]) -> list[int] | None:
    """The middle of the topmost thing of a slider grab's colours, (x, y) from the top left."""
    w, h = size
    top = np.frombuffer(screen.read(viewport=(0, 0, w, h), components=3), np.uint8).reshape(h, w, 3)[h - h // 3 :]
    blues = [np.abs(top.astype(int) - blue).max(axis=2) < 12 for blue in ((61, 133, 224), (66, 150, 250))]
    rows, columns = np.logical_or(*blues).nonzero()
    if not len(rows):
        return None
    first = rows.max()  # row 0 is the bottom
    near = rows > first - 10
    return [int(columns[near].mean()), int(h // 3 - 1 - rows[near].mean())]


class Places:
    """Dear ImGui, which notes the middle of each widget, (x, y) from the top left, by its label."""

    def __init__(self) -> None:
        self.found: dict[str, tuple[float, float]] = {}

    def __getattr__(self, name: str):
        real = getattr(imgui, name)
        if name not in ("button", "checkbox", "combo", "radio_button", "slider_float"):
            return real

        def noted(text, *others):
            done = real(text, *others)
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            self.found[text.split("#")[-1]] = (low.x + high.x) / 2, (low.y + high.y) / 2
            return done

        return noted


def main() -> None:
    assert glfw.init()
    hints = {"CONTEXT_VERSION_MAJOR": 4, "CONTEXT_VERSION_MINOR": 3, "OPENGL_PROFILE": glfw.OPENGL_CORE_PROFILE}
    for name, value in hints.items():
        glfw.window_hint(getattr(glfw, name), value)
    window = glfw.create_window(*SIZE, "panel", None, None)
    glfw.make_context_current(window)
    glfw.set_window_pos(window, 0, 0)
    gl = moderngl.create_context(require=430)
    listens(window, lambda what: None if is_closed else getattr(panel, f"wants_{what}"))
    module.imgui = places = Places()
    panel, is_closed = module.ControlPanel(window, gl, CONTROLS, label), False
    chosen = {"latency": 200.0, "warp": "forward", "fill": "none", "guard": 1.0, "lens": "auto", "view": "both"}
    status = Status(values=chosen, choices={"warp": ("forward", "mesh")}, budget_ms=16.7, stage_ms={"warp": 4.0})
    status.total_ms.extend((5.0, 6.0))
    status.holes.extend((float("nan"), 0.03))
    panel.draw(status, SIZE)
    tell(scale=panel._scale)
    while not glfw.window_should_close(window):
        glfw.poll_events()
        gl.screen.use()
        gl.clear(0.5, 0.5, 0.5)
        for command in panel.draw(status, glfw.get_framebuffer_size(window)) if not is_closed else ():
            tell(control=command.control, value=command.value)
            status.values[command.control] = command.value
        glfw.swap_buffers(window)
        for line in lines_now(0.1):  # or a software renderer draws all the time
            match line:
                case "end":
                    glfw.set_window_should_close(window, True)
                case "on" | "off":
                    panel.on = line == "on"
                case "catch" | "free":
                    caught = glfw.CURSOR_DISABLED if line == "catch" else glfw.CURSOR_NORMAL
                    glfw.set_input_mode(window, glfw.CURSOR, caught)
                case "close":
                    panel.close()
                    is_closed = True
            grab = grab_of(gl.screen, glfw.get_framebuffer_size(window))
            tell(line=line, grab=grab, column=panel.column, places=places.found)
    panel.close()
    glfw.terminate()


if __name__ == "__main__":
    main()
