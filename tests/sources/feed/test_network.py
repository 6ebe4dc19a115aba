"""What a network does to the feed: each of it is told, taken up again, and bounded; and without a
key nobody can read it."""

import itertools
import os
import signal
import stat
import sys
import time
from contextlib import ExitStack, closing

import attrs
import numpy as np
import pytest
from serving import Serving

from hmdwarp.base import InputError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.headsets import load_headset
from hmdwarp.pipeline.remote import Remote, is_another_view
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.run import LiveOptions, live
from hmdwarp.sources.feed import FeedOptions, sockets
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import encode
from hmdwarp.sources.feed.options import key_pair, public_key

from .exchange import ASK, FRAME, answered, exchanged, feeder, port_of
from .relay import Relay

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")


@pytest.fixture
def relay(listener):
    with Relay(port_of(listener.address)) as made:
        yield made


@pytest.fixture
def caller(relay):
    made = Caller(relay.address)
    yield made
    made.close()


@pytest.mark.parametrize("jitter_s", [0.0, 0.04])
def test_a_delay_is_measured_and_none_of_it_is_taken_for_the_clock(relay, listener, caller, jitter_s):
    relay.delay_s, relay.jitter_s = 0.05, jitter_s
    arrival, _ = exchanged(caller, listener)
    for _ in range(5):
        arrival, _ = exchanged(caller, listener)
        # Both ways take the delay.
        assert arrival.heard_ns - arrival.frame.asked_ns >= 2 * 50_000_000
    # One machine has one clock.
    assert abs(caller.clock.offset_ns) <= caller.clock.round_trip_ns / 2
    assert caller.clock.jumps == 0 and caller.malformed == 0


def ask(caller, number: int) -> None:
    caller.ask(attrs.evolve(ASK, number=number, token=bytes(32)))


def large(number: int, width: int, height: int):
    """A frame of two eyes of that size."""
    colour, flat = np.ones((height, width, 4), np.float16), np.ones((height, width), np.float32)
    return attrs.evolve(FRAME, number=number, colours=(colour,) * 2, inverse_depths=(flat,) * 2)


def test_a_narrow_link_slows_frames_and_the_server_holds_no_more_than_it_may(relay, listener, caller):
    exchanged(caller, listener)
    relay.bytes_s, sent = 20e6, 0
    for number in range(10_000, 10_200):
        ask(caller, number)
        if (asked := listener.next(20)) is not None:
            # Larger than what the kernel holds for a connection; a few of them take seconds.
            sent += listener.answer(asked, large(number, 1024, 512))
    # 256 MiB or 64 frames that are not acknowledged are the most.
    assert 0 < sent <= 64 + 40
    relay.bytes_s = None
    exchanged(caller, listener)


_LATE = iter(range(20_000, 30_000))


def test_a_cut_link_is_taken_up_again(relay, listener, caller):
    """Also one that is down for a while, or cut within frames: nothing of them is left."""
    for _ in range(3):
        exchanged(caller, listener)
        relay.cut()
        exchanged(caller, listener)
    relay.is_down = True
    relay.cut()
    for number in range(5000, 5030):
        ask(caller, number)
        found = listener.next(5)
        # None, or one that had got through before the cut and was not read yet.
        assert found is None or not 5000 <= found.ask.number < 5030
    relay.is_down = False
    arrival, _ = exchanged(caller, listener)
    # Requests of the time without a link were not kept for later.
    assert not 5000 <= arrival.frame.number < 5029
    relay.delay_s = 0.002
    for _ in range(20):
        ask(caller, next(_LATE))
        answered(listener)
        relay.cut()
    relay.delay_s = 0.0
    exchanged(caller, listener)
    assert caller.malformed == 0 and caller.clock.jumps == 0


def silenced(relay, where: str) -> None:
    """Let the link fall silent, without an end."""
    for_good, ways = where.startswith("for good"), {"up", "down"} & set(where.split()) or {"up", "down"}
    relay.freezes_within = where == "within a frame"
    if for_good:
        relay.freeze(*ways)
    elif not relay.freezes_within:
        relay.silent = ways
    if where == "connecting":
        relay.cut()


# How long the link is silent, or a process stopped; `make test-silence` has other times, and prints
# when each was told and mended.
SECONDS = [float(text) for text in os.environ.get("FEED_SILENT_SECONDS", "1").split(",")]


