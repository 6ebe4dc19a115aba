"""Frames by shared memory: the same frames, nothing left behind, and no harm from what is none."""

import errno
import os
import random
import time
from contextlib import closing
from pathlib import Path

import attrs
import numpy as np
import pytest
from serving import Serving

from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.key_pairs import key_pair
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import FrameMessage, Malformed, Stub, decode, encode
from hmdwarp.sources.feed.shared_frames import IS_ABLE, SHARED, FrameReader, SharedFrames

from .exchange import WHENEVER_MS, answered, exchanged, in_step, next_of
from .test_message import ASK, FRAME, LAYERED

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")
pytestmark = pytest.mark.skipif(not IS_ABLE, reason="there is no /dev/shm to write to")

NAME = "hmdwarp-0123456789abcdef-1"


@pytest.fixture
def names(monkeypatch):
    """The segments that callers of this process have read."""
    found: list[str] = []
    read = FrameReader.read

    def noted(reader: FrameReader, stub: Stub) -> memoryview:
        found.append(stub.name)
        return read(reader, stub)

    monkeypatch.setattr(FrameReader, "read", noted)
    return found


@pytest.fixture
def address(tmp_path):
    return f"ipc://{tmp_path}/frames"


def left(names: list[str]) -> list[str]:
    """What there is of the segments, and of the locks of who made them."""
    files = {*names, *(name.rpartition("-")[0] for name in names)}
    return sorted(name for name in files if (SHARED / name).exists())


def test_frames_are_the_same_and_few_segments_hold_them(address, names):
    with closing(Listener(address)) as listener, closing(Caller(address)) as caller:
        exchanged(caller, listener)
        in_step(caller, listener)  # and what was asked for more than once is over
        names.clear()
        for _ in range(50):
            arrival = in_step(caller, listener)
        for ours, theirs in zip(FRAME.colours, arrival.frame.colours, strict=True):
            np.testing.assert_array_equal(ours, theirs)
        assert len(names) == 50 and len(set(names)) <= 4
        assert left(names)
        assert caller.malformed == 0 and caller.lines() == []
    assert left(names) == []


def test_only_this_user_reads_them(address, names):
    with closing(Listener(address)) as listener, closing(Caller(address)) as caller:
        exchanged(caller, listener)
        assert [(SHARED / name).stat().st_mode & 0o777 for name in left(names)] == [0o600] * 2


def test_a_frame_is_written_as_it_would_be_sent():
    turned = attrs.evolve(LAYERED, colours=tuple(colour[::-1, ::-1] for colour in FRAME.colours))
    with closing(SharedFrames()) as frames:
        for number, frame in enumerate((FRAME, LAYERED, turned), 1):
            asked = attrs.evolve(frame, number=number)
            assert FrameReader().read(frames.put(b"client", asked)) == encode(asked)


def test_a_frame_that_is_held_stays_and_its_memory_serves_again_after():
    reader, rng = FrameReader(), np.random.default_rng(1)

    def read_of(number: int) -> tuple[FrameMessage, FrameMessage]:
        # At first of another size each time, smaller ones after larger ones too.
        rows = 64 - number % 5 if number < 20 else 60
        cut = tuple(rng.random((rows, 300, 4), np.float32).astype(np.float16) for _ in FRAME.colours)
        depths = tuple(rng.random(one.shape[:2], np.float32) for one in cut)
        sent = attrs.evolve(FRAME, number=number, colours=cut, inverse_depths=depths)
        found = decode(reader.read(frames.put(b"client", sent)))
        frames.received(b"client", number)
        return sent, found

    with closing(SharedFrames()) as frames:
        held = [read_of(number) for number in range(1, 4)]
        places = set()
        for number in range(4, 40):
            held.append(read_of(number))
            for sent, found in held:
                assert encode(found) == encode(sent)
            if number >= 25:  # by when none is of an earlier size
                places.add(held[-1][1].colours[0].__array_interface__["data"][0])
            held.pop(number % 3)
        assert len(places) <= 6  # three that are held, two that are free, and the one that comes


def test_segments_stay_until_their_frame_has_arrived_and_then_few():
    with closing(SharedFrames()) as frames:
        stubs = [frames.put(b"client", attrs.evolve(FRAME, number=number)) for number in range(1, 21)]
        assert len({stub.name for stub in stubs}) == 20
        for stub in stubs:
            assert decode(FrameReader().read(stub)).number == stub.number
        frames.received(b"client", 18)
        assert [stub.number for stub in stubs if (SHARED / stub.name).exists()] == [1, 2, 3, 19, 20]
        other = frames.put(b"other", FRAME)
        frames.forget(b"client")
        assert left([stub.name for stub in stubs]) == left([other.name])[:1]
    assert left([other.name]) == []


