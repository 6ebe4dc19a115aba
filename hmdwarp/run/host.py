"""The pipeline of one display, and its changes during a live run."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import attrs

from ..client.lens import lenses
from ..client.plan import Plan, needs_of
from ..display import Display
from ..errors import InputError
from ..frames import Needs
from ..geometry import GuardBand, Pose
from ..pipeline.build import Pipeline, Target, build_pipeline, check_held, expected_age_ns, latency_ns
from ..pipeline.feed_coding import wish_of
from ..pipeline.layers_read import Reads
from ..pipeline.loop import Loop
from ..pipeline.options import AUTO
from ..pipeline.planning import plans_for
from ..pipeline.recorded_scene import RecordedScene, fitted, scene_of
from ..pipeline.remote import Remote, check_remote, check_shown_elsewhere
from ..pipeline.remote_server import scene_elsewhere
from ..pipeline.sizes import guarded_size
from ..poses import Origin, PoseSample
from ..poses.pose_source import LoopedSource, Moment
from ..scenes import Scene
from .bench_levels import LevelSet, levels_from_file
from .options import OFFSCREEN, LiveOptions
from .pose_request import RecentPoses, check_names, pose_request
from .recorded_frames import ONE_EYE


def checked_scene(options: LiveOptions, scene: Scene | None = None) -> Scene:
    """Return the scene, after all checks that need no display.

    scene: if it is loaded already. Errors: InputError and its subclasses.
    """
    check_names(options)
    if options.lens != AUTO:
        lenses.get(options.lens)
    if options.feed.is_used:
        check_remote(options, recorded=options.is_recorded)
        scene = scene_elsewhere(options.feed.connect)
    scene = scene or scene_of(options)
    if not options.chooses_warp:
        plans = plans_for(attrs.evolve(options, lens="none", fused=False), None, scene)
        if options.feed.is_used:
            check_shown_elsewhere(plans)
    return scene


class PipelineHost:
    """The pipeline for `options` on a display, rebuilt only as far as a change requires.

    A change of latency alone affects the link: frames in transit arrive as scheduled. A change of
    warp or fill whose frames carry the same exchanges the passes. Any other change builds a new
    pipeline, which shows nothing until its first frame arrives.

    Where frames come from elsewhere the latency is the measured one, and there is no scene to
    choose. say: called with each line about the connection.
    Errors: InputError and its subclasses for options that cannot run; the old pipeline then stays.
    MachineError where no server answers.
    """

    def __init__(
        self,
        display: Display,
        options: LiveOptions,
        scene: Scene | None = None,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._display = display
        self._recent = RecentPoses(display.source)
        self._remote = None
        with ExitStack() as unfinished:
            self.scene = scene or scene_of(options)
            if options.feed.is_used:
                # A display whose clock stands still between pictures waits for the server's.
                self._remote = Remote(options.feed, holds=options.source == OFFSCREEN, say=say)
                unfinished.callback(self._remote.close)
                options = self._with_latency_to(self._remote, options)
            self.options = fitted(options, self.scene)
            self.pipeline = self._build(self.options, self.scene)
            unfinished.pop_all()

    def _with_latency_to(self, remote: Remote, options: LiveOptions) -> LiveOptions:
        """Return the options with what is found at the server in place of what is set."""
        head, shown = PoseSample(0, Pose((0, 1.6, 0)), Origin.MEASURED), self._display
        views, size = shown.eyes.views(head.pose), options.size or shown.size
        remote.wish = wish_of(options.coding, shown.rate_hz, views, size, options.latency_ms * 1e-3)
        needs = needs_of(self._plans(options, self.scene, self._levels_for(options)))
        longest_ns = remote.measure(head, views, options.guard_band, size, needs)
        return attrs.evolve(options, scene=options.feed.connect, latency_ms=longest_ns / 1e6)

    @property
    def notice(self) -> str:
        """What is to be shown over the picture about where it comes from, "" for nothing."""
        return self._remote.notice if self._remote is not None else ""

    @property
    def loop(self) -> Loop:
        """The loop over refreshes."""
        return self.pipeline.loop

    @property
    def plan(self) -> Plan:
        """The current plan."""
        return self.loop.compensator.plan

    def change(self, options: LiveOptions) -> None:
        """Continue with these options."""
        before = self.options
        if options == before:
            return
        if self._remote is not None and (options.latency_ms, options.scene) != (before.latency_ms, before.scene):
            raise InputError("latency and scene are the server's, where frames come from one: they stay")
        if attrs.evolve(options, latency_ms=before.latency_ms) == before:
            self._retime(options)
        elif not self._exchanged(before, options):
            self._rebuild(options)
        self.options = options

    def _retime(self, options: LiveOptions) -> None:
        made, rate_hz = self.pipeline, options.rate_hz or self._display.rate_hz
        check_held(made.gpu, options, made.requested.needs, made.sizes, rate_hz)
        made.channel.retime(options.client_link, latency_ns(options))
        made.requested.age_ns = expected_age_ns(options, latency_ns(options), rate_hz)

    def _exchanged(self, before: LiveOptions, options: LiveOptions) -> bool:
        """Exchange the passes if that is enough; return whether it was."""
        same = {name: getattr(before, name) for name in ("warp", "fill", "lens")}
        if before.chooses_warp or options.chooses_warp or attrs.evolve(options, **same) != before:
            return False
        (plan,) = self._plans(options, self.scene, LevelSet())
        carried = self.pipeline.requested
        if not carried.needs.serve(plan.needs) or Reads.of([plan]).pictures > carried.pictures:
            return False
        self.pipeline.exchange(plan)
        return True

    def _rebuild(self, options: LiveOptions) -> None:
        same = options.scene_key == self.options.scene_key
        scene = self.scene if same else scene_of(options)
        made = self._seen(options, scene)
        self.pipeline.close()
        self.pipeline, self.scene = made, scene

    def _seen(self, options: LiveOptions, scene: Scene) -> Pipeline:
        """Build for the view of these options; on failure, restore the display's view."""
        before = self.options.view
        if options.view == before:
            return self._build(options, scene)
        self._display.set_view(options.view)
        try:
            return self._build(options, scene)
        except BaseException:
            self._display.set_view(before)
            raise

    def fit(self) -> None:
        """Rebuild if the shown field of view has changed enough to resize the rendered frames."""
        options, sizes = self.options, self.pipeline.sizes
        guard = options.guard_band
        if guard == GuardBand() or options.is_recorded:
            return
        if guarded_size(guard, self._display.eyes, sizes.shown) != sizes.rendered:
            self._rebuild(options)

    def _levels_for(self, options: LiveOptions) -> LevelSet:
        if options.bench is None:
            return LevelSet()
        size = options.size or self._display.size
        return levels_from_file(options.bench, attrs.evolve(options, lens="none", size=size), None)

    def _plans(self, options: LiveOptions, scene: Scene, choice: LevelSet) -> list[Plan]:
        shown = self._display
        fixed = {"distorts": shown.distorts, "takes_depth": shown.takes_depth}
        plans = plans_for(attrs.evolve(options, lens=self._lens(options)), shown.headset, scene, choice.levels, **fixed)
        if self._remote is not None:
            check_shown_elsewhere(plans)
        return plans

    def _lens(self, options: LiveOptions) -> str:
        """Return "none" where the program has no lens to correct.

        A runtime that corrects its own lens refuses another correction.
        """
        headset = self._display.headset
        if headset is None and not self._display.distorts:
            return "none"
        if options.lens != AUTO:
            return options.lens
        return "radial" if headset is not None and headset.lens is not None else "none"

    def _build(self, options: LiveOptions, scene: Scene) -> Pipeline:
        shown, choice = self._display, self._levels_for(options)
        plans = self._plans(options, scene, choice)
        needs = needs_of(plans)
        refuse_one_eye(needs, len(shown.eyes.views(Pose())))
        if isinstance(scene, RecordedScene):
            refuse_one_eye(needs, 1, ONE_EYE)
        size = options.size or shown.size
        guarded_size(options.guard_band, shown.eyes, size)
        rate_hz = options.rate_hz or shown.rate_hz
        age_ns = expected_age_ns(options, latency_ns(options), rate_hz)
        pictures = Reads.of(plans).pictures
        request = pose_request(options, self._recent, self._recent.track_until, age_ns, size, needs, pictures=pictures)
        target = Target(shown.gpu, shown.eyes, rate_hz, latency_ns(options), shown.headset)
        source = self._display.source
        moment_of = source.moment if isinstance(source, LoopedSource) else Moment
        return build_pipeline(
            options, scene, target, plans, request, choice.levels, remote=self._remote, moment_of=moment_of
        )

    def close(self) -> None:
        """Free the pipeline, and hang up."""
        self.pipeline.close()
        if self._remote is not None:
            self._remote.close()


_FLAT_VIEW = "the flat view has one eye", "use the view of both eyes"


def refuse_one_eye(needs: Needs, eyes: int, told: tuple[str, str] = _FLAT_VIEW) -> None:
    """Raise InputError if the passes need the other eye's picture and the display has one eye.

    told: why it has one, and what to do.
    """
    if needs.others.other_eye and eyes < 2:
        why, remedy = told
        raise InputError(f"{why}, and this warp or fill looks into the other eye's picture: {remedy}")
