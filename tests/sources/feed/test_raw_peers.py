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
from collections.abc import Callable
from itertools import product
from pathlib import Path

import pytest
from serving import Serving

from .exchange import port_of
from .foreign import command, greeting, part, ready, request
from .test_any_request import memory

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

MIB = 1 << 20


RESET = struct.pack("ii", 1, 0)  # of SO_LINGER: what closes drops all that is not sent, and says so
VERSIONS_1_AND_2 = (b"\x01\x00", b"\xff" + bytes(7) + b"\x01\x7f\x01\x05\x00\x00")  # no handshake, an identity
ROLES = (b"PUB", b"SUB", b"REQ", b"ROUTER", b"PAIR", b"STREAM", b"X" * 200, b"")
COMMANDS = (b"SUBSCRIBE", b"CANCEL", b"ERROR", b"READY", b"PONG", b"JOIN", b"\xff" * 50)
IDS = (0, 1, 2**64 - 1, 2**63, *range(10**18, 2 * 10**18, 5 * 10**15))
ASKED = part(request(1))
Connections = list[list[bytes]]


def named(name: bytes, rng: random.Random) -> bytes:
    return command(bytes([len(name)]) + name + rng.randbytes(100))


def identity(length: int, rng: random.Random) -> bytes:
    return ready(more=b"\x08Identity" + struct.pack(">I", length) + rng.randbytes(min(length, 400)))


def ping(context: bytes, rng: random.Random) -> bytes:
    return command(b"\x04PING" + struct.pack(">H", rng.randrange(2**16)) + context)


HELLO = [greeting(), ready()]
# What the connections of each attack send, one after the other.
ATTACKS: dict[str, Callable[[random.Random], Connections]] = {
    "greetings of noise": lambda rng: [[rng.randbytes(rng.randint(1, 200))] for _ in range(60)],
    "greetings of other versions": lambda rng: [
        *([greeting(version=bytes([v, rng.randrange(256)])), ready(), ASKED] for v in range(0, 256, 5)),
        *([start, *[b"\x02\x01x"] * 50_000] for start in VERSIONS_1_AND_2),
    ],
    "other mechanisms and roles": lambda rng: [
        *(
            [greeting(mechanism=mechanism, server=server), command(b"\x05HELLO" + rng.randbytes(194))]
            for mechanism, server in product((b"PLAIN", b"CURVE", b"GSSAPI", b"A" * 20, b"\xff" * 20), (0, 1))
        ),
        *([greeting(), ready(kind), part(b""), ASKED] for kind in ROLES),
    ],
    "properties without end": lambda rng: [
        *([greeting(), identity(length, rng), ASKED] for length in (0, 1, 255, 256, 2**31, 2**32 - 1)),
        [greeting(), command(b"\x05READY" + rng.randbytes(100_000))],
        [greeting(), b"\x06" + struct.pack(">Q", 2**40), *[bytes(60_000)] * 200],
    ],
    # With all that a PING may carry, and no PONG is read.
    "calls that nobody answers": lambda rng: [
        [*HELLO, *[ping(context, rng) * 200] * 60] for context in (b"", b"x" * 16, b"x" * 200)
    ],
    "commands of other sockets": lambda rng: [[*HELLO, named(name, rng) * 20] for name in COMMANDS],
    "commands without end": lambda rng: [[*HELLO, *[command(b"\x09SUBSCRIBE" + rng.randbytes(200)) * 100] * 400]],
    "messages of many parts": lambda rng: [
        [*HELLO, *[part(data, more=True) * 100] * 3000] for data in (b"", request(1), rng.randbytes(800))
    ],
    "requests that stop within": lambda rng: [[*HELLO, ASKED[: rng.randrange(len(ASKED))]] for _ in range(60)],
    "clients that leave without reading": lambda rng: [[*HELLO, part(request(1, size=(512, 512)))]] * 70,
    "clients that read a byte at a time": lambda rng: (
        [[*HELLO, *(part(request(number, size=(512, 512), received=number)) for number in range(1, 9))]] * 6
    ),
    "requests as fast as they go": lambda rng: [[*HELLO, *[part(request(n)) * 40 for n in range(1, 300)]]],
    "tokens and ids of all kinds": lambda rng: [[*HELLO, *(part(request(n, token=rng.randbytes(32))) for n in IDS)]],
}


def send(one: socket.socket, pieces: list[bytes]) -> None:
    """Send these, as far as the connection is open, and read what has come."""
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


def attack(name: str, connect: Callable[[], socket.socket], rng: random.Random) -> None:
    connections = ATTACKS[name](rng)
    with contextlib.ExitStack() as held:
        if "a byte" in name:
            readers = [(held.enter_context(connect()), pieces) for pieces in connections]
            for at, (one, pieces) in product(range(len(connections[0])), readers):
                with contextlib.suppress(OSError):
                    one.sendall(pieces[at])
                    one.recv(1)
            return
        for pieces in connections:
            with connect() as one:
                send(one, pieces)
                if "leave" in name:
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
                time.sleep(0.01)


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
                client.send(request(number))
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
        attack(name, connect, random.Random(7))
        served = honest.served
        while honest.served < served + 2:
            time.sleep(0.01)
            assert serving.process.poll() is None
    peak = memory(process, "VmHWM") - before
    print(
        f"{name}: {tried[0]} connections, {peak / MIB:+.0f} MiB, another client waited {honest.longest_s:.2f} s at most"
    )
    assert peak < 128 * MIB
