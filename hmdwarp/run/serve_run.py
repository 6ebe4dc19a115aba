"""A renderer for others: draws a scene for clients of the feed, or warps what a server draws."""

from __future__ import annotations

import functools
import time
import traceback
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, closing, nullcontext
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from .. import web
from ..base import AUTO, InputError, MachineError, import_extra, recording_names
from ..client import ClientScene, Plan, build_plan
from ..frames import Frame, Needs
from ..frames.layers import PICTURE, RENDERED, Delivered, EyeSizes, layers
from ..geometry import Pose, View, guarded_eyes
from ..gpu import Gpu, download
from ..link import LinkOptions
from ..link.codec import codecs
from ..pipeline import PipelineOptions
from ..pipeline.channel import SEEN_PX, Changes
from ..pipeline.feed_coding import (
    FOVEA_GRID,
    LIGHT,
    FeedEncoder,
    check_work,
    needs_of_client,
    parts_of,
    sizes_of,
    videos_for_browsers,
    wish_of,
)
from ..pipeline.proxy import KnownHead, Proxy
from ..pipeline.recorded_source import RecordedRenderer, RecordingSource
from ..pipeline.remote import Remote, RemoteFrames
from ..pipeline.source import PoseRequest, Source, nothing
from ..poses import Origin, PoseSample, folded, load_trace
from ..scenes import InputBook, InputEvent, load_scene
from ..sources import sequences
from ..sources.feed import bounds, message
from ..sources.feed.listener import Asked, Listener, listening
from ..sources.feed.options import KeyPair
from ..sources.feed.parts import Layers
from ..sources.repairs import parse_repairs
from ..sources.server import Renderer, Server
from .browser_log import SessionLog
from .options import ProxyRunOptions, ServeOptions
from .run import placed

# Of the encoders of all clients; those of who has waited longest go, and their streams begin anew.
_MOST_CODED_BYTES = 1 << 30
_MOST_UNTOLD = 2 * message.MOST_FATES  # frames of a client that never tells
_NO_CONTENT = np.zeros(0, np.uint8)
AS_RECORDED = "as-recorded"  # the head of recorded frames: where the camera was
_WAIT_MS = 200  # between looks at whether to stop


def serve(
    options: ServeOptions, say: Callable[[str], None] = lambda text: None, goes_on: Callable[[], bool] = lambda: True
) -> None:
    """Draw for clients until interrupted, or until goes_on() says no.

    say: called with each line for the log, first with the address.
    Errors: InputError for wrong options, MachineError for missing hardware or software.
    """
    how = {"is_open": options.open, "per_address": options.per_address}
    listener, secret, pair = listening(options.listen, say, options.token_file, options.key_pair, **how)
    with closing(listener):
        drawing = PipelineOptions(mirrors=options.mirrors, samples=options.samples)
        if options.frames is None:
            source = Source(drawing, load_scene(options.scene, options.scene_options))
        else:
            sequence = sequences.open(options.frames, options.sequence_options)
            source = RecordingSource(sequence.repaired(parse_repairs(options.repair)))
        # Recorded frames are played to their end and back, endlessly.
        moment_of = functools.partial(folded, length_ns=max(source.instants_ns, default=0))
        with Gpu() as gpu, closing(source.renderer(gpu, drawing, moment_of)) as server:
            say(f"listening at {listener.address}: {source.title}")
            with _door(options, listener, source, secret, pair, say) if options.web else nullcontext():
                _answering(listener, server, functools.partial(_drawn, server), goes_on)


# Returns the frame for a request that needs these layers.
Draw = Callable[[Asked, Needs], Frame]


def _answering(listener: Listener, server: Renderer, draw: Draw, goes_on: Callable[[], bool]) -> None:
    """Answer requests until goes_on() says no."""
    answers = _Answers(listener, server, draw)
    while goes_on():
        asked = listener.next(_WAIT_MS)
        if asked is not None:
            try:
                answers.answer(asked)
            except (InputError, MachineError, bounds.OutOfBounds) as error:
                listener.refuse(asked, str(error))
            except Exception as error:  # whatever it is, the next client has its turn
                file, line, *_ = traceback.extract_tb(error.__traceback__)[-1]
                why = f"{type(error).__name__} at {Path(file).name}:{line}: {error}"
                listener.refuse(asked, f"an internal error, please report it ({why})")
            server.take_back()
        if asked is not None or not listener.clients:  # what was drawn for those who have left is freed
            server.trim()


