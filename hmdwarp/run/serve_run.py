"""A renderer for others: draws a scene for whoever asks over the feed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import TYPE_CHECKING

from ..errors import InputError
from ..feed.key_pairs import key_pair
from ..feed.listener import Asked, Listener
from ..feed.message import MOST_BYTES, FrameMessage
from ..feed.options import secret_in
from ..gpu.context import Gpu
from ..gpu.textures import download
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
            while goes_on():
                asked = listener.next(_WAIT_MS)
                if asked is not None:
                    _answer(server, listener, asked)


def _answer(server: Server, listener: Listener, asked: Asked) -> None:
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
    sent_ns = time.monotonic_ns()
    listener.answer(
        asked,
        FrameMessage(
            ask.number,
            ask.sent_ns,
            asked.received_ns,
            sent_ns,
            sent_ns - begun_ns,
            ask.time_ns,
            ask.views,
            colours,
            depths,
        ),
    )


def _pictures(frame: Frame) -> Iterator[tuple]:
    for eye in frame.eyes:
        yield download(eye.colour), download(eye.inverse_depth)
