"""The link against what it promises, whatever the network does. A model that remembers everything
recomputes what should have come."""

from __future__ import annotations

import itertools
import math

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hmdwarp.link import Bandwidth, GilbertElliott, Link, LinkOptions
from hmdwarp.link.delays import NormalJitter, UniformJitter

STEPS_NS = st.one_of(st.just(0), st.integers(1, 3), st.integers(0, 50_000_000))
DELAYS_NS = st.one_of(st.sampled_from([0, 1, 2]), st.integers(0, 200_000_000))
STAGES_NS = st.one_of(st.just(0), st.integers(0, 30_000_000))
BANDWIDTHS = st.none() | st.builds(Bandwidth, st.sampled_from([0.5, 8, 50]), st.sampled_from([0, 10, 100]))


@attrs.define
class Sent:
    """What the test knows of a frame. When it arrives (None: never), and whether anything it builds
    on is missing."""

    ready_ns: int | None
    usable: bool
    # Queue, transfer, delay and hold, in ns.
    way: tuple[int, int, int, int]
    heard_ns: int
    fate: str = "under_way"
    decode_ns: int = 0


class AgainstAModel(RuleBasedStateMachine):
    """Frames are numbers in the order they were sent. Nothing of the link's own book-keeping is
    read to judge it."""

    @initialize(bandwidth=BANDWIDTHS, decodes=st.booleans(), stages=st.booleans())
    def start(self, bandwidth, decodes, stages):
        """stages: whether rendering, encoding and decoding take time."""
        self.bandwidth, self.decodes, self.stages = bandwidth, decodes, stages
        self.discarded: list[int] = []
        self.wasted: list[int] = []
        self.received: list[int] = []
        self.settled: list[tuple[int, bool, int]] = []
        self.told: list[tuple[int, bool, int]] = []
        # When the sender hears of each loss that no key frame has repaired.
        self.losses: list[int] = []
        self.delay, self.is_lost = 0, False
        delays, losses = iter(lambda: self.delay, None), iter(lambda: self.is_lost, None)
        receive = self.receive if decodes else None
        self.link = Link(
            delays, losses, bandwidth, discard=self.discarded.append, wasted=self.wasted.append, receive=receive,
            decoding=lambda number: self.frames[number].decode_ns, settled=lambda *fate: self.settled.append(fate),
        )  # fmt: skip
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
        waits = max(0, self.encoded_ns - self.sent_ns - render)
        self.encoded_ns = self.sent_ns + render + waits + encode
        self.frames.append(self.predicted(waits, delay, size, lost, key, decode))
        self.link.send(len(self.frames) - 1, self.sent_ns, size, key, render, encode)

    def predicted(self, waits, delay, size, lost, key, decode) -> Sent:
        start, dropped, transfer, hold = self.encoded_ns, False, 0, 0
        if self.bandwidth is not None:
            start = max(self.encoded_ns, self.free_ns)
            dropped = start - self.encoded_ns > self.bandwidth.queue_ms * 1e6
            transfer = 0 if dropped else round(size * 8 / (self.bandwidth.mbit * 1e6) * 1e9)
            self.free_ns = self.free_ns if dropped else start + transfer
        ready = start + transfer + delay
        if self.decodes:
            hold = max(0, self.ready_ns - ready)
            self.ready_ns = ready = ready + hold
        missing = dropped or lost
        self.losses = [] if key else self.losses
        if missing:
            self.losses.append(ready + delay)
            self.told.append((len(self.frames), False, ready + delay))
        self.chain_is_whole = not missing and (key or self.chain_is_whole)
        usable = self.chain_is_whole or not self.decodes
        fate = "dropped" if dropped else "lost" if lost else "under_way"
        way = (start - self.encoded_ns + waits, transfer, delay, hold)
        return Sent(None if missing else ready, usable, way, ready + delay, fate, decode)

    def decode(self) -> None:
        """Note when each frame that has arrived can be shown: decoded one by one as they arrive."""
        came = [(frame.ready_ns, n) for n, frame in enumerate(self.frames) if frame.ready_ns is not None]
        for ready, n in sorted(came):
            if ready <= self.asked_ns and n not in self.decoded:
                takes = self.frames[n].decode_ns if self.frames[n].usable else 0
                self.decoded[n] = max(ready, self.decoder_ns) + takes if takes else ready
                self.decoder_ns = self.decoded[n] if takes else self.decoder_ns
                self.told.append((n, self.frames[n].usable, self.frames[n].heard_ns))

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
        found = self.link.transit
        assert (found.number if found else None) == got
        if got is not None:
            assert found.ready_ns == self.decoded[got]
            *way, hold = self.frames[got].way
            decoding = found.ready_ns - self.frames[got].ready_ns  # its work, and the wait for it
            assert [found.queue_ns, found.transfer_ns, found.delay_ns] == way
            assert found.hold_ns + found.decode_ns == hold + decoding
        assert self.settled == self.told, "once each, lost ones when they are sent"
        assert self.link.needs_key(self.asked_ns) == any(heard <= self.asked_ns for heard in self.losses)

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
            assert self.discarded[-1:] == [self.last] or self.last is None
            assert sorted(self.discarded + self.wasted) == list(range(len(self.frames)))
            assert self.link.newest(self.asked_ns) is None
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
    """One frame and one question a refresh, 600 of them. The bound is of the number alone, frames
    may be of any size."""
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


def test_faults_of_the_caller():
    with pytest.raises(ValueError, match="delay of -1 ns"):
        Link(iter([-1])).send("a", 0)
    with pytest.raises(ValueError, match="-5 bytes"):
        Link(iter([1])).send("a", 0, -5)


@given(st.integers(0, 200), st.integers(0, 200), st.lists(st.integers(1, 40), min_size=1), st.integers(0, 30))
def test_a_change_of_delay_is_for_what_is_sent_from_then_on(first, second, steps, at):
    """A window's slider, or a controller's. Frames under way arrive as they would have, and what is
    shown never goes back."""
    link, now, due = LinkOptions().link(first), 0, []
    for number, step in enumerate(steps):
        if number == at:
            link.delay_by(itertools.repeat(second))
        link.send(number, now)
        due.append(now + (second if number >= at else first))
        now += step
        assert link.newest(now) == max((n for n, ready in enumerate(due) if ready <= now), default=None)
