"""One client's requests and a server's answers, by hand: what is told, when, by which clock."""

import time
from contextlib import closing
from types import SimpleNamespace

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from serving import Serving

from hmdwarp.frames import Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset
from hmdwarp.pipeline.remote import Remote
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.scenes import InputEvent
from hmdwarp.sources.feed import FeedOptions, caller
from hmdwarp.sources.feed import listener as listening
from hmdwarp.sources.feed.caller import MOST_DRIFT, Alignment, Caller, Exchange
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import Fate, encode
from hmdwarp.sources.feed.message import Session as Told

from .exchange import ASK, FRAME, WHENEVER_MS, answered, exchanged

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")


def next_asked(listener):
    """Return the next request; the limit is a fail-safe."""
    for _ in range(600):
        asked = listener.next(200)
        if asked is not None:
            return asked
    raise AssertionError("no request came")


def test_a_request_that_comes_again_is_left_out():
    lines = []
    with closing(Listener("127.0.0.1:*", say=lines.append)) as listener, closing(Caller(listener.address)) as caller:
        exchanged(caller, listener)
        for number in (10**9, 10**9, 10**9 - 1, 10**9 + 1):
            caller.ask(attrs.evolve(ASK, number=number, token=bytes(32)))
        # They come in order, so all before the last one have been read by then.
        while next_asked(listener).ask.number <= 10**9:
            pass
    assert [line.partition("request ")[2] for line in lines if "left out" in line] == [
        f"{number} after {10**9}" for number in (10**9, 10**9 - 1)
    ]


class Session:
    """A client's session and the server's end of it: what one asks, and answers by hand."""

    def __init__(self) -> None:
        self.listener, self._asked = Listener("127.0.0.1:*"), 0
        self.remote = Remote(FeedOptions(connect=self.listener.address), holds=False)
        self.eyes, self.head = load_headset("flat-90"), PoseSample(0, Pose(), Origin.MEASURED)

    def ask(self, now_ns, needs=None):
        self.remote.ask(self.head, self.eyes.views(self.head.pose), 1.0, (4, 3), now_ns, needs)
        self._asked += 1

    def asked(self, now_ns, needs=None):
        """Ask; return the request as it arrived, once the ones before it have."""
        self.ask(now_ns, needs)
        while (found := next_asked(self.listener)).ask.number < self._asked:
            pass
        return found

    def answer(self, asked, *, shown=True, **says):
        says = {"takes_inputs": True, "takes_session": True, **says}
        self.listener.answer(asked, attrs.evolve(FRAME, number=asked.ask.number, **says))
        while not (found := self.remote.arrived(0)) and (shown or asked.ask.number in self.remote._pending):
            pass
        return found[-1] if shown else None

    def first(self):
        """Ask until the connection is there; return what was asked."""
        found = None
        while found is None:
            self.ask(0)
            found = self.listener.next(200)
        return found

    def begin(self) -> None:
        """Answer one request, so that the client knows what it may tell."""
        self.answer(self.first())

    def close(self) -> None:
        self.remote.close()
        self.listener.close()


def test_a_frame_that_missed_its_refresh_is_counted_as_later_than_it():
    """A refresh was shown without it, so an offline replay of its delay must not show it there."""
    with closing(Session()) as session:
        asked = session.first()
        assert session.remote.arrived(5_000_000_000) == []
        session.listener.answer(asked, attrs.evolve(FRAME, number=asked.ask.number, sent_ns=FRAME.received_ns))
        while not (found := session.remote.arrived(6_000_000_000)):
            pass
    assert found[0].took_ns > 5_000_000_000


def test_what_people_did_is_told_until_the_server_has_it():
    events = [InputEvent(at, "push", "ball") for at in (100, 200, 300)]
    with closing(Session()) as session:
        session.begin()
        session.remote.act(events)
        told = [session.asked(at) for at in (199, 200, 250, 300)]
        # With that of the very instant; what was not answered is told again.
        assert [list(one.ask.inputs) for one in told] == [events[:1], events[:2], events[:2], events]
        session.answer(told[2])
        last = session.asked(400)
        assert list(last.ask.inputs) == events[2:]
        session.answer(last)
        after = session.asked(500)
        assert after.ask.inputs == ()
        session.answer(after, began=7, shown=False)  # another server in its place, which knows nothing
        session.answer(last := session.asked(600), began=7)
        assert list(last.ask.inputs) == events


def test_inputs_to_a_scene_that_does_not_react_are_said_and_frames_go_on():
    """Once a session, by the server, whose frames say that it takes none."""
    events, found, number = tuple(InputEvent(at, "push", "ball") for at in (1, 2)), [], 1
    with Serving() as serving, closing(Caller(serving.address)) as client:
        while len(found) < 2:
            client.ask(attrs.evolve(ASK, number=number, token=bytes(32), inputs=events, session=Told(1)))
            client.wait_until(time.monotonic_ns() + 200_000_000)
            found, number = found + client.take(), number + 1
        assert not any(arrival.frame.takes_inputs for arrival in found)
        assert "its inputs are left out: planes does not react" in serving.line("inputs are left out")


def test_a_fate_is_told_from_when_it_is_heard_until_a_request_that_told_it_is_answered():
    needs = Needs(irradiance=layers.get("irradiance").something)

    def told(asked):
        return asked.ask.session.fates

    with closing(Session()) as session:
        session.begin()
        of = session.answer(session.asked(500, needs))
        fate = Fate(of.ask.number, True, 1000)
        session.remote.tell(of, arrived=True, heard_ns=1000)
        before, first, second = (session.asked(at, needs) for at in (999, 1000, 1001))
        assert [told(one) for one in (before, first, second)] == [(), (fate,), (fate,)]
        session.answer(before)  # it was not in there
        third = session.asked(1100, needs)
        assert told(third) == (fate,)
        session.answer(second)
        # The first will have no answer: its frame is lost, which is known at once.
        lost = Fate(first.ask.number, False, 1000)
        assert told(session.asked(1200, needs)) == (lost,)


