"""The display of the desktop with nothing behind it, on a virtual screen.

Python -m display.window_alone WHAT.

Ends with 0 if all is as it should be.
"""

from __future__ import annotations

import sys

import numpy as np

from hmdwarp.display import Closed, DisplayOptions
from hmdwarp.display.desktop import DesktopDisplay
from hmdwarp.gpu import Canvas, Gpu
from hmdwarp.poses import Origin, PoseSource

SMALL = DisplayOptions("rift-dk1", size=(32, 40), control_panel=False)


def refresh(display: DesktopDisplay, times: int = 1) -> None:
    for _ in range(times):
        tick = display.wait()
        assert tick is not None and tick.render and tick.shown_ns > display.now_ns() - 600 * 10**9
        display.show(None)


def twice() -> None:
    """A window after another in one process, each closed twice.

    The second with a context of its own kind (EGL).
    """
    for api in ("native", "EGL"):
        if api == "EGL":
            import glfw

            glfw.NATIVE_CONTEXT_API = glfw.EGL_CONTEXT_API
        display = DesktopDisplay(SMALL)
        assert display.about["renderer"] and "X11" in display.about["window"]
        refresh(display, 3)
        canvas = Canvas(display.gpu.gl, (8, 8))
        canvas.clear()
        assert not np.frombuffer(canvas.texture.read(), np.uint8).any()
        canvas.release()
        display.close()
        display.close()
        assert not display.reopen()


def beside() -> None:
    """Another context in the same thread, that has stepped aside: each GL call reaches its own.

    (While a context of EGL is current, no window with one of GLX can be made.)
    """
    with Gpu() as first:
        before = first.gl.texture((1, 1), 4, b"\1\2\3\4")
        first.step_aside()
        display = DesktopDisplay(SMALL)
        refresh(display, 2)
        with first.current():
            assert before.read() == b"\1\2\3\4"
        refresh(display, 2)
        display.close()
        with first.current():
            assert before.read() == b"\1\2\3\4"


def source() -> None:
    """Poses are read when they are asked for, and say when."""
    display = DesktopDisplay(SMALL)
    assert isinstance(display.source, PoseSource)
    display.source.start()
    tick = display.wait()
    asked = display.now_ns()
    head = display.source.head_at(tick.shown_ns)
    assert asked <= head.read_ns <= display.now_ns()
    assert head.origin is Origin.PREDICTED and head.pose.position_m.tolist() == [0, 1.6, 0]
    handed = display.show(None)
    assert head.read_ns <= handed <= display.now_ns()
    display.source.close()
    display.close()


def switches() -> None:
    """What the window does by itself, by command of a panel.

    Nobody else hears of it, and what is on is told back.
    """
    from hmdwarp.display import Command, Status

    display, status = DesktopDisplay(SMALL), Status(values={"latency": 0.0})
    refresh(display, 12)
    assert display.rate_hz == 60.0
    settings = (
        ("vsync", False), ("full_screen", True), ("help", True), ("full_screen", None), ("recentre", None),
        ("vsync", None),
    )  # fmt: skip
    for name, value in settings:
        display._commands.pending.append(Command(name, value))
        assert not display.commands()
        refresh(display)
    display._commands.pending.append(Command("warp"))
    assert [command.control for command in display.commands()] == ["warp"] and not display.commands()
    display.show_status(status)
    assert {name: status.values[name] for name in ("vsync", "full_screen", "help")} == {
        "vsync": True,
        "full_screen": False,
        "help": True,
    }
    before = display.eyes
    display.set_view("flat")
    assert len(display.eyes.views(display.source.head_at(0).pose)) == 1 and display.headset is None
    display.set_view("both")
    assert display.eyes is before is display.headset
    display._commands.pending.append(Command("quit"))
    display.commands()
    assert closed(display) == "the window was closed"
    display.close()


