"""A server that sends what it must not: the frame is left out and told, and the session goes on."""

from __future__ import annotations

import functools
import itertools
import signal
import struct
import threading
import zlib
from collections.abc import Callable
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.base import MachineError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.run import LiveOptions, live
from hmdwarp.sources.feed import caller
from hmdwarp.sources.feed.caller import Arrival, Caller
from hmdwarp.sources.feed.message import decode

from . import foreign

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

Odd = Callable[[bytes], bytes]
NAN, INF = struct.pack("<f", np.nan), struct.pack("<f", -np.inf)
BOMB = functools.cache(lambda: zlib.compress(bytes(8192 * 8192 * 8)))  # as zlib, a thousandth of that


def pixels(asked: bytes) -> int:
    width, height = struct.unpack_from("<2I", asked, 84)
    return width * height


def whole(asked: bytes, **more) -> bytes:
    """A frame with raw pictures of the requested size; depth: 4 bytes, colour: 8 bytes a pixel."""
    colour, depth = more.pop("colour", struct.pack("<4e", 1, 1, 1, 1)), more.pop("depth", struct.pack("<f", 0.1))
    return foreign.frame(asked, formats=(1, 1), pictures=(colour * pixels(asked), depth * pixels(asked)), **more)


def bomb(asked: bytes, name: str = "peeled") -> bytes:
    return foreign.frame(asked, heads=(foreign.part_head(name, (8192, 8192), len(BOMB())),), parts=BOMB())


def depth_of(step: float, nearest: float) -> bytes:
    """Depth as a video, as docs/feed.md has it, of which only the head is right."""
    rest = struct.pack("<ddI", step, nearest, 0)
    return struct.pack("<I", zlib.crc32(rest)) + rest


def coded(colour: int, depth: int, *pictures: bytes) -> Odd:
    return lambda asked: foreign.frame(asked, formats=(colour, depth), pictures=pictures)


# What is no frame, though it is a message; and some of what is none: test_message.py has the rest.
ODD: dict[str, Odd] = {
    "no field of view": lambda asked: foreign.frame(asked, eyes=(foreign.eye(angles=(np.nan,) * 4),) * 2),
    "one eye": lambda asked: foreign.frame(asked, eyes=(foreign.eye(),)),
    "depth that is no number": lambda asked: whole(asked, depth=NAN),
    "depth without an end": lambda asked: whole(asked, depth=INF),
    "light without an end": lambda asked: whole(asked, colour=struct.pack("<4e", 1, np.inf, 1, 1)),
    "light that is no number": lambda asked: whole(asked, colour=struct.pack("<4e", 1, 1, -np.nan, 1)),
    "another size": lambda asked: foreign.frame(asked, size=(3, 2)),
    "the largest size": lambda asked: foreign.frame(asked, size=(8192, 8192), formats=(3, 3), pictures=(b"", b"")),
    "an unknown format": lambda asked: foreign.frame(asked, formats=(9, 1)),
    "codes without a step": lambda asked: coded(2, 5, b"\x80" * 4 * pixels(asked), b"")(asked),
    "codes of no step": lambda asked: coded(2, 5, b"\x80" * 4 * pixels(asked), NAN + bytes(2 * pixels(asked)))(asked),
    "a video of noise": coded(3, 2, b"\0\0\0\1g" * 9, b"d" * 99),
    "a depth of noise": coded(4, 3, b"", depth_of(2.0**-30, 2.0**128)),
    "drawn for ever": lambda asked: foreign.frame(asked, drawing=2**63 - 1),
    "not requested": lambda asked: foreign.frame(asked, number=2**64 - 1),
    "a layer that is not requested": bomb,
    "a layer larger than requested": lambda asked: bomb(asked, "velocity"),
    "another kind": lambda asked: foreign.message(4, struct.pack("<QI64s", 1, 99, b"../../etc/passwd")),
    "a request": lambda asked: asked,
    "nothing": lambda asked: b"",
}


