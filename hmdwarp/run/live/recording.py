"""Recording a head without showing it anything: of a headset, of a window, or made up, each as fast as time goes."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path

import attrs

from ...display import Closed, Lost
from ...errors import MachineError
from ...pipeline.options import number
from ...poses import Origin, PoseSample
from ...poses.synth import RATE_HZ, synthesise
from .ending import Ending
from .options import DESKTOP, OPENXR, LiveOptions, one_of
from .recorder import LEAST, Recorder
from .returning import come_back
from .run import live
from .watchdog import Watchdog

SYNTHETIC = "synthetic"
SOURCES = (OPENXR, DESKTOP, SYNTHETIC)
BY = "hmdwarp record"
Say = Callable[[str], None]


@attrs.frozen(kw_only=True)
class RecordOptions:
    """source: whose head. out: the trace to write; it must not be there yet. seconds: how long; None until Ctrl-C, of a made-up head the
    length its kind has. rate_hz: how often; None for the display's, of a made-up head 90. kind: of the made-up motion.
    scene: what the window shows. reconnect_s, hang_s: as LiveOptions. Errors: InputError for what cannot be meant."""

    source: str = attrs.field(validator=one_of("source", SOURCES))
    out: Path = attrs.field(converter=Path)
    seconds: float | None = attrs.field(default=None, validator=number("seconds", " s", above=True))
    rate_hz: float | None = attrs.field(default=None, validator=number("rate", " Hz", least=1, most=1000))
    kind: str = "look-around"
    scene: str = "room"
    reconnect_s: float = attrs.field(default=60.0, validator=number("reconnect", " s"))
    hang_s: float = attrs.field(default=5.0, validator=number("hang", " s", least=0.1))


@attrs.frozen
class _Head:
    about: Mapping[str, str]
    rate_hz: float


def record(options: RecordOptions, say: Say = lambda text: None) -> None:
    """Until it is ended, by Ctrl-C, by the runtime, by the window, or after the seconds asked for. say: gets a sentence now and then.

    Errors: InputError for what was asked, a file that is there among it; MachineError for what the machine lacks, and where a headset
    told no pose at all. What was recorded until then is there in any case.
    """
    {OPENXR: _of_headset, DESKTOP: _of_window, SYNTHETIC: _made_up}[options.source](options, say)


def _of_window(options: RecordOptions, say: Say) -> None:
    """Without latency and warp: what is shown is the scene as it is."""
    asked = {
        "seconds": options.seconds,
        "rate_hz": options.rate_hz,
        "reconnect_s": options.reconnect_s,
        "hang_s": options.hang_s,
    }
    live(
        LiveOptions(
            source=DESKTOP, scene=options.scene, warp="none", fill="none", latency_ms=0.0, record=options.out, **asked
        ),
        say,
    )


def _made_up(options: RecordOptions, say: Say) -> None:
    track = synthesise(options.kind, seconds=options.seconds, rate_hz=options.rate_hz or RATE_HZ)
    with Ending(None, None) as ending, Recorder(options.out, say, BY) as recorder:
        recorder.begin(_Head({"made-up motion": options.kind}, options.rate_hz or RATE_HZ))
        say(_telling(f"a made-up head, {options.kind}", recorder, track.duration_ns * 1e-9))
        began_ns = time.monotonic_ns()
        for index in range(len(track)):
            time_ns = began_ns + int(track.time_ns[index])
            _sleep_until(time_ns)
            recorder.add(PoseSample(time_ns, track.pose(index), Origin.MEASURED))
            if ending.asked is not None:
                return


def _of_headset(options: RecordOptions, say: Say) -> None:
    from ...display.openxr import OpenXrHead

    with (
        Ending(options.seconds, None) as ending,
        Recorder(options.out, say, BY) as recorder,
        Watchdog(options.hang_s, [recorder.save]) as watchdog,
        OpenXrHead(watchdog.watching) as head,
    ):
        rate_hz = options.rate_hz or head.rate_hz
        recorder.begin(_Head(head.about, rate_hz))
        say(_telling(f"{head.about['headset']} at {rate_hz:g} Hz", recorder, options.seconds))
        _Sampler(head, recorder, ending, round(1e9 / rate_hz), options.reconnect_s, say).run()
        if recorder.count < LEAST and ending.asked is None:
            raise MachineError(
                "the runtime has not told where the head is: put the headset on, where its tracking can see the room"
            )


def _telling(what: str, recorder: Recorder, seconds: float | None) -> str:
    ends = "Ctrl-C ends" if seconds is None else f"{seconds:g} s, Ctrl-C ends sooner"
    return f"recording {what} to {recorder.path} ({ends})"


class _Sampler:
    """Asks a head at even instants. One that takes longer than a period to answer is asked as often as it can be."""

    def __init__(self, head, recorder: Recorder, ending: Ending, period_ns: int, reconnect_s: float, say: Say) -> None:
        self._head, self._recorder, self._ending, self._period_ns = head, recorder, ending, period_ns
        self._reconnect_s, self._say = reconnect_s, say

    def run(self) -> None:
        asked = 0
        due_ns = self._head.now_ns()
        while not self._ending.due(asked):
            _sleep_until(due_ns)
            try:
                if self._head.poll():
                    self._recorder.add(self._head.head_at(self._head.now_ns()))
            except Closed as closed:
                self._say(str(closed))
                return
            except Lost as lost:
                self._recorder.flush()
                come_back(self._head.reopen, lost, self._reconnect_s, self._ending, self._say)
            asked += 1
            due_ns = max(due_ns + self._period_ns, self._head.now_ns())


def _sleep_until(due_ns: int) -> None:
    """A signal that only asks for an end does not wake it."""
    wait_ns = due_ns - time.monotonic_ns()
    if wait_ns > 0:
        time.sleep(wait_ns * 1e-9)