def _door(
    options: ServeOptions,
    listener: Listener,
    source: Source,
    secret: str,
    pair: KeyPair | None,
    say: Callable[[str], None],
) -> AbstractContextManager[object]:
    import_extra("aiohttp", "aiohttp", "web")
    if options.codec != AUTO:
        codecs.get(options.codec).check()
    scene, is_recorded = source.scene, isinstance(source, RecordingSource)
    start, names = scene.viewpoint, [*([AS_RECORDED] if is_recorded else []), *recording_names()]
    about: dict[str, Any] = {
        "scene": scene.name,
        "viewpoint": {"position": start.position_m.tolist(), "orientation": start.orientation_xyzw.tolist()},
        "traces": names,
        "head": names[0] if is_recorded else "hand",
        "videos": videos_for_browsers(),
        "codec": options.codec,
        "most_work": bounds.CODED.most,
        "panels": bool(scene.panels),
    }
    traces = {f"traces/{name}.json": functools.partial(_samples, name, source) for name in names}
    with ExitStack() as opened:
        logs = None
        if options.out is not None:
            logs = opened.enter_context(closing(SessionLog(options.out, say)))
        door = web.Door(
            options.web, listener.address, about | {"reports": logs is not None}, traces, secret=secret, pair=pair,
            certificate=options.certificate, is_open=options.open, log=None if logs is None else logs.begin,
            places=listener.places, say=say
        )  # fmt: skip
        opened.enter_context(closing(door))
        say(f"for a browser: open {door.address}")
        return opened.pop_all()


def _samples(name: str, source: Source) -> dict[str, list[list[float]]]:
    """Return a recording as the page plays it: seconds and pose, moved into the scene."""
    trace = source.head(None if name == AS_RECORDED else load_trace(name))
    assert trace is not None, "there are frames of its own, or a trace"
    track, _ = placed(trace.track, source.scene)
    seconds = (track.time_ns - track.start_ns) * 1e-9
    return {"samples": np.column_stack([seconds, track.position_m, track.orientation_xyzw]).tolist()}


@attrs.define(eq=False)
class _Session:
    """What a client has of layers that build on the frames before, as far as it has told."""

    number: int
    began: int
    # None where every frame is sent.
    changes: Changes | None
    # What both ends remember of each frame whose fate is not told yet, by its id.
    sent: dict[int, Mapping[str, Any]] = attrs.field(factory=dict)
    # What its people did: the scene is theirs alone, as its clock is.
    book: InputBook = attrs.field(factory=InputBook)
    # Whether the log says that nothing reacts to it.
    is_told: bool = False
    # Of one that requests coded frames.
    encoder: FeedEncoder | None = None

    def remember(self, number: int, frame: Frame) -> None:
        """Remember a frame that is about to be sent, without its content."""
        light = {
            layer.name: {each: attrs.evolve(update, content=_NO_CONTENT) for each, update in data.items()}
            for layer, data in frame.eyes[0].contents()
            if issubclass(layer, Delivered)
        }
        if light:
            self.sent[number] = light
        while len(self.sent) > _MOST_UNTOLD:
            del self.sent[next(iter(self.sent))]


