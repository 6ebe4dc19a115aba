"""Requests and frames between both ends of the feed, without a renderer."""

from __future__ import annotations

import itertools
import time

import attrs

from hmdwarp.feed.caller import Arrival, Caller
from hmdwarp.feed.listener import Listener

from .test_message import ASK, FRAME

_NUMBERS = itertools.count(1)


def port_of(address: str) -> int:
    """The port of an address."""
    return int(address.rpartition(":")[2])


def answered(listener: Listener, wait_ms: int = 20) -> bool:
    """Answer the next request, if there is one within that time."""
    asked = listener.next(wait_ms)
    if asked is None:
        return False
    now_ns = time.monotonic_ns()
    listener.answer(
        asked,
        attrs.evolve(
            FRAME, number=asked.ask.number, asked_ns=asked.ask.sent_ns, received_ns=asked.received_ns, sent_ns=now_ns
        ),
    )
    return True


def exchanged(caller: Caller, listener: Listener, at_most: int = 3000) -> tuple[Arrival, int]:
    """Ask until a frame is there; return it, and how often it was asked for."""
    for count in range(1, at_most):
        caller.ask(attrs.evolve(ASK, number=next(_NUMBERS), token=bytes(32)))
        answered(listener)
        caller.wait_until(time.monotonic_ns() + 10_000_000)
        if arrived := caller.take():
            return arrived[-1], count
    raise AssertionError("no frame came")
