"""The link against what it promises, whatever the network does.

A model that remembers everything recomputes what should have come.
"""

from __future__ import annotations

import itertools
import math

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hmdwarp.errors import InputError
from hmdwarp.link import Bandwidth, GilbertElliott, Link, LinkOptions
from hmdwarp.link.delays.normal import NormalJitter
from hmdwarp.link.delays.uniform import UniformJitter

STEPS_NS = st.one_of(st.just(0), st.integers(1, 3), st.integers(0, 50_000_000))
DELAYS_NS = st.one_of(st.sampled_from([0, 1, 2]), st.integers(0, 200_000_000))
STAGES_NS = st.one_of(st.just(0), st.integers(0, 30_000_000))
BANDWIDTHS = st.none() | st.builds(Bandwidth, st.sampled_from([0.5, 8, 50]), st.sampled_from([0, 10, 100]))


def constant(latency_ns: int, *callbacks) -> Link:
    return LinkOptions().link(latency_ns, *callbacks)


@attrs.define
class Sent:
    """What the test knows of a frame.

    When it arrives (None: never), and whether anything it builds on is missing.
    """

    ready_ns: int | None
    usable: bool
    fate: str = "under_way"
    decode_ns: int = 0


class AgainstAModel(RuleBasedStateMachine):
    """Frames are numbers in the order they were sent.

    Nothing of the link's own book-keeping is read to judge it.
    """

    @initialize(bandwidth=BANDWIDTHS, decodes=st.booleans(), stages=st.booleans())
    def start(self, bandwidth, decodes, stages):
        """stages: whether rendering, encoding and decoding take time."""
        self.bandwidth, self.decodes, self.stages = bandwidth, decodes, stages
        self.discarded: list[int] = []
        self.wasted: list[int] = []
        self.received: list[int] = []
        self.delay, self.is_lost = 0, False
        delays, losses = iter(lambda: self.delay, None), iter(lambda: self.is_lost, None)
        receive = self.receive if decodes else None
        self.link = Link(
            delays,
            losses,
            bandwidth,
            discard=self.discarded.append,
            wasted=self.wasted.append,
            receive=receive,
            decoding=lambda number: self.frames[number].decode_ns,
        )
        self.frames: list[Sent] = []
        self.encoded_ns = self.decoder_ns = 0
        self.decoded: dict[int, int] = {}
        self.chain_is_whole = True
        self.sent_ns = self.asked_ns = self.free_ns = self.ready_ns = 0
        self.last: int | None = None

    def receive(self, number):
        self.received.append(number)
        return self.frames[number].usable

    @rule(
        step=STEPS_NS,
        delay=DELAYS_NS,
        size=st.integers(0, 200_000),
        lost=st.sampled_from([False] * 4 + [True]),
        key=st.booleans(),
        times=st.tuples(STAGES_NS, STAGES_NS, STAGES_NS),
    )
    def send(self, step, delay, size, lost, key, times):
        self.sent_ns += step
        self.delay, self.is_lost = delay, lost
        render, encode, decode = times if self.stages else (0, 0, 0)
        # The encoder takes one after the other.
        self.encoded_ns = max(self.sent_ns + render, self.encoded_ns) + encode
        self.frames.append(self.predicted(delay, size, lost, key, decode))
        self.link.send(len(self.frames) - 1, self.sent_ns, size, key, render, encode)

    def predicted(self, delay, size, lost, key, decode) -> Sent:
        start, dropped, transfer = self.encoded_ns, False, 0
        if self.bandwidth is not None:
            start = max(self.encoded_ns, self.free_ns)
            dropped = start - self.encoded_ns > self.bandwidth.queue_ms * 1e6
            transfer = 0 if dropped else round(size * 8 / (self.bandwidth.mbit * 1e6) * 1e9)
            self.free_ns = self.free_ns if dropped else start + transfer
        ready = start + transfer + delay
        if self.decodes:
            self.ready_ns = ready = max(ready, self.ready_ns)
        missing = dropped or lost
        self.chain_is_whole = not missing and (key or self.chain_is_whole)
        usable = self.chain_is_whole or not self.decodes
        fate = "dropped" if dropped else "lost" if lost else "under_way"
        return Sent(None if missing else ready, usable, fate, decode)

    def decode(self) -> None:
        """Note when each frame that has arrived can be shown: decoded one by one as they arrive."""
        came = [(frame.ready_ns, n) for n, frame in enumerate(self.frames) if frame.ready_ns is not None]
        for ready, n in sorted(came):
            if ready <= self.asked_ns and n not in self.decoded:
                takes = self.frames[n].decode_ns if self.frames[n].usable else 0
                self.decoded[n] = max(ready, self.decoder_ns) + takes if takes else ready
                self.decoder_ns = self.decoded[n] if takes else self.decoder_ns

    @rule(step=STEPS_NS)
    def ask(self, step):
        self.asked_ns += step
        self.check(self.link.newest(self.asked_ns))

    @rule(which=st.integers(0, 100), beside=st.sampled_from([-1, 0, 1]))
    def ask_at_an_arrival(self, which, beside):
        """At the very nanosecond of an arrival, one before and one after."""
        arrivals = [frame.ready_ns for frame in self.frames if frame.ready_ns is not None]
        instants = [*arrivals, *self.decoded.values()]
        if instants:
            self.asked_ns = max(self.asked_ns, instants[which % len(instants)] + beside)
            self.check(self.link.newest(self.asked_ns))

    def check(self, got):
        self.decode()
        came = [n for n, ready in sorted(self.decoded.items()) if ready <= self.asked_ns]
        fresh = [n for n in came if self.frames[n].fate == "under_way"]
        newest = max((n for n in came if self.frames[n].usable), default=None)
        # The newest that has arrived: never early, and no due frame is passed over. Never back.
        assert got == newest
        assert self.last is None or got >= self.last
        for n in fresh:
            if not self.frames[n].usable:
                self.frames[n].fate = "undecodable"
            elif n == newest:
                self.frames[n].fate = "shown"
            else:
                self.frames[n].fate = "late" if self.last is not None and n < self.last else "superseded"
        self.last = got
        assert (self.link.transit.number if self.link.transit else None) == got
        if got is not None:
            assert self.link.transit.ready_ns == self.decoded[got]

    @invariant()
    def the_tally_adds_up(self):
        if not hasattr(self, "link"):
            return
        fates, tally = [frame.fate for frame in self.frames], self.link.tally.as_dict()
        for fate in ("dropped", "lost", "undecodable", "late", "superseded", "shown", "under_way"):
            assert tally[fate] == fates.count(fate), fate
        assert tally["drawn"] == len(fates) == tally["dropped"] + tally["sent"]
        # In hand: those under way and the one on the screen. All others have left, once each, by
        # the right door.
        assert len(self.link) == fates.count("under_way") + (self.last is not None)
        assert sorted(self.wasted) == [n for n, fate in enumerate(fates) if fate in ("dropped", "lost", "undecodable")]
        gone = [n for n, fate in enumerate(fates) if fate in ("late", "superseded", "shown") and n != self.last]
        assert sorted(self.discarded) == gone

    @invariant()
    def a_decoder_is_given_each_arrival_in_the_order_of_sending(self):
        if hasattr(self, "link"):
            assert self.received == sorted(set(self.received))

    @rule(step=st.integers(1, 10**9))
    def backwards_is_refused_and_changes_nothing(self, step):
        before = self.link.tally, len(self.link)
        if self.frames:
            with pytest.raises(ValueError, match="sent at"):
                self.link.send(-1, self.sent_ns - step)
        assert (self.link.tally, len(self.link)) == before
        if self.asked_ns:
            self.check(self.link.newest(self.asked_ns))
            before = self.link.tally, len(self.link)
            with pytest.raises(ValueError, match="asked at"):
                self.link.newest(self.asked_ns - step)
            assert (self.link.tally, len(self.link)) == before

    def teardown(self):
        if hasattr(self, "link"):
            tally = self.link.tally
            self.link.close()
            assert sorted(self.discarded + self.wasted) == list(range(len(self.frames)))
            assert len(self.link) == 0
            assert self.link.tally == tally
            self.link.close()  # a second time is nothing
            assert len(self.discarded) + len(self.wasted) == len(self.frames)