class _Answers:
    """Frames for the clients, each with its session as long as it is connected."""

    def __init__(self, listener: Listener, server: Renderer, draw: Draw) -> None:
        self._listener, self._server, self._draw = listener, server, draw
        # By client, who was answered last at the end.
        self._sessions: dict[bytes, _Session] = {}

    def _session(self, asked: Asked) -> _Session:
        """Return the session of a request, once what it tells of earlier frames is known."""
        server, sessions = self._server, self._sessions
        for gone in [who for who in sessions if who not in self._listener.clients]:
            server.forget(gone)
            del sessions[gone]
        told, found = asked.ask.session or message.Session(0), sessions.pop(asked.client, None)
        if found is None or found.number != told.number:
            server.begin_anew(asked.client)
            changes = Changes(server.scene, server.content) if told.only_changes else None
            encoder = None if found is None else found.encoder
            found = _Session(told.number, asked.ask.number, changes, encoder=encoder)
        sessions[asked.client] = found
        if (log := server.scene.inputs) is not None:  # the scene turns to the session's history
            bounds.KEPT_INPUTS.check(len(found.book) + len(asked.ask.inputs))
            log.book = found.book
            for event in asked.ask.inputs:
                log.add(event)
        for fate in told.fates:
            if fate.number in found.sent:
                server.heard_of(asked.client, found.sent.pop(fate.number), fate.arrived, fate.heard_ns)
        return found

    def answer(self, asked: Asked) -> None:
        """Draw and send, unless it would show nothing new. Errors: any of drawing for it."""
        server, listener, ask = self._server, self._listener, asked.ask
        most = server.gpu.max_texture_size
        begun_ns = time.monotonic_ns()
        is_recorded = isinstance(server, RecordedRenderer)
        needs = needs_of_client(None if is_recorded else ask.wanted)
        fovea = None if is_recorded else ask.fovea
        if max(ask.size) > most:
            size = f"{ask.size[0]}x{ask.size[1]}"
            raise InputError(f"a picture of {size}: the server's GPU has at most {most} pixels a side")
        _check_bytes(ask, needs, is_software=server.gpu.is_software)
        check_work(ask)
        session = self._session(asked)
        changes = session.changes
        may_stay = changes is not None and not ask.anew and not server.has_more(ask.time_ns, asked.client)
        if changes is not None and may_stay and changes.moved_px(ask.views, ask.time_ns) <= SEEN_PX:
            listener.leave_out(asked)
            return
        look = Needs() if fovea is None else Needs(foveated=fovea, foveated_depth=fovea)
        frame = self._draw(asked, needs | look)
        if changes is not None:
            changes.sent(frame)
        session.remember(ask.number, frame)
        if ask.inputs and not session.is_told and not server.reacts_to(asked.client):
            session.is_told = True
            listener.tell(asked, f"its inputs are left out: {server.scene.name} does not react to what people do")
        server.gpu.wait()
        packs = not {ask.wish.colour, ask.wish.depth} <= {message.ANY, message.NONE, message.RGBA8, message.DEPTH_CODES}
        further = parts_of(frame, needs, packs=packs) if needs else ()
        sent = frame
        if fovea is not None:
            sent, grids, ask = _coarser(frame, ask)
            further = tuple(
                {**of_eye, **grid} for of_eye, grid in zip(further or ({},) * len(grids), grids, strict=True)
            )
        pictures = list(_pictures(server, sent, ask))
        views = tuple(eye.view for eye in frame.eyes) if is_recorded else ask.views
        server.recycle(frame)
        colours, depths = (tuple(of_eye) for of_eye in zip(*pictures, strict=True))
        times = (ask.number, ask.sent_ns, asked.received_ns, 0, 0, frame.shows_ns)
        takes: dict[str, Any] = dict.fromkeys(("takes_hidden", "takes_session"), True)
        takes |= {"takes_fovea": not is_recorded, "takes_inputs": server.reacts_to(asked.client)}
        began = session.began & 0xFFFF
        drawn = message.FrameMessage(*times, views, colours, depths, layers=further, began=began, **takes)
        coded = self._coded(session, ask, drawn)
        sent_ns = time.monotonic_ns()
        listener.answer(asked, attrs.evolve(coded, sent_ns=sent_ns, render_ns=sent_ns - begun_ns))

    def _coded(self, session: _Session, ask: message.Ask, frame: message.FrameMessage) -> message.FrameMessage:
        """Return the frame as its client would have it. Errors: MachineError without the codec."""
        encoder, session.encoder = session.encoder, None  # none where it fails: its eyes may be at different places
        if encoder is None or not encoder.suits(ask):
            encoder = FeedEncoder(ask)
        coded, session.encoder = encoder.encode(frame), encoder
        every = [one for one in self._sessions.values() if one.encoder is not None]
        while sum(one.encoder.bytes for one in every if one.encoder) > _MOST_CODED_BYTES and len(every) > 1:
            every.pop(0).encoder = None
        return coded


