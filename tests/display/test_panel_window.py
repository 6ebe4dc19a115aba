"""The panel in a real window of a virtual screen, led by a real mouse and keyboard."""

from __future__ import annotations

import subprocess
import time

import needs
import pytest

from hmdwarp.display import CONTROLS
from hmdwarp.display.desktop.control_panel import PANEL_REMEDY, installed

from .programs import Led
from .virtual_screen import PATIENCE_S, VirtualScreen, needs_a_screen, until

if not installed():
    pytest.skip(f"the panel's package is not installed: {PANEL_REMEDY}", allow_module_level=True)
pytestmark = needs_a_screen


@pytest.fixture(scope="module")
def screen(tmp_path_factory):
    with VirtualScreen(tmp_path_factory.mktemp("screen")) as made:
        yield made


class Panel(Led):
    def hand(self, *what: object) -> None:
        """xdotool, and a few refreshes, as many as a hand takes time for."""
        self.screen.do(*what)
        time.sleep(0.15)
        for _ in range(4):
            self.say("where")

    def grab(self) -> tuple[int, int]:
        """Where the latency slider's grab is, once the panel has been drawn."""
        return tuple(until(lambda: self.say("where")["grab"], "a slider"))

    def places(self) -> dict[str, list[float]]:
        """The middle of each widget in the window, once the panel has been drawn."""
        self.grab()
        return self.say("where")["places"]

    def to(self, label: str, *then: object) -> tuple[int, int]:
        """The mouse to the middle of a widget, and what it does there; where that is."""
        x, y = map(round, self.places()[label])
        self.hand("mousemove", x, y, *then)
        return x, y

    def wanted(self, key: str) -> set[bool | None]:
        """Whether the panel wanted the clicks or keys of late; each down and up."""
        events = self.heard(key)
        assert events and len(events) % 2 == 0, events
        return {event["wanted"] for event in events}

    def asked(self) -> list[tuple[str, object]]:
        return [(event["control"], event["value"]) for event in self.heard("control")]


@pytest.fixture(scope="module")
def program(screen, tmp_path_factory):
    with Panel(screen, tmp_path_factory.mktemp("told"), "panel_window") as made:
        yield made


@pytest.fixture
def led(program):
    """One program for all tests here; the mouse is out of the way."""
    program.hand("mousemove", "600", "700")
    program.heard("line")
    return program


def test_the_slider_of_latency_is_dragged(led):
    x, y = led.grab()
    led.hand("mousemove", x, y)
    led.hand("mousedown", "1")
    led.hand("mousemove", x + 40, y)
    led.hand("mousemove", x + 80, y + 200)
    led.hand("mouseup", "1")
    names, values = zip(*led.asked(), strict=True)
    assert set(names) == {"latency"}
    assert list(values) == sorted(values) and values[-1] > 600
    assert led.grab()[0] == pytest.approx(x + 80, abs=6)  # where the hand left it


def test_the_mouse_is_the_panels_over_it_alone(led):
    def asked() -> int:
        return sum("control" in event for event in led.events)

    x, y = led.grab()
    led.hand("mousemove", "100", "300", "click", "1")
    assert led.wanted("click") == {False}
    led.hand("mousemove", "600", y)
    led.hand("click", "1")
    assert led.wanted("click") == {True}
    before = asked()
    led.say("off")
    led.hand("click", "1")
    assert led.wanted("click") == {False}
    led.say("on")
    led.hand("mousemove", x, y)
    led.say("catch")
    led.hand("mousedown", "1", "mousemove_relative", "60", "0", "mouseup", "1")
    assert led.wanted("click") == {False}
    led.say("free")
    assert asked() == before, "what was clicked meanwhile is not made up for"


def test_keys_are_the_windows_until_a_number_is_typed(led):
    x, y = led.grab()
    led.hand("mousemove", x, y, "sleep", "0.2", "key", "t")
    assert led.wanted("key") == {False}
    led.hand("keydown", "ctrl")
    led.hand("click", "1")
    led.hand("keyup", "ctrl")
    led.heard("key")
    led.hand("type", "--delay", "60", "345")
    typed = led.heard("key")
    assert len(typed) == 6 and all(event["wanted"] for event in typed)
    led.hand("key", "Return")
    assert led.asked()[-1] == ("latency", 345.0)
    led.hand("key", "w")
    assert led.wanted("key") == {False}


def test_a_slider_of_the_guard_waits_for_the_hand_to_let_go(led):
    """It builds the whole pipeline anew: once, not at every pixel."""
    x, y = led.to("guard")
    led.hand("mousemove", x - 60, y)
    led.hand("mousedown", "1")
    led.hand("mousemove", x - 20, y)
    led.hand("mousemove", x, y)
    assert led.asked() == []
    led.hand("mouseup", "1")
    ((name, value),) = led.asked()
    assert name == "guard" and value == pytest.approx(2.0, abs=0.1)
    assert value == pytest.approx(round(value / 0.05) * 0.05)


def test_a_choice_is_chosen_from_its_list(led):
    x, y = led.to("warp")
    led.hand("click", "1")
    led.hand("mousemove", x, y + 48)  # the second of two
    assert led.asked() == []
    led.hand("click", "1")
    assert led.asked() == [("warp", "mesh")]  # asked for once


def test_switches_and_buttons_ask_for_what_they_say(led):
    places = led.places()
    buttons = [control.name for control in CONTROLS if control.of_display or control.kind == "hold"]
    asks = [("lens", [("lens", "none")]), ("flat", [("view", "flat")]), ("flat", [])]
    for name in buttons:
        (text,) = (text for text in places if text.startswith(name.replace("_", " ") + " ("))
        asks.append((text, [(name, None)]))
    assert {"quit (Esc)", "full screen (F11)", "grab (B)"} <= {text for text, _ in asks}
    for text, expected in asks:
        led.to(text, "sleep", "0.1", "click", "1")
        assert led.asked() == expected, text


def test_a_run_that_has_not_begun_has_no_row_without_a_value(led):
    assert {"latency", "warp", "fill", "guard", "lens"} <= led.places().keys()
    assert not {"scene", "effects"} & led.places().keys()


@needs.programs("xrdb")
def test_on_a_dense_screen_it_is_larger_and_closed_it_gives_the_callbacks_back(screen, tmp_path):
    how = {"text": True, "env": screen.environment, "timeout": PATIENCE_S}
    subprocess.run(["xrdb", "-nocpp", "-merge"], check=True, input="Xft.dpi: 192\n", **how)
    try:
        with Panel(screen, tmp_path, "panel_window") as led:
            assert led.events[0]["scale"] == 2.0 and led.say("where")["column"] == 660
            led.say("close")
            led.heard("line")
            led.hand("mousemove", "600", "60", "click", "1", "key", "t")
            told = led.heard("wanted")
            assert len(told) == 4 and {event["wanted"] for event in told} == {None}
    finally:
        subprocess.run(["xrdb", "-remove"], check=True, **how)
