"""Runs on a display, live or recording a head: the loop driven by it, once a refresh."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from pathlib import Path
from typing import Protocol

from ..display import (
    CONTROLS,
    Closed,
    Command,
    Control,
    Display,
    DisplayOptions,
    Label,
    Lost,
    OffscreenDisplay,
    Tick,
    desktop,
    openxr,
)
from ..errors import InputError, MachineError
from ..options import AUTO
from ..pipeline.loop import Refresh
from ..pipeline.options import SERVER_SCENE
from ..pipeline.sizes import smaller_size
from ..pipeline.source import Source
from ..poses import Origin, PoseSample, load_trace
from ..poses.synth import RATE_HZ, synthesise
from ..report import refuse_source
from ..scenes import InputEvent, check_scene_name
from .ending import Ending, GarbageControl, Watchdog, come_back
from .host import CommandHandler, Hand, PipelineHost, checked_source, choices, has, values
from .live_log import LiveLog, LiveResult
from .options import BOTH, DESKTOP, OFFSCREEN, OPENXR, SYNTHETIC, LiveOptions, RecordOptions
from .recorder import LEAST, Recorder

Say = Callable[[str], None]
AfterRefresh = Callable[[int], None]
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
        ...

    def label(self) -> Label:
        """Return the text over the picture, "" for none."""
        ...

    def handle(self, commands: Sequence[Command]) -> bool:
        """Apply the commands; return whether the options of the run changed."""
        ...

    def arrived(self, refresh: Refresh) -> None:
        """Handle a refresh that has a frame, shown or not."""
        ...

    def on_display_lost(self, why: str) -> None:
        """Handle the loss of the display; it may come back."""
        ...


class Driver:
    """Drive one display and its pipeline. A stretch may have its own log and recorder.

    Waits for a lost display as long as the options allow.
    """

    def __init__(self, display: Display, host: PipelineHost, ending: Ending, say: Say) -> None:
        """Drive a display.

        ending: a signal ends every stretch. say: called with a sentence for the user.
        """
        self._display, self._host, self._ending, self._say = display, host, ending, say

    def run(
        self,
        handler: FrameHandler,
        log: LiveLog | None = None,
        recorder: Recorder | None = None,
        after: AfterRefresh = lambda number: None,
    ) -> None:
        """Run until `handler` is over or a signal arrives.

        after(number): called after each refresh that showed a picture, counted from 1.
        Errors: Closed, when the window or session was closed; Lost, when the display did not come
        back in time.
        """
        number = 0
        with GarbageControl(self._host.options.collect and (handler.pictures or handler.ahead)) as garbage:
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
                        garbage.between()
                    if handler.handle(self._display.commands()) and log is not None:
                        log.changed(self._host)
                except Lost as lost:
                    self._come_back(lost, handler, log, recorder)

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

    def _come_back(self, lost: Lost, handler: FrameHandler, log: LiveLog | None, recorder: Recorder | None) -> None:
        """Wait until the display is back. Errors: Lost, when that takes too long."""
        handler.on_display_lost(str(lost))
        if recorder is not None:
            recorder.flush()
        if log is not None:
            log.on_display_lost(str(lost))
        back = come_back(self._display.reopen, lost, self._host.options.reconnect_s, self._ending, self._say)
        if back and log is not None:
            log.came_back()


Watching = Callable[[str], AbstractContextManager[None]]


def live(options: LiveOptions, say: Say = lambda text: None, after: AfterRefresh = lambda number: None) -> LiveResult:
    """Run until the window, the runtime or Ctrl-C ends it, or as long as the options say.

    say: called with a sentence for the user. after(number): called after each refresh that showed a
    picture, counted from 1.
    Errors: InputError and its subclasses for wrong options; MachineError where there is neither
    headset nor window, and where a lost headset does not come back. Recording and log up to that
    point are written in any case.
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
        watchdog = stack.enter_context(Watchdog(options.hang_s, _last_words(recorder, log)))
        display = stack.enter_context(closing(open_display(options, source, watchdog.watching, say)))
        ending.now_ns = display.now_ns
        if source.kind.is_timed:
            of = (
                "the server's scene"
                if source.scene.name == SERVER_SCENE
                else f"scene '{source.scene.name}' on both ends"
            )
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
            user = _UserRun(host, log, ending, _Pace(display, options, say), hand)
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


def _last_words(recorder: Recorder | None, log: LiveLog) -> list[Callable[[], str]]:
    """Return what the watchdog runs before it ends the program: the recording first."""

    def save_log() -> str:
        log.finish()
        folder = log.result().folder
        return f"the log until then is in {folder}" if folder is not None else ""

    return [lambda: recorder.save() if recorder is not None else "", save_log]


JUDGED_NS = 1_000_000_000  # from the first picture: what a machine makes in a second, it makes in the next


class _Pace:
    """Tells once, a second after the first picture, that most refreshes get none."""

    def __init__(self, display: Display, options: LiveOptions, say: Say) -> None:
        self.say = say
        self._display, self._options = display, options
        self._count, self._began_ns, self._over = 0, 0, False

    def picture(self) -> None:
        """Count a picture."""
        now_ns = self._display.now_ns()
        self._began_ns = self._began_ns or now_ns
        took_ns = now_ns - self._began_ns
        if took_ns >= JUDGED_NS and not self._over:
            self._over = True
            refreshes = round(took_ns * 1e-9 * (self._options.rate_hz or self._display.rate_hz))
            if 2 * self._count < refreshes:
                self.say(
                    f"note: {self._count} of {refreshes} refreshes got a picture: this machine is too slow for these "
                    f"options; a smaller --size helps{'' if self._options.warp == AUTO else ', or --warp auto'}"
                )
        self._count += 1


