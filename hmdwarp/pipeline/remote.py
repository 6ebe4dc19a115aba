"""A server elsewhere: its frames come by the feed, as old as they then are.

The loop is the same one. Requests go out where frames would be drawn, and a frame that has arrived
enters the link with the delay that was measured.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import attrs

from ..client.plan import needs_of
from ..errors import InputError, MachineError
from ..frames import EyeImage, Frame, Needs
from ..frames.layers import layers
from ..geometry import guarded_eyes
from ..link import LinkOptions
from ..link.codec import Undecodable, check_codec
from ..link.options import ALL, DROP
from ..sources.feed.caller import Arrival, Caller
from ..sources.feed.key_pairs import public_key
from ..sources.feed.message import ANY, Ask, FrameMessage, Wish, length_of
from ..sources.feed.options import FeedOptions, secret_in
from ..sources.feed.parts import Wanted
from ..sources.feed.parts import length_of as part_bytes
from .channel import Channel
from .feed_coding import FeedDecoder, codec_of, depth_error
from .feed_layers import made, misfit, wanted_of
from .layers_read import Reads
from .remote_server import upload_eye
from .views_apart import ViewsApart

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..client.plan import Plan
    from ..geometry import Eyes, Guard, View
    from ..poses import PoseSample
    from ..sources.server import Server
    from .options import PipelineOptions
    from .requested import PoseRequest

# Requests whose answers say how long the way is; the first also waits for the server's set-up.
_TRIALS = 6
_ANSWER_NS = 30_000_000_000
_TELL_NS = 2_000_000_000
# Requests that may be without an answer; what is older is never answered.
_MOST_PENDING = 4096
_MS = 1e6


@attrs.frozen(eq=False)
class _Pending:
    head: PoseSample
    # On the loop's clock, and on this machine's.
    drawn_ns: int
    sent_ns: int
    size: tuple[int, int]
    views: tuple[View, ...]
    wanted: Wanted | None


@attrs.frozen(eq=False)
class _Answer:
    """A request and its frame, and how long after the request the loop had it."""

    pending: _Pending
    # Decoded.
    arrival: Arrival
    took_ns: int
    # Bytes that crossed the feed, by layer.
    layer_bytes: Counter[str]


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
        self._holds, self._keeps, self._say = holds, keeps, say
        self.feed = feed
        self._number = 0
        self._pending: dict[int, _Pending] = {}
        self._heard_ns = time.monotonic_ns()
        # When frames stopped coming; None while they come.
        self._lost_ns: int | None = None
        self._losses, self._away_ns = 0, 0
        self.unanswered = self.refused = self.undecodable = 0
        self._decoder, self._anew_number = FeedDecoder(), 0
        # What was wrong with the layers of the last frame that was left out.
        self._misfit = ""
        self._apart = ViewsApart()
        # How frames are to be coded; raw until it is said.
        self.wish, self._format = Wish(), ANY
        self._paced: tuple[int, int] | None = None
        # The last instant for which the loop was told what had arrived.
        self._told_ns: int | None = None
        # Of each frame in the order of drawing, in ns: the instant it was drawn for, and its delay.
        # Where it keeps them.
        self.delays_ns: list[tuple[int, int]] = []

    def ask(
        self,
        head: PoseSample,
        views: Sequence[View],
        guard: Guard,
        size: tuple[int, int],
        now_ns: int,
        needs: Needs | None = None,
    ) -> None:
        """Ask for a frame of these eyes at that instant of the loop's clock, with needed layers."""
        fovs, grown = guarded_eyes(views, guard, size)
        wide = tuple(attrs.evolve(view, fov=fov) for view, fov in zip(views, fovs, strict=True))
        self._number += 1
        # Asked for once, and again only if that request will have no answer.
        anew = self._decoder.wants_anew and self._anew_number not in self._pending
        if anew:
            self._anew_number = self._number
        wanted = wanted_of(needs, views, size) if needs is not None else None
        times = (self._number, 0, now_ns, head.time_ns, 0)
        ask = Ask(*times, grown, head.pose, wide, wish=self.wish, anew=anew, wanted=wanted)
        sent_ns = self._caller.ask(ask)
        self._pending[self._number] = _Pending(head, now_ns, sent_ns, grown, wide, wanted)
        while len(self._pending) > _MOST_PENDING:
            del self._pending[next(iter(self._pending))]
            self.unanswered += 1

    def measure(
        self, head: PoseSample, views: Sequence[View], guard: Guard, size: tuple[int, int], needs: Needs
    ) -> int:
        """Return the longest time in ns from a request to its frame, of a few.

        Errors: InputError where the server refuses, or sends no needed layer; MachineError where
        nothing answers.
        """
        took = []
        for _ in range(_TRIALS):
            took.append(self._trial(head, views, guard, size, needs))
        self.forget()
        self.delays_ns.clear()
        self.unanswered = 0
        self._decoder.wants_anew = True
        return max(took[1:])

    def forget(self) -> None:
        """Leave out the answers to all requests so far: they are for another loop."""
        self._pending.clear()

    def _trial(self, head: PoseSample, views: Sequence[View], guard: Guard, size: tuple[int, int], needs: Needs) -> int:
        until_ns = time.monotonic_ns() + _ANSWER_NS
        while (now_ns := time.monotonic_ns()) < until_ns:
            self.ask(head, views, guard, size, head.time_ns, needs)
            # Asked again after a while: the connection may not have been there.
            again_ns = min(until_ns, now_ns + 1_000_000_000)
            while time.monotonic_ns() < again_ns:
                self._caller.wait_until(again_ns)
                lines = self._caller.lines()
                if lines and "refused" in lines[-1]:
                    raise InputError(f"--connect {lines[-1]}")
                for answer in self._known():
                    return answer.took_ns
                if self._misfit:
                    raise InputError(
                        f"--connect {self._caller.address}: {self._misfit}: use --effects none, or another warp or fill"
                    )
        raise MachineError(
            f"--connect {self._caller.address}: no frame in {_ANSWER_NS // 10**9} s: start 'hmdwarp serve' there, and "
            "check the address"
        )

    def pace(self, now_ns: int) -> None:
        """Wait so that refreshes come no faster than on the display, where the loop holds."""
        if not self._holds:
            return
        clock_ns = time.monotonic_ns()
        if self._paced is not None:
            due_ns = self._paced[1] + now_ns - self._paced[0]
            if due_ns > clock_ns:
                time.sleep((due_ns - clock_ns) * 1e-9)
                clock_ns = due_ns
        self._paced = now_ns, clock_ns

    def arrived(self, now_ns: int) -> list[_Answer]:
        """Return what has arrived since the last call, oldest first.

        Where the loop holds, what has not arrived when this returns arrives later than `now_ns`.
        """
        found = self._known()
        while self._holds and self._pending:
            latest_ns = max(one.sent_ns + now_ns - one.drawn_ns for one in self._pending.values())
            if time.monotonic_ns() >= latest_ns:
                break
            self._caller.wait_until(latest_ns)
            found += self._known()
        self._told_ns = now_ns
        self._tell()
        return found

    def _known(self) -> list[_Answer]:
        """Return the arrivals that answer a request.

        Frames come in order, so requests before one that is answered never will be.
        """
        found = []
        for arrival in self._caller.take():
            number = arrival.frame.number
            if number not in self._pending:
                continue
            for older in [one for one in self._pending if one < number]:
                del self._pending[older]
                self.unanswered += 1
            pending = self._pending.pop(number)
            if arrival.frame.size != pending.size or len(arrival.frame.views) != len(pending.views):
                self.refused += 1
                continue
            self._heard_ns, self._format = arrival.heard_ns, arrival.frame.colour
            try:
                decoded = self._decoder.decode(arrival.frame)
            except Undecodable:
                self.undecodable += 1
                continue
            if wrong := misfit(decoded, pending.wanted):
                self._leave_out(wrong)
                continue
            self._compare(pending.views, decoded.views)
            took_ns = arrival.heard_ns - pending.sent_ns
            if self._told_ns is not None:
                # It came in just before a refresh that was shown without it: handed over after.
                took_ns = max(took_ns, self._told_ns + 1 - pending.drawn_ns)
            found.append(_Answer(pending, attrs.evolve(arrival, frame=decoded), took_ns, _bytes_of(arrival.frame)))
            if self._keeps:
                self.delays_ns.append((pending.drawn_ns, took_ns))
        return found

    def _compare(self, asked: Sequence[View], drawn: Sequence[View]) -> None:
        told = bool(self._apart)
        for pair in zip(asked, drawn, strict=True):
            self._apart.take(*pair)
        if self._apart and not told:
            self._say(
                f"{self._caller.address}: it draws other views than it is asked for, {self._apart}; what it has not "
                "drawn is a hole"
            )

    def _leave_out(self, wrong: str) -> None:
        self.refused += 1
        if wrong != self._misfit:
            self._misfit = wrong
            self._say(f"{self._caller.address}: frames are left out: {wrong}")

    def _tell(self) -> None:
        for line in self._caller.lines():
            self._say(line)
        # Nothing is missed before it was asked for: while a pipeline is built nothing is.
        since_ns = max(self._heard_ns, next((one.sent_ns for one in self._pending.values()), 0))
        silent_ns = time.monotonic_ns() - since_ns
        if self._lost_ns is not None and self._heard_ns > self._lost_ns:
            self._say(f"{self._caller.address}: frames come again")
            self._away_ns += self._heard_ns - self._lost_ns
            self._lost_ns = None
        elif self._lost_ns is None and self._pending and silent_ns >= _TELL_NS:
            self._say(f"{self._caller.address}: no frame for {silent_ns / 1e9:.0f} s; the last one stays")
            self._lost_ns = since_ns
            self._losses += 1

    @property
    def notice(self) -> str:
        """What is shown over the picture: that frames do not come; "" while they do."""
        return "" if self._lost_ns is None else f"no frames from {self._caller.address}: the last one stays"

    @property
    def codec(self) -> str:
        """The codec of the frames that came last."""
        return codec_of(self._format)

    def summary(self) -> dict[str, Any]:
        """Return what summary.json has of the connection."""
        return {
            "address": self._caller.address,
            "lost": self._losses,
            "away_s": (self._away_ns + (time.monotonic_ns() - self._lost_ns if self._lost_ns is not None else 0)) / 1e9,
            "clock": self._caller.clock.summary(),
            "unanswered": self.unanswered,
            "undecodable": self.undecodable,
            "views_off": attrs.asdict(self._apart),
            "malformed": self._caller.malformed + self.refused,
        }

    def close(self) -> None:
        """End the session."""
        self._caller.close()


