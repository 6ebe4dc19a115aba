"""Hostile clients: whatever they send, memory stays bounded and the next one is served."""

import contextlib
import itertools
import os
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.geometry import Fovea, Hidden
from hmdwarp.scenes import InputEvent
from hmdwarp.sources.feed import listener as listening
from hmdwarp.sources.feed import sockets
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import LARGEST_ASK, MOST_FATES, MOST_INPUTS, Fate, Session, encode
from hmdwarp.sources.feed.options import KeyPair
from hmdwarp.sources.feed.parts import Wanted
from hmdwarp.sources.feed.sockets import (
    MOST_CONNECTIONS,
    MOST_OF_ADDRESS,
    MOST_OF_CLIENT,
    MOST_UNREAD,
    Connection,
    Wire,
)

from .exchange import ASK, FRAME, WHENEVER_MS, answered, exchanged, port_of
from .foreign import greeting, part, ready

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")
MIB = 1 << 20


def raw(listener) -> socket.socket:
    """A client that speaks the library's protocol by hand."""
    one = socket.create_connection(("127.0.0.1", port_of(listener.address)))
    one.sendall(greeting())
    one.recv(len(greeting()), socket.MSG_WAITALL)
    one.sendall(ready())
    # Flag, length and text of the server's own.
    one.recv(one.recv(2, socket.MSG_WAITALL)[1], socket.MSG_WAITALL)
    return one


def request(number: int = ASK.number, **more) -> bytes:
    return encode(attrs.evolve(ASK, number=number, token=bytes(32), **more))


def until(listener, told: str) -> None:
    """Serve until that is told."""
    while not any(told in line for line in listener.told):
        listener.next(10)


ALONE = "HMDWARP_TEST_ALONE"  # set in the process that a test has for itself


@pytest.fixture
def is_done(request) -> bool:
    """Run the test in a process of its own: what others left in this one grows and shrinks too."""
    if ALONE in os.environ:
        return False
    own = {name: value for name, value in os.environ.items() if "XDIST" not in name} | {ALONE: "1"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"{__file__}::{request.node.name}"]
    done = subprocess.run(command, check=False, capture_output=True, text=True, env=own, cwd=request.config.rootpath)
    assert done.returncode == 0, done.stdout
    return True


def resident() -> int:
    """Bytes of this process in memory that are its own."""
    _, all_of_it, shared, *_ = map(int, Path("/proc/self/statm").read_text().split())
    return (all_of_it - shared) * 4096


def serves(listener) -> None:
    caller = Caller(listener.address)
    exchanged(caller, listener)
    caller.close()


@pytest.mark.parametrize("part", [b"", b"x" * 200], ids=["empty parts", "parts of 200 bytes"])
def test_a_message_without_an_end_is_cut_and_takes_no_more_memory_than_it_may(listener, is_done, part):
    if is_done:
        return
    # Flags "more", length, bytes.
    parts = (b"\x01" + bytes([len(part)]) + part) * 2000
    before = resident()
    with raw(listener) as one, pytest.raises(OSError):
        for _ in range(10_000):
            one.sendall(parts)
    # A part of two bytes takes 64 in the library; it may go on for a few looks of the watcher.
    assert resident() - before < 32 * 8 * MOST_UNREAD
    while not any("without an end" in line for line in listener.told):
        assert listener.next(10) is None
    serves(listener)


def test_the_longest_request_is_taken_and_one_byte_more_is_not(listener):
    # Sixteen layers are the most, each with eight rows of eight settings, 512 fates and inputs.
    most = ((1.0,) * 8,) * 8
    wanted = Wanted(tuple(("a" * count, most) for count in range(1, 17)), (4, 3), tuple(view.fov for view in ASK.views))
    views = tuple(attrs.evolve(view, hidden=Hidden((((-1, -1), (0, -1), (-1, 0)),), view.fov)) for view in ASK.views)
    session = Session(1, fates=tuple(Fate(number, True, 0) for number in range(MOST_FATES)))
    inputs = (InputEvent(0, "push"),) * MOST_INPUTS
    longest = encode(attrs.evolve(ASK, views=views, wanted=wanted, session=session, fovea=Fovea(), inputs=inputs))
    assert len(longest) == LARGEST_ASK
    with raw(listener) as one:
        one.sendall(part(longest))
        until(listener, "token")  # it is wrong, so it was read