TestAgainstAModel = AgainstAModel.TestCase
TestAgainstAModel.settings = settings(max_examples=150, stateful_step_count=40)

JITTERS = st.one_of(
    st.just(LinkOptions().delay), st.builds(NormalJitter, st.floats(0, 60)), st.builds(UniformJitter, st.floats(0, 20))
)  # fmt: skip


@settings(max_examples=40)
@given(
    st.builds(LinkOptions, JITTERS, st.none() | st.just(GilbertElliott(0.1, 0.3)), BANDWIDTHS, st.integers(0, 9)),
    st.integers(20_000_000, 400_000_000),
    st.integers(20, 240),
    st.integers(0, 10**15),
    st.integers(0, 500_000),
    st.booleans(),
)
def test_it_holds_what_can_be_under_way_and_no_more_however_long(options, latency_ns, rate_hz, start_ns, size, decodes):
    """One frame and one question a refresh, 600 of them.

    The bound is of the number alone, frames may be of any size.
    """
    link = options.link(latency_ns, receive=(lambda frame: True) if decodes else None)
    most, bound = 0, options.most_under_way(latency_ns, rate_hz)
    for number in range(600):
        now_ns = start_ns + number * 1_000_000_000 // rate_hz
        link.send(number, now_ns, size)
        most = max(most, len(link))
        link.newest(now_ns)
    assert most <= bound + 1  # and the one that is shown


