"""What every display does, checked on one of them: python -m display.contract NAME.

Prints a line of JSON for each case: its name, and why it failed ("" if it holds). A window needs an
X server, OpenXR a monado-service that it may start and kill.
"""

from __future__ import annotations

import json
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from unittest.mock import patch

import attrs
import moderngl
import numpy as np

from hmdwarp.colour import srgb8_from_linear
from hmdwarp.display import Closed, Command, Display, DisplayOptions, Lost, Status, Tick
from hmdwarp.geometry import View
from hmdwarp.gpu import Canvas, Gpu
from hmdwarp.headsets import Headset
from hmdwarp.poses import PoseSource, synthesise

SMALL = (48, 60)


class Backend:
    """How a display is opened here, and what happens to it from outside."""

    name = ""
    own: tuple[Callable[[Backend], None], ...] = ()  # cases of this one alone
    user_ends: Callable[[Display], None] | None = None  # has the user end the display
    goes_away: Callable[[], None] | None = None  # makes it lost ..
    comes_back: Callable[[], None] | None = None  # .. and lets it be reopened


class Offscreen(Backend):
    """A display without a screen."""

    name = "offscreen"

    def open(self) -> Display:
        from hmdwarp.display import OffscreenDisplay

        return OffscreenDisplay(
            DisplayOptions("rift-dk1", size=SMALL, trace=synthesise("look-around", seed=1, seconds=2))
        )


class Window(Backend):
    """A window of this X server."""

    name = "desktop"

    def open(self, **options: object) -> Display:
        from hmdwarp.display.desktop import DesktopDisplay

        return DesktopDisplay(
            DisplayOptions(**{"headset": "rift-dk1", "size": SMALL, "control_panel": False, **options})
        )

    def user_ends(self, display: Display) -> None:
        display._window.end()


class OpenXr(Backend):
    """A headset of Monado."""

    name = "openxr"

    def __init__(self) -> None:
        import os

        from openxr.monado import REMOTE, UNSEEN, Monado

        self._monado = Monado(Path(tempfile.mkdtemp()), {**REMOTE, **UNSEEN})
        os.environ |= self._monado.environment
        self.goes_away, self.comes_back = self._monado.kill, self._monado.start
        self._monado.start()

    def open(self) -> Display:
        from hmdwarp.display.openxr import OpenXrDisplay

        return OpenXrDisplay(DisplayOptions(size=SMALL))

    def user_ends(self, display: Display) -> None:
        import xr

        xr.request_exit_session(display._connection.session.handle)


BACKENDS = {"offscreen": Offscreen, "window": Window, "openxr": OpenXr}


@contextmanager
def opened(backend: Backend, **options: object) -> Iterator[Display]:
    display = backend.open(**options)
    try:
        yield display
    finally:
        display.close()


def next_tick(display: Display) -> Tick:
    while True:
        tick = display.wait()
        if tick is not None:
            return tick


def refresh(display: Display, times: int = 1) -> None:
    for _ in range(times):
        next_tick(display)
        display.show(None)


def why_it_ends(display: Display) -> str:
    try:
        while True:
            refresh(display)
    except Closed as closed:
        return str(closed)


# --- cases on an open display ---


def has_what_a_run_asks_for(display: Display, backend: Backend) -> None:
    """The members hold what the protocol says, in its units."""
    assert display.name == backend.name
    assert display.about and all(isinstance(text, str) for text in (*display.about, *display.about.values()))
    assert display.gpu.gl.version_code >= 430
    assert all(isinstance(part, int) and part > 0 for part in display.size)
    assert 1 < display.rate_hz < 1000
    assert display.headset is None or isinstance(display.headset, Headset)
    assert isinstance(display.distorts, str) and isinstance(display.takes_depth, str)
    assert isinstance(display.takes_panels, str)
    assert display.headset is None or not display.distorts  # the lens is corrected once


def has_eyes(display: Display, backend: Backend) -> None:
    head = display.source.head_at(display.now_ns()).pose
    views = display.eyes.views(head)
    assert len(views) in (1, 2)
    for view in views:
        assert view.pose.isclose(head @ view.head_from_eye, 1e-6)
        assert view.fov.left < view.fov.right and view.fov.down < view.fov.up
    if len(views) == 2:  # the left one first
        assert views[0].head_from_eye.position_m[0] < views[1].head_from_eye.position_m[0]


