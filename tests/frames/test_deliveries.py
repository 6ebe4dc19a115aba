"""Things that cross in fragments: in any order, with losses, until all of them have arrived."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.frames.layers import FRAGMENT_BYTES, Inbox, Outbox

SIZES = [0, 1, FRAGMENT_BYTES, FRAGMENT_BYTES + 1, 7 * FRAGMENT_BYTES + 3]


def things_of(sizes: list[int]) -> list[bytes]:
    rng = np.random.default_rng(1)
    return [rng.bytes(size) for size in sizes]


@settings(max_examples=60)
@given(
    st.lists(st.sampled_from(SIZES), max_size=6),
    st.integers(1, 6 * FRAGMENT_BYTES),
    st.lists(st.booleans(), max_size=60),
    st.integers(1, 9),
    st.randoms(use_true_random=False),
)
def test_all_arrives_whatever_is_lost_late_or_out_of_order(sizes, budget, lost, round_trip, random):
    things = things_of(sizes)
    outbox, inbox, got, flying = Outbox(things), Inbox(), {}, []
    fates = iter(lost)
    for now in range(2000):
        outbox.settle(now)
        update = outbox.update(range(len(things)), budget, now)
        assert len(update.content) <= max(budget, FRAGMENT_BYTES + 20)
        arrives = not next(fates, False)
        outbox.heard(update, arrives, now + round_trip)
        flying += [update] if arrives else []
        random.shuffle(flying)
        if now % 3 == 0:
            for message in flying:
                got |= dict(inbox.take(message.content))
            flying = []
        if len(got) == len(things):
            break
    assert got == dict(enumerate(things))
    assert inbox.whole == len(things)


def test_only_lost_updates_are_sent_twice():
    things = things_of([5 * FRAGMENT_BYTES])
    outbox = Outbox(things)
    sent = [outbox.update([0, 0], 2 * (FRAGMENT_BYTES + 14), now) for now in range(3)]
    assert [len(delivery.pieces) for delivery in sent] == [2, 2, 1]
    assert not outbox.waiting and not outbox.update([0], 10_000, 3).pieces
    outbox.heard(sent[1], False, 10)
    outbox.heard(sent[0], True, 9)
    outbox.settle(8)
    assert not outbox.waiting and outbox.round_trip_ns is None
    outbox.settle(10)
    assert outbox.waiting == {0} and outbox.round_trip_ns == 9
    assert outbox.update([0], 10_000, 11).pieces == sent[1].pieces


def test_the_first_in_order_crosses_first_and_the_order_may_change():
    outbox = Outbox(things_of([FRAGMENT_BYTES] * 4))
    assert outbox.update([2, 0, 1, 3], 1, 0).pieces == ((2, 0),)
    assert outbox.update([3, 2, 1, 0], 1, 0).pieces == ((3, 0),)
    assert outbox.waiting == {0, 1}


def test_a_repeated_update_changes_nothing_and_takes_no_memory():
    outbox, inbox = Outbox(things_of([3 * FRAGMENT_BYTES])), Inbox()
    update = outbox.update([0], 10_000, 0)
    assert len(list(inbox.take(update.content))) == 1
    for _ in range(3):
        assert not list(inbox.take(update.content))
    assert inbox._begun == {} and inbox.bytes == 4 * len(update.content)
    update.content[...] = update.content.copy()  # the link writes over it
    assert len(outbox.update([], 100, 0).content) == len(Outbox([]).update([], 100, 0).content) == 0