def _bytes_of(frame: FrameMessage) -> Counter[str]:
    pictures = {"colour": frame.colours, "inverse_depth": frame.inverse_depths}
    found = Counter({name: sum(map(length_of, both)) for name, both in pictures.items()})
    for of_eye in frame.layers:
        found.update({name: sum(map(part_bytes, parts)) for name, parts in of_eye.items()})
    return found


@attrs.frozen(eq=False)
class RemoteFrames:
    """Frames that another machine draws: asking returns none, they arrive at the channel.

    server: this side's, of whose textures the frames are made.
    """

    remote: Remote
    server: Server
    requested: PoseRequest
    eyes: Eyes

    def draw(self, head: PoseSample, now_ns: int, scale: float) -> None:
        """Ask for a frame for that head."""
        asked = self.requested
        self.remote.ask(head, self.eyes.views(head.pose), asked.guard, asked.size, now_ns, asked.needs)

    def made(self, pending: _Pending, arrival: Arrival) -> Frame:
        """Return the frame that arrived."""
        found, eyes = arrival.frame, []
        for eye, view in enumerate(found.views):
            target = self.server.acquire(found.size)
            upload_eye(target, found, eye)
            error = depth_error(found, self.remote.wish)
            further = made(self.server, found.layers[eye], pending.wanted) if found.layers else {}
            textures = (target.colour, target.inverse_depth)
            eyes.append(EyeImage(view, *textures, further, drawn_ns=pending.drawn_ns, depth_error=error))
        took_ms = {"render": found.render_ns / _MS}
        return Frame(tuple(eyes), pending.drawn_ns, head=pending.head, timings_ms=took_ms)

    def has_more(self, now_ns: int) -> bool:
        """Return False: nobody here knows."""
        return False

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        """Pass over: the server elsewhere hears of it with the next request."""

    def recycle(self, frame: Frame) -> None:
        """Return the frame's textures to the pools."""
        self.server.recycle(frame)