def answers_ticks(display: Display, backend: Backend) -> None:
    """Each tick is to come, and is answered by one show() within its refresh."""
    for _ in range(4):
        before_ns = display.now_ns()
        tick = next_tick(display)
        begun_ns = display.now_ns()
        handed_over_ns = display.show(None)
        assert before_ns <= begun_ns <= handed_over_ns <= display.now_ns()
        assert before_ns < tick.shown_ns
        assert tick.missed >= 0 and isinstance(tick.notice, str) and isinstance(tick.render, bool)


def has_one_clock_that_never_goes_back(display: Display, backend: Backend) -> None:
    ticks, instants = [], [display.now_ns()]
    for _ in range(8):
        ticks.append(next_tick(display))
        instants += [display.now_ns(), display.show(None), display.now_ns()]
    assert instants == sorted(instants)
    shown = [tick.shown_ns for tick in ticks]
    assert all(early < late for early, late in zip(shown, shown[1:], strict=False)), shown
    # A runtime may report a longer period to a slow program.
    assert all(tick.period_ns > 0.99e9 / display.rate_hz for tick in ticks)


def has_a_head_on_its_clock(display: Display, backend: Backend) -> None:
    assert isinstance(display.source, PoseSource)
    display.source.start()
    tick, before_ns = next_tick(display), display.now_ns()
    head = display.source.head_at(tick.shown_ns)
    display.show(None)
    assert head.time_ns == tick.shown_ns
    assert before_ns <= head.read_ns <= display.now_ns()


@attrs.frozen
class Eye:
    view: View
    panel: Canvas
    inverse_depth: moderngl.Texture | None = None
    panels: tuple[()] = ()


@attrs.frozen
class Eyes:
    eyes: tuple[Eye, ...]


@attrs.frozen
class Question:
    """A text panel."""

    pointed: bool
    takes_text: bool = False

    def ink(self) -> np.ndarray:
        return np.full((20, 60), 255, np.uint8)


def shows_pictures(display: Display, backend: Backend) -> None:
    """Linear light of each eye, with depth where the display takes it, under any label."""
    gl, made = display.gpu.gl, []
    for view in display.eyes.views(display.source.head_at(display.now_ns()).pose):
        canvas = Canvas(gl, display.size)
        canvas.texture.write(np.full((*display.size[::-1], 4), 0.5, np.float16).tobytes())
        depth = gl.texture(display.size, 1, np.ones(display.size, np.float32).tobytes(), dtype="f4")
        made.append(Eye(view, canvas, depth if display.takes_depth else None))
    for label in ("", "tracking lost", Question(pointed=True), Question(pointed=False), ""):
        next_tick(display)
        display.show(Eyes(tuple(made)), label)
        next_tick(display)
        display.show(None, label)
    assert gl.error == "GL_NO_ERROR"


def looks_at_another_view_and_back(display: Display, backend: Backend) -> None:
    def seen() -> tuple[object, ...]:
        return len(display.eyes.views(display.source.head_at(display.now_ns()).pose)), display.size, display.headset

    before = seen()
    display.set_view("flat")
    refresh(display)
    assert seen() == before or seen()[0] == 1
    display.set_view("both")
    refresh(display)
    assert seen() == before


def restarts(display: Display, backend: Backend) -> None:
    """The head goes on or begins anew; the clock goes on."""
    refresh(display, 2)
    before_ns, source = display.now_ns(), display.source
    display.restart()
    assert display.now_ns() >= before_ns and display.source is source
    refresh(display)


def asks_for_nothing_by_itself(display: Display, backend: Backend) -> None:
    display.commands()
    refresh(display, 2)
    assert list(display.commands()) == []


def takes_a_status(display: Display, backend: Backend) -> None:
    status = Status(values={"latency": 50.0, "scene": "room", "warp": "forward", "fill": "none"})
    for _ in range(2):
        display.show_status(status)
        refresh(display)
    assert status.values["latency"] == 50.0


# --- cases that end the display ---


def ends_with_a_reason(backend: Backend) -> None:
    """Closed, from wait() or show(), once the user ends it; then it closes like any other."""
    if backend.user_ends is None:
        return
    with opened(backend) as display:
        refresh(display, 2)
        backend.user_ends(display)
        assert len(why_it_ends(display).split()) > 2
        display.close()