def timed(what: str, seconds: float, told_s: float, mended_s: float) -> None:
    """Print a row, to stderr past pytest's capture, where a longer run was asked for."""
    if "FEED_SILENT_SECONDS" in os.environ:
        print(f"\n| {what} for {seconds:g} s | {told_s:.1f} s | {mended_s:.1f} s |", file=sys.__stderr__)


def steps(remote: Remote, size: tuple[int, int], lives=lambda: True):
    """Yield how many frames came at each of a client's refreshes, while the other end lives."""
    asked = (PoseSample(0, Pose(), Origin.MEASURED), load_headset("flat-90").views(Pose()), 1.0, size)
    for number in itertools.count(1):
        assert lives(), "the other end has ended"
        remote.ask(*asked, number * 16_000_000)
        yield len(remote.arrived(number * 16_000_000))
        time.sleep(0.005)


WHERE = ["up", "down", "connecting", "within a frame", "for good", "for good up", "a stopped server"]


@pytest.mark.parametrize("seconds", SECONDS)
@pytest.mark.parametrize("where", WHERE)
def test_a_link_that_falls_silent_is_told_and_taken_up_again(monkeypatch, where, seconds):
    """One that is silent for good stays so: the client makes a new connection."""
    # The server's limit, which is all that ends a connection of which only the way up is lost.
    monkeypatch.setattr(sockets, "SILENT_NS", 3_000_000_000)
    lines: list[str] = []
    with ExitStack() as stack:
        stopped = stack.enter_context(Serving()) if where == "a stopped server" else None
        address = stopped.address if stopped else stack.enter_context(feeder())
        relay = stack.enter_context(Relay(port_of(address)))
        remote = stack.enter_context(closing(Remote(FeedOptions(connect=relay.address), holds=False, say=lines.append)))
        came = steps(remote, (96, 80), lambda: stopped is None or stopped.process.poll() is None)
        while not next(came):
            pass
        begun, connections, lasts = time.monotonic(), relay.accepted, seconds
        lines.clear()
        if stopped:
            stopped.process.send_signal(signal.SIGSTOP)
        else:
            silenced(relay, where)
            lasts = seconds if relay.silent else 0
        told = ("not a byte", "the last one stays") if stopped else ("the last one stays",)
        while not all(text in "".join(lines) for text in told):
            next(came)
        told_s = time.monotonic() - begun
        while time.monotonic() - begun < lasts:
            next(came)
        relay.silent, begun = set(), begun if "for good" in where else time.monotonic()
        if stopped:
            stopped.process.send_signal(signal.SIGCONT)
        while not next(came) or remote.notice:
            pass
        timed(where, lasts, told_s, time.monotonic() - begun)
        if where not in ("up", "down", "a stopped server"):
            assert relay.accepted > connections
        assert remote.summary()["malformed"] == 0 and any("frames come again" in line for line in lines)
        # However long it takes, it is said once.
        assert sum("not a byte" in line for line in lines) <= 1
        assert stopped is None or stopped.process.poll() is None


def test_a_long_frame_over_a_narrow_link_is_no_silence(relay, listener, caller):
    """The library's own heartbeats would hear nothing until the whole frame is there."""
    exchanged(caller, listener)
    relay.bytes_s, connections = 2e6, relay.accepted
    ask(caller, 5000)
    while (asked := listener.next(100)) is None or asked.ask.number < 5000:
        pass
    assert listener.answer(asked, large(5000, 512, 512))
    arrived = []
    while not arrived:
        caller.wait_until(time.monotonic_ns() + 10_000_000)
        arrived = [one for one in caller.take() if one.frame.number == 5000]
    assert relay.accepted == connections and not caller.lines()


def test_a_client_that_asks_for_nothing_for_a_while_misses_nothing(relay, listener):
    """As while a pipeline is built, at the start and after a change."""
    lines: list[str] = []
    remote = Remote(FeedOptions(connect=relay.address), holds=False, say=lines.append)
    time.sleep(2.1)
    remote.ask(PoseSample(0, Pose(), Origin.MEASURED), load_headset("flat-90").views(Pose()), 1.0, (4, 3), 0)
    remote.arrived(0)
    assert not remote.notice and not lines and remote.summary()["lost"] == 0
    remote.close()


@pytest.fixture
def pair(tmp_path):
    made, is_new = key_pair(tmp_path / "mine")
    assert is_new
    return made


