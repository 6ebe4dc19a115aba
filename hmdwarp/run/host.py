"""The pipeline of one display, and its changes during a live run by the commands of a user."""

from __future__ import annotations

import time
from bisect import bisect_left
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

import attrs
import numpy as np

from ..client.plan import needs_of
from ..client.variants import every_fill, every_warp
from ..display import MOVED, Command, Display, Lost, control
from ..errors import InputError, MachineError
from ..geometry import GuardBand, Pose
from ..options import AUTO
from ..pipeline.channel import Reads
from ..pipeline.loop import Refresh
from ..pipeline.options import PROXY, SCENE
from ..pipeline.proxy import check_names, source_of
from ..pipeline.sizes import check_held, expected_age_ns, guarded_size, latency_ns, plans_for
from ..pipeline.source import Source
from ..poses import Origin, PoseSample, PoseSource, PoseTrack, gaze_of, jumps_between
from ..poses.track import LoopedSource, Moment
from ..scenes import ACTIONS, GRAB, PUSH, RELEASE, InputEvent, SceneOptions, scenes
from .choosing import levels_from_file
from .options import BOTH, FLAT, OFFSCREEN, LiveOptions
from .run import EmulatedScreen, Run


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

    The lens is "none" where the program has none to correct: a runtime that corrects its own
    refuses another correction. Errors: as levels_from_file.
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
    """A pose source that keeps the last second of its answers.

    A recentre, a snap turn or a teleport is a jump of the track, as in a recording.
    """

    def __init__(self, source: PoseSource) -> None:
        self._source = source
        self._kept: list[PoseSample] = []

    def start(self) -> None:
        """Start the source."""
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
        """Close the source."""
        self._source.close()


class PipelineHost:
    """The run for `options` on a display, made anew only as far as a change requires.

    A change of latency alone affects the link: frames in transit arrive as scheduled. A change of
    warp or fill whose frames carry the same exchanges the passes. Any other change makes a new run,
    which shows nothing until its first frame arrives.

    Where frames come from elsewhere the latency is the measured one, and there is no scene to
    choose. source: if it is open already. say: called with each line about the connection.
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
            self.run = self._checked(options, source)
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
        (plan,) = self._checked(options, self.run.source).plans
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
            made = self._start(self._checked(options, source))
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

    def _checked(self, options: LiveOptions, source: Source) -> Run[LiveOptions]:
        return Run.of(on_screen(options, self._display), source, self._display)

    def _start(self, run: Run[LiveOptions]) -> Run[LiveOptions]:
        link_ns, poses, recent = latency_ns(run.options), self._display.source, self._recent
        moment_of = poses.moment if isinstance(poses, LoopedSource) else Moment
        return run.start(self._display.gpu, recent, recent.track_until, link_ns, link_ns, moment_of)

    def close(self) -> None:
        """Free the run, and hang up."""
        self.run.close()
        self.run.source.close()


LATENCY_STEP_MS, GUARD_STEP = 50.0, 0.25
READING_S = 4.0  # how long a refusal stays over the picture: time to read two lines


def choices() -> dict[str, tuple[object, ...]]:
    """Return the allowed values of the controls of kind "choice"."""
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
    return {
        "latency": options.latency_ms,
        "warp": options.warp,
        "fill": options.fill,
        "guard": max(guard.x, guard.y),
        "scene": options.scene,
        "effects": options.effects,
        "lens": options.lens,
        "view": options.view,
    }


def changed(options: LiveOptions, command: Command) -> LiveOptions:
    """Return the options after the command. Errors: InputError for a value out of range."""
    name, value = command.control, command.value
    if name not in _STEPS:
        raise InputError(f"control '{name}' changes nothing of the run: expected {', '.join(_STEPS)}")
    options.source_kind.refuse_change(name)
    value = _STEPS[name](options, -1 if command.back else 1) if value is None else _checked(name, value)
    change: dict[str, Any] = {"latency_ms" if name == "latency" else name: value}
    if name == "scene":
        change["scene_options"] = SceneOptions()  # those of a file, which this scene is not
    if name == "guard":
        change["rendered_size"] = None
    return attrs.evolve(options, **change)


def _checked(name: str, value: object) -> object:
    """Return a number within its range, or a word unchanged. Errors: InputError."""
    meant = control(name)
    if meant.kind != "number":
        if not isinstance(value, str):
            raise InputError(f"{name} {value!r}: expected a word")
        return value
    least, most = meant.span
    if not isinstance(value, int | float) or not least <= value <= most:
        raise InputError(f"{name} {value}: expected a number from {least:g} to {most:g}")
    return float(value)


def _along(name: str) -> Callable[[LiveOptions, int], object]:
    def step(options: LiveOptions, direction: int) -> object:
        known, now = choices()[name], values(options)[name]
        at = known.index(now) + direction if now in known else 0
        return known[at % len(known)]

    return step


def _within(name: str, value: float) -> float:
    least, most = control(name).span
    return min(max(value, least), most)


_STEPS: dict[str, Callable[[LiveOptions, int], object]] = {
    **{name: _along(name) for name in ("warp", "fill", "scene", "effects")},
    "latency": lambda o, way: _within("latency", o.latency_ms + way * LATENCY_STEP_MS),
    # A rendered size begins at 1.
    "guard": lambda o, way: _within("guard", max(o.guard_band.x, o.guard_band.y) + way * GUARD_STEP),
    "lens": lambda o, _: "none" if o.lens != "none" else AUTO,
    "view": lambda o, _: FLAT if o.view == BOTH else BOTH,
}


def has(run: Run[LiveOptions]) -> frozenset[str]:
    """Return what of the needs of controls the run has: see `display.controls.Control.needs`."""
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
        """Apply the commands; return whether the options changed.

        Stepping onto a value that is refused continues to the next one.
        """
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