@pytest.mark.parametrize("stage", ["nothing", "greeting", "ready"])
def test_silent_connections_make_room_for_those_that_ask(listener, stage):
    """As many as there may be in all, from one address."""
    with ExitStack() as held:
        for _ in range(MOST_CONNECTIONS):
            one = held.enter_context(socket.create_connection(("127.0.0.1", port_of(listener.address))))
            if stage != "nothing":
                one.sendall(greeting() + ready() * (stage == "ready"))
        serves(listener)
        until(listener, f"more than {MOST_OF_ADDRESS} from one address")
        serves(listener)


@pytest.mark.parametrize("behind_s", [0, 0.5])
def test_where_all_of_an_address_ask_the_newcomer_is_cut(monkeypatch, behind_s):
    """Also where the thread that watches connections notes them after their first requests."""
    waits = iter([behind_s])

    def noted(*about):
        time.sleep(next(waits, 0))
        return Connection(*about)

    monkeypatch.setattr(sockets, "Connection", noted)
    monkeypatch.setattr(sockets, "IDLE_NS", 10**12)  # on a busy machine a round of both may take seconds
    told: list[str] = []
    with closing(Listener("127.0.0.1:*", per_address=2, say=told.append)) as listener, ExitStack() as open_now:
        callers = [open_now.enter_context(closing(Caller(listener.address))) for _ in range(2)]
        for caller in callers:
            exchanged(caller, listener)
        with socket.create_connection(("127.0.0.1", port_of(listener.address))):
            while not any("more than 2 from one address" in line for line in told):
                for caller in callers:
                    exchanged(caller, listener)
        # Both kept their connection.
        assert sum("connected:" in line for line in told) == 2 and not any("superseded" in line for line in told)


def test_a_descriptor_that_is_another_s_by_now_is_not_cut(tmp_path):
    """The library closes a connection when it ends; what is opened next gets its descriptor."""
    with ExitStack() as stack:
        (gone, _), (other, peer) = (map(stack.enter_context, socket.socketpair()) for _ in range(2))
        wire, own = Wire.of(gone.fileno()), Wire.of(other.fileno())
        os.dup2(other.fileno(), gone.fileno())
        count = len([*Path("/proc/self/fd").iterdir()])
        wire.cut()
        with pytest.raises(OSError, match="another's"):
            wire.handle()
        other.send(b"x")
        assert peer.recv(1) == b"x"
        own.cut()
        assert peer.recv(1) == b""
        with (tmp_path / "file").open("wb") as file:
            os.dup2(file.fileno(), gone.fileno())
            wire.cut()
            assert len([*Path("/proc/self/fd").iterdir()]) == count + 1  # the file's, and none left over


@pytest.mark.parametrize("asks", [False, True])
def test_a_connection_that_falls_silent_is_cut(listener, monkeypatch, asks):
    with raw(listener) as one:
        if asks:
            one.sendall(part(request()))
            while not answered(listener):
                pass
        monkeypatch.setattr(sockets, "SILENT_NS", 200_000_000)
        with contextlib.suppress(ConnectionError):
            while one.recv(1 << 16):  # what the library calls, and the frame
                listener.next(10)
    until(listener, "cut: silent")
    assert any("superseded" in line for line in listener.told) == asks


def test_log_lines_are_limited_whatever_comes(listener):
    begun = time.monotonic()
    with raw(listener) as one:
        for number in range(600):
            bad = b"HWFD\x1b[2J" + bytes(number % 7)
            one.sendall(b"\x00" + bytes([len(bad)]) + bad)
            listener.next(0)
        until(listener, "more lines")
    seconds = 2 + time.monotonic() - begun
    # Of one kind and address, and a line a second on the rest.
    assert 0 < len(listener.told) <= 5 * seconds
    assert all(line.isprintable() for line in listener.told)


LARGE = {"size": (2048, 2048), "views": ASK.views[:1]}
PICTURES = {"colours": (np.ones((2048, 2048, 4), np.float16),), "inverse_depths": (np.ones((2048, 2048), np.float32),)}


