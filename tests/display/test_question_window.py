"""A question in a window: keys, digits, mouse and wheel answer it.

While nothing is asked, and only then, the mouse leads the head.
"""

from __future__ import annotations

import time

import numpy as np
import pytest

from .programs import Led
from .virtual_screen import VirtualScreen, needs_a_screen, until

pytestmark = [needs_a_screen, pytest.mark.slow]  # a program of its own: 10 s


class Asking(Led):
    """A question's window."""

    def __enter__(self):
        super().__enter__()
        self.window = until(lambda: self.screen.do("search", "--name", "^hmdwarp").partition("\n")[0], "a window")
        return self

    def keys(self, *names: str) -> None:
        self.screen.do("key", *names)

    def shown(self, line: str) -> None:
        """Say it, and wait until it is on the screen."""
        self.say(line)
        time.sleep(0.2)

    def commands(self) -> list[tuple[str, object]]:
        """All so far."""
        return [(event["command"], event["given"]) for event in self.events if "command" in event]

    def now(self, what: str) -> object:
        """The newest state."""
        return self.events[-1][what]

    def waits(self, what: str, wanted: object) -> None:
        until(lambda: self.now(what) == wanted, f"{what} == {wanted}", lambda: f"{what} is {self.now(what)}")

    def changes(self, what: str, *hand: object) -> None:
        """Let xdotool do that, and wait until it is another."""
        before = self.now(what)
        self.screen.do(*hand)
        until(lambda: self.now(what) != before, f"{what} is another")

    def picture(self) -> np.ndarray:
        x, y, w, h = self.screen.geometry(self.window)
        return self.screen.picture()[y : y + h, x : x + w].copy()

    def halves(self) -> list[int]:
        """How many pixels of each eye's half of the window are not black."""
        return [int(half.sum()) for half in np.hsplit(self.picture().max(axis=2) > 60, 2)]

    def to(self, across: float, up: float) -> int:
        """The mouse to a place of the left eye's half, as shares of it from bottom left.

        How many pixels that is from the left.
        """
        x, y, w, h = self.screen.geometry(self.window)
        at = round(x + across * w / 2), round(y + (1 - up) * h)
        self.screen.do("mousemove", *at)
        return at[0] - x


@pytest.fixture(scope="module")
def screen(tmp_path_factory):
    with VirtualScreen(tmp_path_factory.mktemp("screen"), (900, 640)) as made:
        yield made


@pytest.fixture
def asking(screen, tmp_path):
    with Asking(screen, tmp_path, "question_window") as made:
        yield made


def test_keys_answer(asking):
    """A held key goes on to the end, and Escape is the menu and ends nothing."""
    asking.shown("ask")
    assert asking.now("value") is None  # nothing is chosen beforehand
    asking.keys("Return")
    until(lambda: ("confirm", None) in asking.commands(), "Enter")
    for keys, value in (
        (("3", "comma", "2"), None),  # 3.2 is none of quarter steps
        (("5",), 3.25),
        (("BackSpace", "BackSpace", "KP_Decimal", "KP_7", "KP_5"), 3.75),
        (("Left", "Left"), 3.25),
    ):
        asking.keys(*keys)
        asking.waits("value", value)
    asking.screen.do("keydown", "Right")
    asking.waits("value", 6)
    asking.screen.do("keyup", "Right")
    asking.keys("Escape", "x")
    until(lambda: asking.commands()[-2:] == [("menu", None), ("skip", None)], "menu and skip")
    assert not asking.now("confirmed")
    asking.keys("KP_Enter")
    asking.waits("confirmed", True)


def test_pictures_stay_free_of_text(asking):
    """The help is there beside a question, over the left eye, goes with it, and cannot be called
    over what is shown.
    """
    asking.shown("show")
    asking.keys("h", "r")
    time.sleep(0.5)  # as long as a help would take to be drawn, and more
    assert asking.halves() == [0, 0]
    asking.shown("ask")
    left, right = asking.halves()
    assert left == right > 0, "the question before both eyes: no help was waiting for it"
    asking.keys("h")
    until(lambda: asking.halves()[0] != right, "the help")
    asking.shown("show")
    assert asking.halves() == [0, 0]