@given(st.integers(0, 400_000_000), st.integers(20, 240))
def test_the_bound_of_a_constant_link_is_what_it_needs(latency_ns, rate_hz):
    assert LinkOptions().most_under_way(latency_ns, rate_hz) == math.ceil(latency_ns * 1e-9 * rate_hz) + 2


@given(st.lists(STEPS_NS, max_size=30), DELAYS_NS)
def test_a_constant_delay_shows_frames_in_the_order_of_sending_and_drops_none_late(steps, latency_ns):
    link, now, seen = constant(latency_ns), 0, []
    for number, step in enumerate(steps):
        now += step
        link.send(number, now)
        seen.append(link.newest(now))
    shown = [frame for frame in seen if frame is not None]
    assert shown == sorted(shown)
    assert link.tally.late == 0


def test_no_latency_shows_the_frame_just_sent():
    link = constant(0)
    for number in range(5):
        link.send(number, number * 11)
        assert link.newest(number * 11) == number
        assert len(link) == 1


def test_the_last_of_frames_sent_at_once_is_shown():
    discarded = []
    link = constant(10, discarded.append)
    for name in "abc":
        link.send(name, 5)
    assert link.newest(14) is None
    assert link.newest(15) == "c"
    assert discarded == ["a", "b"]
    assert (link.tally.superseded, link.tally.shown) == (2, 1)


def test_the_same_frame_again_until_a_newer_has_arrived():
    link = constant(100)
    link.send("a", 0)
    link.send("b", 50)
    assert [link.newest(t) for t in (0, 99, 100, 100, 149, 150, 10**12)] == [None, None, "a", "a", "a", "b", "b"]
    assert link.tally.shown == 2


def test_a_frame_that_is_overtaken_never_comes_to_the_screen():
    discarded = []
    link = Link(iter([100, 10, 10]), discard=discarded.append)
    for number in range(3):
        link.send(number, number * 20)
    # 0 arrives at 100, 1 at 30, 2 at 50.
    assert [link.newest(t) for t in (30, 50, 99, 100, 200)] == [1, 2, 2, 2, 2]
    assert discarded == [1, 0]
    assert (link.tally.shown, link.tally.late) == (2, 1)


def test_where_a_decoder_needs_them_frames_wait_for_those_before_them():
    received = []
    link = Link(iter([100, 10, 10]), receive=lambda frame: received.append(frame) or True)
    for number in range(3):
        link.send(number, number * 20)
    assert [link.newest(t) for t in (30, 99, 100)] == [None, None, 2]
    assert received == [0, 1, 2]
    assert link.transit.hold_ns == 50


def test_a_lost_frame_is_waited_for_until_it_would_have_come():
    """Until then nobody can tell a lost frame from a slow one."""
    link = Link(iter([100, 10]), iter([True, False]), receive=lambda frame: True)
    link.send(0, 0)
    link.send(1, 20)
    assert [link.newest(t) for t in (30, 99, 100)] == [None, None, 1]


def test_the_last_frame_is_held_when_nothing_comes_any_more():
    link = Link(itertools.repeat(10), itertools.chain([False], itertools.repeat(True)))
    for number in range(100):
        link.send(number, number * 10)
        assert link.newest(number * 10 + 10) == 0
    assert (link.tally.shown, link.tally.lost) == (1, 99)
    assert len(link) == 1


def test_bytes_take_their_time_and_frames_queue():
    """8 Mbit/s is one byte a microsecond: 1000 bytes take 1 ms."""
    link = Link(itertools.repeat(5_000_000), None, Bandwidth(8, queue_ms=1.5))
    for name in "abc":  # a goes at 0, b waits 1 ms, c would wait 2
        link.send(name, 0, 1000)
    assert [link.newest(t) for t in (5_999_999, 6_000_000, 6_999_999, 7_000_000, 10**9)] == [None, "a", "a", "b", "b"]
    transit = link.transit
    assert (transit.queue_ns, transit.transfer_ns, transit.delay_ns, transit.ready_ns) == (
        1_000_000,
        1_000_000,
        5_000_000,
        7_000_000,
    )
    assert (link.tally.dropped, link.tally.sent) == (1, 2)