def test_a_smaller_size_gives_the_memory_back():
    large = attrs.evolve(
        FRAME, colours=(np.zeros((512, 512, 4), np.uint8),) * 2, inverse_depths=(np.zeros((512, 512), np.float32),) * 2
    )
    with closing(SharedFrames()) as frames:
        names = []
        for number, frame in enumerate((*(large,) * 10, *(FRAME,) * 10), 1):
            names.append(frames.put(b"client", attrs.evolve(frame, number=number)).name)
            frames.received(b"client", number)
        assert len(set(names)) == 2 and len(left(names)) == 3


@pytest.mark.parametrize("way", ["tcp", "key pair", "not wished"])
def test_it_is_for_one_machine_without_encryption_and_if_wished(address, names, tmp_path, way):
    pair = key_pair(tmp_path / "feed")[0] if way == "key pair" else None
    where = "127.0.0.1:*" if way == "tcp" else address
    with closing(Listener(where, pair=pair)) as listener:
        server_key = pair.public if pair is not None else b""
        with closing(Caller(listener.address, server_key=server_key, shares=way != "not wished")) as caller:
            exchanged(caller, listener)
    assert names == []


def test_frames_go_by_the_socket_without_room_in_memory(address, names, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    with closing(Listener(address)) as listener, closing(Caller(address)) as caller:
        arrival, _ = exchanged(caller, listener)
    np.testing.assert_array_equal(arrival.frame.colours[0], FRAME.colours[0])
    assert names == []


def test_a_server_that_was_killed_is_cleaned_up_after_by_the_next(address, names, tmp_path):
    with Serving("--listen", address) as serving, closing(Caller(address)) as caller:
        while not caller.take():
            caller.ask(attrs.evolve(ASK, number=time.monotonic_ns(), token=bytes(32)))
            caller.wait_until(time.monotonic_ns() + 50_000_000)
        # Once it is killed the next of any test may clean up.
        assert len(left(names)) >= 2
        serving.process.kill()
        serving.process.wait()
        with closing(SharedFrames()) as living:
            stub = living.put(b"client", FRAME)
            with closing(Listener(f"ipc://{tmp_path}/others")):
                assert left(names) == []
                # One that lives keeps its own.
                assert FrameReader().read(stub) == encode(FRAME)


def test_a_server_that_ends_leaves_nothing(address, names):
    with Serving("--listen", address), closing(Caller(address)) as caller:
        while not caller.take():
            caller.ask(attrs.evolve(ASK, number=time.monotonic_ns(), token=bytes(32)))
            caller.wait_until(time.monotonic_ns() + 50_000_000)
        assert left(names)
    assert left(names) == []


class Hostile:
    """A server that answers requests with whatever it likes."""

    def __init__(self, address: str) -> None:
        self._context = zmq.Context()
        self._socket = self._context.socket(zmq.ROUTER)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.bind(address)
        self.address = self._socket.getsockopt_string(zmq.LAST_ENDPOINT)

    def answer(self, caller: Caller, make) -> bool:
        """Answer the next request by make(ask); return whether shared memory was wished."""
        while not self._socket.poll(10):
            caller.ask(attrs.evolve(ASK, number=time.monotonic_ns()))
        who, data = self._socket.recv_multipart()
        ask = decode(data)
        self._socket.send_multipart([who, encode(make(ask))])
        return ask.shares

    def close(self) -> None:
        self._socket.close(0)
        self._context.term()


@pytest.fixture
def owner():
    """The name of an owner that lives: a server that begins elsewhere leaves its segments alone."""
    with closing(SharedFrames()) as frames:
        yield frames.put(b"client", FRAME).name.rpartition("-")[0]


def bad_files(tmp_path: Path, owner: str) -> dict[str, Stub]:
    """Segments that are none, each with what names it."""
    whole, noise = encode(attrs.evolve(FRAME, number=5)), random.Random(1).randbytes(1000)
    contents = {"short": whole[:-1], "cut inside": whole, "noise": noise, "another frame": whole}
    stubs = {}
    for number, (what, data) in enumerate(contents.items(), 100):
        (SHARED / f"{owner}-{number}").write_bytes(data)
        stubs[what] = Stub(5, len(data), f"{owner}-{number}")
    (SHARED / f"{owner}-108").symlink_to(SHARED / stubs["noise"].name)
    os.mkfifo(SHARED / f"{owner}-109")
    (tmp_path / "mine").write_bytes(whole)
    stubs["short"] = attrs.evolve(stubs["short"], length=len(whole))
    stubs["another frame"] = attrs.evolve(stubs["another frame"], number=6)
    stubs["cut inside"] = attrs.evolve(stubs["cut inside"], length=len(whole) - 8)
    return stubs | {
        "a link": Stub(5, 1000, f"{owner}-108"),
        "a pipe": Stub(5, 1000, f"{owner}-109"),
        "not there": Stub(5, 1000, f"{owner}-110"),
        "too long": Stub(5, 1 << 29, stubs["noise"].name),
        "a path": Stub(5, len(whole), os.path.relpath(tmp_path / "mine", SHARED)[:64]),
        "the root": Stub(5, len(whole), str(tmp_path / "mine")[:64]),
        "a lock": Stub(5, 100, owner),
        "no name": Stub(5, 100, ""),
        "a directory": Stub(5, 100, "."),
    }


def test_hostile_names_and_segments_are_left_out_and_the_next_frame_is_taken(address, tmp_path, owner):
    stubs = bad_files(tmp_path, owner)
    try:
        with closing(Hostile(address)) as server, closing(Caller(address)) as caller:
            for stub in stubs.values():
                server.answer(caller, lambda ask, stub=stub: stub)
                server.answer(caller, lambda ask: attrs.evolve(FRAME, number=7, asked_ns=ask.sent_ns))
            seen = 0
            while seen < len(stubs):
                seen += len(next_of(caller))
            assert caller.malformed == len(stubs) - 2  # a link and what is not there
    finally:
        for stub in stubs.values():
            if stub.name.startswith(f"{owner}-"):
                (SHARED / stub.name).unlink(missing_ok=True)


def test_a_client_that_cannot_open_them_asks_for_frames_by_the_socket(address):
    """As in a container with a /dev/shm of its own."""
    with closing(Hostile(address)) as server, closing(Caller(address)) as caller:
        asked = 0
        while server.answer(caller, lambda ask: Stub(1, 1000, NAME)):
            asked += 1
        assert asked >= 3
        server.answer(caller, lambda ask: attrs.evolve(FRAME, number=7, asked_ns=ask.sent_ns))
        assert [arrival.frame.number for arrival in next_of(caller)] == [7]
        assert any("frames come by the socket" in line for line in caller.lines())


def test_an_unrequested_stub_opens_nothing(names):
    with closing(Hostile("tcp://127.0.0.1:*")) as server, closing(Caller(server.address)) as caller:
        server.answer(caller, lambda ask: Stub(1, 1000, NAME))
        server.answer(caller, lambda ask: attrs.evolve(FRAME, number=7, asked_ns=ask.sent_ns))
        next_of(caller)
        assert caller.malformed == 1 and names == []


def test_a_segment_that_is_cut_while_it_is_read_is_a_short_read(tmp_path, monkeypatch):
    with closing(SharedFrames()) as frames:
        stub, found = frames.put(b"client", FRAME), os.fstat

        def shrinks(descriptor: int) -> os.stat_result:
            told = found(descriptor)
            os.truncate(SHARED / stub.name, 100)
            return told

        with monkeypatch.context() as patched, pytest.raises(Malformed, match="ends at 100"):
            patched.setattr(os, "fstat", shrinks)
            FrameReader().read(stub)


def test_segments_go_with_their_client(address, names):
    with closing(Listener(address)) as listener:
        with closing(Caller(address)) as caller:
            exchanged(caller, listener)
        while len(left(names)) > 1:  # the lock, which is the server's
            listener.next(1)


def test_a_client_that_takes_nothing_costs_no_more_than_it_may_lag(address):
    """And what it had is gone with it."""
    with closing(Listener(address)) as listener:
        context = zmq.Context()
        with context.socket(zmq.DEALER) as slow:
            slow.setsockopt(zmq.LINGER, 0)
            slow.connect(address)
            sent = 0
            for number in range(1, 100):
                slow.send(encode(attrs.evolve(ASK, number=number, received=0, token=bytes(32), shares=True)))
                if not answered(listener, WHENEVER_MS):  # as soon as it is there and has to wait
                    break
                sent += 1
            assert 0 < sent <= 64
            stub = decode(slow.recv())
            assert isinstance(stub, Stub)
            owner = stub.name.rpartition("-")[0]
            assert len(list(SHARED.glob(f"{owner}-*"))) == sent
        context.term()
    assert list(SHARED.glob(f"{owner}*")) == []
