"""Peers that speak to a running server by hand: nothing ends it, stalls it or makes it grow."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import os
import random
import socket
import struct
import termios
import time
from collections import Counter
from collections.abc import Callable
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from serving import Serving

from hmdwarp.pipeline.feed_coding import FeedEncoder
from hmdwarp.run import ServeOptions, serve_run
from hmdwarp.sources.feed.listener import Asked
from hmdwarp.sources.feed.message import FrameMessage, decode
from hmdwarp.sources.server import Server

from . import foreign
from .exchange import port_of
from .foreign import command, greeting, part, ready, request

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

REQUESTS, SEED = int(os.environ.get("FEED_REQUESTS", "150")), int(os.environ.get("FEED_SEED", "34"))
CLIENTS = 3
MOST_TAKEN, MOST_CPU_S = 200 << 20, 2.0


def memory(process: int, what: str = "VmRSS") -> int:
    """Bytes that a process holds; VmHWM: and held at most."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(status.split(f"{what}:")[1].split()[0]) << 10


def cpu_s(process: int) -> float:
    """Seconds that a process has worked: work is bounded here, not time, which others take too."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def asked(client, data: bytes) -> tuple[str, int, str]:
    """Send a request; return its answer. The limit is a fail-safe."""
    client.send(data)
    assert client.poll(300_000), f"no answer to {data.hex()}"
    return foreign.answer(client.recv())


@pytest.fixture(scope="module")
def serving():
    with Serving() as one:
        yield one


@pytest.fixture
def clients(serving):
    with zmq.Context() as context:
        made = [context.socket(zmq.DEALER) for _ in range(CLIENTS)]
        for client in made:
            client.linger = 0
            client.connect(serving.address)
        yield made
        for client in made:
            client.close()


# Within the bounds of a message, and more than a server draws; those are in test_message.py.
TOO_MUCH = {
    "most peeled": {"layers": (("peeled", 2**32 - 1),)},
    "cube": {"layers": (("cube", 1),), "shown": (8192, 8192), "shown_angles": (-1e-4, 1e-4, -1e-4, 1e-4)},
    "overlay": {"layers": (("overlay", 1),), "shown": (8000, 8000)},
    "large": {"size": (8192, 8192)},
    "large videos": {"size": (2048, 2048), "eyes": (foreign.eye(),) * 2, "formats": (4, 2)},
    "large depth": {"size": (2304, 2304), "eyes": (foreign.eye(),) * 2, "formats": (255, 3)},
}


@pytest.mark.parametrize("wrong", TOO_MUCH.values(), ids=TOO_MUCH)
def test_a_request_that_no_server_should_draw_is_refused_and_others_notice_nothing(serving, clients, wrong):
    hostile, other, _ = clients
    asked(other, foreign.request(1))
    before, worked = memory(serving.process.pid), cpu_s(serving.process.pid)
    kind, _, text = asked(hostile, foreign.request(7, **wrong))
    assert kind == "refusal" and "expected" in text
    assert memory(serving.process.pid) - before < 8 << 20 and cpu_s(serving.process.pid) - worked < 1
    assert asked(other, foreign.request(2))[:2] == ("frame", 2)


def test_whatever_fails_while_drawing_is_refused_and_the_next_request_is_drawn(monkeypatch):
    """By a server of this process; each request is sent after the answer to the one before."""
    draw, calls, said, left, answers = Server.draw_frame, itertools.count(1), list[str](), [1, 2, 3], []
    monkeypatch.setattr(
        Server, "draw_frame", lambda *args, **options: draw(*args, **options) if next(calls) != 2 else {}["it"]
    )
    with zmq.Context() as context, context.socket(zmq.DEALER) as client:
        client.linger = 0

        def goes_on() -> bool:
            if said and not client.last_endpoint:
                client.connect(said[0].split()[2].rstrip(":"))
            elif client.last_endpoint and client.poll(0):
                answers.append(foreign.answer(client.recv()))
            if client.last_endpoint and left and len(answers) == 3 - len(left):
                client.send(foreign.request(left.pop(0)))
            return len(answers) < 3

        serve_run.serve(ServeOptions(scene="planes", listen="127.0.0.1:*"), said.append, goes_on)
    assert [answer[:2] for answer in answers] == [("frame", 1), ("refusal", 2), ("frame", 3)]
    assert all(words in answers[1][2] for words in ("internal error", "KeyError", "test_any_request.py"))
    assert any("refused: an internal error" in line for line in said)


@pytest.mark.parametrize("formats", [(255, 3), (3, 2), (4, 255)])
def test_encoders_of_all_clients_are_bounded_and_the_oldest_begins_anew(monkeypatch, formats):
    listener, size = SimpleNamespace(clients=range(5)), (64, 64)
    forgets = dict.fromkeys(("forget", "begin_anew"), lambda client: None)
    answers = serve_run._Answers(listener, SimpleNamespace(scene=SimpleNamespace(inputs=None), **forgets), None)
    ask = decode(foreign.request(1, size=size, formats=formats))
    colour, depth = np.full((*size, 4), 255, np.uint8), np.ones(size, np.float32)
    frame = FrameMessage(1, 0, 0, 0, 0, 0, ask.views, (colour,), (depth,))
    monkeypatch.setattr(serve_run, "_MOST_CODED_BYTES", 3 * FeedEncoder(ask).bytes)

    def place(client: int) -> int:
        return answers._coded(answers._session(Asked(client, ask, 0)), ask, frame).place

    def kept() -> list[int]:
        return [client for client, session in answers._sessions.items() if session.encoder is not None]

    assert [place(client) for client in range(5)] == [0] * 5 and kept() == [2, 3, 4]
    assert (place(2), place(0), place(3)) == (1, 0, 0)
    listener.clients = ()
    place(5)
    assert kept() == [5]


def test_whatever_people_are_said_to_do_is_drawn():
    """Also at the ends of what there is; too many inputs are refused, and other clients go on."""
    rng = random.Random(SEED)
    with Serving("--scene", "playroom", "--samples", "1") as serving, zmq.Context() as context:
        first, other = made = [context.socket(zmq.DEALER) for _ in range(2)]
        for client in made:
            client.linger = 0
            client.connect(serving.address)
        for number in range(1, 30):
            inputs = tuple(foreign.any_input(rng) for _ in range(rng.randint(0, 20)))
            instants = (rng.choice(foreign.INSTANTS), 0)
            kind, _, text = asked(first, foreign.request(number, inputs=inputs, instants=instants))
            assert kind == "frame", text
        kind, _, text = asked(first, foreign.request(40, inputs=(foreign.acted(name=b"cat"),)))
        assert kind == "refusal" and "unknown thing that reacts 'cat'" in text
        kind, number = "frame", 40
        while kind == "frame":  # each of an instant of its own
            number += 1
            many = tuple(foreign.acted(512 * number + k, 2, b"lamp") for k in range(512))
            kind, _, text = asked(first, foreign.request(number, inputs=many))
        assert kind == "refusal" and "inputs of a session" in text and 30 < number - 40 < 34
        assert asked(other, foreign.request(1))[:2] == ("frame", 1)
        for client in made:
            client.close()


def test_every_request_within_the_bounds_is_answered_and_none_costs_much(serving, clients, capsys):
    rng, found, worst = random.Random(SEED), Counter(), 0.0
    for client in clients:
        # Programs are compiled at the first use of each layer, once.
        asked(client, foreign.request(1, layers=tuple((name, 1) for name in foreign.SENT)))
    process = serving.process.pid
    before, most_taken = memory(process), 0
    for number in range(2, REQUESTS + 2):
        data = foreign.any_request(rng, number)
        Path(f"/proc/{process}/clear_refs").write_text("5")  # VmHWM is VmRSS again
        worked, held = cpu_s(process), memory(process)
        kind, answered, text = asked(rng.choice(clients), data)
        worst = max(worst, cpu_s(process) - worked)
        most_taken = max(most_taken, memory(process, "VmHWM") - held)
        assert answered == number and kind in {"frame", "refusal"} and "internal" not in text, (text, data.hex())
        found[kind] += 1
    grown = memory(process) - before
    if "FEED_REQUESTS" in os.environ:
        with capsys.disabled():
            print(f"\n{REQUESTS} requests, seed {SEED}: {dict(found)}; the worst took {worst:.2f} s of work")
            print(f"memory: {most_taken / 2**20:.0f} MiB for one at most, {grown / 2**20:.0f} MiB more in the end")
    assert found["frame"] > REQUESTS / 3
    # What is kept for the next frames: textures of some sizes, and encoders of the clients.
    assert most_taken < MOST_TAKEN and grown < MOST_TAKEN and worst < MOST_CPU_S and serving.process.poll() is None


RESET = struct.pack("ii", 1, 0)  # of SO_LINGER: what closes drops all that is not sent, and says so
VERSIONS_1_AND_2 = (b"\x01\x00", b"\xff" + bytes(7) + b"\x01\x7f\x01\x05\x00\x00")  # no handshake, an identity
ROLES = (b"PUB", b"SUB", b"REQ", b"ROUTER", b"PAIR", b"STREAM", b"X" * 200, b"")
COMMANDS = (b"SUBSCRIBE", b"CANCEL", b"ERROR", b"READY", b"PONG", b"JOIN", b"\xff" * 50)
MECHANISMS = (b"PLAIN", b"CURVE", b"GSSAPI", b"A" * 20, b"\xff" * 20)
IDS = (0, 1, 2**64 - 1, 2**63, *range(10**18, 2 * 10**18, 5 * 10**15))
ASKED, HELLO = part(request(1)), [greeting(), ready()]


def identity(length: int, noise: Callable[[int], bytes]) -> bytes:
    return ready(more=b"\x08Identity" + struct.pack(">I", length) + noise(min(length, 400)))


# What the connections of each attack send, one after the other. A message without an end, and
# clients that do not read, are in test_hostile.py.
ATTACKS: dict[str, Callable[[Callable[[int], bytes]], list[list[bytes]]]] = {
    "greetings of noise": lambda noise: [[noise(length)] for length in range(1, 200, 3)],
    "greetings of other versions": lambda noise: [
        *([greeting(version=bytes([v]) + noise(1)), ready(), ASKED] for v in range(0, 256, 5)),
        *([start, *[b"\x02\x01x"] * 50_000] for start in VERSIONS_1_AND_2),
    ],
    "other mechanisms and roles": lambda noise: [
        *(
            [greeting(mechanism=mechanism, server=server), command(b"\x05HELLO" + noise(194))]
            for mechanism, server in product(MECHANISMS, (0, 1))
        ),
        *([greeting(), ready(kind), part(b""), ASKED] for kind in ROLES),
    ],
    "properties without end": lambda noise: [
        *([greeting(), identity(length, noise), ASKED] for length in (0, 1, 255, 256, 2**31, 2**32 - 1)),
        [greeting(), command(b"\x05READY" + noise(100_000))],
        [greeting(), b"\x06" + struct.pack(">Q", 2**40), *[bytes(60_000)] * 200],
    ],
    # With all that a PING may carry, and no PONG is read.
    "calls that nobody answers": lambda noise: [
        [*HELLO, *[command(b"\x04PING" + noise(2) + b"x" * more) * 200] * 60] for more in (0, 16, 200)
    ],
    "commands of other sockets": lambda noise: [
        [*HELLO, command(bytes([len(name)]) + name + noise(100)) * 20] for name in COMMANDS
    ],
    "commands without end": lambda noise: [[*HELLO, *[command(b"\x09SUBSCRIBE" + noise(200)) * 100] * 400]],
    "requests cut short": lambda noise: [[*HELLO, ASKED[: noise(1)[0]]] for _ in range(60)],
    "clients that leave without reading": lambda noise: [[*HELLO, part(request(1, size=(512, 512)))]] * 70,
    "requests as fast as they go": lambda noise: [[*HELLO, *[part(request(n)) * 40 for n in range(1, 300)]]],
    "tokens and ids of all kinds": lambda noise: [[*HELLO, *(part(request(n, token=noise(32))) for n in IDS)]],
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


@pytest.mark.parametrize("name", ATTACKS)
def test_a_peer_that_speaks_by_hand_costs_nobody_anything(serving, clients, name):
    process, where = serving.process.pid, ("127.0.0.1", port_of(serving.address))
    asked(clients[0], request(1))
    Path(f"/proc/{process}/clear_refs").write_text("5")  # VmHWM is VmRSS again, not another attack's
    before = memory(process)
    for pieces in ATTACKS[name](random.Random(7).randbytes):
        with socket.create_connection(where, timeout=2) as one:  # what the server does not take is not sent
            send(one, pieces)
            if "leave" in name:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
            time.sleep(0.01)
    assert asked(clients[0], request(2))[:2] == ("frame", 2) and serving.process.poll() is None
    assert memory(process, "VmHWM") - before < 128 << 20