def closed(display: DesktopDisplay) -> str:
    try:
        display.wait()
    except Closed as why:
        return str(why)
    raise AssertionError("it goes on")


def bare() -> None:
    """Without the panel's package everything else works, and the window says how to get it.

    At the start, and when it is asked for.
    """
    import attrs

    from hmdwarp.display import Command

    sys.modules["imgui_bundle"] = None  # as if it were not installed
    display = DesktopDisplay(attrs.evolve(SMALL, control_panel=True))
    assert ".[panel]" in display._painter._remark and "H" in display._painter._remark
    refresh(display)
    display._painter.say("")
    display._commands.pending.append(Command("panel"))
    assert not display.commands() and ".[panel]" in display._painter._remark
    refresh(display)
    display.close()


def reset() -> None:
    """A driver that was reset ends the run.

    No software driver ever is, so its answer is made up; that it is asked is real.
    """
    display = DesktopDisplay(SMALL)
    refresh(display)
    assert display._window._reset_status is None or display._window._reset_status() == 0
    display._window._reset_status = lambda: 0x8253  # GL_GUILTY_CONTEXT_RESET
    assert "driver was reset" in closed(display)
    display.close()


def colours() -> None:
    """Linear light comes out as sRGB bytes, left and right where they belong, the top row at the
    top.
    """
    import attrs

    from hmdwarp.colour import srgb8_from_linear

    @attrs.frozen
    class Eye:
        panel: Canvas

    @attrs.frozen
    class Refresh:
        eyes: tuple[Eye, ...]

    display = DesktopDisplay(SMALL)
    display._painter.say("")
    pictures, rng = [], np.random.default_rng(7)
    for _ in range(2):
        canvas = Canvas(display.gpu.gl, (32, 40))
        light = np.repeat(np.repeat(rng.uniform(0, 1, (5, 4, 4)), 8, axis=0), 8, axis=1)
        light[..., 3] = 1
        canvas.texture.write(light.astype(np.float16).tobytes())
        pictures.append((light, Eye(canvas)))
    for _ in range(2):
        display.wait()
        display.show(Refresh(tuple(eye for _, eye in pictures)))
    shown = picture(display)
    h, w = shown.shape[:2]
    wide = (w // 2) // 4
    for eye, (light, _) in enumerate(pictures):
        for row in range(5):
            for column in range(4):
                x, y = eye * (w // 2) + column * wide + wide // 2, row * (h // 5) + h // 10
                wanted = srgb8_from_linear(light[row * 8, column * 8, :3])
                # Half floats are 11 bits: 2^-12 of the value, which is below half a level of 255
                # anywhere on the curve.
                assert np.abs(shown[y, x].astype(int) - wanted).max() <= 1, (eye, row, column, shown[y, x], wanted)
    display.close()


def picture(display: DesktopDisplay) -> np.ndarray:
    """(h, w, 3) what the window shows, from the bottom."""
    import glfw

    w, h = display._window.framebuffer_size
    glfw.make_context_current(display._window.handle)
    return np.frombuffer(
        display.gpu.gl.screen.read(viewport=(0, 0, w, h), components=3, attachment=0), np.uint8
    ).reshape(h, w, 3)


def words() -> None:
    """The first pictures say how to look; after a while nothing does."""
    import attrs

    from hmdwarp.display.desktop import painter

    painter.REMARK_NS = 10**18  # however slow this machine is
    display = DesktopDisplay(attrs.evolve(SMALL, size=(96, 120)))
    now_ns = display._painter._now_ns
    for late_ns, says in ((0, True), (10**18, False)):
        display._painter._now_ns = lambda late_ns=late_ns: now_ns() + late_ns
        refresh(display, 2)
        assert (picture(display).min(axis=-1) > 240).any() == says
    display.close()


if __name__ == "__main__":
    {function.__name__: function for function in (twice, beside, source, switches, bare, reset, colours, words)}[
        sys.argv[1]
    ]()