class RemoteChannel(Channel):
    """The channel of frames that arrive by the feed: their delay is measured, not set."""

    def __init__(
        self,
        frames: RemoteFrames,
        latency_ns: int,
        reads: Reads,
        offer: Callable[[Frame], None],
        rate_hz: float,
        settled: Callable[[Frame, bool, int], None],
        network: LinkOptions,
    ) -> None:
        super().__init__(network, latency_ns, None, reads, offer, frames.recycle, rate_hz, settled)
        self._remote, self._frames_of = frames.remote, frames
        self._measured_ns = self._render_ns = 0
        self._sent: Counter[str] = Counter()
        self._unanswered = self._remote.unanswered
        self._remote.forget()
        self.link.delay_by(self._delays())

    def _delays(self) -> Iterator[int]:
        while True:
            yield self._measured_ns

    def due(self, now_ns: int) -> list[int]:
        """Return the instants at which a frame is asked for, up to now."""
        self._remote.pace(now_ns)
        return super().due(now_ns)

    def newest(self, now_ns: int) -> Frame | None:
        """Return the newest frame that has arrived by now, or None before the first."""
        for answer in self._remote.arrived(now_ns):
            self._render_ns = min(answer.arrival.frame.render_ns, answer.took_ns)
            self._measured_ns = answer.took_ns - self._render_ns
            self._sent = answer.layer_bytes
            self.send(self._frames_of.made(answer.pending, answer.arrival), answer.pending.drawn_ns)
        return super().newest(now_ns)

    def _at_server(self, frame: Frame, now_ns: int) -> tuple[int, int]:
        return self._render_ns, 0

    def _uncoded_bytes(self, frame: Frame) -> Counter[str]:
        return self._sent

    def fates(self) -> dict[str, int]:
        """Return what became of every frame; skipped: requests that the server passed over."""
        return {**super().fates(), "skipped": self._remote.unanswered - self._unanswered}

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json, with the connection."""
        return {**super().summary(rate_hz), "codec": self._remote.codec, "feed": self._remote.summary()}


def check_remote(options: PipelineOptions, *, recorded: bool) -> None:
    """Check what cannot be set where frames come from elsewhere.

    recorded: whether there are recorded frames. Errors: InputError.
    """
    if recorded:
        raise InputError("--connect with --frames: frames come from the server or the folder; leave one of them out")
    if not options.network.is_plain or options.network.overload != DROP:
        raise InputError(
            "--connect with --jitter, --loss, --bandwidth, --delay-trace or --response: the link is the real one; "
            "leave them out"
        )
    if options.network.send != ALL:
        raise InputError(
            f"--connect with --send {options.network.send}: the server sends what is asked for; leave it out"
        )
    check_codec(options.coding.codec)
    if options.proxy.on or options.chooses_warp:
        raise InputError("--connect with --proxy or --warp auto: not supported, leave them out")


def check_shown_elsewhere(plans: Sequence[Plan]) -> None:
    """Check that plans get by without the scene, with what frames carry. Errors: InputError."""
    check_carried(needs_of(plans))
    steps = [step for plan in plans for step in plan.steps]
    if any(name.startswith("client.") for step in steps for name in (*step.reads, *step.writes)):
        raise InputError(
            "--connect: the client draws some of the scene for this warp or fill, and the scene is at the server: use "
            "another one"
        )


def check_carried(needs: Needs) -> None:
    """Check that plans read what frames of another process may have. Errors: InputError."""
    names = ", ".join(name for name in needs if name != "others" and not layers.get(name).fed)
    if names:
        raise InputError(
            f"--connect: frames of another process have no {names}, which the passes need: use --effects none, or "
            "another warp or fill"
        )
