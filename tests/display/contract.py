"""What every display does, checked on the one that HMDWARP_DISPLAY names.

test_contract.py runs this file by a pytest of its own for each: a window needs an X server, OpenXR
a monado-service that it may start and kill.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import attrs
import moderngl
import numpy as np
import pytest

from hmdwarp.base import srgb8_from_linear
from hmdwarp.display import Closed, Command, Display, DisplayOptions, Lost, OffscreenDisplay, Status, Tick
from hmdwarp.geometry import View
from hmdwarp.gpu import Canvas, Gpu
from hmdwarp.headsets import Headset
from hmdwarp.poses import PoseSource, synthesise

NAME, SMALL = os.environ["HMDWARP_DISPLAY"], (48, 60)


class Offscreen:
    """How a display is opened here, and what happens to it from outside: this one has no screen."""

    user_ends = goes_away = comes_back = None

    def open(self) -> Display:
        return OffscreenDisplay(
            DisplayOptions("rift-dk1", size=SMALL, trace=synthesise("look-around", seed=1, seconds=2))
        )


class Window(Offscreen):
    """A window of this X server."""

    def open(self, **options: object) -> Display:
        from hmdwarp.display.desktop import DesktopDisplay

        return DesktopDisplay(
            DisplayOptions(**{"headset": "rift-dk1", "size": SMALL, "control_panel": False, **options})
        )

    def user_ends(self, display: Display) -> None:
        display._window.end()


class OpenXr(Offscreen):
    """A headset of Monado."""

    def __init__(self) -> None:
        from openxr.monado import REMOTE, UNSEEN, Monado

        monado = Monado(Path(tempfile.mkdtemp()), {**REMOTE, **UNSEEN})
        os.environ |= monado.environment
        self.goes_away, self.comes_back = monado.kill, monado.start
        monado.start()

    def open(self) -> Display:
        from hmdwarp.display.openxr import OpenXrDisplay

        return OpenXrDisplay(DisplayOptions(size=SMALL))

    def user_ends(self, display: Display) -> None:
        import xr

        xr.request_exit_session(display._connection.session.handle)


@pytest.fixture(scope="module")
def backend() -> Iterator[Offscreen]:
    made = {"offscreen": Offscreen, "desktop": Window, "openxr": OpenXr}[NAME]()
    yield made
    if made.goes_away is not None:
        made.goes_away()


@contextmanager
def opened(backend: Offscreen, **options: object) -> Iterator[Display]:
    display = backend.open(**options)
    try:
        yield display
    finally:
        display.close()


@pytest.fixture(scope="class")
def display(backend) -> Iterator[Display]:
    with opened(backend) as made:
        yield made


def next_tick(display: Display) -> Tick:
    while True:
        tick = display.wait()
        if tick is not None:
            return tick


def refresh(display: Display, times: int = 1) -> None:
    for _ in range(times):
        next_tick(display)
        display.show(None)


def end_of(display: Display, kind: type[Exception]) -> str:
    """What it says as it ends."""
    with pytest.raises(kind) as ended:
        while True:
            refresh(display)
    return str(ended.value)


def seen_by(*eyes: tuple[View, Canvas, moderngl.Texture | None]) -> SimpleNamespace:
    """What a refresh shows to these eyes."""
    names = ("view", "panel", "inverse_depth")
    return SimpleNamespace(eyes=[SimpleNamespace(panels=(), **dict(zip(names, eye, strict=True))) for eye in eyes])


@attrs.frozen
class Question:
    """A text panel."""

    pointed: bool
    takes_text: bool = False

    def ink(self) -> np.ndarray:
        return np.full((20, 60), 255, np.uint8)


class TestOpen:
    """On one display, open all the while."""

    def test_has_what_a_run_asks_for(self, display):
        """The members hold what the protocol says, in its units."""
        assert display.name == NAME
        assert display.about and all(isinstance(text, str) for text in (*display.about, *display.about.values()))
        assert display.gpu.gl.version_code >= 430
        assert all(isinstance(part, int) and part > 0 for part in display.size)
        assert 1 < display.rate_hz < 1000
        assert display.headset is None or isinstance(display.headset, Headset)
        assert isinstance(display.distorts, str) and isinstance(display.takes_depth, str)
        assert isinstance(display.takes_panels, str)
        assert display.headset is None or not display.distorts  # the lens is corrected once

    def test_has_eyes(self, display):
        head = display.source.head_at(display.now_ns()).pose
        views = display.eyes.views(head)
        assert len(views) in (1, 2)
        for view in views:
            assert view.pose.isclose(head @ view.head_from_eye, 1e-6)
            assert view.fov.left < view.fov.right and view.fov.down < view.fov.up
        if len(views) == 2:  # the left one first
            assert views[0].head_from_eye.position_m[0] < views[1].head_from_eye.position_m[0]

    def test_answers_ticks(self, display):
        """Each tick is to come, and is answered by one show() within its refresh."""
        for _ in range(4):
            before_ns = display.now_ns()
            tick = next_tick(display)
            begun_ns = display.now_ns()
            handed_over_ns = display.show(None)
            assert before_ns <= begun_ns <= handed_over_ns <= display.now_ns()
            assert before_ns < tick.shown_ns
            assert tick.missed >= 0 and isinstance(tick.notice, str) and isinstance(tick.render, bool)

    def test_has_one_clock_that_never_goes_back(self, display):
        ticks, instants = [], [display.now_ns()]
        for _ in range(8):
            ticks.append(next_tick(display))
            instants += [display.now_ns(), display.show(None), display.now_ns()]
        assert instants == sorted(instants)
        shown = [tick.shown_ns for tick in ticks]
        assert shown == sorted({*shown})
        # A runtime may report a longer period to a slow program.
        assert all(tick.period_ns > 0.99e9 / display.rate_hz for tick in ticks)

    def test_has_a_head_on_its_clock(self, display):
        assert isinstance(display.source, PoseSource)
        display.source.start()
        tick, before_ns = next_tick(display), display.now_ns()
        head = display.source.head_at(tick.shown_ns)
        display.show(None)
        assert head.time_ns == tick.shown_ns
        assert before_ns <= head.read_ns <= display.now_ns()

    def test_shows_pictures(self, display):
        """Linear light of each eye, with depth where the display takes it, under any label."""
        gl, made = display.gpu.gl, []
        for view in display.eyes.views(display.source.head_at(display.now_ns()).pose):
            canvas = Canvas(gl, display.size)
            canvas.texture.write(np.full((*display.size[::-1], 4), 0.5, np.float16).tobytes())
            depth = gl.texture(display.size, 1, np.ones(display.size, np.float32).tobytes(), dtype="f4")
            made.append((view, canvas, depth if display.takes_depth else None))
        for label in ("", "tracking lost", Question(pointed=True), Question(pointed=False), ""):
            next_tick(display)
            display.show(seen_by(*made), label)
            next_tick(display)
            display.show(None, label)
        assert gl.error == "GL_NO_ERROR"

    def test_looks_at_another_view_and_back(self, display):
        def seen() -> tuple[object, ...]:
            return len(display.eyes.views(display.source.head_at(display.now_ns()).pose)), display.size, display.headset

        before = seen()
        display.set_view("flat")
        refresh(display)
        assert seen() == before or seen()[0] == 1
        display.set_view("both")
        refresh(display)
        assert seen() == before

    def test_restarts(self, display):
        """The head goes on or begins anew; the clock goes on."""
        refresh(display, 2)
        before_ns, source = display.now_ns(), display.source
        display.restart()
        assert display.now_ns() >= before_ns and display.source is source
        refresh(display)

    def test_asks_for_nothing_by_itself(self, display):
        display.commands()
        refresh(display, 2)
        assert list(display.commands()) == []

    def test_takes_a_status(self, display):
        status = Status(values={"latency": 50.0, "scene": "room", "warp": "forward", "fill": "none"})
        for _ in range(2):
            display.show_status(status)
            refresh(display)
        assert status.values["latency"] == 50.0


class TestEnds:
    """Each on a display of its own."""

    def test_ends_with_a_reason(self, backend):
        """Closed, from wait() or show(), once the user ends it; then it closes like any other."""
        with opened(backend) as display:
            refresh(display, 2)
            if backend.user_ends is not None:
                backend.user_ends(display)
                assert len(end_of(display, Closed).split()) > 2
            display.close()

    def test_is_lost_and_comes_back(self, backend):
        """Lost with words; reopen() says whether it is back, and the gpu stays the same."""
        with opened(backend) as display:
            refresh(display, 2)
            if backend.goes_away is None:
                assert display.reopen() is False
                return
            gpu, before_ns = display.gpu, display.now_ns()
            backend.goes_away()
            assert len(end_of(display, Lost).split()) > 2
            assert list(display.commands()) == []
            assert [display.reopen(), display.reopen()] == [False, False]
            backend.comes_back()
            assert display.reopen() is True
            assert next_tick(display).shown_ns > before_ns
            display.show(None)
            assert display.gpu is gpu

    def test_closes_twice_in_any_state(self, backend):
        """Unused, in the middle of a tick, after a tick: each time another one can be opened."""
        for ticks, answers in ((0, 0), (1, 0), (1, 1)):
            display = backend.open()
            for _ in range(ticks):
                next_tick(display)
            for _ in range(answers):
                display.show(None)
            display.close()
            display.close()


def seen(display: Display) -> np.ndarray:
    """(h, w, 3) what the window shows, from the bottom."""
    import glfw

    w, h = display._window.framebuffer_size
    glfw.make_context_current(display._window.handle)
    pixels = display.gpu.gl.screen.read(viewport=(0, 0, w, h), components=3, attachment=0)
    return np.frombuffer(pixels, np.uint8).reshape(h, w, 3)


@pytest.mark.skipif(NAME != "desktop", reason="of a window alone")
class TestWindow:
    def test_stands_beside_another_context(self, backend):
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

    def test_switches_by_itself(self, backend):
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
            assert end_of(display, Closed) == "the window was closed"

    def test_works_without_the_panels_package(self, backend):
        """And says how to get it: at the start, and when it is asked for."""
        with patch.dict(sys.modules, {"imgui_bundle": None}), opened(backend, control_panel=True) as display:
            assert ".[panel]" in display._remark and "H" in display._remark
            refresh(display)
            display._say("")
            display._input.commands.append(Command("panel"))
            assert not display.commands() and ".[panel]" in display._remark
            refresh(display)

    def test_shows_colours_in_their_places(self, backend):
        """Linear light as sRGB bytes, left and right where they belong, the top row at the top."""
        rng = np.random.default_rng(7)
        with opened(backend) as display:
            display._say("")
            patches, eyes = rng.uniform(0, 1, (2, 5, 4, 4)), []
            patches[..., 3] = 1
            for patch_ in patches:
                canvas = Canvas(display.gpu.gl, SMALL)
                canvas.texture.write(patch_.repeat(12, axis=0).repeat(12, axis=1).astype(np.float16).tobytes())
                eyes.append((display.eyes.views(display.source.head_at(0).pose)[0], canvas, None))
            for _ in range(2):
                next_tick(display)
                display.show(seen_by(*eyes))
            shown = seen(display)
            h, w = shown.shape[:2]
            rows = ((np.arange(5) + 0.5) * h / 5).astype(int)
            columns = ((np.arange(8) + 0.5) * w / 8).astype(int)
            # Half floats are 11 bits: 2^-12 of the value is below half a level of 255 anywhere.
            wanted = srgb8_from_linear(np.hstack(patches)[..., :3])
            assert np.abs(shown[np.ix_(rows, columns)].astype(int) - wanted).max() <= 1

    def test_says_how_to_look_for_a_while(self, backend):
        from hmdwarp.display.desktop import desktop_display

        long_ns = 10**18  # however slow this machine is
        with patch.object(desktop_display, "REMARK_NS", long_ns), opened(backend, size=(96, 120)) as display:
            for until_ns in (display._until_ns, 0):
                display._until_ns = until_ns
                refresh(display, 2)
                assert (seen(display).min(axis=-1) > 240).any() == (until_ns > 0)

    def test_shows_help_beside_a_question_of_a_study_alone(self, monkeypatch):
        """In the window beside a headset; in a live run its key calls it over what is shown."""
        import glfw

        from hmdwarp.display import CONTROLS, Presenter
        from hmdwarp.display.openxr.mirror_window import Mirror
        from hmdwarp.study.dialogs import dialog_panels

        panel = dialog_panels.message_panel("Ready?", "Sit comfortably.", "Enter: begin")
        found: list[str] = []

        def noted(presenter: Presenter, label: object) -> object:
            found.append("panel" if not isinstance(label, str) else "help" if "\t" in label else label)
            return notice(presenter, label)

        def noticed(controls, *does: object) -> list[str]:
            found.clear()
            with closing(Mirror(controls)) as mirror, closing(Gpu(mirror.gl)) as gpu, closing(Presenter(gpu)) as over:
                for each in does:
                    if each in ("H", "ESCAPE"):
                        mirror._key(None, getattr(glfw, f"KEY_{each}"), 0, glfw.PRESS, 0)
                    else:
                        mirror._drawn_ns = 0  # due
                        mirror.show(over, None, each)
            return list(found)

        notice = Presenter.notice
        monkeypatch.setattr(Presenter, "notice", noted)
        shown = noticed(dialog_panels.CONTROLS, "", "H", "", panel, "H", panel, "", panel)
        assert shown == ["", "", "panel", "help", "", "panel"]
        assert noticed(CONTROLS, "", "H", "", "H", "", "H", "", "ESCAPE", "") == ["", "help"] * 2 + [""]