class _UserRun(FrameHandler):
    """A run whose user may change everything, up to the limits of the options."""

    pictures = True

    def __init__(self, host: PipelineHost, log: LiveLog, ending: Ending, pace: _Pace, hand: Hand) -> None:
        self._log, self._ending, self._host, self._pace, self._hand = log, ending, host, pace, hand
        self._commands = CommandHandler(host, pace.say, hand)
        self._began_ns, self._arrived_s = ending.now_ns(), time.monotonic()
        log.status.choices = choices()
        self._show_values()

    def _show_values(self) -> None:
        self._log.status.values = values(self._host.options, self._host.run.sizes.shown)
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
        self._pace.picture()
        self._hand.follow(refresh)

    def on_display_lost(self, why: str) -> None:
        return


def open_display(
    options: LiveOptions,
    source: Source,
    watching: Watching,
    say: Callable[[str], None],
    controls: tuple[Control, ...] = CONTROLS,
    *,
    briefly: bool = False,
) -> Display:
    """Return the display that the options name.

    For "auto": the headset if one answers, else the window.

    say: called with the reason for the window. controls: offered to the user. briefly: give that
    reason in a clause, and leave the rest to the doctor.
    Errors: MachineError (and its subclasses) that names what is missing and what to do: for "auto"
    of both.
    """
    wanted = display_options(options, source, watching, controls)
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
    if briefly:
        why = f"{re.split('[:;] ', why, maxsplit=1)[0]} (hmdwarp doctor tells more)"
    say(f"a window, as there is no headset: {why}")
    return display


def display_options(
    options: LiveOptions, source: Source, watching: Watching, controls: tuple[Control, ...] = CONTROLS
) -> DisplayOptions:
    """Return the options that the display needs of the run."""
    trace = source.head(load_trace(options.trace) if options.trace else None)
    options = source.fitted(options)
    return DisplayOptions(
        headset=options.headset,
        emulated=source.headset if source.kind.has_head else None,
        view=options.view,
        size=options.size,
        full_screen=options.full_screen,
        vsync=options.vsync,
        control_panel=options.panel,
        depth_layer=options.depth_layer,
        watching=watching,
        trace=trace.track if trace is not None else None,
        rate_hz=options.rate_hz,
        controls=controls,
    )


BY = "hmdwarp record"


def record(options: RecordOptions, say: Say = lambda text: None) -> None:
    """Record until Ctrl-C, the runtime or the window ends it, or for the seconds in the options.

    say: called with a sentence for the user.
    Errors: InputError for wrong options, including an existing file; MachineError for missing
    hardware or software, and for a headset without any pose. The recording up to that point is kept
    in any case.
    """
    check_scene_name(options.scene)  # also where no window will show it
    {OPENXR: _of_headset, DESKTOP: _of_window, SYNTHETIC: _made_up}[options.source](options, say)


def _of_window(options: RecordOptions, say: Say) -> None:
    """Record a window's head without latency or warp: the scene is shown as it is."""
    shown = LiveOptions(
        source=DESKTOP,
        scene=options.scene,
        scene_options=options.scene_options,
        warp="none",
        fill="none",
        size=(688, 747),  # less than a headset's: only the head is kept
        latency_ms=0.0,
        record=options.out,
        force=options.force,
        seconds=options.seconds,
        rate_hz=options.rate_hz,
        reconnect_s=options.reconnect_s,
        hang_s=options.hang_s,
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
        openxr.OpenXrHead(watchdog.watching) as head,
    ):
        rate_hz = options.rate_hz or head.rate_hz
        recorder.begin(head.about, rate_hz)
        say(_telling(f"{head.about['headset']} at {rate_hz:g} Hz", recorder, options.seconds))
        _sample(head, recorder, ending, round(1e9 / rate_hz), options.reconnect_s, say)
        if recorder.count < LEAST and ending.asked is None:
            raise MachineError(
                "the runtime has not told where the head is: put the headset on, where its tracking can see the room"
            )


def _telling(what: str, recorder: Recorder, seconds: float | None) -> str:
    ends = "Ctrl-C ends" if seconds is None else f"{seconds:g} s, Ctrl-C ends sooner"
    return f"recording {what} to {recorder.path} ({ends})"


def _sample(
    head: openxr.OpenXrHead, recorder: Recorder, ending: Ending, period_ns: int, reconnect_s: float, say: Say
) -> None:
    """Sample a head at even intervals, or as often as its source can be read."""
    count = 0
    due_ns = head.now_ns()
    while not ending.due(count):
        _sleep_until(due_ns)
        try:
            if head.poll():
                recorder.add(head.head_at(head.now_ns()))
        except Closed as closed:
            say(str(closed))
            return
        except Lost as lost:
            recorder.flush()
            come_back(head.reopen, lost, reconnect_s, ending, say)
        count += 1
        due_ns = max(due_ns + period_ns, head.now_ns())


def _sleep_until(due_ns: int) -> None:
    """Sleep until then; a signal that only requests an end does not wake it."""
    wait_ns = due_ns - time.monotonic_ns()
    if wait_ns > 0:
        time.sleep(wait_ns * 1e-9)