def is_lost_and_comes_back(backend: Backend) -> None:
    """Lost with words; reopen() says whether it is back, and the gpu stays the same."""
    with opened(backend) as display:
        refresh(display, 2)
        if backend.goes_away is None:
            assert display.reopen() is False
            return
        gpu, before_ns = display.gpu, display.now_ns()
        backend.goes_away()
        try:
            while True:
                refresh(display)
        except Lost as lost:
            assert len(str(lost).split()) > 2, lost
        assert list(display.commands()) == []
        assert display.reopen() is False
        assert display.reopen() is False
        backend.comes_back()
        assert display.reopen() is True
        assert next_tick(display).shown_ns > before_ns
        display.show(None)
        assert display.gpu is gpu


def closes_twice_in_any_state(backend: Backend) -> None:
    """Unused, in the middle of a tick, and after a tick; each time another one can be opened."""
    for ticks, answers in ((0, 0), (1, 0), (1, 1)):
        display = backend.open()
        for _ in range(ticks):
            next_tick(display)
        for _ in range(answers):
            display.show(None)
        display.close()
        display.close()


# --- cases of a window alone ---


def stands_beside_another_context(backend: Backend) -> None:
    """Each GL call reaches its own, where the other has stepped aside.

    (While a context of EGL is current, no window with one of GLX can be made.)
    """
    with Gpu() as first:
        before = first.gl.texture((1, 1), 4, b"\1\2\3\4")
        first.step_aside()
        with opened(backend) as display:
            refresh(display, 2)
            with first.current():
                assert before.read() == b"\1\2\3\4"
            refresh(display, 2)
        with first.current():
            assert before.read() == b"\1\2\3\4"


def switches_by_itself(backend: Backend) -> None:
    """By command of a panel: nobody else hears of it, and what is on is told back."""
    with opened(backend) as display:
        refresh(display, 12)
        assert display.rate_hz == 60.0
        settings = {"full_screen": True, "help": True}
        for name, value in (*settings.items(), ("full_screen", None), ("recentre", None)):
            display._input.commands.append(Command(name, value))
            assert not display.commands()
            refresh(display)
        display._input.commands.append(Command("warp"))
        assert [command.control for command in display.commands()] == ["warp"] and not display.commands()
        display.show_status(status := Status(values={"latency": 0.0}))
        assert [status.values[name] for name in settings] == [False, True]
        before = display.eyes
        display.set_view("flat")
        assert display.headset is None
        display.set_view("both")
        assert display.eyes is before is display.headset
        display._input.commands.append(Command("quit"))
        display.commands()
        assert why_it_ends(display) == "the window was closed"


def works_without_the_panels_package(backend: Backend) -> None:
    """And says how to get it: at the start, and when it is asked for."""
    with patch.dict(sys.modules, {"imgui_bundle": None}), opened(backend, control_panel=True) as display:
        assert ".[panel]" in display._remark and "H" in display._remark
        refresh(display)
        display._say("")
        display._input.commands.append(Command("panel"))
        assert not display.commands() and ".[panel]" in display._remark
        refresh(display)


def seen(display: Display) -> np.ndarray:
    """(h, w, 3) what the window shows, from the bottom."""
    import glfw

    w, h = display._window.framebuffer_size
    glfw.make_context_current(display._window.handle)
    pixels = display.gpu.gl.screen.read(viewport=(0, 0, w, h), components=3, attachment=0)
    return np.frombuffer(pixels, np.uint8).reshape(h, w, 3)


