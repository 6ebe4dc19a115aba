"""A renderer for others: draws a scene for clients of the feed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MachineError
from ..frames import Frame, Needs
from ..frames.layers import layers
from ..gpu.context import Gpu
from ..gpu.textures import download
from ..pipeline.feed_coding import FeedEncoder
from ..pipeline.feed_layers import needs_of_client, parts_of, sizes_of
from ..scenes import load_scene
from ..sources.feed.key_pairs import key_pair
from ..sources.feed.listener import Asked, Listener
from ..sources.feed.message import ANY, MOST_BYTES, NONE, Ask, FrameMessage
from ..sources.feed.options import secret_in
from ..sources.server import Server
from .serve_options import ServeOptions

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
    """The streams of the clients that request coded frames, as long as they are connected."""

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
    begun_ns = time.monotonic_ns()
    try:
        needs = needs_of_client(ask.wanted)
        if max(ask.size) > most or _bytes_of(ask, needs) > MOST_BYTES:
            raise InputError(f"{ask.size[0]}x{ask.size[1]} pixels are too many")
        frame = _drawn(server, ask, needs)
    except InputError as error:
        listener.refuse(asked, str(error))
        return
    pictures = list(_pictures(frame, ask))
    packs = not {ask.wish.colour, ask.wish.depth} <= {ANY, NONE}
    further = tuple(parts_of(eye, needs, packs=packs) for eye in frame.eyes) if needs else ()
    server.recycle(frame)
    colours, depths = (tuple(of_eye) for of_eye in zip(*pictures, strict=True))
    times = (ask.number, ask.sent_ns, asked.received_ns, 0, 0, ask.time_ns)
    drawn = FrameMessage(*times, ask.views, colours, depths, layers=further)
    try:
        coded = coders.coded(asked, drawn)
    except MachineError as error:
        listener.refuse(asked, str(error))
        return
    sent_ns = time.monotonic_ns()
    listener.answer(asked, attrs.evolve(coded, sent_ns=sent_ns, render_ns=sent_ns - begun_ns))


def _bytes_of(ask: Ask, needs: Needs) -> int:
    """Return the bytes of a frame, or a little more."""
    of_eye = 13 * ask.size[0] * ask.size[1]
    if ask.wanted is not None:
        sizes = sizes_of(ask.wanted, ask.size)
        of_eye += sum(layers.get(name).bytes(amount, sizes) for name, amount in needs.items())
    return len(ask.views) * of_eye


def _drawn(server: Server, ask: Ask, needs: Needs) -> Frame:
    if ask.wanted is None:
        return server.draw_frame(ask.views, ask.time_ns, ask.size)
    return server.draw_guarded(ask.views, ask.time_ns, ask.size, needs, ask.wanted.fovs, ask.wanted.size)


def _pictures(frame: Frame, ask: Ask) -> Iterator[list[NDArray[np.floating] | bytes]]:
    wishes = (ask.wish.colour, ask.wish.depth)
    for eye in frame.eyes:
        both = zip((eye.colour, eye.inverse_depth), wishes, strict=True)
        yield [download(texture) if wish != NONE else b"" for texture, wish in both]
