"""A server's pace beside a display of another rate, and lower resolution where it is too much."""

from __future__ import annotations

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.link import SCALES, Bandwidth, Link, LinkOptions, Overload, Pacer, scaled_size

PERIOD_NS = 10_000_000
S = 100  # periods in a second


@attrs.define
class Run:
    """A server of 100 Hz over a link: what it drew, and what became of it."""

    scales: list[float] = attrs.field(factory=list)
    dropped: int = 0
    changes: int = 0


def run(mbit: list[float], full_bytes: int, queue_ms: float = 250.0) -> Run:
    """mbit: of each period. A frame's bytes are in proportion to its pixels."""
    overload, found = Overload(PERIOD_NS, round(queue_ms * 1e6)), Run()
    link: Link[int] = Link(iter(lambda: 0, None), None, Bandwidth(mbit[0], queue_ms))
    for number, rate in enumerate(mbit):
        link._bandwidth = Bandwidth(rate, queue_ms)  # it changes while the link runs
        size = round(full_bytes * overload.scale**2)
        transit = link.send(number, number * PERIOD_NS, size)
        found.scales.append(overload.scale)
        overload.sent(number * PERIOD_NS, transit.queue_ns, transit.transfer_ns)
        link.newest(number * PERIOD_NS)
    found.dropped, found.changes = link.tally.dropped, overload.changes
    return found


@given(load=st.floats(0.05, 0.99))
def test_frames_that_fit_are_never_lowered(load):
    """load: of the link by full frames. 8 Mbit/s are 10,000 bytes in a period."""
    found = run([8.0] * 3 * S, round(load * 10_000))
    assert set(found.scales) == {1.0} and not found.changes


@given(load=st.floats(1.05, 3.5))
def test_too_large_frames_are_lowered_before_any_is_dropped(load):
    """At a quarter of the pixels everything up to a load of 3.5 fits."""
    found = run([8.0] * 20 * S, round(load * 10_000))
    assert found.dropped == 0
    assert load * found.scales[-1] ** 2 < 1, "it ends where frames fit"
    # Between two scales of which one is too much and the other leaves room, attempts grow rarer: a
    # step up and its step down after 1, 2, 4 and 8 s.
    assert found.changes <= len(SCALES) - 1 + 2 * 4


def test_it_goes_down_one_step_at_a_time_and_back_up_when_there_is_room():
    found = run([8.0] * S + [2.0] * 2 * S + [8.0] * 8 * S, 7_000)
    steps = [later for earlier, later in zip([1.0, *found.scales], found.scales, strict=False) if earlier != later]
    assert steps[: len(SCALES) - 1] == list(SCALES[1:]), "7,000 bytes where 2,500 fit: down to a quarter"
    assert steps[-1] == 1.0 and found.scales[-1] == 1.0, "and all the way back"
    assert found.changes == len(steps) == 2 * (len(SCALES) - 1)
    ups = [n for n, (a, b) in enumerate(zip(found.scales, found.scales[1:], strict=False)) if b > a]
    assert all(later - earlier >= S for earlier, later in zip(ups, ups[1:], strict=False)), "a second between"


def test_beyond_the_lowest_resolution_frames_are_dropped_as_ever():
    found = run([8.0] * 5 * S, 80_000, queue_ms=50.0)
    assert found.scales[-1] == SCALES[-1] and found.dropped > 0


def test_a_busy_server_gets_the_time_to_finish_before_the_next_step():
    overload = Overload(PERIOD_NS, 250_000_000)
    overload.sent(0, 0, 3 * PERIOD_NS)
    overload.lower(1 * PERIOD_NS, 2 * PERIOD_NS)
    overload.lower(2 * PERIOD_NS, 1 * PERIOD_NS)  # the same frame
    assert (overload.scale, overload.changes) == (SCALES[1], 1)
    overload.sent(3 * PERIOD_NS, 0, 2 * PERIOD_NS)
    overload.lower(4 * PERIOD_NS, 1 * PERIOD_NS)
    assert overload.scale == SCALES[2]


def test_sizes_and_texts():
    assert scaled_size((640, 800), 0.65) == (416, 520) and scaled_size((1, 1), 0.5) == (1, 1)
    assert LinkOptions().overload_at(60.0) is None
    made = LinkOptions.of({"overload": "resolution", "bandwidth": "8", "queue": 40.0, "server_rate": 20.0}).overload_at(
        60.0
    )
    assert (made.period_ns, made.queue_ns, made.scale) == (50_000_000, 40_000_000, 1.0)


RATES = st.one_of(st.sampled_from([10.0, 15.0, 24.0, 30.0, 59.94, 60.0, 72.0, 90.0, 144.0]), st.floats(1, 1000))


def refreshes(rate_hz: float, count: int, first_ns: int = 7) -> list[int]:
    return [first_ns + round(number * 1e9 / rate_hz) for number in range(count)]


@pytest.mark.parametrize(("server_hz", "every"), [(None, 1), (60.0, 1), (30.0, 2), (20.0, 3), (10.0, 6)])
def test_a_rate_that_divides_the_displays_is_every_nth_refresh(server_hz, every):
    pacer, instants = Pacer(server_hz, 60.0), refreshes(60.0, 30)
    assert [pacer.due(now) for now in instants] == [[now] if n % every == 0 else [] for n, now in enumerate(instants)]


@given(server_hz=RATES, display_hz=RATES)
def test_every_instant_comes_once_in_order_and_at_the_servers_rate(server_hz, display_hz):
    pacer, instants = Pacer(server_hz, display_hz), refreshes(display_hz, 60)
    found = [pacer.due(now) for now in instants]
    drawn = [instant for at in found for instant in at]
    assert drawn == sorted(set(drawn))
    assert found[0] == [instants[0]], "the first refresh has a frame"
    # Within a period of the server and of the display, and the thousandth that counts as a divisor.
    length_s = (instants[-1] - instants[0]) * 1e-9
    assert abs(len(drawn) - length_s * server_hz) <= 1 + 2e-3 * length_s * server_hz
    for before, now, at in zip(instants, instants[1:], found[1:], strict=False):
        assert all(before - 1001 <= instant <= now for instant in at), "each belongs to the refresh that asks for it"


def test_other_rates_draw_between_refreshes_and_after_a_stall_the_newest_alone():
    pacer = Pacer(25.0, 60.0)
    drawn = [instant for now in refreshes(60.0, 31, first_ns=0) for instant in pacer.due(now)]
    assert drawn == [number * 40_000_000 for number in range(13)]
    faster = Pacer(120.0, 60.0)
    assert [len(faster.due(now)) for now in refreshes(60.0, 5)] == [1, 2, 2, 2, 2]
    assert pacer.due(10_000_000_000) == [9_960_000_000, 10_000_000_000]
    assert pacer.due(10_016_666_667) == []
