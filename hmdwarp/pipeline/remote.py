"""A server elsewhere as a source: its frames come by the feed, as old as they then are.

And so does the truth. The loop is the same one: requests go out where frames would be drawn, and a
frame that has arrived enters the link with the delay that was measured.
"""

from __future__ import annotations

import math
import time
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any

import attrs
import numpy as np

from ..base import HmdwarpError, InputError, MachineError, counted
from ..frames import EyeImage, Frame, Needs
from ..frames.layers import PICTURE, layers
from ..frames.layers.pictures import FoveatedPicture
from ..geometry import Eyes, Guard, Pose, View, guarded_eyes, looking
from ..gpu import COLOUR, SCALAR, Gpu
from ..link import CHANGES, TransitStats
from ..link.codec import Undecodable
from ..poses import PoseSample
from ..poses.track import Moment
from ..scenes import InputEvent, Scene
from ..sources.feed import bounds, message
from ..sources.feed.caller import Caller, Viewer
from ..sources.feed.message import Ask, Fate, FrameMessage, Session, Wish
from ..sources.feed.options import FULL, FeedOptions, public_key, secret_in
from ..sources.feed.parts import length_of as part_bytes
from ..sources.server import Renderer, Target
from . import feed_coding
from .channel import Channel, Reads, Way
from .feed_coding import depth_error
from .options import REMOTE, SERVER_SCENE, PipelineOptions
from .source import FrameSource, MomentOf, Options, PoseRequest, Source, nothing
from .source import Target as Shown

# Requests whose answers say how long the way is; the first also waits for the server's set-up.
_TRIALS = 6
_ANSWER_NS, _AGAIN_NS = 30_000_000_000, 1_000_000_000
_TELL_NS = 1_500_000_000
# Kinds of frames that are left out, each with a line.
_MOST_TOLD = 20
# Requests that may be without an answer; what is older is never answered.
_MOST_PENDING = 4096
Size = tuple[int, int]
_NO_PICTURE = (1, 1)  # asked for where nothing reads the eyes' pictures: a frame always has some


@attrs.define(eq=False)
class Request:
    """A request for a frame, and the frame once it has come."""

    ask: Ask
    head: PoseSample
    drawn_ns: int  # on the loop's clock
    sent_ns: int  # on this machine's
    # (w, h) of one eye's picture as it comes: smaller than asked for where it is foveated.
    size: Size
    acted: range  # which inputs it told the server
    # As it came, how long after the request the loop had it, and what was made of it.
    message: FrameMessage | None = None
    took_ns: int = 0
    frame: Frame | None = None