def test_a_frame_that_finds_the_bottleneck_free_passes_however_large():
    link = Link(itertools.repeat(0), None, Bandwidth(8, queue_ms=0))
    link.send("huge", 0, 10_000_000)
    assert link.newest(10 * 10**9) == "huge"


def test_the_sender_hears_of_a_loss_one_delay_after_it_and_once_a_key_frame_has_gone_no_more():
    link = Link(itertools.repeat(100), iter([False, True, False, False, False, True]))
    for number in range(3):
        link.send(number, number * 10, key=number == 0)
    # Frame 1, sent at 10, is missing at 110 and known to be at 210.
    assert [link.needs_key(t) for t in (0, 110, 209, 210, 300)] == [False, False, False, True, True]
    link.send(3, 300, key=True)
    assert not link.needs_key(10**9)
    link.send(4, 310, key=False)
    link.send(5, 320, key=True)  # the key frame itself goes missing
    assert [link.needs_key(t) for t in (519, 520)] == [False, True]


def test_of_several_losses_the_one_heard_of_first_wants_the_key_frame():
    link = Link(iter([100, 20, 300]), iter([True, True, True]))
    for number in range(3):
        link.send(number, number * 10, key=False)
    # Sent at 0, 10 and 20, and known to be missing at 200, 50 and 620.
    assert [link.needs_key(t) for t in (49, 50)] == [False, True]


def test_each_frame_is_settled_once_and_heard_of_one_delay_after_it_came():
    """Shown or not. A lost one is settled when it is sent, one in transit at the end never."""
    delays, losses = iter([30, 10, 20, 5, 40]), iter([False, False, True, False, False])
    settled, wasted = [], []
    link = Link(delays, losses, wasted=wasted.append, settled=lambda *fate: settled.append(fate))
    for frame in range(5):
        link.send(frame, 0)
        assert wasted == [2][: frame >= 2]
    assert settled == [(2, False, 40)]
    assert link.newest(10) == 3  # which came first, and is newer than 1
    assert link.newest(35) == 3
    link.close()
    assert settled == [(2, False, 40), (3, True, 10), (1, True, 20), (0, True, 60)]


def test_undecodable_frames_count_as_not_arrived():
    settled = []
    link = Link(itertools.repeat(7), receive=lambda frame: frame != 1, settled=lambda *fate: settled.append(fate))
    for frame in range(3):
        link.send(frame, frame)
    link.newest(20)
    assert settled == [(0, True, 14), (1, False, 15), (2, True, 16)]


def test_a_dropped_frame_is_heard_of_as_well():
    link = Link(itertools.repeat(0), None, Bandwidth(8, queue_ms=0))
    link.send(0, 0, 1000, key=True)
    link.send(1, 10, 1000, key=False)
    assert [link.needs_key(t) for t in (999_999, 1_000_000)] == [False, True]


def test_falsy_frames_are_frames():
    """An empty or zero payload must not be taken for none."""
    discarded = []
    link = constant(0, discarded.append)
    link.send(0, 0)
    link.send("", 0)
    assert link.newest(0) == ""
    link.close()
    assert discarded == [0, ""]


def test_close_gives_back_what_is_under_way_and_what_is_shown():
    discarded, wasted = [], []
    link = constant(100, discarded.append, wasted.append)
    for number in range(4):
        link.send(number, number * 60)
    assert link.newest(100) == 0
    link.close()
    assert (discarded, wasted) == ([0], [1, 2, 3])
    assert link.newest(10**9) is None
    assert link.tally.under_way == 3


@pytest.mark.parametrize("latency", [-1, -(10**12), math.nan, math.inf, -math.inf])
def test_latencies_that_are_none(latency):
    with pytest.raises(InputError, match=r"latency .* ms: expected 0 or more"):
        constant(latency)


def test_faults_of_the_caller():
    with pytest.raises(ValueError, match="delay of -1 ns"):
        Link(iter([-1])).send("a", 0)
    with pytest.raises(ValueError, match="-5 bytes"):
        Link(iter([1])).send("a", 0, -5)


@given(
    st.integers(0, 200), st.integers(0, 200), st.lists(st.integers(1, 40), min_size=1, max_size=30), st.integers(0, 30)
)
def test_a_change_of_delay_is_for_what_is_sent_from_then_on(first, second, steps, at):
    """A window's slider, or a controller's.

    Frames under way arrive as they would have, and what is shown never goes back.
    """
    link, now, due = constant(first), 0, []
    for number, step in enumerate(steps):
        if number == at:
            link.delay_by(itertools.repeat(second))
        link.send(number, now)
        due.append(now + (second if number >= at else first))
        now += step
        arrived = [n for n, ready in enumerate(due) if ready <= now]
        assert link.newest(now) == (max(arrived) if arrived else None)
