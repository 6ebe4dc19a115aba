"""Runs on a display, live or recording a head: the pipeline, its changes, and how a run ends."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, nullcontext, suppress
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

import attrs
import numpy as np

from ..base import AUTO, InputError, MachineError
from ..client import every_fill, every_warp, needs_of
from ..display import (
    CONTROLS,
    MOVED,
    Closed,
    Command,
    Control,
    Display,
    DisplayOptions,
    Label,
    Lost,
    OffscreenDisplay,
    Tick,
    control,
    desktop,
    openxr,
)
from ..geometry import GuardBand, Pose
from ..pipeline import Reads, Refresh, Source
from ..pipeline.options import PROXY, SCENE, SERVER_SCENE
from ..pipeline.proxy import check_names, source_of
from ..pipeline.sizes import check_held, expected_age_ns, guarded_size, latency_ns, plans_for, smaller_size
from ..poses import Origin, PoseSample, PoseSource, PoseTrack, gaze_of, jumps_between, load_trace
from ..poses.synth import RATE_HZ, synthesise
from ..poses.track import LoopedSource, Moment
from ..report import refuse_source
from ..scenes import ACTIONS, GRAB, PUSH, RELEASE, InputEvent, SceneOptions, check_scene_name, scenes
from .choosing import levels_from_file
from .live_log import LiveLog, LiveResult
from .options import BOTH, DESKTOP, FLAT, OFFSCREEN, OPENXR, SYNTHETIC, LiveOptions, RecordOptions
from .recorder import LEAST, Recorder
from .run import EmulatedScreen, Run

_RETRY_S = 0.5


class Ending:
    """End a live run, by a signal or after some seconds or pictures; None for no limit.

    Use as a context manager. Time counts from the first refresh. Inside, Ctrl-C, SIGTERM and SIGHUP
    only request the end of the run after the current refresh; a second one interrupts at once.
    Signals other than Ctrl-C are raised again on exit, after everything inside was written.
    """

    def __init__(self, seconds: float | None, frames: int | None) -> None:
        self._seconds, self._frames = seconds, frames
        self._began_ns: int | None = None
        # The clock; replaced by the display's once there is one.
        self.now_ns: Callable[[], int] = time.monotonic_ns
        # Number of the first signal received, or None.
        self.asked: int | None = None
        self._before: dict[int, Any] = {}

    def due(self, count: int) -> bool:
        """Return whether to end now, after `count` refreshes with a picture."""
        now_ns = self.now_ns()
        if self._began_ns is None and count:
            self._began_ns = now_ns
        late = (
            self._seconds is not None and self._began_ns is not None and now_ns - self._began_ns >= self._seconds * 1e9
        )
        return self.asked is not None or late or (self._frames is not None and count >= self._frames)

    def _ask(self, number: int, _: FrameType | None) -> None:
        if self.asked is not None:
            raise KeyboardInterrupt
        self.asked = number

    def __enter__(self) -> Ending:
        if threading.current_thread() is threading.main_thread():
            for name in ("SIGINT", "SIGTERM", "SIGHUP"):
                number = getattr(signal, name, None)
                # nohup ignores SIGHUP; keep it ignored.
                if number is not None and signal.getsignal(number) != signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()
        if self.asked is not None and self.asked != signal.SIGINT:
            signal.raise_signal(self.asked)


def come_back(
    reopen: Callable[[], bool], lost: Lost, wait_s: float, ending: Ending, say: Callable[[str], None]
) -> bool:
    """Retry opening a lost display until it succeeds, or a signal requests the end: False.

    Errors: Lost, when it takes too long.
    """
    say(f"{lost}; waiting up to {wait_s:g} s for it to come back (Ctrl-C ends)")
    until = time.monotonic() + wait_s
    while time.monotonic() < until:
        if ending.asked is not None:
            return False
        if reopen():
            say("it is back")
            return True
        time.sleep(_RETRY_S)
    raise Lost(f"{lost}; it has not come back within {wait_s:g} s")


_LOOKS = 20  # polls of a call within the limit
_LONGEST_LOOK_S = 0.25
# For each: a report takes a second or two, and a hung disk must not keep the program alive.
LAST_WORDS_S = 10.0
_PRINTING_S = 1.0


class Watchdog:
    """Watch calls from a thread of its own while it is entered.

    limit_s: how long one call may take. last_words: each is called before the program ends, from
    another thread than the hung one, and may fail or hang itself; it returns a sentence for the
    user, or "". Polls that find the call still running count, not elapsed time: a program that was
    stopped for a while (Ctrl-Z, a debugger) continues undisturbed.
    """

    def __init__(self, limit_s: float, last_words: Sequence[Callable[[], str]]) -> None:
        self._limit_s, self._last_words = limit_s, last_words
        self._look_s = min(limit_s / _LOOKS, _LONGEST_LOOK_S)
        self._under_way: list[str] = []  # the innermost call last
        self._entered = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look_on, name="watchdog", daemon=True)

    @contextmanager
    def watching(self, what: str) -> Iterator[None]:
        """Watch a call of that name, in place of one around it."""
        self._under_way.append(what)
        self._entered += 1
        try:
            yield
        finally:
            self._under_way.pop()

    def _look_on(self) -> None:
        last, looks = 0, 0
        while not self._over.wait(self._look_s):
            entered, under_way = self._entered, self._under_way[-1:]
            looks = looks + 1 if under_way and entered == last else 0
            last = entered
            if looks * self._look_s >= self._limit_s:
                self._end(under_way[0])

    def _end(self, what: str) -> None:
        saved: list[str] = []

        def tell() -> None:
            found = f"hmdwarp: the OpenXR runtime has not answered {what} for {self._limit_s:g} s: it hangs"
            line = "; ".join([found, "end its service, start it again, then try once more", *filter(None, saved)])
            # Not sys.stderr, which may be locked by the hung thread.
            os.write(2, f"{' '.join(line.split())}\n".encode(errors="replace"))
            sys.stdout.flush()  # os._exit does not flush

        words = [(lambda say=say: saved.append(say()), LAST_WORDS_S) for say in self._last_words]
        for do, limit_s in (*words, (tell, _PRINTING_S)):
            with suppress(BaseException):  # it may fail, or hang itself
                ThreadPoolExecutor(1).submit(do).result(limit_s)
        os._exit(MachineError.exit_status)

    def __enter__(self) -> Watchdog:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()


class GarbageControl:
    """Collect garbage only between pictures.

    What exists on entry is frozen, so that no collection scans it, unless the program has frozen
    its objects itself.
    """

    def __enter__(self) -> None:
        self._was_enabled, self._freezes = gc.isenabled(), not gc.get_freeze_count()
        gc.collect()
        if self._freezes:
            gc.freeze()
        gc.disable()

    def __exit__(self, *_: object) -> None:
        if self._freezes:
            gc.unfreeze()
        if self._was_enabled:
            gc.enable()


def checked_source(options: LiveOptions, source: Source | None = None) -> Source:
    """Return what gives the frames, after all checks that need no display.

    source: if it is open already. Errors: InputError and its subclasses.
    """
    if source is None:
        source = source_of(options)
    else:
        check_names(options)
    if options.warp != AUTO:
        plans = plans_for(attrs.evolve(options, lens="none", fused=False), None, source.scene)
        source.check(plans, needs_of(plans))
    return source


def on_screen(options: LiveOptions, screen: Display | EmulatedScreen) -> LiveOptions:
    """Return the options with what `auto` stands for there: the lens, and the levels of the warp.

    The lens is "none" for a runtime that corrects its own. Errors: as levels_from_file.
    """
    lens, headset = options.lens, screen.headset
    if headset is None and not screen.distorts:
        lens = "none"
    elif lens == AUTO:
        lens = headset.lens.model if headset is not None and headset.lens is not None else "none"
    if options.bench is not None:
        sized = attrs.evolve(options, lens="none", size=options.size or screen.size)
        options = attrs.evolve(options, levels=levels_from_file(options.bench, sized).levels)
    return attrs.evolve(options, lens=lens)


KEPT_NS = 1_000_000_000


class RecentPoses:
    """A pose source that keeps the last second of its answers; recentring is a jump."""

    def __init__(self, source: PoseSource) -> None:
        self._source = source
        self._kept: list[PoseSample] = []

    def start(self) -> None:
        self._source.start()

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the source's pose, and keep it."""
        sample = self._source.head_at(time_ns)
        kept = self._kept
        # What was foretold before a jump, for the display, is of where the head is no more.
        while kept and kept[-1].time_ns >= sample.time_ns and jumps_between([sample, kept[-1]]):
            kept.pop()
        at = bisect_left(kept, sample.time_ns, key=lambda pose: pose.time_ns)
        # Within known motion nothing is added; between the sides of a jump it says which is now.
        if at == len(kept) or (at and kept[at].time_ns > sample.time_ns and jumps_between([kept[at - 1], kept[at]])):
            kept.insert(at, sample)
            del kept[: bisect_left(kept, sample.time_ns - KEPT_NS, key=lambda pose: pose.time_ns)]
        return sample

    def track_until(self, now_ns: int) -> PoseTrack:
        """Return the last second of motion, including the current pose."""
        self.head_at(now_ns)
        kept = self._kept
        return PoseTrack(
            time_ns=np.array([pose.time_ns for pose in kept]),
            position_m=np.array([pose.pose.position_m for pose in kept]),
            orientation_xyzw=np.array([pose.pose.orientation_xyzw for pose in kept]),
            jumps=jumps_between(kept),
            gaze=gaze_of(kept),
        )

    def close(self) -> None:
        self._source.close()