class Remote:
    """The session with a server elsewhere.

    holds: the loop waits, at each refresh, until it is known what has arrived by then; for loops
    that run on a clock of their own. keeps: delays_ns has every frame's. say: called with each line
    about the connection.
    Errors: as Caller, and InputError for a secret that cannot be read.
    """

    def __init__(
        self, feed: FeedOptions, *, holds: bool, keeps: bool = False, say: Callable[[str], None] = lambda text: None
    ) -> None:
        self._caller = Caller(feed.connect, secret_in(feed.token_file), public_key(feed.server_key))
        self.keeps, self._holds, self._say = keeps, holds, say
        self.added_ns = round(feed.added_latency_ms * 1e6)  # emulated latency behind the real network's
        self._number = 0
        self._pending: dict[int, Request] = {}
        self._heard_ns = time.monotonic_ns()
        self._lost_ns: int | None = None  # when frames stopped coming; None while they come
        self._losses = self._away_ns = 0
        self.unanswered = self.refused = self.undecodable = 0
        self._decoder, self._anew_number = feed_coding.FeedDecoder(), 0
        # What was wrong with the layers of the last frame that was left out, and what was said.
        self._misfit, self._draws_others = "", False
        self._told: set[str] = set()
        # How frames are to be coded; raw until it is set.
        self.wish, self.format = Wish(), message.ANY  # the format is that of the colour that came last
        self.pictures = frozenset(PICTURE)  # what is read of the eyes' pictures; the rest is not sent
        self._paced: tuple[int, int] | None = None
        self._told_ns: int | None = None  # the last instant for which the loop knows what had arrived
        # Of each frame in the order of drawing, in ns: the instant it was drawn for, and its delay.
        self.delays_ns: list[tuple[int, int]] = []
        # What the server does, as its frames say: leave out what is hidden, take a session, draw
        # foveated frames, and react to inputs.
        self._takes_hidden = self._takes_session = self._takes_fovea = self.takes_inputs = False
        # What is told in a session until a request that told it has been answered.
        self._session = 0
        self._fates: dict[int, Fate] = {}
        self.age_ns, self.only_changes = 0, False
        self.unchanged = 0  # requests of this session to which nothing had changed
        # The scene's clock at an instant of the loop's.
        self.scene_ns: Callable[[int], int] = lambda now_ns: now_ns
        # What people did, oldest first, and how many of these the server is known to have.
        self._acted: list[InputEvent] = []
        self._known_inputs, self._began = 0, -1
        # Whether the link knows of a frame that is missing.
        self.needs_key: Callable[[int], bool] = lambda now_ns: False

    def ask(
        self, head: PoseSample, views: Sequence[View], guard: Guard, size: Size, now_ns: int, needs: Needs | None = None
    ) -> None:
        """Ask for a frame of these eyes at that instant of the loop's clock, with needed layers."""
        fovs, grown = guarded_eyes(views, guard, size)
        fovea, stand_for, rest = feed_coding.fovea_of(needs or Needs())
        read = self.pictures | stand_for
        grown = grown if read else _NO_PICTURE
        wide = tuple(view.within(fov) for view, fov in zip(views, fovs, strict=True))
        if not self._takes_hidden:  # it draws all of it, or has not said yet
            wide = tuple(attrs.evolve(view, hidden=None) for view in wide)
        self._number += 1
        # Requested once, and again only if that request will have no answer.
        anew = (self._decoder.wants_anew or self.needs_key(now_ns)) and self._anew_number not in self._pending
        if anew:
            self._anew_number = self._number
        times = (self._number, 0, self.scene_ns(now_ns), self.scene_ns(head.time_ns), 0)
        session = None
        if self._takes_session:  # with the fates heard of by now
            due = [fate for fate in self._fates.values() if fate.heard_ns <= now_ns][: message.MOST_FATES]
            session = Session(self._session, self.age_ns, self.only_changes, tuple(due))
        fovea = fovea if self._takes_fovea else None
        known = acted = self._known_inputs
        if self.takes_inputs:
            until = bisect_right(self._acted, times[2], key=lambda event: event.time_ns)
            acted = min(until, known + message.MOST_INPUTS)
        kinds = zip(("colour", "depth"), PICTURE, strict=True)
        left_out = {kind: message.NONE for kind, name in kinds if name not in read}
        more: dict[str, Any] = {"wish": attrs.evolve(self.wish, **left_out), "inputs": tuple(self._acted[known:acted])}
        more |= {"wanted": feed_coding.wanted_of(rest, views, size), "session": session, "fovea": fovea, "anew": anew}
        ask = Ask(*times, grown, head.pose, wide, **more)
        small = grown if fovea is None else fovea.grid(wide[0], grown).small
        told = range(known, acted)
        self._pending[self._number] = Request(ask, head, now_ns, self._caller.ask(ask), small, told)
        while len(self._pending) > _MOST_PENDING:
            self._unanswer(self._pending.pop(next(iter(self._pending))))

    def act(self, events: Iterable[InputEvent]) -> None:
        """Send what people did with the requests of later instants, until the server has it.

        Errors: InputError where nothing there reacts, or once it is too much for a session.
        """
        if not self.takes_inputs:
            raise InputError(f"what {self._caller.address} draws does not react to what people do")
        self._acted += events
        if len(self._acted) > bounds.KEPT_INPUTS.most:
            raise InputError(f"{len(self._acted)} inputs: a server keeps {bounds.KEPT_INPUTS.most:g} of a session")

    def tell(self, of: Request, *, arrived: bool, heard_ns: int) -> None:
        """Tell the server of a frame's fate, from that instant on, where layers build on it."""
        if any(layers.get(name).builds_on_frames for name, _ in (of.ask.wanted.layers if of.ask.wanted else ())):
            self._fates[of.ask.number] = Fate(of.ask.number, arrived, heard_ns)

    def _unanswer(self, request: Request) -> None:
        """Note that a request will not be answered by a frame that can be shown."""
        self.unanswered += 1
        self.tell(request, arrived=False, heard_ns=request.drawn_ns)

    def _answered(self, number: int) -> Request:
        """Take a request that was answered: what it told is known there."""
        request = self._pending.pop(number)
        for fate in request.ask.session.fates if request.ask.session else ():
            if self._fates.get(fate.number) == fate:
                del self._fates[fate.number]
        if request.acted.start <= self._known_inputs:  # not where the server has forgotten those before, too
            self._known_inputs = max(self._known_inputs, request.acted.stop)
        return request

    def measure(self, head: PoseSample, views: Sequence[View], guard: Guard, size: Size, needs: Needs) -> int:
        """Return the longest time in ns from a request to its frame, of a few.

        Errors: InputError where the server refuses, or sends no needed layer; MachineError where
        nothing answers.
        """
        place, took, again_ns = f"--connect {self._caller.address}", list[int](), 0
        until_ns = time.monotonic_ns() + _ANSWER_NS
        while len(took) < _TRIALS:
            if (now_ns := time.monotonic_ns()) >= until_ns:
                remedy = "start 'hmdwarp serve' there, check the address, and read what it has printed"
                raise MachineError(f"{place}: no frame in {_ANSWER_NS // 10**9} s: {remedy}")
            if now_ns >= again_ns:  # also after a while: there may have been no connection
                self.ask(head, views, guard, size, head.time_ns, needs)
                again_ns = now_ns + _AGAIN_NS
            self._caller.wait_until(min(again_ns, until_ns))
            for line in self._caller.lines():
                if "refused" in line:
                    raise InputError(f"--connect {line}")
                self._say(line)
            answered = next((one for one in self._known() if self.decoded(one) is not None), None)
            if answered is None and self._misfit:
                raise InputError(f"{place}: {self._misfit}: use --effects none, or another warp or fill")
            if answered is not None and feed_coding.fovea_of(needs)[0] is not None and not self._takes_fovea:
                raise InputError(f"{place} --fovea: that server sends whole frames alone; leave it out")
            if answered is not None:
                took.append(answered.took_ns)
                again_ns, until_ns = 0, time.monotonic_ns() + _ANSWER_NS
        self.forget()
        self.delays_ns.clear()
        self.unanswered = 0
        self._decoder.wants_anew = True
        return max(took[1:])

    def forget(self) -> None:
        """Leave out the answers to all requests so far, for another loop: a session begins."""
        self._pending.clear()
        self._fates.clear()
        self._session += 1
        self.unchanged = self._known_inputs = 0

    def pace(self, now_ns: int) -> None:
        """Wait so that refreshes come no faster than on the display, where the loop holds."""
        if self._holds:
            clock_ns = time.monotonic_ns()
            shown_ns, then_ns = self._paced or (now_ns, clock_ns)
            wait_ns = max(0, then_ns + now_ns - shown_ns - clock_ns)
            time.sleep(wait_ns * 1e-9)
            self._paced = now_ns, clock_ns + wait_ns

    def arrived(self, now_ns: int) -> list[Request]:
        """Return what has arrived since the last call, oldest first.

        Where the loop holds, what has not arrived when this returns arrives later than `now_ns`.
        """
        found = self._known()
        while self._holds and self._pending:
            latest_ns = max(request.sent_ns + now_ns - request.drawn_ns for request in self._pending.values())
            if time.monotonic_ns() >= latest_ns:
                break
            self._caller.wait_until(latest_ns)
            found += self._known()
        self._told_ns = now_ns
        for line in self._caller.lines():
            self._say(line)
        # No frame is missed before it is requested, so none while a pipeline is built.
        since_ns = max(self._heard_ns, next((request.sent_ns for request in self._pending.values()), 0))
        silent_ns = time.monotonic_ns() - since_ns
        if self._lost_ns is not None and self._heard_ns > self._lost_ns:
            self._say(f"{self._caller.address}: frames come again")
            self._away_ns += self._heard_ns - self._lost_ns
            self._lost_ns = None
        elif self._lost_ns is None and self._pending and silent_ns >= _TELL_NS:
            self._say(f"{self._caller.address}: no frame for {silent_ns / 1e9:.1f} s; the last one stays")
            self._lost_ns = since_ns
            self._losses += 1
        return found

    def _known(self) -> list[Request]:
        """Return the requests that are answered by now, their frames not decoded yet.

        Frames come in order, so requests before one that is answered never will be.
        """
        found = []
        for number in self._caller.take_unchanged():
            if number in self._pending:
                self._answered(number)
                self._heard_ns = time.monotonic_ns()
                self.unchanged += 1
        for arrival in self._caller.take():
            frame = arrival.frame
            if frame.number not in self._pending:
                continue
            for older in [sent for sent in self._pending if sent < frame.number]:
                self._unanswer(self._pending.pop(older))
            request = self._answered(frame.number)
            if frame.size != request.size or len(frame.views) != len(request.ask.views):
                self.refused += 1
                self._leave_out("another size or number of eyes than requested", "")
                self.tell(request, arrived=False, heard_ns=request.drawn_ns)
                continue
            self._heard_ns, self.format = arrival.heard_ns, frame.colour
            if self._acted and self.takes_inputs and not frame.takes_inputs:  # another server in its place
                self._say(f"{self._caller.address}: it does not react any more: what people do is left out")
            self._takes_hidden, self._takes_session = frame.takes_hidden, frame.takes_session
            self._takes_fovea, self.takes_inputs = frame.takes_fovea, frame.takes_inputs
            if frame.began != self._began:  # it knows nothing of what it was sent before
                self._began, self._known_inputs = frame.began, 0
            if request.acted.start > self._known_inputs:  # a scene without what people did before
                self._unanswer(request)
                continue
            request.message, request.took_ns = frame, arrival.heard_ns - request.sent_ns
            if self._told_ns is not None:
                # It came in just before a refresh that was shown without it: handed over after.
                request.took_ns = max(request.took_ns, self._told_ns + 1 - request.drawn_ns)
            found.append(request)
            if feed_coding.stands_alone(frame):  # until it turns out that it is damaged
                self._decoder.wants_anew = False
        return found

    def decoded(self, request: Request) -> FrameMessage | None:
        """Return a frame that came, decoded; None for one that is none, which is counted."""
        frame, ask = request.message, request.ask
        assert frame is not None
        try:
            grids = feed_coding.grids_of(frame, ask.size) if ask.fovea else ()
            decoded = self._decoder.decode(feed_coding.wanted_alone(frame, ask.wanted, ask.size))
        except Undecodable as error:
            self.undecodable += 1
            self._leave_out("they cannot be decoded", f" ({error})")
            return None
        wrong = feed_coding.misfit(decoded, ask.wanted, ask.size)
        if not wrong and (lacks := self.pictures & feed_coding.left_out(decoded, 0)):
            wrong = f"the server sends no {' and no '.join(sorted(name.removeprefix('rendered.') for name in lacks))}"
        if wrong:
            self.refused += 1
            self._misfit = wrong
            self._leave_out(wrong, "")
            return None
        if not self._draws_others and any(map(is_another_view, ask.views, decoded.views)):
            self._draws_others = True
            self._say(f"{self._caller.address}: it draws other views than it is asked for; what is not drawn is a hole")
        return attrs.evolve(decoded, grids=grids)

    def _leave_out(self, kind: str, what: str) -> None:
        """Say, once for each kind, what is wrong with frames that are left out."""
        if kind not in self._told and len(self._told) < _MOST_TOLD:
            self._told.add(kind)
            self._say(f"{self._caller.address}: frames are left out: {kind}{what}")

    @property
    def notice(self) -> str:
        """What is shown over the picture: that frames do not come; "" while they do."""
        return "" if self._lost_ns is None else f"no frames from {self._caller.address}: the last one stays"

    def summary(self) -> dict[str, Any]:
        """Return what summary.json has of the connection."""
        since_ns = 0 if self._lost_ns is None else time.monotonic_ns() - self._lost_ns
        return {
            "address": self._caller.address,
            "lost": self._losses,
            "away_s": (self._away_ns + since_ns) / 1e9,
            "clock": self._caller.clock.summary(),
            "unanswered": self.unanswered,
            "undecodable": self.undecodable,
            "draws_others": self._draws_others,
            "malformed": self._caller.malformed + self.refused,
        }

    def close(self) -> None:
        """End the session."""
        self._caller.close()


