"""When a window's pictures will be seen: told of swaps as screens of several kinds make them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.display.desktop.pacing import UNSYNCED, Pacer

MS = 1_000_000
PERIOD = round(1e9 / 60)


def run(pacer: Pacer, works_ms, screen) -> list[tuple[int, int]]:
    """Pictures that take so long each; screen(done) says when a swap asked for then is back.

    [(expected, seen)].
    """
    now, out = 5_000 * MS, []
    for work in works_ms:
        begun = max(now, pacer.due(now))
        expected = pacer.expect(begun)
        now = screen(begun + round(work * MS))
        pacer.swapped(begun, now)
        out.append((expected, now))
    return out


def at_vblank(done: int) -> int:
    return -(-done // PERIOD) * PERIOD


@pytest.mark.parametrize(("work_ms", "periods"), [(3, 1), (14, 1), (20, 2), (60, 4)])
def test_a_screen_that_is_waited_for_shows_the_picture_at_the_expected_refresh(work_ms, periods):
    """Exactly, once pictures of the same kind came before; a picture takes whole refreshes."""
    seen = run(Pacer(60, waits=True), [work_ms] * 40, at_vblank)
    assert all(abs(expected - at) <= 40 for expected, at in seen[2:])  # the period is rounded to whole ns
    assert seen[-1][1] - seen[-2][1] == pytest.approx(periods * PERIOD, abs=1)
    after_a_slow_one = run(Pacer(60, waits=True), [work_ms] * 20 + [90] + [work_ms] * 5, at_vblank)
    assert all(abs(expected - at) <= 40 for k, (expected, at) in enumerate(after_a_slow_one) if k > 1 and k != 20)


def test_pictures_that_take_longer_than_a_refresh_are_counted_as_missed():
    pacer = Pacer(60, waits=True)
    run(pacer, [5] * 10, at_vblank)
    assert pacer.missed() == 0
    run(pacer, [5, 5, 55, 5, 5], at_vblank)
    # The first of these comes after the clock was set back by `run`; 55 ms reach into the fourth
    # refresh.
    assert pacer.missed() == 3
    pacer.pause()  # which is no miss
    pacer.swapped(9_000_000 * MS, 9_000_004 * MS)
    assert pacer.missed() == 0


def test_without_waiting_a_picture_is_seen_when_it_is_done_and_half_a_refresh_later():
    seen = run(Pacer(60, waits=False), [7] * 20, int)
    assert all(expected == at + PERIOD // 2 for expected, at in seen[1:])
    assert not Pacer(60, waits=False).paced


def test_a_driver_that_does_not_wait_though_asked_is_waited_for():
    """llvmpipe, and drivers whose settings say "off".

    Pictures come at the screen's rate nevertheless.
    """
    pacer = Pacer(60, waits=True)
    seen = run(pacer, [2] * 60, int)
    assert pacer.paced
    gaps = np.diff([at for _, at in seen])
    assert (gaps[:UNSYNCED] == 2 * MS).all()
    assert gaps[UNSYNCED + 1 :] == pytest.approx(PERIOD, abs=1)
    pacer.set(60, waits=False)
    assert not pacer.paced
    pacer = Pacer(60, waits=True)
    run(pacer, [100] * 20, int)  # a slow software driver is not held up
    assert not pacer.paced and pacer.due(7) == 7


@given(st.floats(20, 500), st.lists(st.floats(0, 200), max_size=40), st.booleans(), st.booleans())
def test_no_picture_is_expected_before_it_is_begun_nor_held_back_for_more_than_a_period(rate, works, waits, obeys):
    pacer = Pacer(rate, waits)
    now, before = 10**15, 0
    for work in works:
        begun = pacer.due(now)
        assert now <= begun <= now + pacer.period_ns
        expected = pacer.expect(begun)
        assert expected >= begun and expected > before  # the link refuses to be asked about the past
        before = expected
        done = begun + round(work * MS)
        now = -(-done // pacer.period_ns) * pacer.period_ns if waits and obeys else done
        pacer.swapped(begun, now)
    assert pacer.missed() >= 0