def given(listener) -> bool:
    """Answer the next request by 48 MiB; return whether it was sent. There is none as soon as it is
    there and has to wait."""
    asked = listener.next(WHENEVER_MS)
    if asked is None:
        return False
    frame = attrs.evolve(FRAME, number=asked.ask.number, views=ASK.views[:1], **PICTURES)
    return listener.answer(asked, frame)


class Mute:
    """A client that asks and reads nothing, not even into this process."""

    def __init__(self, listener: Listener) -> None:
        self._socket, self._listener, self._numbers = raw(listener), listener, itertools.count(1)

    def asks(self) -> bool:
        """Ask for a frame; return whether it was sent."""
        self._socket.sendall(part(request(next(self._numbers), **LARGE)))
        return given(self._listener)

    def close(self) -> None:
        self._socket.close()


class Liar:
    """A client that says it has everything and reads nothing."""

    def __init__(self, listener: Listener, pair: KeyPair | None = None, *, received: int = 2**64 - 1) -> None:
        self._context = zmq.Context()
        self.socket = self._context.socket(zmq.DEALER)
        for name, value in (("LINGER", 0), ("RCVHWM", 1), ("RCVBUF", 4096)):
            self.socket.setsockopt(getattr(zmq, name), value)
        if pair is not None:
            self.socket.curve_publickey, self.socket.curve_secretkey = zmq.curve_keypair()
            self.socket.curve_serverkey = pair.public
        self.socket.connect(listener.address)
        self._received, self._listener, self._numbers = received, listener, itertools.count(1)

    def asks(self) -> bool:
        """Ask for a frame; return whether it was sent."""
        self.socket.send(self.next_request())
        return given(self._listener)

    def next_request(self) -> bytes:
        return request(next(self._numbers), received=self._received, **LARGE)

    def close(self) -> None:
        self.socket.close(0)
        self._context.term()


@pytest.mark.parametrize(("way", "received"), [("tcp", 2**64 - 1), ("encrypted", 0)], ids=["false", "honest"])
def test_what_waits_for_a_client_is_bounded_whatever_it_says_that_it_has(is_done, way, received):
    if is_done:
        return
    pair = KeyPair(*zmq.curve_keypair()) if way == "encrypted" else None
    with closing(Listener("127.0.0.1:*", pair=pair)) as listener:
        with closing(Liar(listener, pair, received=received)) as liar:
            before = resident()
            sent = sum(liar.asks() for _ in range(20))
            # One frame more is being made, and is not sent.
            assert resident() - before < MOST_OF_CLIENT + 64 * MIB
        assert 0 < sent < 8
        while listener.clients:
            listener.next(10)
        if pair is None:
            serves(listener)


def test_what_waits_for_all_is_bounded_and_the_one_that_takes_nothing_makes_room(monkeypatch, is_done):
    if is_done:
        return
    monkeypatch.setattr(listening, "MOST_OF_ALL", 200 * MIB)
    monkeypatch.setattr(listening, "_STUCK_NS", 0)
    told: list[str] = []
    with closing(Listener("127.0.0.1:*", say=told.append)) as listener, ExitStack() as open_now:
        before = resident()
        for _ in range(5):
            mute = open_now.enter_context(closing(Mute(listener)))
            for _ in range(3):
                mute.asks()
            assert resident() - before < 300 * MIB
        while not any("no room for others'" in line for line in told):
            if (asked := listener.next(10)) is not None:
                listener.answer(asked, attrs.evolve(FRAME, number=asked.ask.number, views=ASK.views[:1], **PICTURES))
            assert resident() - before < 300 * MIB
        serves(listener)


def test_a_client_that_asks_on_and_on_stays_while_it_is_read(listener):
    """Many whole messages are no endless one, even if nobody takes them for a while."""
    numbers = itertools.count(1)

    def some(size: int) -> bytes:
        return b"".join(part(request(next(numbers))) for _ in range(size // 400))

    flood = some(MOST_UNREAD // 4)
    with raw(listener) as one:
        one.sendall(flood)
        time.sleep(0.1)
        for _ in range(8):
            one.sendall(some(MOST_UNREAD // 4))
            last = next(numbers) - 1
            while (asked := listener.next(10)) is None or asked.ask.number < last:
                pass
        assert not any("cut" in line for line in listener.told)
        with pytest.raises(OSError):
            for _ in range(1 << 14):
                one.sendall(flood)
    until(listener, "KiB unread")
    serves(listener)