def test_a_pair_is_made_once_and_its_secret_is_this_users_alone(pair, tmp_path):
    again, is_new = key_pair(tmp_path / "mine")
    assert again == pair and not is_new
    assert public_key(tmp_path / "mine.key") == pair.public
    assert stat.S_IMODE((tmp_path / "mine.key_secret").stat().st_mode) == 0o600
    assert pair.secret not in (tmp_path / "mine.key").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.key", "mine.key_secret"]


@pytest.mark.parametrize("text", ["", 'curve\n    public-key = "short"\n', "\x00\xff"])
def test_files_without_keys_are_named(tmp_path, text):
    bad = tmp_path / "bad.key"
    bad.write_text(text)
    (tmp_path / "bad.key_secret").write_text(text)
    for read in (lambda: public_key(bad), lambda: key_pair(tmp_path / "bad"), lambda: public_key(tmp_path)):
        with pytest.raises(InputError, match="hmdwarp serve --key-pair"):
            read()


@pytest.mark.parametrize("encrypted", [True, False])
def test_network_traffic_is_plain_only_without_keys(pair, encrypted):
    used = pair if encrypted else None
    server_key = used.public if used else b""
    with closing(Listener("127.0.0.1:*", pair=used)) as listener, Relay(port_of(listener.address)) as relay:
        relay.seen = bytearray()
        with closing(Caller(relay.address, server_key=server_key)) as caller:
            # A request and a frame, both ways.
            arrival, _ = exchanged(caller, listener)
    assert arrival.frame.colours[0].tobytes() == FRAME.colours[0].tobytes()
    pictures, magic = FRAME.colours[0].tobytes(), encode(ASK)[:4]
    plain = pictures in relay.seen and magic in relay.seen
    assert relay.seen and plain != encrypted
    if encrypted:
        assert pictures not in relay.seen and magic not in relay.seen and pair.public not in relay.seen


@pytest.mark.parametrize("key", ["another server's", "none"])
def test_a_client_without_the_key_gets_no_frame_but_a_reason(pair, tmp_path, key):
    other = key_pair(tmp_path / "other")[0].public if key != "none" else b""
    lines: list[str] = []
    listener = Listener("127.0.0.1:*", pair=pair)
    with closing(listener), closing(Caller(listener.address, server_key=other)) as caller:
        while not lines:
            caller.ask(attrs.evolve(ASK, token=bytes(32)))
            assert listener.next(10) is None
            lines = caller.lines()
            time.sleep(0.01)
        assert caller.take() == []
    assert "no handshake" in lines[0] and "--server-key" in lines[0]


def test_serve_and_live_speak_encrypted(tmp_path):
    name = tmp_path / "mine"
    with Serving("--listen", "0.0.0.0:*", "--key-pair", str(name)) as one:
        there = "127.0.0.1:" + one.address.rpartition(":")[2]
        said = {"source": "offscreen", "trace": "look-around", "connect": there, "panel": False, "pictures": 3}
        done = live(LiveOptions.of({**said, "server_key": tmp_path / "mine.key", "size": "96x80"}))
        assert done.summary["live"]["refreshes"] == 3
        with pytest.raises(InputError, match="no handshake"):
            live(LiveOptions.of({**said, "size": "96x80"}))


def test_an_address_beyond_this_machine_needs_keys_a_secret_or_consent(pair):
    for allowed in ({"pair": pair}, {"secret": "secret"}, {"is_open": True}):
        Listener("0.0.0.0:*", **allowed).close()
    with pytest.raises(InputError, match="--key-pair NAME or --token-file FILE, or --open"):
        Listener("0.0.0.0:*")


@pytest.mark.parametrize(
    ("moved_m", "turned_deg", "grown", "is_other"),
    [(0, 0, 0, False), (1e-7, 1e-5, 1e-8, False), (0, 0, 0.1, False), (0, 0, -1e-5, True), (1e-4, 0, 0, True)]
    + [(0, 0.01, 0, True)],
)
def test_another_view_is_told_from_rounding_and_from_one_that_shows_more(moved_m, turned_deg, grown, is_other):
    asked = View(Pose((1, 2, 3)), Fov(-0.6, 0.7, -0.5, 0.8))
    for wider in np.eye(4) * (-grown, grown, -grown, grown):
        turn = np.radians(turned_deg) / 2
        pose = asked.pose @ Pose((0, moved_m, 0), (0, np.sin(turn), 0, np.cos(turn)))
        assert is_another_view(asked, View(pose, Fov.from_tangents(asked.fov.tangents + wider))) == is_other
