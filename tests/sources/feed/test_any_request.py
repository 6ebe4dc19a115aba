"""Random requests that docs/feed.md allows, really drawn: each is answered and the server stays.

`make test-requests` sends 100,000 of them (REQUESTS=, SEED=) and prints what the worst cost.
"""

from __future__ import annotations

import os
import random
import time
from collections import Counter
from pathlib import Path

import pytest

from . import foreign
from .serving import Serving

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install 'hmdwarp[feed]'")

REQUESTS, SEED = int(os.environ.get("FEED_REQUESTS", "150")), int(os.environ.get("FEED_SEED", "34"))
CLIENTS = 3
MOST_GROWTH, MOST_CPU_S = 200 << 20, 2.0


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


@pytest.mark.parametrize(
    "wrong",
    [
        {"eyes": (foreign.eye((0, 1e19, 0)),)},
        {"eyes": (foreign.eye(angles=(-1e-300, 1e-300, -0.5, 0.5)),)},
        {"layers": (("peeled", 60_000_000),)},
        {"layers": (("peeled", 2**32 - 1),)},
        {"layers": (("cube", 1),), "shown": (8192, 8192), "shown_angles": (-1e-4, 1e-4, -1e-4, 1e-4)},
        {"layers": (("cube", 1),), "size": (700, 1), "eyes": (foreign.eye(angles=(-0.1, 0.1, -0.5, 0.5)),)},
        {"layers": (("overlay", 1),), "shown": (8000, 8000)},
        {"size": (8192, 8192)},
        {"instants": (2**63 - 1, 0)},
    ],
    ids=["far", "narrow", "peeled", "most peeled", "cube", "drawn cube", "overlay", "large", "late"],
)
def test_a_request_that_no_server_should_draw_is_refused_and_others_notice_nothing(serving, clients, wrong):
    hostile, other, _ = clients
    asked(other, foreign.request(1))
    before, worked = memory(serving.process.pid), cpu_s(serving.process.pid)
    kind, _, text = asked(hostile, foreign.request(7, **wrong))
    assert kind == "refusal" and "expected" in text
    assert memory(serving.process.pid) - before < 8 << 20 and cpu_s(serving.process.pid) - worked < 1
    assert asked(other, foreign.request(2))[:2] == ("frame", 2)


def test_every_request_within_the_bounds_is_answered_and_none_costs_much(serving, clients, capsys):
    rng, found, worst, longest_s = random.Random(SEED), Counter(), 0.0, 0.0
    for client in clients:
        # Programs are compiled at the first use of each layer, once.
        asked(client, foreign.request(1, layers=tuple((name, 1) for name in foreign.SENT)))
    process = serving.process.pid
    before = memory(process)
    for number in range(2, REQUESTS + 2):
        data = foreign.any_request(rng, number)
        begun, worked = time.monotonic(), cpu_s(process)
        kind, answered, text = asked(rng.choice(clients), data)
        longest_s, worst = max(longest_s, time.monotonic() - begun), max(worst, cpu_s(process) - worked)
        assert answered == number and kind in {"frame", "refusal"} and "internal" not in text, (text, data.hex())
        found[f"{kind} {text[:40]}".strip()] += 1
    grown, peak = memory(process) - before, memory(process, "VmHWM") - before
    if "FEED_REQUESTS" in os.environ:
        with capsys.disabled():
            print(f"\n{REQUESTS} requests, seed {SEED}: the worst took {worst:.2f} s of work, {longest_s:.2f} s in all")
            print(f"memory: grown by {grown / 2**20:.0f} MiB, at most by {peak / 2**20:.0f} MiB; answers: {found}")
    assert found["frame"] > REQUESTS / 3
    assert peak < MOST_GROWTH and worst < MOST_CPU_S and serving.process.poll() is None