@pytest.mark.parametrize("room", [1, 3])
def test_frames_that_were_taken_no_longer_count_as_held(monkeypatch, room):
    """Two frames that fit are both there, however many were taken before."""
    with closing(Listener("127.0.0.1:*")) as listener, closing(Caller(listener.address)) as client:
        exchanged(client, listener)
        monkeypatch.setattr(caller, "_MOST_HELD", room * FRAME.bytes)
        for first in range(1_000_000, 1_000_010, 2):
            for number in (first, first + 1):
                client.ask(attrs.evolve(ASK, number=number, token=bytes(32)))
                while not answered(listener):
                    pass
            while client._newest < first + 1:  # both have come
                client.wait_until(time.monotonic_ns() + 1_000_000)
            there = [arrival.frame.number for arrival in client.take()]
            assert there[-2 if room == 3 else -1 :] == [first, first + 1][-2 if room == 3 else -1 :]
            assert (first in there) == (room == 3)


def test_clients_share_the_time_of_a_server_so_that_cheap_requests_have_more_turns(monkeypatch):
    """By a clock of its own: a frame takes 10 ms, or 60."""
    clock = [0]
    monkeypatch.setattr(listening, "time", SimpleNamespace(monotonic_ns=lambda: clock[0]))
    with closing(Listener("127.0.0.1:*")) as listener, zmq.Context() as context:
        sockets = [context.socket(zmq.DEALER) for _ in range(5)]
        for socket in sockets:
            socket.setsockopt(zmq.LINGER, 0)
            socket.connect(listener.address)
        number, turns, silent = dict.fromkeys(range(5), 0), [], None

        def ask(which):
            number[which] += 1
            # Each has a size of its own, by which it is known here.
            request = attrs.evolve(ASK, number=number[which], size=(4 + which, 3), received=0, token=bytes(32))
            sockets[which].send(encode(request))

        def turn():
            which = next_asked(listener).ask.size[0] - 4
            clock[0] += 10_000_000 if which == 4 else 60_000_000
            turns.append(which)
            if which != silent:
                ask(which)
                assert listener._socket.poll(WHENEVER_MS)  # it is there in time

        for which in number:
            ask(which)
        while {*turns} != {*number}:  # until the connection of each is there
            turn()
        turns.clear()
        for _ in range(24):
            turn()
        # Six for one of each other in turn: 14 or 15 of 24; of five if turns only went round.
        assert 12 <= turns.count(4) <= 16 and {*turns} == {*number}
        silent = 0
        for _ in range(48):
            turn()
        silent = None
        ask(0)
        while turns[-1] != 0:
            turn()
        for _ in range(10):
            turn()
        assert turns[-10:].count(0) <= 2  # silence has saved it no turns
        for socket in sockets:
            socket.close()


MS = 1_000_000


def exchange(at: int, there: int, back: int, offset: float, drift: float = 0.0, work: int = MS) -> Exchange:
    def theirs(time_ns: int) -> int:
        return round(time_ns + offset + drift * time_ns)

    arrived = at + there
    return Exchange(at, theirs(arrived), theirs(arrived + work), arrived + work + back)


WAYS = st.lists(st.tuples(st.integers(0, 300 * MS), st.integers(0, 300 * MS)), min_size=1, max_size=60)


@given(WAYS, st.integers(-(10**15), 10**15))
def test_the_offset_is_within_half_the_shortest_round_trip(ways, offset):
    """And a drift is told only where there could be none so large that round trips feign."""
    found = Alignment()
    for number, (there, back) in enumerate(ways):
        assert not found.add(exchange(number * 16 * MS, there, back, offset))
    shortest = min(there + back for there, back in ways)
    # Rounding to ns.
    assert abs(found.offset_ns - offset) <= shortest / 2 + 1 and found.round_trip_ns == shortest
    assert found.drift is None or abs(found.drift) <= MOST_DRIFT


@given(st.floats(-2e-4, 2e-4))
def test_a_drift_is_found(drift):
    found = Alignment()
    for number in range(200):
        assert not found.add(exchange(number * 100 * MS, MS, MS, 10**12, drift))
    # Both ways take the same, so only rounding to 1 ns is left, over seconds.
    assert abs(found.drift - drift) < 1e-6 + 1e-3 * abs(drift)


@given(st.integers(400 * MS, 10**15), st.sampled_from((1, -1)))
def test_a_jump_is_reported_once_and_followed(jump, sign):
    found = Alignment()
    told = [
        found.add(exchange(number * 16 * MS, 20 * MS, 30 * MS, sign * jump if number >= 10 else 0))
        for number in range(30)
    ]
    assert told.count(True) == 1 and told[10] and found.jumps == 1
    # The two ways differ by 10 ms, and half of that is taken for offset.
    assert abs(found.offset_ns - sign * jump) <= 5 * MS + 2


def test_what_a_quartz_may_drift_in_a_pause_is_no_jump():
    found = Alignment()
    for at in (0, 100_000 * MS):
        assert not found.add(exchange(at, MS, MS, 10**12, 0.9 * MOST_DRIFT))
    # 60 ms in 100 s are more than that, and than the two ways.
    assert found.add(exchange(200_000 * MS, MS, MS, 10**12 + 60 * MS, 0.9 * MOST_DRIFT))
