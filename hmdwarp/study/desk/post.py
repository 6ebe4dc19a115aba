"""What the two programs of a desk tell each other: the session's, which must not wait, and the one that keeps the screen.

Packets are pickles of tuples; both ends are of one program, started by itself, so nobody else's pickle ever comes in. To the screen:
("state", DeskState), ("say", text), ("leave",). Back: ("command", name, value, about), ("failed", why).
"""

from __future__ import annotations

import pickle
import socket
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

PACKET = 1 << 16
LONGEST_LINE = 2000
LINES_KEPT = 1000  # for a screen that is behind


class Gone(Exception):
    """The other end is there no more."""


class Post:
    """One end. Nothing here waits: what cannot be sent now is sent later, of states the newest only."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._state: bytes | None = None
        self._room = memoryview(bytearray(PACKET))  # its own: a new one for every look would cost 10 us
        self._packets: deque[bytes] = deque(maxlen=LINES_KEPT)

    def state(self, state: object) -> None:
        """The newest state; one that has not been sent yet is forgotten. Errors: Gone."""
        self._state = pickle.dumps(("state", state), pickle.HIGHEST_PROTOCOL)
        self.flush()

    def send(self, *packet: object) -> None:
        """Anything else, in its order. Errors: Gone."""
        self._packets.append(pickle.dumps(packet, pickle.HIGHEST_PROTOCOL))
        self.flush()

    def flush(self) -> None:
        """Send what was left. Errors: Gone."""
        try:
            while self._packets:
                self._end.send(self._packets[0])
                self._packets.popleft()
            if self._state is not None:
                self._end.send(self._state)
                self._state = None
        except BlockingIOError:
            return
        except OSError as error:
            raise Gone(str(error)) from None

    def received(self) -> Iterator[tuple[Any, ...]]:
        """What has come since the last time. Errors: Gone."""
        while True:
            try:
                length = self._end.recv_into(self._room)
            except BlockingIOError:
                return
            except OSError as error:
                raise Gone(str(error)) from None
            if not length:
                raise Gone("it has ended")
            yield pickle.loads(self._room[:length])

    def fileno(self) -> int:
        """To be told when something comes."""
        return self._end.fileno()

    def leave(self) -> None:
        """The last word; an end that is gone has no need of it."""
        with suppress(Gone):
            self.send("leave")

    def close(self) -> None:
        """Let go."""
        self._end.close()
