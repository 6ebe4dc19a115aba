"""A renderer for others: draws a scene for whoever asks over the feed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import TYPE_CHECKING

import attrs

from ..errors import InputError, MachineError
from ..feed.key_pairs import key_pair
from ..feed.listener import Asked, Listener
from ..feed.message import MOST_BYTES, FrameMessage
from ..feed.options import secret_in
from ..gpu.context import Gpu
from ..gpu.textures import download
from ..pipeline.feed_coding import FeedEncoder
from ..scenes import load_scene
from ..server import Server
from .serve_options import ServeOptions

if TYPE_CHECKING:
    from ..frames import Frame

_WAIT_MS = 200  # between looks at whether to stop


def serve(
    options: ServeOptions,
    say: Callable[[str], None] = lambda text: None,
    goes_on: Callable[[], bool] = lambda: True,
) -> None:
    """Draw for clients until interrupted, or until goes_on() says no.

    say: called with each line for the log, first with the address.
    Errors: InputError for wrong options, MachineError for missing hardware or software.
    """
    secret, pair = secret_in(options.token_file), None
    if options.key_pair is not None:
        pair, is_new = key_pair(options.key_pair)
        if is_new:
            say(f"made {options.key_pair}.key_secret, which stays here, and {options.key_pair}.key, which clients need")
    with closing(Listener(options.listen, secret, pair, is_open=options.open, say=say)) as listener:
        scene = load_scene(options.scene, options.scene_options)
        with Gpu() as gpu, closing(Server(gpu, scene, options.mirrors)) as server:
            say(f"listening at {listener.address}: scene '{scene.name}'")
            coders = _Coders(listener)
            while goes_on():
                asked = listener.next(_WAIT_MS)
                if asked is not None:
                    _answer(server, listener, coders, asked)


class _Coders:
    """The streams of the clients that asked for coded frames, as long as they are here."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self._of: dict[bytes, FeedEncoder] = {}

    def coded(self, asked: Asked, frame: FrameMessage) -> FrameMessage:
        """Return the frame as its client would have it. Errors: MachineError without the codec."""
        for gone in [who for who in self._of if who not in self._listener.clients]:
            del self._of[gone]
        found = self._of.get(asked.client)
        if found is None or not found.suits(asked.ask):
            found = self._of[asked.client] = FeedEncoder(asked.ask)
        return found.encode(frame)


def _answer(server: Server, listener: Listener, coders: _Coders, asked: Asked) -> None:
    ask, most = asked.ask, server.gpu.max_texture_size
    pixels = len(ask.views) * ask.size[0] * ask.size[1]
    if max(ask.size) > most or 13 * pixels > MOST_BYTES:
        listener.refuse(asked, f"{ask.size[0]}x{ask.size[1]} pixels are too many")
        return
    begun_ns = time.monotonic_ns()
    try:
        frame = server.draw_frame(ask.views, ask.time_ns, ask.size)
    except InputError as error:
        listener.refuse(asked, str(error))
        return
    pictures = list(_pictures(frame))
    server.recycle(frame)
    colours, depths = (tuple(one) for one in zip(*pictures, strict=True))
    drawn = FrameMessage(ask.number, ask.sent_ns, asked.received_ns, 0, 0, ask.time_ns, ask.views, colours, depths)
    try:
        coded = coders.coded(asked, drawn)
    except MachineError as error:
        listener.refuse(asked, str(error))
        return
    sent_ns = time.monotonic_ns()
    listener.answer(asked, attrs.evolve(coded, sent_ns=sent_ns, render_ns=sent_ns - begun_ns))


def _pictures(frame: Frame) -> Iterator[tuple]:
    for eye in frame.eyes:
        yield download(eye.colour), download(eye.inverse_depth)