def marker(pictures: list[np.ndarray]) -> list[float]:
    """Where in each of two pictures of the left half something bright is that is not in the other.

    Its middle, in pixels from the left.
    """
    first, second = (picture.astype(int).sum(axis=2) for picture in pictures)
    upper = int(np.flatnonzero((first != second).any(axis=1))[0])
    off = (first - second)[upper : upper + 25]  # number and pointer; the line and its words are below
    return [float(np.flatnonzero((sign * off).max(axis=0) > 300).mean()) for sign in (1, -1)]


def test_the_mouse_answers(asking):
    asking.shown("ask")
    pictures, places, values = [], [], []
    for across in (0.33, 0.62):
        before = len(asking.commands())
        places.append(asking.to(across, 0.525))
        until(lambda before=before: len(asking.commands()) > before, "a point")
        asking.shown("wait")
        pictures.append(np.hsplit(asking.picture(), 2)[0])
        values.append(asking.now("value"))
    assert values[0] < values[1] and all(value % 1 for value in values), "between two words: only the marker is another"
    # 20 steps over 0.84 of a text panel that is 0.94 of the half: the marker is within half a step
    # of the mouse.
    step = 0.84 * 0.94 * pictures[0].shape[1] / 20
    assert np.allclose(marker(pictures), places, atol=step / 2 + 2)
    asking.to(1.62, 0.525)  # the same place before the right eye
    until(lambda: asking.commands()[-1][1][0] > 0, "a point")
    asking.shown("wait")
    assert asking.now("value") == values[1]
    for wheel, step in ((["click", "4"], 0.25), (["click", "5", "click", "5"], -0.25)):
        asking.screen.do(*wheel)
        asking.waits("value", values[1] + step)
    assert not asking.now("confirmed")
    asking.screen.do("click", "1")
    asking.waits("confirmed", True)
    assert asking.now("value") == values[1] and not asking.now("captured")


def test_the_head_has_the_mouse_while_nothing_is_asked(asking):
    """A trial takes it without a click: participants at a window do not know that they could."""
    asking.shown("ask")
    asking.to(0.5, 0.9)  # beside the text panel
    asking.screen.do("click", "1")
    asking.keys("2")
    asking.waits("value", 2)
    assert {name for name, _ in asking.commands()} <= {"digit"} and not asking.now("captured")
    asking.shown("trial")
    asking.waits("captured", True)
    asking.changes("turned", "mousemove_relative", "--", 60, 0)
    asking.changes("stands", "keydown", "w")
    asking.shown("ask")  # in the middle of a walk
    asking.waits("captured", False)

    def stands_still() -> bool:
        """Two reports, each of a head two refreshes later: the program tells of changes only."""
        asking.shown("wait")
        before = asking.now("stands")
        asking.shown("wait")
        return asking.now("stands") == before

    until(stands_still, "standing still")
    turned, stood = asking.now("turned"), asking.now("stands")
    asking.to(0.4, 0.525)
    asking.screen.do("keydown", "s")
    asking.keys("4")
    asking.waits("value", 4)
    assert (asking.now("turned"), asking.now("stands")) == (turned, stood)
    asking.screen.do("keyup", "w", "keyup", "s")
    asking.shown("show")
    asking.waits("captured", True)  # as it was before the question
    asking.changes("turned", "mousemove_relative", "--", -60, 0)


def test_words_are_typed(asking):
    """Letters that are keys of controls elsewhere are letters here; Enter and Esc stay keys."""
    asking.shown("words")
    asking.keys("H", "m", "x", "space", "1", "period", "r", "BackSpace", "W")
    asking.waits("text", "Hmx 1.W")
    asking.keys("Escape")
    until(lambda: asking.commands()[-1] == ("menu", None), "the menu")
    asking.keys("Return")
    asking.waits("confirmed", True)
    assert {name for name, _ in asking.commands()} == {"type", "erase", "menu", "confirm"}
    asking.shown("ask")
    asking.keys("x")
    until(lambda: asking.commands()[-1] == ("skip", None), "a key again")
