"""Messages of the feed, one of each kind, and both its ends without a renderer."""

from __future__ import annotations

import itertools
import threading
import time
from contextlib import contextmanager

import attrs
import numpy as np

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.feed.caller import Arrival, Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import DEPTH_EXACT, HEVC, Ask, FrameMessage, token_of
from hmdwarp.sources.feed.parts import Wanted, packed

HEAD = Pose((0.1, 1.6, -1e-9), (0.1, 0.2, 0.3, 0.9))
VIEWS = tuple(View(HEAD @ Pose((x, 0, 0)), Fov(-0.8, 0.7, -0.6, 0.65), Pose((x, 0, 0))) for x in (-0.03, 0.03))
RNG = np.random.default_rng(1)
ASK = Ask(7, -5, 2**62, 12, 6, (4, 3), HEAD, VIEWS, token_of("secret"))
COLOURS = tuple(RNG.random((3, 4, 4)).astype(np.float16) for _ in VIEWS)
FRAME = FrameMessage(7, 1, 2, 3, 4, 5, VIEWS, COLOURS, tuple(RNG.random((3, 4)).astype(np.float32) for _ in VIEWS))
BYTES = attrs.evolve(FRAME, colours=tuple(RNG.integers(0, 256, (3, 4, 4), np.uint8) for _ in VIEWS))
_CODED = {"colours": (b"colour", b"of two"), "inverse_depths": (b"depth", b""), "colour": HEVC, "depth": DEPTH_EXACT}
CODED = attrs.evolve(FRAME, **_CODED, coded_size=(4, 3), begins=False, place=9)
WANTED = Wanted((("velocity", 1), ("peeled", 2)), (4, 2), tuple(view.fov for view in VIEWS))
OF_EYE = {
    "velocity": [RNG.random((3, 4, 4)).astype(np.float16)],
    "ids": [RNG.integers(0, 9, (3, 4), np.uint16), RNG.random((9, 16))],
    "peeled": [packed(RNG.random((3, 4, 4)).astype(np.float16)), packed(RNG.random((3, 4)).astype(np.float32))],
}
LAYERED = attrs.evolve(FRAME, layers=(OF_EYE, {name: OF_EYE[name] for name in ("ids",)}))
_NUMBERS = itertools.count(1)
WHENEVER_MS = 600_000  # at most, to wait for what is certain to come: a fail-safe


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
            FRAME,
            number=asked.ask.number,
            views=asked.ask.views,
            asked_ns=asked.ask.sent_ns,
            received_ns=asked.received_ns,
            sent_ns=now_ns,
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


@contextmanager
def feeder(layers_of=lambda ask: (), views_of=lambda views: views, as_sent=lambda frame: frame):
    """Like cameras of a robot: it answers for two eyes with what it has, and refuses the rest. A
    red stripe, a fifth as wide as the picture and 2 m away, stands on grey. layers_of(ask): what
    comes beside it. views_of(views): those that are drawn where these are asked for.
    as_sent(frame): what goes out in place of it."""
    listener, done = Listener("127.0.0.1:*"), threading.Event()

    def work() -> None:
        while not done.is_set():
            asked = listener.next(20)
            if asked is None:
                continue
            (wide, high), ask = asked.ask.size, asked.ask
            if len(ask.views) == 1:
                listener.refuse(asked, "there is one camera")
                continue
            colour, flat = np.full((high, wide, 4), 0.5, np.float16), np.full((high, wide), 0.1, np.float32)
            stripe = slice(2 * wide // 5, 3 * wide // 5)
            colour[:, stripe], flat[:, stripe] = (1, 0, 0, 1), 0.5
            views = views_of(ask.views)
            pictures = {"colours": (colour,) * len(views), "inverse_depths": (flat,) * len(views)}
            frame = attrs.evolve(FRAME, number=ask.number, views=views, **pictures)
            frame = attrs.evolve(frame, asked_ns=ask.sent_ns, render_ns=0, layers=layers_of(ask))
            listener.answer(asked, as_sent(frame))

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield listener.address
    finally:
        done.set()
        thread.join()
        listener.close()


def vector_row(before: View, near: float, far: float, scale=(1, 1, 1), offset=(0, 0, 0), seconds=1.0) -> np.ndarray:
    """What stands beside motion vectors: how they are coded, and the view that they come from."""
    poses = [
        number for pose in (before.pose, before.head_from_eye) for number in (*pose.position_m, *pose.orientation_xyzw)
    ]
    angles = [before.fov.left, before.fov.right, before.fov.down, before.fov.up]
    return np.array([[*scale, *offset, near, far, seconds, *poses, *angles]], np.float64)
