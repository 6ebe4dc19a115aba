"""Which key of a terminal is which to an Entry."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.keys import Keys

if TYPE_CHECKING:
    from .screen import Screen

NAMED = {"enter": "enter", "escape": "escape", "backspace": "backspace", "c-u": "clear", "c-w": "clear"}
NOTHING = ("c-z", "c-s", "c-q", "c-d")  # a stopped program would be a lost trial


def bindings(screen: Screen) -> KeyBindings:
    """All keys of the screen."""
    keys = KeyBindings()

    def bind(key: str, name: str) -> None:
        @keys.add(key)
        def _(event: KeyPressEvent) -> None:
            screen.ask(screen.entry.key(name, screen.state))

    for key, name in NAMED.items():
        bind(key, name)

    @keys.add(Keys.Any)
    def _(event: KeyPressEvent) -> None:
        if len(event.data) == 1 and event.data.isprintable():
            screen.ask(screen.entry.key(event.data, screen.state))

    @keys.add(Keys.BracketedPaste)
    def _(event: KeyPressEvent) -> None:
        screen.entry.paste(event.data, screen.state)

    @keys.add("c-l")
    def _(event: KeyPressEvent) -> None:
        event.app.renderer.clear()

    @keys.add("c-c")
    def _(event: KeyPressEvent) -> None:
        screen.signal(signal.SIGINT)

    @keys.add("c-\\")
    def _(event: KeyPressEvent) -> None:
        screen.signal(signal.SIGQUIT)

    for key in NOTHING:
        keys.add(key)(lambda event: None)
    return keys
