"""Peers that speak to a running server by hand: nothing ends it, stalls it or makes it grow.

Written from docs/feed.md and ZeroMQ's RFC 23 and 37; nothing of hmdwarp is imported.
"""

from __future__ import annotations

import contextlib
import fcntl
import random
import socket
import struct
import termios
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from serving import Serving

from . import foreign
from .exchange import port_of
from .test_any_request import memory

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

MIB = 1 << 20


def greeting(*, version: bytes = b"\x03\x00", mechanism: bytes = b"NULL", server: int = 0) -> bytes:
    return b"\xff" + bytes(8) + b"\x7f" + version + mechanism.ljust(20, b"\0") + bytes([server]) + bytes(31)


def command(body: bytes) -> bytes:
    return (b"\x04" + bytes([len(body)]) if len(body) < 256 else b"\x06" + struct.pack(">Q", len(body))) + body


def ready(kind: bytes = b"DEALER", more: bytes = b"") -> bytes:
    return command(b"\x05READY\x0bSocket-Type" + struct.pack(">I", len(kind)) + kind + more)


def part(data: bytes, *, more: bool = False) -> bytes:
    return bytes([2 + more]) + struct.pack(">Q", len(data)) + data


Attack = Callable[[Callable[[], socket.socket], random.Random], None]
ATTACKS: dict[str, Attack] = {}


def attack(run: Attack) -> Attack:
    ATTACKS[run.__name__.replace("_", " ")] = run
    return run


@contextlib.contextmanager
def sent(connect: Callable[[], socket.socket], *pieces: bytes) -> Iterator[socket.socket]:
    """A connection over which these went, as far as it was open."""
    with connect() as one, contextlib.suppress(OSError):
        with contextlib.suppress(OSError):
            for piece in pieces:
                one.sendall(piece)
            # What has not arrived would be lost with the connection.
            for _ in range(200):
                if not struct.unpack("i", fcntl.ioctl(one, termios.TIOCOUTQ, bytes(4)))[0]:
                    break
                time.sleep(0.001)
            one.setblocking(False)
            while one.recv(1 << 16):
                pass
        one.settimeout(2)
        yield one
        time.sleep(0.01)


def throw(connect: Callable[[], socket.socket], *pieces: bytes) -> None:
    with sent(connect, *pieces):
        pass


@attack
def greetings_of_noise(connect, rng):
    for _ in range(60):
        throw(connect, rng.randbytes(rng.randint(1, 200)))


@attack
def greetings_of_other_versions(connect, rng):
    for version in range(0, 256, 5):
        throw(connect, greeting(version=bytes([version, rng.randrange(256)])), ready(), part(foreign.request(1)))
    # Versions 1 and 2, without a handshake: an identity, and messages.
    for start in (b"\x01\x00", b"\xff" + bytes(7) + b"\x01\x7f\x01\x05\x00\x00"):
        throw(connect, start, *[b"\x02\x01x"] * 50_000)


@attack
def other_mechanisms_and_roles(connect, rng):
    for mechanism in (b"PLAIN", b"CURVE", b"GSSAPI", b"A" * 20, b"\xff" * 20):
        for server in (0, 1):
            with sent(
                connect, greeting(mechanism=mechanism, server=server), command(b"\x05HELLO" + rng.randbytes(194))
            ):
                pass
    for kind in (b"PUB", b"SUB", b"REQ", b"ROUTER", b"PAIR", b"STREAM", b"X" * 200, b""):
        throw(connect, greeting(), ready(kind), part(b""), part(foreign.request(1)))


@attack
def properties_without_end(connect, rng):
    for length in (0, 1, 255, 256, 2**31, 2**32 - 1):
        identity = b"\x08Identity" + struct.pack(">I", length) + rng.randbytes(min(length, 400))
        throw(connect, greeting(), ready(more=identity), part(foreign.request(1)))
    throw(connect, greeting(), command(b"\x05READY" + rng.randbytes(100_000)))
    throw(connect, greeting(), b"\x06" + struct.pack(">Q", 2**40), *[bytes(60_000)] * 200)


@attack
def calls_that_nobody_answers(connect, rng):
    """PING with all that it may carry, and no PONG is read."""
    for context in (b"", b"x" * 16, b"x" * 200):
        ping = command(b"\x04PING" + struct.pack(">H", rng.randrange(2**16)) + context)
        with sent(connect, greeting(), ready(), *[ping * 200] * 60) as one:
            one.shutdown(socket.SHUT_WR)


