"""A proxy as a process of its own: it warps a server's frames for clients that only show them."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Hashable
from contextlib import ExitStack, closing
from typing import Any

import attrs

from ..client.client_scene import ClientScene
from ..client.plan import Plan, build_plan
from ..errors import InputError, MachineError
from ..frames import Frame, Needs
from ..frames.layers import PICTURE
from ..geometry import Pose, View, guarded_eyes
from ..gpu.context import Gpu
from ..link import LinkOptions
from ..pipeline.feed_coding import wish_of
from ..pipeline.proxy import KnownHead, Proxy
from ..pipeline.remote import Remote, RemoteFrames
from ..pipeline.source import PoseRequest, nothing
from ..poses import Origin, PoseSample
from ..scenes import InputEvent
from ..sources.feed.listener import Asked, listening
from ..sources.feed.message import RAW, Ask
from ..sources.server import Renderer
from .options import ProxyRunOptions
from .serve_run import answering

# For the first frame, and between looks at whether it is there.
_FIRST_NS, _LOOK_S = 30_000_000_000, 0.005


def proxy(
    options: ProxyRunOptions,
    say: Callable[[str], None] = lambda text: None,
    goes_on: Callable[[], bool] = lambda: True,
) -> None:
    """Warp for clients until interrupted, or until goes_on() says no.

    say: called with each line for the log, first with the address.
    Errors: InputError for wrong options, MachineError for missing hardware or software.
    """
    plan = build_plan((), options.warp, options.fill, "none", client_geometry=False)
    how = {"is_open": options.open, "per_address": options.per_address}
    listener, _, _ = listening(options.listen, say, options.token_file, options.key_pair, **how)
    with closing(listener), Gpu() as gpu, closing(_Warping(gpu, options, plan, say)) as server:
        say(f"listening at {listener.address}: a proxy for {options.feed.connect}, {options.warp} + {options.fill}")
        answering(listener, server, server.draw_asked, goes_on)


@attrs.define(eq=False)
class _AskedEyes:
    """The views of the request that is answered."""

    asked: tuple[View, ...]

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        return self.asked


@attrs.define(eq=False)
class _Client:
    """The session with the server for one client, and what warps its frames."""

    form: tuple[Any, ...]
    eyes: _AskedEyes
    remote: Remote
    proxy: Proxy
    made: ExitStack
    # What its people did, as far as the server was told.
    acted: set[InputEvent] = attrs.field(factory=set)
    # Why the server drew nothing, until the client knows.
    refused: deque[str] = attrs.field(factory=deque)


class _Warping(Renderer):
    """Frames for clients: the server's newest, warped to the views that are asked for."""

    def __init__(self, gpu: Gpu, options: ProxyRunOptions, plan: Plan, say: Callable[[str], None]) -> None:
        super().__init__(gpu, nothing("proxy", f"what {options.feed.connect} draws"))
        self._options, self._plan, self._say = options, plan, say
        self._clients: dict[Hashable, _Client] = {}
        self._out: dict[int, _Client] = {}

    def draw_asked(self, asked: Asked, needs: Needs) -> Frame:
        """Return the picture for a request. Errors: InputError, MachineError."""
        ask = asked.ask
        if needs:
            raise InputError(
                f"a proxy sends the finished picture, and no {', '.join(needs)}: show it by --warp none or rotation"
            )
        client = self._client(asked.client, ask)
        head = ask.views[0].pose @ ask.views[0].head_from_eye.inverse()
        client.eyes.asked = ask.views
        if client.remote.takes_inputs and (new := [event for event in ask.inputs if event not in client.acted]):
            client.remote.act(new)
            client.acted.update(new)
        until_ns = time.monotonic_ns() + _FIRST_NS
        while (now_ns := time.monotonic_ns()) < until_ns:
            shift_ns = ask.time_ns - now_ns
            client.remote.scene_ns = lambda own_ns, shift_ns=shift_ns: own_ns + shift_ns  # type: ignore[misc]
            frame = client.proxy.draw(PoseSample(now_ns, head, Origin.HELD), now_ns)
            if client.refused:
                if frame is not None:
                    client.proxy.recycle(frame)
                raise InputError(client.refused.popleft())
            if frame is not None:
                self._out[id(frame)] = client
                return frame
            time.sleep(_LOOK_S)
        raise MachineError(f"no frame from {self._options.feed.connect}")

    def _client(self, who: Hashable, ask: Ask) -> _Client:
        form = ask.size, tuple(view.fov for view in ask.views)
        if who in self._clients and self._clients[who].form != form:
            self.forget(who)
        if who not in self._clients:
            self._clients[who] = self._opened(form, ask)
        return self._clients[who]

    def _opened(self, form: tuple[Any, ...], ask: Ask) -> _Client:
        options, plan, rate_hz = self._options, self._plan, ask.wish.rate_hz
        refused: deque[str] = deque(maxlen=1)

        def say(line: str) -> None:
            self._say(line)
            if ": refused: " in line:
                refused.append(line)

        if plan.needs.others.other_eye and len(ask.views) < 2:
            raise InputError(f"the proxy's warp {options.warp} looks into the other eye's picture: there is one eye")
        rendered = guarded_eyes(ask.views, options.guard, ask.size)[1]
        pictures = frozenset(PICTURE) & frozenset(plan.layers)
        with ExitStack() as stack:
            remote = Remote(options.feed, holds=False, say=say)
            stack.callback(remote.close)
            remote.pictures = pictures
            remote.wish = wish_of(RAW[options.feed.raw], options.coding, rate_hz, ask.views, ask.size, 1 / rate_hz)
            now_ns = time.monotonic_ns()
            remote.scene_ns = lambda own_ns: own_ns + ask.time_ns - now_ns
            head = PoseSample(now_ns, ask.head, Origin.HELD)
            latency_ns = remote.measure(head, ask.views, options.guard, ask.size, plan.needs)
            eyes, known = _AskedEyes(ask.views), KnownHead()
            geometry = ClientScene(self)
            stack.callback(geometry.close)
            request = PoseRequest(
                known, None, ask.size, options.guard, plan.needs, age_ns=latency_ns, pictures=pictures
            )
            frames = RemoteFrames(remote, self, request, eyes)
            link = (LinkOptions(), latency_ns, rate_hz, None)
            made = Proxy(frames, geometry, request, plan, eyes, rendered, link, {}, stack)
            return _Client(form, eyes, remote, made, stack.pop_all(), refused=refused)

    def recycle(self, frame: Frame) -> None:
        if id(frame) in self._out:
            self._out.pop(id(frame)).proxy.recycle(frame)
        else:
            super().recycle(frame)

    def take_back(self) -> None:
        """Do nothing: the links hold frames."""

    def reacts_to(self, client: Hashable) -> bool:
        """Return whether what the server draws reacts to what a client's people do."""
        return client in self._clients and self._clients[client].remote.takes_inputs

    def begin_anew(self, client: Hashable) -> None:
        """Go on where nobody acted: pictures build on none, and calling again takes seconds."""
        if client in self._clients and self._clients[client].acted:
            self.forget(client)

    def forget(self, client: Hashable) -> None:
        """Hang up for a client that has gone."""
        if client in self._clients:
            self._clients.pop(client).made.close()

    def close(self) -> None:
        """Hang up, and free everything."""
        for who in list(self._clients):
            self.forget(who)
        super().close()