# Degrees, metres and share of the field of view, on each axis, that equal views may differ by: a
# renderer's single floats leave 1e-5 degrees, 5e-7 m at 8 m, and 4e-7 of the field.
_SAME_DEG, _SAME_M, _SAME_SHARE = 1e-4, 1e-6, 1e-6


def is_another_view(asked: View, drawn: View) -> bool:
    """Return whether a view was drawn from elsewhere, or lacks some of the requested one."""
    left, right, down, up = (asked.fov.tangents - drawn.fov.tangents) * (-1, 1, -1, 1)
    across, high = np.diff(asked.fov.tangents)[[0, 2]]
    lacks = max(left, right) > _SAME_SHARE * across or max(down, up) > _SAME_SHARE * high
    is_elsewhere = np.abs(drawn.pose.position_m - asked.pose.position_m).max() > _SAME_M
    return bool(lacks or is_elsewhere or math.degrees(drawn.pose.angle_to(asked.pose)) > _SAME_DEG)


class NoTruth(HmdwarpError):
    """The server elsewhere has not drawn what an eye should see."""


class RemoteSource(Source):
    """Frames that a server elsewhere draws.

    The scene is here as well if the options name it, for passes and for the truth, which the server
    draws otherwise.
    """

    kind = REMOTE

    def __init__(self, options: Any) -> None:
        feed: FeedOptions = options.feed
        self.feed, self._draws_truth = feed, options.draws_truth
        self._is_here = options.scene != SERVER_SCENE
        super().__init__(options, None if self._is_here else nothing(SERVER_SCENE, f"drawn by {feed.connect}"))
        if feed.raw != FULL and options.coding.codec != "none":
            raise InputError(f"--raw {feed.raw} beside --codec {options.coding.codec}: leave one of them out")
        try:
            options.network.delay.check(round(feed.added_latency_ms * 1e6))
        except InputError as error:
            raise InputError(f"--added-latency {feed.added_latency_ms:g} ms: {error}") from error

    def fitted(self, options: Options) -> Options:
        """Return the options with the server in place of a scene, where there is none here."""
        return options if self._draws_truth or self._is_here else attrs.evolve(options, scene=self.feed.connect)

    def measured(self, options: Options, **first: Any) -> Options:
        """Connect, send what people do, and return the options with the measured latency.

        first: head and views of one instant, rate_hz, needs and pictures as of PoseRequest; holds,
        keeps and say as of Remote.
        """
        assert options.size is not None
        remote = self.remote = Remote(self.feed, **{name: first[name] for name in ("holds", "keeps", "say")})
        remote.pictures, head, views, rate_hz = first["pictures"], first["head"], first["views"], first["rate_hz"]
        wanted = (message.RAW[self.feed.raw], options.coding, rate_hz, views, options.size)
        remote.wish = feed_coding.wish_of(*wanted, options.latency_ms * 1e-3)
        longest_ns = remote.measure(head, views, options.guard_band, options.size, first["needs"]) + remote.added_ns
        remote.wish = feed_coding.wish_of(*wanted, longest_ns * 1e-9 + 1 / rate_hz)
        if self.scene.inputs is not None:
            remote.act(self.scene.inputs)
        return attrs.evolve(options, latency_ms=longest_ns / 1e6)

    def act(self, event: InputEvent) -> InputEvent | None:
        """Send what somebody does, and return it: what it means is known where the scene is.

        Errors: as Source.act, and as Remote.act.
        """
        done = super().act(event) if self._is_here else event
        if done is not None and self.remote is not None:
            self.remote.act([done])
        return done

    def frames(
        self, options: PipelineOptions, server: Renderer, target: Shown, requested: PoseRequest, stack: ExitStack
    ) -> RemoteFrames:
        """Return the frames that the server elsewhere draws."""
        remote = self.remote
        assert remote is not None, "measured() connects"
        remote.pictures = requested.pictures
        remote.only_changes = options.network.send == CHANGES
        return RemoteFrames(remote, server, requested, target.eyes)

    def renderer(self, gpu: Gpu, options: PipelineOptions, moment_of: MomentOf = Moment) -> Renderer:
        """Return what draws the truth, and has textures for the frames."""
        if self._is_here:
            return super().renderer(gpu, options, moment_of)
        return RemoteRenderer(gpu, self.scene, self.feed) if self._draws_truth else Renderer(gpu, self.scene)

    def close(self) -> None:
        """Hang up."""
        if self.remote is not None:
            self.remote.close()
            self.remote = None


