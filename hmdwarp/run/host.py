"""The pipeline of one display, and its changes during a live run."""

from __future__ import annotations

import attrs

from ..client.lens import lenses
from ..client.plan import Plan, needs_of
from ..display import Display
from ..errors import InputError
from ..frames import Needs
from ..geometry import GuardBand, Pose
from ..pipeline.build import Pipeline, Target, build_pipeline, check_held, expected_age_ns, latency_ns
from ..pipeline.layers_read import Reads
from ..pipeline.loop import Loop
from ..pipeline.options import AUTO
from ..pipeline.planning import plans_for
from ..pipeline.recorded_scene import RecordedScene, fitted, scene_of
from ..pipeline.sizes import guarded_size
from ..poses.looped import LoopedSource, Moment
from ..scenes import Scene
from .bench_levels import LevelSet, levels_from_file
from .options import LiveOptions
from .pose_request import RecentPoses, check_names, pose_request
from .recorded_frames import ONE_EYE


def checked_scene(options: LiveOptions, scene: Scene | None = None) -> Scene:
    """Return the scene, after all checks that need no display.

    scene: if it is loaded already. Errors: InputError and its subclasses.
    """
    check_names(options)
    if options.lens != AUTO:
        lenses.get(options.lens)
    scene = scene or scene_of(options)
    if not options.chooses_warp:
        plans_for(attrs.evolve(options, lens="none", fused=False), None, scene)
    return scene


class PipelineHost:
    """The pipeline for `options` on a display, rebuilt only as far as a change requires.

    A change of latency alone affects the link: frames in transit arrive as scheduled. A change of
    warp or fill whose frames carry the same exchanges the passes. Any other change builds a new
    pipeline, which shows nothing until its first frame arrives.
    Errors: InputError and its subclasses for options that cannot run; the old pipeline then stays.
    """

    def __init__(self, display: Display, options: LiveOptions, scene: Scene | None = None) -> None:
        self._display = display
        self._recent = RecentPoses(display.source)
        self.scene = scene or scene_of(options)
        self.options = fitted(options, self.scene)
        self.pipeline = self._build(self.options, self.scene)

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
        if attrs.evolve(options, latency_ms=before.latency_ms) == before:
            self._retime(options)
        elif not self._exchanged(before, options):
            self._rebuild(options)
        self.options = options

    def _retime(self, options: LiveOptions) -> None:
        made, rate_hz = self.pipeline, options.rate_hz or self._display.rate_hz
        check_held(made.gpu, options, made.requested.needs, made.sizes, rate_hz)
        made.channel.retime(options.client_link, latency_ns(options))

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
        return plans_for(attrs.evolve(options, lens=self._lens(options)), shown.headset, scene, choice.levels, **fixed)

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
        return build_pipeline(options, scene, target, plans, request, choice.levels, moment_of=moment_of)

    def close(self) -> None:
        """Free the pipeline."""
        self.pipeline.close()


_FLAT_VIEW = "the flat view has one eye", "use the view of both eyes"


def refuse_one_eye(needs: Needs, eyes: int, told: tuple[str, str] = _FLAT_VIEW) -> None:
    """Raise InputError if the passes need the other eye's picture and the display has one eye.

    told: why it has one, and what to do.
    """
    if needs.others.other_eye and eyes < 2:
        why, remedy = told
        raise InputError(f"{why}, and this warp or fill looks into the other eye's picture: {remedy}")
