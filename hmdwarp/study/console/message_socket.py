"""Messages between the session's program and the console's, and the commands that came.

The session's program must not wait. Messages are pickled tuples. Both ends belong to one program
that started the other, so no foreign pickle comes in. To the console: ("state", ConsoleState),
("say", text), ("leave",). Back: ("command", name, value, subject).
"""

from __future__ import annotations

import os
import pickle
import socket
import sys
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any

from ...display import Command
from ...platforms import unblock, widen_pipe
from .line_console import ConsoleState, LineConsole, Subject, is_bound, subject_of

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


class CommandQueue:
    """Commands that came; those that belong to their subject are released one at a time."""

    def __init__(self, state: ConsoleState) -> None:
        self._state = state
        self._free: deque[Command] = deque()
        self._bound: deque[tuple[str, object, Subject]] = deque()
        self._is_current = True  # since a bound one was returned: only then is the next one's subject known

    def tell(self, state: ConsoleState) -> None:
        """Take note of a new state."""
        self._state, self._is_current = state, True

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
        while self._bound and self._is_current:
            name, value, subject = self._bound.popleft()
            if subject != subject_of(self._state):
                messages.send("say", f"{name!r} came too late and was dropped: that question is over")
            else:
                self._free.append(Command(name, value))
                self._is_current = False


class ProgramConsole:
    """Console whose screen is another program; plain lines replace one that ends."""

    what = ""  # the program, in messages

    def __init__(self, title: str) -> None:
        self._title = title
        self._state = ConsoleState(heading=title)
        self._queue = CommandQueue(self._state)
        self._lines: LineConsole | None = None
        self.messages: MessageSocket | None = None  # where the state is shown now

    def tell(self, state: ConsoleState) -> None:
        """Show a new state."""
        self._state = state
        self._queue.tell(state)
        if self._lines is not None:
            self._lines.tell(state)
        else:
            self._reach(lambda screen: screen.send_state(state))

    def say(self, text: str) -> None:
        """Add a line to the journal."""
        if self._lines is None:
            self._note(text[:LONGEST_LINE])
        if self._lines is not None:  # by now, perhaps
            self._lines.say(text)

    def commands(self) -> Sequence[Command]:
        """Return the commands since the last call."""
        if self._lines is None:
            self._reach(self._queue.receive)
        more = self._lines.commands() if self._lines is not None else ()
        taken = self._queue.taken()
        return [*taken, *more] if taken else more

    def _note(self, line: str) -> None:
        """Send a line of the journal."""
        self._reach(lambda screen: screen.send("say", line))

    def _reach(self, use: Callable[[MessageSocket], None]) -> None:
        """Use the screen's end, if there is a screen."""
        if self.messages is not None:
            try:
                use(self.messages)
            except PeerGone:
                self._lose_screen()

    def _lose_screen(self) -> None:
        """Go on without the screen."""
        self._continue_with_lines()

    def __exit__(self, *_: object) -> None:
        if self._lines is not None:
            self._lines.__exit__()
        else:
            self._end()

    def _end(self) -> int:
        """End the program. Returns its exit status."""
        raise NotImplementedError

    def _continue_with_lines(self) -> LineConsole:
        """Replace a program that ended."""
        why = f"{self.what} ended (exit status {self._end()}); the session goes on"
        self._lines = LineConsole(self._title, why).__enter__()
        self._lines.tell(self._state)
        return self._lines


# Room for prints while the console is busy; the kernel's 64 KiB are little for a talkative runtime.
PIPE_BYTES = 1 << 20


class OutputCapture:
    """Redirection of file descriptors 1 and 2, where they are terminals, from begin() to end()."""

    def __init__(self) -> None:
        self.read, self._write = os.pipe()  # reads do not wait
        unblock(self.read)
        with suppress(OSError):  # more than this user may have
            widen_pipe(self._write, PIPE_BYTES)
        self.out, self.err = os.dup(1), os.dup(2)  # stdout and stderr as they were
        self._taken = [fd for fd in (1, 2) if os.isatty(fd)]

    def begin(self) -> None:
        """Redirect from now on."""
        _flush()
        for fd in self._taken:
            os.dup2(self._write, fd)

    def end(self) -> None:
        """Restore stdout and stderr. May be called twice."""
        _flush()
        for fd, saved in ((1, self.out), (2, self.err)):
            if fd in self._taken:
                os.dup2(saved, fd)
        self._taken = []
        if self._write >= 0:
            os.close(self._write)
            self._write = -1

    def close(self) -> None:
        """Close the pipe; what the console has not read is printed."""
        for piece in pieces(self.read):
            _write(self.err, piece)
        for fd in (self.read, self.out, self.err):
            os.close(fd)


def pieces(fd: int) -> Iterator[bytes]:
    """Yield what lies in the pipe now."""
    while True:
        try:
            piece = os.read(fd, 1 << 16)
        except BlockingIOError:
            return
        if not piece:
            return
        yield piece


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            with suppress(OSError, ValueError):
                stream.flush()


def _write(fd: int, data: bytes) -> None:
    with suppress(OSError):
        while data:
            data = data[os.write(fd, data) :]