class PipelineHost:
    """The run for `options` on a display, made anew only as far as a change requires.

    A change of latency alone affects the link: frames in transit arrive as scheduled. A change of
    warp or fill whose frames carry the same exchanges the passes. Any other change makes a new run,
    which shows nothing until its first frame arrives. source: if it is open already. say: called
    with each line about the connection.
    Errors: InputError and its subclasses for options that cannot run; the old run then stays.
    MachineError where no server answers.
    """

    def __init__(
        self,
        display: Display,
        options: LiveOptions,
        source: Source | None = None,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._display = display
        self._recent = RecentPoses(display.source)
        source = source or source_of(options)
        with ExitStack() as unfinished:
            unfinished.callback(source.close)
            options = source.fitted(options)
            self.run = Run.of(on_screen(options, display), source, display)
            head = PoseSample(0, Pose((0, 1.6, 0)), Origin.MEASURED)
            # A display whose clock stands still between pictures waits for the server's.
            self.run.measure(head, holds=options.source == OFFSCREEN, say=say)
            # As they were asked for; those of the run are as the display has them.
            self.options = attrs.evolve(options, latency_ms=self.run.options.latency_ms)
            self._start(self.run)
            unfinished.pop_all()

    def change(self, options: LiveOptions) -> None:
        """Continue with these options."""
        before, run = self.options, self.run
        if options == before:
            return
        if run.source.kind.is_timed and (options.latency_ms, options.scene) != (before.latency_ms, before.scene):
            raise InputError("latency and scene are the server's, where frames come from one: they stay")
        if attrs.evolve(options, latency_ms=before.latency_ms) == before:
            rate_hz = options.rate_hz or self._display.rate_hz
            check_held(run.target.gpu, options, run.requested.needs, run.sizes, rate_hz)
            run.channel.retime(options.client_link, latency_ns(options))
            run.requested.age_ns = expected_age_ns(options, latency_ns(options), rate_hz)
        elif not self._exchanged(before, options):
            self._rebuild(options)
        self.options = options

    def _exchanged(self, before: LiveOptions, options: LiveOptions) -> bool:
        """Exchange the passes if that is enough; return whether it was."""
        same = {name: getattr(before, name) for name in ("warp", "fill", "lens")}
        if AUTO in (before.warp, options.warp) or attrs.evolve(options, **same) != before:
            return False
        (plan,) = Run.of(on_screen(options, self._display), self.run.source, self._display).plans
        carried = self.run.requested
        if not carried.needs.serve(plan.needs) or not Reads.of([plan]).pictures <= carried.pictures:
            return False
        self.run.exchange(plan)
        return True

    def _rebuild(self, options: LiveOptions) -> None:
        """Make a new run, for the view of these options; on failure, restore the display's view."""
        same, before = options.scene_key == self.options.scene_key, self.options.view
        source = self.run.source if same else source_of(options)
        if options.view != before:
            self._display.set_view(options.view)
        try:
            made = self._start(Run.of(on_screen(options, self._display), source, self._display))
        except BaseException:
            if options.view != before:
                self._display.set_view(before)
            raise
        self.run.close()
        self.run = made

    def fit(self) -> None:
        """Rebuild if the shown field of view has changed enough to resize the rendered frames."""
        options, sizes = self.options, self.run.sizes
        guard = options.guard_band
        if guard == GuardBand() or "guard" in self.run.source.kind.sets:
            return
        if guarded_size(guard, self._display.eyes, sizes.shown) != sizes.rendered:
            self._rebuild(options)

    def _start(self, run: Run[LiveOptions]) -> Run[LiveOptions]:
        link_ns, poses, recent = latency_ns(run.options), self._display.source, self._recent
        moment_of = poses.moment if isinstance(poses, LoopedSource) else Moment
        return run.start(self._display.gpu, recent, recent.track_until, link_ns, link_ns, moment_of)

    def values(self) -> dict[str, object]:
        return values(self.options, self.run.sizes.shown)

    def close(self) -> None:
        self.run.close()
        self.run.source.close()


STEPS = {"latency": 50.0, "guard": 0.25}
READING_S = 4.0  # how long a refusal stays over the picture: time to read two lines


def choices() -> dict[str, tuple[object, ...]]:
    return {
        "warp": tuple(every_warp()),
        "fill": tuple(every_fill()),
        "scene": tuple(scenes.names()),
        "effects": ("auto", "none"),
    }


def values(options: LiveOptions, shown: tuple[int, int] | None = None) -> dict[str, object]:
    """Return the current value of each control; of two guard factors the larger one.

    shown: (w, h) of the shown picture, to tell what a rendered size is in factors.
    """
    guard = options.guard_band if shown is None else options.guard_band.factors(shown)
    own = {"latency": options.latency_ms, "guard": max(guard.x, guard.y)}
    names = ("warp", "fill", "scene", "effects", "latency", "guard", "lens", "view")
    return {name: own[name] if name in own else getattr(options, name) for name in names}


def changed(options: LiveOptions, command: Command) -> LiveOptions:
    """Return the options after the command. Errors: InputError for a value out of range."""
    name, value, now = command.control, command.value, values(options)
    if name not in now:
        raise InputError(f"control '{name}' changes nothing of the run: expected {', '.join(now)}")
    options.source_kind.refuse_change(name)
    meant, way = control(name), -1 if command.back else 1
    is_number, (least, most) = meant.kind == "number", meant.span
    if value is None and is_number:
        value = min(max(now[name] + way * STEPS[name], least), most)  # type: ignore[operator]
    elif value is None:
        known = choices().get(name) or {"lens": ("none", AUTO), "view": (BOTH, FLAT)}[name]
        value = known[(known.index(now[name]) + way if now[name] in known else 0) % len(known)]
    elif is_number:
        if not isinstance(value, int | float) or not least <= value <= most:
            raise InputError(f"{name} {value}: expected a number from {least:g} to {most:g}")
        value = float(value)
    elif not isinstance(value, str):
        raise InputError(f"{name} {value!r}: expected a word")
    change: dict[str, Any] = {"latency_ms" if name == "latency" else name: value}
    if name == "scene":
        change["scene_options"] = SceneOptions()  # those of a file, which this scene is not
    return attrs.evolve(options, **change)


def has(run: Run[LiveOptions]) -> frozenset[str]:
    """Return what of the needs of controls the run has: see `display.Control.needs`."""
    inputs, headset = run.source.scene.inputs, run.target.lens_of
    found = {action for thing in (inputs.things.values() if inputs is not None else ()) for action in thing.takes}
    found |= {"lens"} if headset is not None and headset.lens is not None else set()
    return frozenset(found | ({"scenes"} if run.options.source_kind in (SCENE, PROXY) else set()))


@attrs.define(eq=False)
class Hand:
    """What the user does in the scene: by a controller, or from the head towards where it looks."""

    host: PipelineHost
    now_ns: Callable[[], int]
    # Called with each input that meant something, and whether it only moves what is held.
    took: Callable[[InputEvent, bool], None]
    _head: Pose | None = None
    _grabbed: InputEvent | None = None
    _by_controller: bool = False  # whether what is held follows a controller
    _last_ns: int = 0

    def follow(self, refresh: Refresh) -> None:
        """Be where the head is; move what is held."""
        self._head = refresh.head.pose
        if self._grabbed is not None and not self._by_controller:
            self._do(GRAB, self._head)

    def act(self, command: Command) -> None:
        """Push, switch, grab or let go; a push lets go of what it throws. Errors: as Source.act."""
        action, pose = command.control, command.hand or self._head
        if command.value == MOVED:
            if self._grabbed is not None:
                self._do(GRAB, pose)
            return
        if action == GRAB:
            grabs = self._grabbed is None if command.value is None else bool(command.value)
            if grabs == (self._grabbed is not None):
                return
            action, self._by_controller = GRAB if grabs else RELEASE, command.hand is not None
        done, held = self._do(action, pose), self._grabbed
        if action == PUSH and done is not None and held is not None and done.target == held.target:
            self._do(RELEASE, pose)  # where only a server knows what the push meant
            action = RELEASE
        if action == RELEASE:
            self._grabbed = None

    def _do(self, action: str, pose: Pose | None) -> InputEvent | None:
        if pose is None:
            return None
        # Later than what was drawn by now, which does not show it.
        (x, y, z), (dx, dy, dz) = pose.position_m.tolist(), (-pose.rotation_matrix[:, 2]).tolist()
        later_ns, held = max(self.now_ns(), self._last_ns) + 1, self._grabbed
        asked = InputEvent(later_ns, action, "", (x, y, z), (dx, dy, dz))
        is_held = action == GRAB and held is not None
        if is_held and held is not None and held.ray == asked.ray:
            return held  # no news
        self._last_ns = asked.time_ns
        done = self.host.run.source.act(asked)
        if done is not None:
            self.took(done, is_held)
            self._grabbed = done if action == GRAB else held
        return done


@attrs.define(eq=False)
class CommandHandler:
    """Apply user commands to the running pipeline."""

    host: PipelineHost
    # Called with each refusal.
    say: Callable[[str], None]
    hand: Hand | None = None
    _refused: str = ""
    _until: float = 0.0

    def handle(self, commands: Sequence[Command]) -> bool:
        """Apply the commands, past values that are refused; return whether the options changed."""
        before = self.host.options
        for command in commands:
            if self.hand is not None and command.control in ACTIONS:
                try:
                    self.hand.act(command)
                except InputError as error:  # the scene does not react
                    self._refuse(str(error))
            else:
                self._handle(command)
        return self.host.options is not before

    def _handle(self, command: Command) -> None:
        options = self.host.options
        steps = len(choices().get(command.control, ())) if command.value is None else 0
        for _ in range(max(steps, 1)):
            try:
                options = changed(options, command)
                self.host.change(options)
                return
            except Lost:
                raise
            except (InputError, MachineError) as error:  # the run continues unchanged
                self._refuse(str(error))

    def _refuse(self, why: str) -> None:
        if why != self._refused:  # the same of every value that was tried
            self.say(why)
        self._refused, self._until = why, time.monotonic() + READING_S

    @property
    def refusal(self) -> str:
        """The last refusal while it is displayed, else ""."""
        if self._refused and time.monotonic() > self._until:
            self._refused = ""
        return self._refused


Say = Callable[[str], None]
_AfterRefresh = Callable[[int], None]
WAITING = "waiting for the first frame"
# Beyond the latency, for the first frame where nobody sees that it is waited for; of a server
# elsewhere, which may be busy, last.
PATIENCE_S = (10.0, 30.0)


class FrameHandler(Protocol):
    """The behaviour of a stretch of refreshes: its label, its commands, its end."""

    # Whether the scene is shown. If not, the display stays black but for the label, and nothing is
    # logged.
    pictures: bool
    # Whether, without pictures, the server and the passes run all the same: then frames are in
    # transit and caches are warm when pictures begin.
    ahead: bool = False

    def over(self) -> bool:
        """Return whether to stop now; called before each refresh."""

    def label(self) -> Label:
        """Return the text over the picture, "" for none."""

    def handle(self, commands: Sequence[Command]) -> bool:
        """Apply the commands; return whether the options of the run changed."""

    def arrived(self, refresh: Refresh) -> None:
        """Handle a refresh that has a frame, shown or not."""

    def on_display_lost(self, why: str) -> None:
        """Handle the loss of the display; it may come back."""


class Driver:
    """Drive one display and its pipeline. A stretch may have its own log and recorder.

    It waits for a lost display. ending: a signal ends every stretch.
    """

    def __init__(self, display: Display, host: PipelineHost, ending: Ending, say: Say) -> None:
        self._display, self._host, self._ending, self._say = display, host, ending, say

    def run(
        self,
        handler: FrameHandler,
        log: LiveLog | None = None,
        recorder: Recorder | None = None,
        after: _AfterRefresh = lambda number: None,
    ) -> None:
        """Run until `handler` is over or a signal arrives.

        after(number): called after each refresh that showed a picture, counted from 1.
        Errors: Closed, for window or session; Lost, when the display did not come back in time.
        """
        number = 0
        with GarbageControl() if handler.pictures or handler.ahead else nullcontext():
            while self._ending.asked is None and not handler.over():
                try:
                    tick = self._display.wait()
                    if tick is not None:
                        refresh = self._refresh(tick, handler, log)
                        if refresh is not None:
                            if recorder is not None:
                                recorder.add(refresh.head)
                            number += 1
                            after(number)
                            if log is not None:
                                self._display.show_status(log.status)
                        gc.collect(0)  # the youngest generation, to which a refresh adds some hundred objects
                    if handler.handle(self._display.commands()) and log is not None:
                        log.changed(self._host)
                except Lost as lost:
                    handler.on_display_lost(str(lost))
                    if recorder is not None:
                        recorder.flush()
                    if log is not None:
                        log.on_display_lost(str(lost))
                    wait_s = self._host.options.reconnect_s
                    if come_back(self._display.reopen, lost, wait_s, self._ending, self._say) and log is not None:
                        log.came_back()

    def _refresh(self, tick: Tick, handler: FrameHandler, log: LiveLog | None) -> Refresh | None:
        """Submit a picture, and return it if one was shown."""
        refresh = None
        if tick.render and (handler.pictures or handler.ahead):
            self._host.fit()
            loop = self._host.run.loop
            loop.draw(self._display.now_ns())
            if (refresh := loop.show(tick.shown_ns)) is not None:
                handler.arrived(refresh)
        if not handler.pictures:
            # A question stays in place, even while tracking is lost.
            self._display.show(None, handler.label())
            return None
        label = tick.notice or handler.label() or (WAITING if tick.render and refresh is None else "")
        submitted_ns = self._display.show(refresh, label)
        if log is not None:
            log.add(tick, refresh, submitted_ns, label if isinstance(label, str) else "")
        return refresh


_Watching = Callable[[str], AbstractContextManager[None]]


def live(options: LiveOptions, say: Say = lambda text: None, after: _AfterRefresh = lambda number: None) -> LiveResult:
    """Run until the window, the runtime or Ctrl-C ends it, or as long as the options say.

    Recording and log up to that point are written in any case.

    Parameters
    ----------
    options : LiveOptions
    say : callable
        Called with a sentence for the user.
    after : callable
        Called with a number after each refresh that showed a picture, counted from 1.

    Raises
    ------
    InputError, MachineError
        For wrong options; where there is neither headset nor window, or a lost one stays away.
    """
    if options.record is not None and options.trace:
        refuse_source(options.record, Path(options.trace))
    source = checked_source(options)
    options = source.fitted(options)
    with ExitStack() as stack:
        # Outermost: a signal ends the program only after everything is written.
        ending = stack.enter_context(Ending(options.seconds, options.pictures))
        recorder = None
        if options.record is not None:
            recorder = stack.enter_context(Recorder(options.record, say, force=options.force))
        log = stack.enter_context(LiveLog(options))

        def save_log() -> str:
            log.finish()
            folder = log.result().folder
            return f"the log until then is in {folder}" if folder is not None else ""

        last_words = [save_log] if recorder is None else [recorder.save, save_log]
        watchdog = stack.enter_context(Watchdog(options.hang_s, last_words))
        display = stack.enter_context(closing(open_display(options, source, watchdog.watching, say)))
        ending.now_ns = display.now_ns
        if source.kind.is_timed:
            named = source.scene.name
            of = "the server's scene" if named == SERVER_SCENE else f"scene '{named}' on both ends"
            say(f"connecting to {options.feed.connect}; {of}")
        host = PipelineHost(display, options, source, say)
        stack.callback(host.close)
        slow = smaller_size(display.gpu, options, display.size) if options.view == BOTH else ""
        for note in filter(None, (slow, *source.notes, *source.scene.notes)):
            say(f"note: {note}")
        stack.callback(log.leave)
        if recorder is not None:
            recorder.begin(display.about, display.rate_hz)
        log.begin(display, host)
        try:
            hand = Hand(host, display.now_ns, took_by(recorder, log))
            user = _UserRun(host, log, ending, hand, say)
            Driver(display, host, ending, say).run(user, log, recorder, after)
        except Closed as closed:
            say(str(closed))
        if options.feed.connect and not log.count and ending.asked is not None:
            raise _unshown(options)
    return log.result()


def _unshown(options: LiveOptions, waited_s: float = 0.0) -> MachineError:
    within = f" within {waited_s:.0f} s" if waited_s else ""
    return MachineError(
        f"--connect {options.feed.connect}: no frame that could be shown has arrived{within}: the lines above say why "
        "frames are left out; see whether 'hmdwarp serve' there is of this version"
    )


def took_by(recorder: Recorder | None, log: LiveLog) -> Callable[[InputEvent, bool], None]:
    """Return what a hand calls with its inputs: the recorder takes all, the log those that act."""

    def took(event: InputEvent, moves: bool) -> None:
        if recorder is not None:
            recorder.act(event)
        if not moves:
            log.acted(event)

    return took


class _UserRun(FrameHandler):
    """A run whose user may change everything, up to the limits of the options."""

    pictures = True

    def __init__(self, host: PipelineHost, log: LiveLog, ending: Ending, hand: Hand, say: Say) -> None:
        self._log, self._ending, self._host, self._hand = log, ending, host, hand
        self._commands = CommandHandler(host, say, hand)
        self._began_ns, self._arrived_s = ending.now_ns(), time.monotonic()
        log.status.choices = choices()
        self._show_values()

    def _show_values(self) -> None:
        self._log.status.values = self._host.values()
        self._log.status.has = has(self._host.run)

    def over(self) -> bool:
        options = self._host.options
        waits_s, patience_s = time.monotonic() - self._arrived_s, PATIENCE_S[bool(options.feed.connect)]
        if options.feed.connect:
            # A display's clock may stand still between pictures.
            if waits_s > options.latency_ms * 1e-3 + patience_s and (
                options.source == OFFSCREEN or options.seconds or options.pictures
            ):
                raise _unshown(options, waits_s)
        elif not self._log.count and options.source == OFFSCREEN:  # nobody sees that it waits
            waited_s = (self._ending.now_ns() - self._began_ns) * 1e-9
            if waited_s > options.latency_ms * 1e-3 + patience_s:
                raise InputError(
                    f"no frame has arrived within {waited_s:g} s: expected one after the latency: use less --loss, "
                    "more --bandwidth or a shorter delay"
                )
        return self._ending.due(self._log.count)

    def label(self) -> str:
        remote = self._host.run.source.remote
        return self._commands.refusal or (remote.notice if remote is not None else "")

    def handle(self, commands: Sequence[Command]) -> bool:
        changed = self._commands.handle(commands)
        if changed:
            self._show_values()
        return changed

    def arrived(self, refresh: Refresh) -> None:
        self._arrived_s = time.monotonic()
        self._hand.follow(refresh)

    def on_display_lost(self, why: str) -> None:
        return


def open_display(
    options: LiveOptions,
    source: Source,
    watching: _Watching,
    say: Callable[[str], None],
    controls: tuple[Control, ...] = CONTROLS,
) -> Display:
    """Return the display that the options name; for "auto" a headset if one answers, else a window.

    say: called with the reason for the window. controls: offered to the user.
    Errors: MachineError that names what is missing and what to do.
    """
    trace, fitted = source.head(load_trace(options.trace) if options.trace else None), source.fitted(options)
    same = ("headset", "view", "size", "full_screen", "vsync", "depth_layer", "rate_hz")
    wanted = DisplayOptions(
        **{name: getattr(fitted, name) for name in same},
        emulated=source.headset if source.kind.has_head else None,
        control_panel=options.panel,
        watching=watching,
        trace=trace.track if trace is not None else None,
        controls=controls,
    )
    if options.source == OFFSCREEN:
        return OffscreenDisplay(wanted, real_time=source.kind.is_timed)
    # What was recorded is seen from where the camera was, not from a headset's head.
    if options.source == DESKTOP or source.kind.has_head:
        return desktop.DesktopDisplay(wanted)
    try:
        return openxr.OpenXrDisplay(wanted)
    except MachineError as error:
        why = str(error)
        if options.source == OPENXR:
            raise MachineError(f"{why}; or take a window: --source desktop") from error
    try:
        display = desktop.DesktopDisplay(wanted)
    except MachineError as error:
        raise MachineError(
            f"neither headset nor window: {why}; and {error}; or show it nowhere: --source offscreen"
        ) from error
    say(f"a window, as there is no headset: {why}")
    return display


BY = "hmdwarp record"


def record(options: RecordOptions, say: Say = lambda text: None) -> None:
    """Record until Ctrl-C, the runtime or the window ends it, or for the seconds in the options.

    say: called with a sentence for the user. What was recorded is kept in any case.
    Errors: InputError for wrong options, including an existing file; MachineError for missing
    hardware or software, and for a headset without any pose.
    """
    check_scene_name(options.scene)  # also where no window will show it
    {OPENXR: _of_headset, DESKTOP: _of_window, SYNTHETIC: _made_up}[options.source](options, say)


def _of_window(options: RecordOptions, say: Say) -> None:
    """Record a window's head without latency or warp: the scene is shown as it is."""
    same = ("scene", "scene_options", "force", "seconds", "rate_hz", "reconnect_s", "hang_s")
    shown = LiveOptions(
        **{name: getattr(options, name) for name in same},
        source=DESKTOP,
        warp="none",
        fill="none",
        size=(688, 747),  # less than a headset's: only the head is kept
        latency_ms=0.0,
        record=options.out,
    )
    live(shown, say)


def _made_up(options: RecordOptions, say: Say) -> None:
    track = synthesise(options.kind, seconds=options.seconds, rate_hz=options.rate_hz or RATE_HZ)
    with Ending(None, None) as ending, Recorder(options.out, say, BY, force=options.force) as recorder:
        recorder.begin({"synthetic motion": options.kind}, options.rate_hz or RATE_HZ)
        say(_telling(f"synthetic motion '{options.kind}'", recorder, track.duration_ns * 1e-9))
        began_ns = time.monotonic_ns()
        for index in range(len(track)):
            time_ns = began_ns + int(track.time_ns[index])
            _sleep_until(time_ns)
            recorder.add(PoseSample(time_ns, track.pose(index), Origin.MEASURED))
            if ending.asked is not None:
                return


def _of_headset(options: RecordOptions, say: Say) -> None:
    with (
        Ending(options.seconds, None) as ending,
        Recorder(options.out, say, BY, force=options.force) as recorder,
        Watchdog(options.hang_s, [recorder.save]) as watchdog,
        closing(openxr.OpenXrDisplay(DisplayOptions(watching=watchdog.watching, depth_layer=False))) as shown,
    ):
        rate_hz = min(options.rate_hz or shown.rate_hz, shown.rate_hz)
        if rate_hz < (options.rate_hz or 0):
            say(f"a headset is asked once a refresh: at {rate_hz:g} Hz, not at {options.rate_hz:g}")
        recorder.begin(shown.about, rate_hz)
        say(_telling(f"{shown.about['headset']} at {rate_hz:g} Hz", recorder, options.seconds))
        count, due_ns = 0, shown.now_ns()
        try:
            while not ending.due(count):  # at even intervals, or as often as the runtime wants a picture
                _sleep_until(due_ns)
                try:
                    if shown.wait() is not None:
                        shown.show(None)
                        recorder.add(shown.source.head_at(shown.now_ns()))
                except Lost as lost:
                    recorder.flush()
                    come_back(shown.reopen, lost, options.reconnect_s, ending, say)
                count += 1
                due_ns = max(due_ns + round(1e9 / rate_hz), shown.now_ns())
        except Closed as closed:
            say(str(closed))
        if recorder.count < LEAST and ending.asked is None:
            raise MachineError(
                "the runtime has not told where the head is: put the headset on, where its tracking can see the room"
            )


def _telling(what: str, recorder: Recorder, seconds: float | None) -> str:
    ends = "Ctrl-C ends" if seconds is None else f"{seconds:g} s, Ctrl-C ends sooner"
    return f"recording {what} to {recorder.path} ({ends})"


def _sleep_until(due_ns: int) -> None:
    """Sleep until then; a signal that only requests an end does not wake it."""
    wait_ns = due_ns - time.monotonic_ns()
    if wait_ns > 0:
        time.sleep(wait_ns * 1e-9)