def _check_bytes(ask: message.Ask, needs: Needs, *, is_software: bool) -> None:
    """Check what a frame will weigh. Errors: InputError, bounds.OutOfBounds."""
    of_eye = 13 * ask.size[0] * ask.size[1]
    if ask.wanted is not None:
        # A layer of its own size follows from either picture.
        drawn = EyeSizes(ask.size, ask.size, tuple(view.fov for view in ask.views))
        for name, amount in needs.items():
            layer = layers.get(name)
            count = max(layer.bytes(amount, sizes) for sizes in (sizes_of(ask.wanted, ask.size), drawn))
            if layer.size_class != RENDERED and count > bounds.most_beside(ask.size):
                raise InputError(
                    f"a layer '{name}' of {count:.3g} bytes beside {ask.size[0]}x{ask.size[1]} pixels: expected at "
                    f"most {bounds.most_beside(ask.size):.3g}"
                )
            of_eye += count + layer.kept_bytes(amount)
    (bounds.DRAWN_BY_CPU if is_software else bounds.UNPACKED).check(len(ask.views) * of_eye)


def _drawn(server: Renderer, asked: Asked, needs: Needs) -> Frame:
    ask = asked.ask
    reads = {ask.wish.colour, ask.wish.depth} != {message.NONE} or any(not layers.get(name).per_frame for name in needs)
    if ask.wanted is None or not isinstance(server, Server):
        return server.draw_frame(ask.views, ask.time_ns, ask.size, needs=needs, pictures=reads)
    age_ns = ask.session.age_ns if ask.session is not None else 0
    form = (ask.size, needs, ask.wanted.fovs, ask.wanted.size)
    return server.draw_guarded(ask.views, ask.time_ns, *form, age_ns=age_ns, client=asked.client, pictures=reads)


def _coarser(frame: Frame, ask: message.Ask) -> tuple[Frame, tuple[Layers, ...], message.Ask]:
    """Return a frame of foveated pictures, their grids, and a request of that size."""
    seen = [(eye["foveated"], eye["foveated_depth"]) for eye in frame.eyes]
    small = seen[0][0].grid.small
    if any(colour.grid.small != small for colour, _ in seen):
        raise InputError("a fovea for eyes whose fields of view differ: the eyes' pictures would have two sizes")
    eyes = zip(frame.eyes, seen, strict=True)
    coarse = [attrs.evolve(eye, colour=one.texture, inverse_depth=depth.texture) for eye, (one, depth) in eyes]
    grids = tuple({FOVEA_GRID: [one.grid.numbers()]} for one, _ in seen)
    return attrs.evolve(frame, eyes=tuple(coarse)), grids, attrs.evolve(ask, size=small)


def _pictures(server: Renderer, frame: Frame, ask: message.Ask) -> Iterator[list[message.Picture]]:
    colour, depth = ask.wish.colour, ask.wish.depth
    for eye in frame.eyes:
        as_bytes = colour in message.BYTES and LIGHT not in eye  # which keep no light beyond 1
        half = server.give_codes(eye) if as_bytes or depth == message.DEPTH_CODES else None
        yield [
            b"" if colour == message.NONE else half[0] if half and as_bytes else download(eye.colour),
            b""
            if depth == message.NONE
            else message.DepthCodes(*half[1:])
            if half and depth == message.DEPTH_CODES
            else download(eye.inverse_depth),
        ]


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
        _answering(listener, server, server.draw_asked, goes_on)


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

    def _client(self, who: Hashable, ask: message.Ask) -> _Client:
        form = ask.size, tuple(view.fov for view in ask.views)
        if who in self._clients and self._clients[who].form != form:
            self.forget(who)
        if who not in self._clients:
            self._clients[who] = self._opened(form, ask)
        return self._clients[who]

    def _opened(self, form: tuple[Any, ...], ask: message.Ask) -> _Client:
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
            remote.wish = wish_of(
                message.RAW[options.feed.raw], options.coding, rate_hz, ask.views, ask.size, 1 / rate_hz
            )
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