@contextmanager
def server(answers: Callable[[int, bytes], bytes | None]):
    """Answer the n-th request as that says; None for not at all."""
    done = threading.Event()
    with zmq.Context() as context, context.socket(zmq.ROUTER) as socket:
        socket.linger = 0
        port = socket.bind_to_random_port("tcp://127.0.0.1")

        def work() -> None:
            count = itertools.count()
            while not done.is_set():
                if socket.poll(20):
                    who, asked = socket.recv_multipart()
                    reply = answers(next(count), asked)
                    if reply is not None:
                        socket.send_multipart([who, reply])

        thread = threading.Thread(target=work)
        thread.start()
        try:
            yield f"127.0.0.1:{port}"
        finally:
            done.set()
            thread.join()


def options(address: str, out: Path, **more) -> LiveOptions:
    said = {"source": "offscreen", "trace": "look-around", "connect": address, "size": "32x40", "out": out}
    return LiveOptions.of({**said, "fill": "none", "lens": "none", "rate": 60.0, "panel": False, **more})


def test_odd_frames_are_left_out_and_told_and_the_session_goes_on(tmp_path, monkeypatch):
    """Each kind comes twice among whole frames, once the way is measured."""
    kinds, came = [*ODD.values()] * 2, []
    BOMB()  # not while a frame is waited for

    def answers(number: int, asked: bytes) -> bytes:
        layer = foreign.part_head("velocity", struct.unpack_from("<2I", asked, 84), 8 * pixels(asked), packed=0)
        heads = (layer, layer[:16] + b"\1" + layer[17:])
        plain = foreign.frame(asked, heads=heads, parts=bytes(16 * pixels(asked)))
        if number < 8 or number % 2 or not kinds:
            return plain
        came.append(decode(asked).number)
        return kinds.pop(0)(asked)

    newest, take, later = [0], Caller.take, itertools.count()

    def taking(caller: Caller) -> list[Arrival]:
        arrived = take(caller)
        newest.extend(one.frame.number for one in arrived)
        return arrived

    def ends(number: int) -> None:
        """Press Ctrl-C some pictures after a frame that came after all kinds."""
        if not kinds and newest[-1] > came[-1] and next(later) == 5:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Caller, "take", taking)
    said: list[str] = []
    with server(answers) as address:
        out = tmp_path / "out"
        summary = live(options(address, out, effects="soft_motion"), said.append, ends).summary
    feed = summary["link"]["feed"]
    assert summary["live"]["refreshes"] > len(came) == 2 * len(ODD)
    assert (out / "report.html").stat().st_size > 1000 and (out / "summary.json").exists()
    # Those with a head that can be read are told from each other; what is no message is counted.
    assert feed["malformed"] + feed["undecodable"] >= len(came) - 4
    assert feed["lost"] == sum("no frame for" in line for line in said)  # on a machine that stood still
    told = " ".join(line for line in said if "left out" in line)
    assert all(part in told for part in ("another size", "cannot be decoded", "left out: frame"))
    assert not feed["draws_others"]


@pytest.mark.parametrize("odd", ["another size", "a video of noise", "nothing"])
def test_a_run_whose_frames_are_all_left_out_ends(odd, tmp_path, monkeypatch):
    """They are whole as long as the way is measured; by Ctrl-C it ends without a picture, too."""
    monkeypatch.setattr("hmdwarp.run.live_run.PATIENCE_S", (10.0, 2.0 if odd != "nothing" else 60.0))

    def answers(number: int, asked: bytes) -> bytes:
        if odd == "nothing" and number == 9:
            signal.raise_signal(signal.SIGINT)
        return foreign.frame(asked) if number < 6 else ODD[odd](asked)

    said: list[str] = []
    with server(answers) as address, pytest.raises(MachineError, match="no frame that could be shown"):
        live(options(address, tmp_path / "out", seconds=5.0), said.append)
    assert not (tmp_path / "out").exists()
    left_out = [line for line in said if "left out" in line and not line.startswith("note: ")]
    assert len(left_out) <= 1 + (odd == "nothing")


def test_the_truth_of_a_server_is_whole_or_none(monkeypatch):
    monkeypatch.setattr(caller, "_AGAIN_NS", 100_000_000)
    for odd in ("light that is no number", "another size", "a video of noise"):
        with (
            server(lambda number, asked, odd=odd: foreign.frame(asked) if number else ODD[odd](asked)) as address,
            closing(caller.Viewer(address)) as client,
        ):
            found = client.fetch(View(Pose(), Fov.symmetric(1, 1)), (4, 3), 0)
        assert found is not None and found.is_finite and found.size == (4, 3)
        assert not isinstance(found.colours[0], bytes)
