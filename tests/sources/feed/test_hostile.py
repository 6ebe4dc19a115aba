"""Hostile clients: whatever they send, memory stays bounded and the next one is served."""

import random
import socket
import struct
import time
from pathlib import Path

import attrs
import pytest

from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import LARGEST_ASK, encode
from hmdwarp.sources.feed.parts import Wanted
from hmdwarp.sources.feed.sockets import MOST_CONNECTIONS, MOST_UNREAD

from .exchange import exchanged, port_of
from .test_message import ASK

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install 'hmdwarp[feed]'")

# ZMTP 3.0 (ZeroMQ RFC 23): greeting for NULL security, then READY of a DEALER.
GREETING = b"\xff" + bytes(8) + b"\x7f\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32)
_READY = b"\x05READY\x0bSocket-Type" + struct.pack(">I", 6) + b"DEALER"
READY = b"\x04" + bytes([len(_READY)]) + _READY


@pytest.fixture
def listener():
    told: list[str] = []
    made = Listener("127.0.0.1:*", say=told.append)
    made.told = told
    yield made
    made.close()


def raw(listener) -> socket.socket:
    """A client that speaks the library's protocol by hand."""
    one = socket.create_connection(("127.0.0.1", port_of(listener.address)))
    one.sendall(GREETING)
    one.recv(len(GREETING), socket.MSG_WAITALL)
    one.sendall(READY)
    # Flag, length and text of the server's own.
    one.recv(one.recv(2, socket.MSG_WAITALL)[1], socket.MSG_WAITALL)
    return one


def resident() -> int:
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def serves(listener) -> None:
    caller = Caller(listener.address)
    exchanged(caller, listener)
    caller.close()


@pytest.mark.parametrize("part", [b"", b"x" * 200], ids=["empty parts", "parts of 200 bytes"])
def test_a_message_without_an_end_is_cut_and_takes_no_more_memory_than_it_may(listener, part):
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


def test_a_message_that_is_too_long_ends_the_connection(listener):
    before = resident()
    with raw(listener) as one, pytest.raises(OSError):
        # Flag "long", and a length that nobody asks for.
        one.sendall(b"\x02" + struct.pack(">Q", 1 << 40))
        for _ in range(1 << 14):
            one.sendall(bytes(1 << 16))
    assert resident() - before < 64 << 20
    serves(listener)


def test_the_longest_request_is_taken_and_one_byte_more_is_not(listener):
    # Sixteen layers are the most.
    wanted = Wanted(tuple(("a" * count, 1) for count in range(1, 17)), (4, 3), tuple(view.fov for view in ASK.views))
    longest = encode(attrs.evolve(ASK, wanted=wanted))
    assert len(longest) == LARGEST_ASK
    with raw(listener) as one:
        one.sendall(b"\x02" + struct.pack(">Q", LARGEST_ASK) + longest)
        while not listener.told:  # the token is wrong, so it was read
            listener.next(10)
        assert "token" in listener.told[0]


def test_more_connections_than_there_may_be_are_cut(listener):
    there = "127.0.0.1", port_of(listener.address)
    open_now = [socket.create_connection(there) for _ in range(MOST_CONNECTIONS + 5)]
    try:
        while not any("too many" in line for line in listener.told):
            listener.next(10)
    finally:
        for connection in open_now:
            connection.close()
    serves(listener)


def test_a_thousand_connections_of_noise_leave_it_serving(listener):
    rng = random.Random(19)
    whole = GREETING + READY + b"\x02" + struct.pack(">Q", len(encode(ASK))) + encode(ASK)
    for _ in range(1000):
        data = bytearray(whole)
        for _ in range(rng.randint(0, 8)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        with socket.create_connection(("127.0.0.1", port_of(listener.address))) as one:
            one.sendall(bytes(data[: rng.randint(1, len(data))]))
        listener.next(0)
    serves(listener)


def test_a_client_that_asks_on_and_on_is_not_taken_for_one(listener):
    """Many whole messages are no endless one, even if nobody takes them for a while."""
    request = b"\x02" + struct.pack(">Q", len(encode(ASK))) + encode(ASK)
    flood = request * 20
    with raw(listener) as one:
        one.settimeout(0.2)
        sent = 0
        try:
            while sent < 8 * MOST_UNREAD:
                sent += one.send(flood[sent % len(request) :])
        except TimeoutError:
            pass  # it is held back, as it should be
        time.sleep(0.1)
        one.settimeout(60)
        while sent < 16 * MOST_UNREAD:
            for _ in range(4):
                listener.next(0)
            sent += one.send(flood[sent % len(request) :])
    assert not any("cut" in line for line in listener.told)