@attack
def commands_of_other_sockets(connect, rng):
    for name in (b"SUBSCRIBE", b"CANCEL", b"ERROR", b"READY", b"PONG", b"JOIN", b"\xff" * 50):
        throw(connect, greeting(), ready(), command(bytes([len(name)]) + name + rng.randbytes(100)) * 20)


@attack
def commands_without_end(connect, rng):
    throw(connect, greeting(), ready(), *[command(b"\x09SUBSCRIBE" + rng.randbytes(200)) * 100] * 400)


@attack
def messages_of_many_parts(connect, rng):
    for piece in (part(b"", more=True), part(foreign.request(1), more=True), part(rng.randbytes(800), more=True)):
        throw(connect, greeting(), ready(), *[piece * 100] * 3000)


@attack
def requests_that_stop_within(connect, rng):
    data = part(foreign.request(1))
    for _ in range(60):
        throw(connect, greeting(), ready(), data[: rng.randrange(len(data))])


@attack
def clients_that_leave_without_reading(connect, rng):
    """Each asks for a large frame, and resets its connection."""
    for _ in range(70):
        with sent(connect, greeting(), ready(), part(foreign.request(1, size=(512, 512)))) as one:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


@attack
def clients_that_read_a_byte_at_a_time(connect, rng):
    with contextlib.ExitStack() as held:
        readers = [held.enter_context(sent(connect, greeting(), ready())) for _ in range(6)]
        for number in range(1, 9):
            for one in readers:
                with contextlib.suppress(OSError):
                    one.sendall(part(foreign.request(number, size=(512, 512), received=number)))
                    one.recv(1)


@attack
def requests_as_fast_as_they_go(connect, rng):
    throw(connect, greeting(), ready(), *[part(foreign.request(n)) * 40 for n in range(1, 300)])


@attack
def tokens_and_ids_of_all_kinds(connect, rng):
    numbers = [0, 1, 2**64 - 1, 2**63, *(rng.randrange(2**64) for _ in range(200))]
    tokens = (part(foreign.request(number, token=rng.randbytes(32))) for number in numbers)
    throw(connect, greeting(), ready(), *tokens)


class Honest:
    """A client that asks again and again; the longest that it had to wait."""

    def __init__(self, address: str) -> None:
        self.served, self.longest_s, self._ended = 0, 0.0, threading.Event()
        self._address = address
        self._thread = threading.Thread(target=self._work)

    def _work(self) -> None:
        with zmq.Context() as context, context.socket(zmq.DEALER) as client:
            client.linger = 0
            client.connect(self._address)
            begun, number = time.monotonic(), 0
            while not self._ended.is_set():
                number += 1
                client.send(foreign.request(number))
                # Asked again after a while, as any client does.
                if client.poll(500):
                    client.recv()
                    now = time.monotonic()
                    self.served, self.longest_s, begun = self.served + 1, max(self.longest_s, now - begun), now
                self._ended.wait(0.01)

    def __enter__(self) -> Honest:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()


@pytest.fixture(scope="module")
def serving():
    with Serving() as one:
        yield one


@pytest.mark.parametrize("name", ATTACKS)
def test_a_peer_that_speaks_by_hand_costs_nobody_anything(serving, name):
    process, port, tried = serving.process.pid, port_of(serving.address), [0]

    def connect() -> socket.socket:
        tried[0] += 1
        one = socket.create_connection(("127.0.0.1", port))
        one.settimeout(2)  # what the server does not take is not sent
        return one

    with Honest(serving.address) as honest:
        while not honest.served:
            time.sleep(0.01)
        Path(f"/proc/{process}/clear_refs").write_text("5")  # VmHWM is VmRSS again, not another attack's
        before, honest.longest_s = memory(process), 0.0
        ATTACKS[name](connect, random.Random(7))
        served = honest.served
        while honest.served < served + 2:
            time.sleep(0.01)
            assert serving.process.poll() is None
    peak = memory(process, "VmHWM") - before
    print(
        f"{name}: {tried[0]} connections, {peak / MIB:+.0f} MiB, another client waited {honest.longest_s:.2f} s at most"
    )
    assert peak < 128 * MIB
