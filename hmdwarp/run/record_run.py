"""Recording of head motion without a pipeline: from a headset, a window, or a made-up head."""

from __future__ import annotations

import time
from collections.abc import Callable

from ..display import Closed, Lost, openxr
from ..errors import MachineError
from ..poses import Origin, PoseSample
from ..poses.synth import RATE_HZ, synthesise
from ..scenes import check_scene_name
from .ending import Ending, come_back
from .live_run import live
from .options import DESKTOP, OPENXR, SYNTHETIC, LiveOptions, RecordOptions
from .recorder import LEAST, Recorder
from .watchdog import Watchdog

BY = "hmdwarp record"

Say = Callable[[str], None]


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
    """Sample a head at even intervals.

    A source that needs longer than that is sampled as often as it can be read.
    """
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
