"""The instants at which a server draws beside a display of another rate."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.link import Pacer

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
