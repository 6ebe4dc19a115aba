"""A renderer of the caller's own, in Python, for clients of the feed."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import View, inverse_depth_from_metres
from ..sequences.recorded import as_pictures
from . import bounds
from .listener import Asked, Listener, listening
from .message import FrameMessage

_WAIT_MS = 200  # between looks at whether to stop


class Views(tuple[View, ...]):
    """The eyes to render, the left one first: world_from_eye and field of view of each."""

    size: tuple[int, int]  # (w, h) of each one's image, in pixels


# views, instant in ns -> colour and depth of each eye, and its view where that is another one
Render = Callable[[Views, int], Sequence[Any]]


def serve(
    render: Render, listen: str = "127.0.0.1:5570", *, goes_on: Callable[[], bool] = lambda: True, **who: Any
) -> None:
    """Render for `hmdwarp live|replay --connect` until interrupted, or until goes_on() says no.

    Parameters
    ----------
    render : callable
        ``render(views, time_ns) -> colour, depth_m``, or ``colour, depth_m, views`` of a camera:
        where it really was. ``views.size`` is (w, h) pixels, ``time_ns`` counts from the trace's
        begin. For each eye, row 0 at the top: colour (h, w, 3), or (h, w, 4) with coverage, uint8
        sRGB or floats of linear light; depth_m (h, w) metres along -z, inf infinitely far, 0 or NaN
        no depth.
    listen : str
        HOST:PORT; port ``*`` takes a free one.
    key_pair, token_file, is_open
        Who may connect from other machines, as `hmdwarp serve` takes it.

    Raises
    ------
    InputError
        For an address that cannot be listened at, and for results of another shape.
    MachineError
        Without ZeroMQ.
    """
    with closing(_listener(listen, **who)) as listener, suppress(KeyboardInterrupt):
        _run(listener, render, goes_on)


@contextmanager
def serving(render: Render, listen: str = "127.0.0.1:*", **who: Any) -> Iterator[str]:
    """Serve in a thread while the block runs; gives the address. Errors: as serve, at the end."""
    is_over = threading.Event()
    with closing(_listener(listen, **who)) as listener, ThreadPoolExecutor(1) as thread:
        running = thread.submit(_run, listener, render, lambda: not is_over.is_set())
        try:
            yield listener.address.removeprefix("tcp://")
        finally:
            is_over.set()
        running.result()


def _listener(listen: str, key_pair: Any = None, token_file: Any = None, *, is_open: bool = False) -> Listener:
    def say(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    found, _, _ = listening(listen, say, token_file, key_pair, is_open=is_open)
    say(f"listening at {found.address}")
    return found


def _run(listener: Listener, render: Render, goes_on: Callable[[], bool]) -> None:
    while goes_on():
        if (asked := listener.next(_WAIT_MS)) is not None:
            try:
                bounds.DRAWN_BY_CPU.check(13 * len(asked.ask.views) * asked.ask.size[0] * asked.ask.size[1])
            except bounds.OutOfBounds as error:
                listener.refuse(asked, str(error))
            else:
                listener.answer(asked, _frame(render, asked))


def _frame(render: Render, asked: Asked) -> FrameMessage:
    ask, begun_ns = asked.ask, time.monotonic_ns()
    views = Views(ask.views)
    views.size = ask.size
    colours, depths, *seen = render(views, ask.time_ns)
    at = tuple(seen[0]) if seen else ask.views
    if not len(colours) == len(depths) == len(at) == len(views):
        found = f"{len(colours)} colours, {len(depths)} depths and {len(at)} views"
        raise InputError(f"render returned {found}: expected {len(views)} of each, as it was given")
    pairs = [_pair(np.asarray(c), np.asarray(d), ask.size[::-1]) for c, d in zip(colours, depths, strict=True)]
    sent_ns = time.monotonic_ns()
    times = (ask.number, ask.sent_ns, asked.received_ns, sent_ns, sent_ns - begun_ns, ask.time_ns)
    return FrameMessage(*times, at, tuple(colour for colour, _ in pairs), tuple(depth for _, depth in pairs))


def _pair(colour: NDArray[Any], depth_m: NDArray[Any], shape: tuple[int, ...]) -> tuple[NDArray[Any], NDArray[Any]]:
    if depth_m.shape != shape or colour.shape not in ((*shape, 3), (*shape, 4)):
        found = f"colour {colour.shape} and depth {depth_m.shape}"
        raise InputError(f"render returned {found}: expected {(*shape, 3)} and {shape}")
    covered = colour[..., 3] > 0 if colour.shape[2] == 4 else np.ones(shape, bool)
    picture, depth_m = as_pictures(colour, depth_m)
    inverse = inverse_depth_from_metres(depth_m)
    inverse[np.isnan(inverse)] = -1
    return np.dstack([picture, np.uint8(255) * covered]), inverse.astype(np.float32)