def shows_colours_in_their_places(backend: Backend) -> None:
    """Linear light as sRGB bytes, left and right where they belong, the top row at the top."""
    rng = np.random.default_rng(7)
    with opened(backend) as display:
        display._say("")
        patches, eyes = rng.uniform(0, 1, (2, 5, 4, 4)), []
        patches[..., 3] = 1
        for patch_ in patches:
            canvas = Canvas(display.gpu.gl, SMALL)
            canvas.texture.write(patch_.repeat(12, axis=0).repeat(12, axis=1).astype(np.float16).tobytes())
            eyes.append(Eye(display.eyes.views(display.source.head_at(0).pose)[0], canvas))
        for _ in range(2):
            next_tick(display)
            display.show(Eyes(tuple(eyes)))
        shown = seen(display)
        h, w = shown.shape[:2]
        rows = ((np.arange(5) + 0.5) * h / 5).astype(int)
        columns = ((np.arange(8) + 0.5) * w / 8).astype(int)
        # Half floats are 11 bits: 2^-12 of the value, which is below half a level of 255 anywhere
        # on the curve.
        wanted = srgb8_from_linear(np.hstack(patches)[..., :3])
        assert np.abs(shown[np.ix_(rows, columns)].astype(int) - wanted).max() <= 1


def says_how_to_look_for_a_while(backend: Backend) -> None:
    from hmdwarp.display.desktop import desktop_display

    long_ns = 10**18  # however slow this machine is
    with patch.object(desktop_display, "REMARK_NS", long_ns), opened(backend, size=(96, 120)) as display:
        for until_ns in (display._until_ns, 0):
            display._until_ns = until_ns
            refresh(display, 2)
            assert (seen(display).min(axis=-1) > 240).any() == (until_ns > 0)


def shows_help_beside_a_question_of_a_study_alone(backend: Backend) -> None:
    """In the window beside a headset; in a live run its key calls it over what is shown."""
    import glfw

    from hmdwarp.display import CONTROLS, Presenter
    from hmdwarp.display.openxr.mirror_window import Mirror
    from hmdwarp.study.dialogs import dialog_panels

    panel = dialog_panels.message_panel("Ready?", "Sit comfortably.", "Enter: begin")

    def noticed(controls, *does: object) -> list[str]:
        mirror, found, notice = Mirror(controls), [], Presenter.notice

        def noting(presenter: Presenter, label: object) -> object:
            is_help = isinstance(label, str) and "\t" in label
            found.append("help" if is_help else "panel" if label else "nothing")
            return notice(presenter, label)

        with patch.object(Presenter, "notice", noting), closing(Gpu(mirror.gl)) as gpu, closing(Presenter(gpu)) as over:
            for each in does:
                if each in ("H", "ESCAPE"):
                    mirror._key(None, getattr(glfw, f"KEY_{each}"), 0, glfw.PRESS, 0)
                else:
                    mirror._drawn_ns = 0  # due
                    mirror.show(over, None, each)
        mirror.close()
        return found

    found = noticed(dialog_panels.CONTROLS, "", "H", "", panel, "H", panel, "", panel)
    assert found == ["nothing", "nothing", "panel", "help", "nothing", "panel"]
    assert noticed(CONTROLS, "", "H", "", "H", "", "H", "", "ESCAPE", "") == ["nothing", "help"] * 2 + ["nothing"]


Window.own = (
    stands_beside_another_context, switches_by_itself, works_without_the_panels_package,
    shows_colours_in_their_places, says_how_to_look_for_a_while,
    shows_help_beside_a_question_of_a_study_alone,
)  # fmt: skip
ON_ONE = (
    has_what_a_run_asks_for, has_eyes, answers_ticks, has_one_clock_that_never_goes_back, has_a_head_on_its_clock,
    shows_pictures, looks_at_another_view_and_back, restarts, asks_for_nothing_by_itself, takes_a_status,
)  # fmt: skip
OF_ITS_OWN = (ends_with_a_reason, is_lost_and_comes_back, closes_twice_in_any_state)
CASES = [(name, case.__name__) for name, backend in BACKENDS.items() for case in (*ON_ONE, *OF_ITS_OWN, *backend.own)]


def report(name: str, case: Callable[[], None]) -> None:
    try:
        case()
        failure = ""
    except Exception:
        failure = traceback.format_exc()
    print(json.dumps({"case": name, "failure": failure}), flush=True)


def main(name: str) -> None:
    with ExitStack() as stack:
        backend = BACKENDS[name]()
        if backend.goes_away is not None:
            stack.callback(backend.goes_away)
        with opened(backend) as display:
            for case in ON_ONE:
                report(case.__name__, lambda case=case: case(display, backend))
        for case in (*OF_ITS_OWN, *backend.own):
            report(case.__name__, lambda case=case: case(backend))


if __name__ == "__main__":
    main(sys.argv[1])
