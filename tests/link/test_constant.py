"""The constant link against what it promises: never early, newest first seen, nothing lost twice, nothing kept for ever."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hmdwarp.errors import InputError
from hmdwarp.link import ConstantLink

STEPS_NS = st.one_of(st.just(0), st.integers(1, 3), st.integers(0, 50_000_000))
LATENCIES_NS = st.one_of(st.sampled_from([0, 1, 2]), st.integers(0, 200_000_000))


class AgainstAModel(RuleBasedStateMachine):
    """Frames are numbers in the order they were sent; the model remembers all of them, the link must not."""

    @initialize(latency_ns=LATENCIES_NS)
    def start(self, latency_ns):
        self.latency_ns = latency_ns
        self.discarded: list[int] = []
        self.link = ConstantLink(latency_ns, self.discarded.append)
        self.arrivals: list[int] = []
        self.sent_ns = self.asked_ns = 0
        self.last: int | None = None

    @rule(step=STEPS_NS)
    def send(self, step):
        self.sent_ns += step
        self.link.send(len(self.arrivals), self.sent_ns)
        self.arrivals.append(self.sent_ns + self.latency_ns)

    @rule(step=STEPS_NS)
    def ask(self, step):
        self.asked_ns += step
        self.check(self.link.newest(self.asked_ns))

    @rule(which=st.integers(0, 100), beside=st.sampled_from([-1, 0, 1]))
    def ask_at_an_arrival(self, which, beside):
        """At the very nanosecond of an arrival, one before and one after."""
        if self.arrivals:
            self.asked_ns = max(self.asked_ns, self.arrivals[which % len(self.arrivals)] + beside)
            self.check(self.link.newest(self.asked_ns))

    def check(self, got):
        arrived = [number for number, at in enumerate(self.arrivals) if at <= self.asked_ns]
        # The newest that has arrived: never early, and no due frame is passed over.
        assert got == (arrived[-1] if arrived else None)
        # Never back.
        assert self.last is None or got >= self.last
        self.last = got
        # What can no longer be shown has been handed on, in order, once each.
        assert self.discarded == arrived[:-1]
        assert len(self.link) == len(self.arrivals) - len(self.discarded)

    @rule(step=st.integers(1, 10**9))
    def backwards_is_refused_and_changes_nothing(self, step):
        before = len(self.link), list(self.discarded)
        if self.arrivals:
            with pytest.raises(ValueError, match="sent at"):
                self.link.send(-1, self.sent_ns - step)
        if self.asked_ns:
            self.link.newest(self.asked_ns)
            before = len(self.link), list(self.discarded)
            with pytest.raises(ValueError, match="asked at"):
                self.link.newest(self.asked_ns - step)
        assert (len(self.link), self.discarded) == before

    @invariant()
    def nothing_is_discarded_twice(self):
        assert len(set(self.discarded)) == len(self.discarded)

    def teardown(self):
        if hasattr(self, "link"):
            self.link.close()
            assert sorted(self.discarded) == list(range(len(self.arrivals)))
            assert len(self.link) == 0
            self.link.close()  # a second time is nothing
            assert len(self.discarded) == len(self.arrivals)


TestAgainstAModel = AgainstAModel.TestCase
TestAgainstAModel.settings = settings(max_examples=150, stateful_step_count=40, deadline=None)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 400_000_000), st.integers(20, 240), st.integers(0, 10**15), st.integers(0, 3000))
def test_it_holds_what_is_under_way_and_no_more_however_long(latency_ns, rate_hz, start_ns, frames):
    """One frame and one question a refresh: ceil(latency * rate) frames are under way, one is shown, one has just entered."""
    link: ConstantLink[int] = ConstantLink(latency_ns)
    most = 0
    for number in range(frames):
        now_ns = start_ns + number * 1_000_000_000 // rate_hz
        link.send(number, now_ns)
        most = max(most, len(link))
        link.newest(now_ns)
        most = max(most, len(link))
    assert most <= math.ceil(latency_ns * rate_hz / 1e9) + 2


@given(st.lists(STEPS_NS, max_size=30), LATENCIES_NS)
def test_jittered_times_arrive_in_the_order_of_sending(steps, latency_ns):
    link: ConstantLink[int] = ConstantLink(latency_ns)
    now, seen = 0, []
    for number, step in enumerate(steps):
        now += step
        link.send(number, now)
        seen.append(link.newest(now))
    shown = [frame for frame in seen if frame is not None]
    assert shown == sorted(shown)


def test_no_latency_shows_the_frame_just_sent():
    link = ConstantLink(0)
    for number in range(5):
        link.send(number, number * 11)
        assert link.newest(number * 11) == number
        assert len(link) == 1


def test_of_frames_sent_at_once_the_last_is_shown():
    discarded = []
    link = ConstantLink(10, discarded.append)
    for name in "abc":
        link.send(name, 5)
    assert link.newest(14) is None
    assert link.newest(15) == "c"
    assert discarded == ["a", "b"]


def test_the_same_frame_again_until_a_newer_has_arrived():
    link = ConstantLink(100)
    link.send("a", 0)
    link.send("b", 50)
    assert [link.newest(t) for t in (0, 99, 100, 100, 149, 150, 10**12)] == [None, None, "a", "a", "a", "b", "b"]


def test_falsy_frames_are_frames():
    """An empty or zero payload must not be taken for none."""
    discarded = []
    link = ConstantLink(0, discarded.append)
    link.send(0, 0)
    link.send("", 0)
    assert link.newest(0) == ""
    link.close()
    assert discarded == [0, ""]


def test_close_gives_back_what_is_under_way_and_what_is_shown():
    discarded = []
    link = ConstantLink(100, discarded.append)
    for number in range(4):
        link.send(number, number * 60)
    assert link.newest(100) == 0
    link.close()
    assert sorted(discarded) == [0, 1, 2, 3]
    assert link.newest(10**9) is None


@pytest.mark.parametrize("latency", [-1, -(10**12), math.nan, math.inf, -math.inf])
def test_latencies_that_are_none(latency):
    with pytest.raises(InputError, match=r"latency .* ms: wanted 0 or more"):
        ConstantLink(latency)
