"""Clock alignment: the offset is right within half the shortest round trip, a jump is told."""

from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.sources.feed.caller import MOST_DRIFT, Alignment, Exchange

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


def test_a_drift_that_the_ways_may_feign_is_not_told():
    """They differ by 100 ms: a line through these offsets drifts faster than any quartz."""
    found = Alignment()
    for number in range(8):
        found.add(exchange(number * 3000 * MS, 100 * MS * (number % 2), 100 * MS * ((number + 1) % 2), 0))
    assert found.drift is None and found.summary()["drift_ppm"] is None


def test_impossible_exchanges_are_left_out():
    found = Alignment()
    found.add(Exchange(10, 0, 100, 20))
    found.add(Exchange(10, 5, 4, 20))
    assert not found.is_known