class RemoteRenderer(Renderer):
    """A renderer whose pictures are drawn elsewhere, each on request.

    It is another client than the one for the frames, so that neither replaces the other's requests.
    Errors: as Viewer.
    """

    def __init__(self, gpu: Gpu, scene: Scene, feed: FeedOptions) -> None:
        super().__init__(gpu, scene)
        self._viewer = Viewer(feed.connect, secret_in(feed.token_file), public_key(feed.server_key))
        self._draws_others = False

    def draw(self, view: View, size: Size, into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """Return what the server draws for the view. Errors: NoTruth where it draws nothing."""
        found = self._viewer.fetch(view, size, time_ns)
        if found is None:
            raise NoTruth("the server has not drawn the truth")
        self._draws_others |= is_another_view(view, found.views[0])
        target = into if into is not None else self.acquire(size)
        self.take_in(feed_coding.arrays_of(found, 0, size), target)
        return EyeImage(view, target.colour, target.inverse_depth, drawn_ns=time_ns)

    def truth_facts(
        self, shown: Sequence[tuple[int, Pose]], missing: int, pixels_per_degree: float, *, own_head: bool
    ) -> tuple[dict[str, Any], str]:
        """Return nothing for summary.json, and a sentence or two on what the truth is."""
        text = "The truth is what the server drew for the shown views."
        if self._draws_others:
            text += " It drew other views than those: the figures count that as error."
        if missing:
            text += f" It drew none for {counted(missing, 'picture')}, which were not measured."
        return {}, text

    def close(self) -> None:
        """Free what was uploaded, and hang up."""
        self._viewer.close()
        super().close()


@attrs.frozen(eq=False)
class RemoteFrames(FrameSource):
    """Frames that another machine draws: asking returns none, they arrive at the channel.

    server: this side's, of whose textures the frames are made.
    """

    remote: Remote
    server: Renderer
    requested: PoseRequest
    eyes: Eyes

    def draw(self, head: PoseSample, now_ns: int) -> None:
        """Ask for a frame for that head."""
        asked = self.requested
        self.remote.age_ns = asked.age_ns
        views = looking(self.eyes.views(head.pose), head.gaze)
        self.remote.ask(head, views, asked.guard, asked.size, now_ns, asked.needs)

    def made(self, request: Request, found: FrameMessage) -> Frame:
        """Return the frame that arrived, decoded."""
        eyes, ask, asked, server = [], request.ask, self.requested, self.server
        for eye, (view, wanted) in enumerate(zip(found.views, ask.views, strict=True)):
            # As large as in the request where no picture was sent.
            size = found.size if asked.pictures else guarded_eyes([view], asked.guard, asked.size)[1]
            target, sent = server.acquire(ask.size if ask.fovea else size), feed_coding.left_out(found, eye)
            missing = sent | frozenset(PICTURE).difference(asked.pictures)
            whole = frozenset(PICTURE) if ask.fovea else missing
            server.take_in(feed_coding.arrays_of(found, eye, target.size, whole), target)
            hidden = wanted.hidden if view.fov == wanted.fov else view.hidden
            shown, error = attrs.evolve(view, hidden=hidden, gaze=wanted.gaze), depth_error(found, self.remote.wish)
            image = EyeImage(shown, target.colour, target.inverse_depth, {}, request.drawn_ns, error, missing)
            if ask.fovea:  # foveated pictures came in place of whole ones
                colour, depth = (server.acquire(found.size, kind, depth=False).colour for kind in (COLOUR, SCALAR))
                server.take_in(feed_coding.arrays_of(found, eye, found.size, sent), Target(colour, depth))
                pictures = [FoveatedPicture(texture, found.grids[eye]) for texture in (colour, depth)]
                image = image.having(foveated=pictures[0], foveated_depth=pictures[1])
            eyes.append(image)
        if found.layers:  # a server may choose the size of some
            eyes = feed_coding.made(server, eyes, found.layers, ask.wanted)
            server.trim()
        took_ms = {"render": found.render_ns / 1e6}
        return Frame(tuple(eyes), request.drawn_ns, request.head, None, found.began, took_ms, found.time_ns)

    def recycle(self, frame: Frame | None) -> None:
        """Return the frame's textures to the pools; None for one that was never made."""
        if frame is not None:
            self.server.recycle(frame)

    def channel(self, *setup: Any) -> Channel:
        """Return the channel of what arrives by the feed."""
        return _RemoteChannel(self, *setup)


class _RemoteChannel(Channel):
    """What was measured of the feed, then the emulated link: what that loses is never decoded."""

    def __init__(self, frames: RemoteFrames, way: Way, reads: Reads, offer: Any, tell: Any) -> None:
        self._remote, self._frames_of, self._tell = frames.remote, frames, tell
        how: dict[str, Any] = {"receive": self._receive, "decoding": lambda request: 0, "settled": self._settled}
        how["in_order"] = frames.remote.wish.colour in feed_coding.CODECS
        super().__init__(frames.recycle, (*way[:3], None), reads, offer, tell, **how)  # the server codes them
        self._shown: Request | None = None
        self._sent_ns = self._measured_ns = 0
        self._unanswered = self._remote.unanswered
        self._remote.forget()
        self._remote.needs_key = self.link.needs_key
        self.link.delay_by(self._delays(way[0].delays(frames.remote.added_ns)))

    def _delays(self, added: Iterator[int]) -> Iterator[int]:
        for added_ns in added:
            delay_ns = self._measured_ns + added_ns
            if self._remote.keeps:
                self._remote.delays_ns.append((self._sent_ns, delay_ns))
            yield delay_ns

    def _receive(self, request: Request) -> bool:
        decoded = self._remote.decoded(request)
        if decoded is not None:
            request.frame = self._frames_of.made(request, decoded)
        return decoded is not None

    def _settled(self, request: Request, arrived: bool, heard_ns: int) -> None:
        if arrived and request.frame is not None:
            self._tell(request.frame, arrived, heard_ns)
        self._remote.tell(request, arrived=arrived, heard_ns=heard_ns)

    def due(self, now_ns: int) -> list[int]:
        """Return the instants at which a frame is requested, up to now."""
        self._remote.pace(now_ns)
        return super().due(now_ns)

    def newest(self, now_ns: int) -> Frame | None:
        """Return the newest frame that has arrived by now, or None before the first."""
        for request in self._remote.arrived(now_ns):
            came = request.message
            assert came is not None
            pictures = {"colour": came.colours, "inverse_depth": came.inverse_depths}
            sizes = Counter({name: sum(map(message.length_of, both)) for name, both in pictures.items()})
            for of_eye in came.layers:
                sizes.update({name: sum(map(part_bytes, parts)) for name, parts in of_eye.items()})
            self._frames, self._eyes = self._frames + 1, len(request.ask.views)
            self._bytes.update(+sizes)
            self._measured_ns, self._sent_ns = request.took_ns, request.drawn_ns
            self.link.send(request, request.drawn_ns, sizes.total(), feed_coding.stands_alone(came))
        self._shown = self.link.newest(now_ns)
        return self._shown.frame if self._shown is not None else None

    @property
    def transit(self) -> TransitStats | None:
        """Transit statistics of the shown frame; the server's work is told from its delay."""
        found = self.link.transit
        if found is None or self._shown is None or self._shown.message is None:
            return None
        render_ns = min(self._shown.message.render_ns, self._shown.took_ns)
        return attrs.evolve(found, render_ns=render_ns, delay_ns=found.delay_ns - render_ns)

    def fates(self) -> dict[str, int]:
        """Return what became of every frame; skipped: requests that the server passed over."""
        unanswered = self._remote.unanswered - self._unanswered
        return {**super().fates(), "skipped": unanswered, "unchanged": self._remote.unchanged}

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json, with the connection."""
        codec = feed_coding.CODECS.get(self._remote.format, "none")
        return {**super().summary(rate_hz), "codec": codec, "feed": self._remote.summary()}
