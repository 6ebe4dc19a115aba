"""Commands from a console's program, until the session takes them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from ...display import Command
from ._base import ConsoleState
from .console_commands import Subject, is_bound, subject_of
from .message_socket import MessageSocket


class CommandQueue:
    """Commands that came; those that belong to their subject are released one at a time."""

    def __init__(self, state: ConsoleState) -> None:
        self._state = state
        self._free: deque[Command] = deque()
        self._bound: deque[tuple[str, object, Subject]] = deque()
        self._told = True  # since a bound one was returned: only then is the next one's subject known

    def tell(self, state: ConsoleState) -> None:
        """Take note of a new state."""
        self._state, self._told = state, True

    def receive(self, messages: MessageSocket) -> None:
        """Take what the program sent. Errors: PeerGone."""
        messages.flush()
        for _, name, value, subject in messages.received():
            if is_bound(name):
                self._bound.append((name, value, subject))
            else:
                self._free.append(Command(name, value))
        self._release_bound(messages)

    def taken(self) -> Sequence[Command]:
        """Return the commands that may be carried out now, each once."""
        if not self._free:
            return ()
        commands = list(self._free)
        self._free.clear()
        return commands

    def _release_bound(self, messages: MessageSocket) -> None:
        """Release one bound command at a time.

        A second answer to the same question must not become an answer to the next one.
        """
        while self._bound and self._told:
            name, value, subject = self._bound.popleft()
            if subject != subject_of(self._state):
                messages.send("say", f"{name!r} came too late and was dropped: that question is over")
            else:
                self._free.append(Command(name, value))
                self._told = False
