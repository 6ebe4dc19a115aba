"""The panel in a real window of a virtual screen, led by a real mouse and keyboard."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
import time
from pathlib import Path

import needs
import pytest

from hmdwarp.display import CONTROLS
from hmdwarp.display.desktop.control_panel import PANEL_REMEDY, installed

from .virtual_screen import PATIENCE_S, VirtualScreen, needs_a_screen

if not installed():
    pytest.skip(f"the panel's package is not installed: {PANEL_REMEDY}", allow_module_level=True)
pytestmark = needs_a_screen
TESTS = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def screen(tmp_path_factory):
    with VirtualScreen(tmp_path_factory.mktemp("screen")) as made:
        yield made


class Led:
    """panel_window in a process of its own, and xdotool's hand on it."""

    def __init__(self, screen: VirtualScreen) -> None:
        paths = os.pathsep.join([str(TESTS.parent), str(TESTS)])
        self._screen = screen
        self._process = subprocess.Popen(
            [sys.executable, "-m", "display.panel_window"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**screen.environment, "PYTHONPATH": paths}, cwd=TESTS,
        )  # fmt: skip
        self._said: queue.Queue[str] = queue.Queue()
        self._reader = threading.Thread(target=self._listen)
        self._reader.start()
        self.all: list[dict] = []
        self.scale = 0.0

    def begin(self) -> Led:
        """Wait until its window is there, and put the mouse out of the way."""
        self.scale = self.until(lambda one: "scale" in one)["scale"]
        self.hand("mousemove", "600", "700")
        return self

    def _listen(self) -> None:
        for line in self._process.stdout:
            self._said.put(line)

    def until(self, wanted) -> dict:
        """The next thing it says that is wanted; all others go to `all`."""
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                one = json.loads(self._said.get(timeout=max(end - time.monotonic(), 0.01)))
            except queue.Empty:
                raise AssertionError(f"it said only {self.all}, and ended with {self._process.poll()}") from None
            self.all.append(one)
            if wanted(one):
                return one

    def say(self, word: str) -> dict:
        """Tell it something; its answer."""
        self._process.stdin.write(word + "\n")
        self._process.stdin.flush()
        return self.until(lambda one: one.get("done") == word)

    def hand(self, *what: object) -> None:
        """xdotool, and a few refreshes, as many as a hand takes time for."""
        self._screen.do(*what)
        time.sleep(0.15)
        for _ in range(4):
            self.say("where")

    def grab(self) -> tuple[int, int]:
        """Where the latency slider's grab is, once the panel has been drawn."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            at = self.say("where")["grab"]
            if at is not None:
                return tuple(at)
            time.sleep(0.05)
        raise AssertionError("no slider is to be seen")

    def places(self) -> dict[str, list[float]]:
        """The middle of each widget in the window, once the panel has been drawn."""
        self.grab()
        return self.say("where")["places"]

    def place(self, label: str) -> tuple[int, int]:
        """The middle of a widget."""
        x, y = self.places()[label]
        return round(x), round(y)

    def heard(self, key: str) -> list[dict]:
        """All it said that has that key, since this was asked last."""
        self.say("where")
        found, self.all = [event for event in self.all if key in event], []
        return found

    def __enter__(self) -> Led:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """Ask it to end, and see that it does well."""
        try:
            self._process.stdin.write("end\n")
            self._process.stdin.close()
            status = self._process.wait(PATIENCE_S)
        finally:
            self._process.kill()
            self._reader.join(PATIENCE_S)
            self._process.stdout.close()
        assert kind is not None or status == 0


@pytest.fixture
def led(screen):
    with Led(screen) as made:
        yield made.begin()


def test_the_slider_of_latency_is_dragged(led):
    x, y = led.grab()
    led.hand("mousemove", x, y)
    led.hand("mousedown", "1")
    led.hand("mousemove", x + 40, y)
    led.hand("mousemove", x + 80, y + 200)
    led.hand("mouseup", "1")
    asked = led.heard("control")
    assert {event["control"] for event in asked} == {"latency"}
    values = [event["value"] for event in asked]
    assert values == sorted(values) and values[-1] > 600
    assert led.grab()[0] == pytest.approx(x + 80, abs=6)  # where the hand left it


def test_a_click_beside_the_panel_is_the_windows_and_one_on_it_the_panels(led):
    _, y = led.grab()
    led.hand("mousemove", "100", "300", "click", "1")
    assert [event["wanted"] for event in led.heard("click")] == [False, False]
    led.hand("mousemove", "600", y)
    led.hand("click", "1")
    assert [event["wanted"] for event in led.heard("click")] == [True, True]
    led.say("off")
    led.hand("click", "1")
    assert [event["wanted"] for event in led.heard("click")] == [False, False]
    led.say("on")
    assert led.heard("control") == []  # what was clicked meanwhile is not made up for


def test_a_caught_mouse_is_not_the_panels(led):
    x, y = led.grab()
    led.hand("mousemove", x, y)
    led.say("catch")
    led.hand("mousedown", "1", "mousemove_relative", "60", "0", "mouseup", "1")
    assert [event["wanted"] for event in led.heard("click")] == [False, False]
    assert led.heard("control") == []
    led.say("free")


def test_keys_are_the_windows_until_a_number_is_typed(led):
    x, y = led.grab()
    led.hand("mousemove", x, y, "sleep", "0.2", "key", "t")
    assert [event["wanted"] for event in led.heard("key")] == [False, False]
    led.hand("keydown", "ctrl")
    led.hand("click", "1")
    led.hand("keyup", "ctrl")
    led.heard("key")
    led.hand("type", "--delay", "60", "345")
    typed = led.heard("key")
    assert len(typed) == 6 and all(event["wanted"] for event in typed)
    led.hand("key", "Return")
    assert {"control": "latency", "value": 345.0} in led.all or {"control": "latency", "value": 345.0} in led.heard(
        "control"
    )
    led.heard("key")
    led.hand("key", "w")
    assert [event["wanted"] for event in led.heard("key")] == [False, False]


def test_a_slider_of_the_guard_waits_for_the_hand_to_let_go(led):
    """It builds the whole pipeline anew: once, not at every pixel."""
    x, y = led.place("guard")
    led.hand("mousemove", x - 60, y)
    led.hand("mousedown", "1")
    led.hand("mousemove", x - 20, y)
    led.hand("mousemove", x, y)
    assert led.heard("control") == []
    led.hand("mouseup", "1")
    (asked,) = led.heard("control")
    assert asked["control"] == "guard"
    assert asked["value"] == pytest.approx(2.0, abs=0.1)
    assert asked["value"] == pytest.approx(round(asked["value"] / 0.05) * 0.05)


def test_a_choice_is_chosen_from_its_list(led):
    x, y = led.place("warp")
    led.hand("mousemove", x, y)
    led.hand("click", "1")
    led.hand("mousemove", x, y + 48)  # the second of two
    assert led.heard("control") == []
    led.hand("click", "1")
    assert led.heard("control") == [{"control": "warp", "value": "mesh"}]  # asked for once


def test_switches_say_what_they_switch_to(led):
    for name, control, value in (("lens", "lens", "none"), ("flat", "view", "flat"), ("flat", "", None)):
        x, y = led.place(name)
        led.hand("mousemove", x, y)
        led.hand("click", "1")
        assert led.heard("control") == ([{"control": control, "value": value}] if control else [])


@pytest.mark.parametrize("name", [control.name for control in CONTROLS if control.of_display or control.kind == "hold"])
def test_buttons_ask_for_what_has_no_value(led, name):
    (x, y) = next(place for text, place in led.places().items() if text.startswith(name.replace("_", " ") + " ("))
    led.hand("mousemove", x, y)
    led.hand("click", "1")
    assert led.heard("control") == [{"control": name, "value": None}]


def test_it_leaves_opengl_as_it_was(led):
    """Twice: at first glyphs are sent, later only drawn."""
    for _ in range(2):
        led.say("state")
        assert led.heard("changed") == [{"changed": []}]


def test_a_run_that_has_not_begun_has_no_row_without_a_value(led):
    assert {"latency", "warp", "fill", "guard", "lens"} <= led.places().keys()
    assert not {"scene", "effects"} & led.places().keys()
    assert {"quit (Esc)", "full screen (F11)", "grab (B)"} <= led.places().keys()


def test_closed_it_gives_the_callbacks_back(led):
    led.grab()
    led.say("close")
    led.hand("mousemove", "600", "60", "click", "1", "key", "t")
    assert [event["wanted"] for event in led.heard("click")] == [None, None]


@needs.programs("xrdb")
def test_a_screen_of_twice_the_density_has_a_panel_of_twice_the_size(screen):
    environment = screen.environment
    subprocess.run(
        ["xrdb", "-nocpp", "-merge"], input="Xft.dpi: 192\n", text=True, env=environment, check=True, timeout=PATIENCE_S
    )
    try:
        with Led(screen) as led:
            assert led.begin().scale == 2.0
            assert led.say("where")["column"] == 660
    finally:
        subprocess.run(["xrdb", "-remove"], env=environment, check=True, timeout=PATIENCE_S)
