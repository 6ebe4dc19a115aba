"""Messages between the session's program, which must not wait, and the program of the console.

Messages are pickled tuples. Both ends belong to one program that started the other, so no foreign
pickle comes in. To the console: ("state", ConsoleState), ("say", text), ("leave",). Back:
("command", name, value, subject).
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
LINES_KEPT = 1000  # for a console that is behind


class PeerGone(Exception):  # noqa: N818 (often no error)
    """The other end is closed."""


class MessageSocket:
    """One end. It never waits: what cannot be sent now goes later, of states the newest only."""

    def __init__(self, end: socket.socket) -> None:
        end.setblocking(False)
        self._end = end
        self._state: bytes | None = None
        self._buffer = memoryview(bytearray(PACKET))  # kept: a new one per read would cost 10 us
        self._packets: deque[bytes] = deque(maxlen=LINES_KEPT)

    def send_state(self, state: object) -> None:
        """Send the newest state; an unsent older one is dropped. Errors: PeerGone."""
        self._state = pickle.dumps(("state", state), pickle.HIGHEST_PROTOCOL)
        self.flush()

    def send(self, *message: object) -> None:
        """Send any other message, in its order. Errors: PeerGone."""
        self._packets.append(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))
        self.flush()

    def flush(self) -> None:
        """Send what is left. Errors: PeerGone."""
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
            raise PeerGone(str(error)) from None

    def received(self) -> Iterator[tuple[Any, ...]]:
        """Yield the messages since the last call. Errors: PeerGone."""
        while True:
            try:
                length = self._end.recv_into(self._buffer)
            except BlockingIOError:
                return
            except OSError as error:
                raise PeerGone(str(error)) from None
            if not length:
                raise PeerGone("it has ended")
            yield pickle.loads(self._buffer[:length])

    def fileno(self) -> int:
        """Return the file descriptor, to wait for messages."""
        return self._end.fileno()

    def leave(self) -> None:
        """Tell the other end to leave, if it is still there."""
        with suppress(PeerGone):
            self.send("leave")

    def close(self) -> None:
        """Close this end."""
        self._end.close()
