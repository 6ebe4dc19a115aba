"""What is on: one display's pipeline, and how it changes while the run goes on."""

from __future__ import annotations

import attrs

from ...client.lens import lenses
from ...client.plan import Plan, needs_of
from ...display import Display
from ...errors import InputError
from ...frames import Needs
from ...geometry import Pose
from ...link.codec import check_codec
from ...pipeline.build import Pipeline, Timing, build_pipeline, check_held, expected_age_ns, latency_ns
from ...pipeline.loop import Loop, PoseRequest
from ...pipeline.options import AUTO
from ...pipeline.planning import plans_for
from ...pipeline.sizes import guarded_size
from ...poses.predictors import predictors
from ...scenes import Scene, load_scene
from ..bench_levels import Ladder, ladder_from_file
from .options import LiveOptions
from .recent import Recent


def checked_scene(options: LiveOptions, scene: Scene | None = None) -> Scene:
    """The scene, after everything that can be told wrong without a display. scene: where it is loaded already.
    Errors: InputError and its kin."""
    predictors.get(options.predict)
    check_codec(options.coding.codec)
    if options.lens != AUTO:
        lenses.get(options.lens)
    scene = scene or load_scene(options.scene)
    if options.warp != AUTO:
        plans_for(attrs.evolve(options, lens="none", fused=False), None, scene)
    return scene


class Stage:
    """The pipeline for `options` on a display, built anew only as far as a change of options calls for it.

    A change of latency alone touches the link: frames under way arrive as they would have. A change of warp or fill whose frames carry
    the same exchanges the passes. Anything else builds a new pipeline, and its first frame has to arrive first.
    Errors: InputError and its kin for what cannot be; the stage stays as it was then.
    """

    def __init__(self, display: Display, options: LiveOptions, scene: Scene | None = None) -> None:
        self._display = display
        self.recent = Recent(display.source)
        self.options, self.scene, self._ladder = options, scene or load_scene(options.scene), self._ladder_for(options)
        self.pipeline = self._build(options, self.scene, self._ladder)

    @property
    def loop(self) -> Loop:
        """One refresh after the other."""
        return self.pipeline.loop

    @property
    def plan(self) -> Plan:
        """What runs."""
        return self.loop.compensator.plan

    def change(self, options: LiveOptions) -> None:
        """Go on with these."""
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
        made.channel.retime(options.network, latency_ns(options))

    def _exchanged(self, before: LiveOptions, options: LiveOptions) -> bool:
        """Whether it was enough to exchange the passes."""
        same = {name: getattr(before, name) for name in ("warp", "fill", "lens")}
        if AUTO in (before.warp, options.warp) or attrs.evolve(options, **same) != before:
            return False
        (plan,) = self._plans(options, self.scene, Ladder())
        if not self.pipeline.requested.needs.serve(plan.needs):
            return False
        self.pipeline.exchange(plan)
        return True

    def _rebuild(self, options: LiveOptions) -> None:
        scene = self.scene if options.scene == self.options.scene else load_scene(options.scene)
        ladder = self._ladder_for(options)
        made = self._seen(options, scene, ladder)
        self.pipeline.close()
        self.pipeline, self.scene, self._ladder = made, scene, ladder

    def _seen(self, options: LiveOptions, scene: Scene, ladder: Ladder) -> Pipeline:
        """Built for the view of these options; where that fails, the display looks as before."""
        before = self.options.view
        if options.view == before:
            return self._build(options, scene, ladder)
        self._display.look(options.view)
        try:
            return self._build(options, scene, ladder)
        except BaseException:
            self._display.look(before)
            raise

    def fit(self) -> None:
        """Build anew where the eyes have come to see so much more or less that frames with their guard band get another size."""
        options = self.options
        if (
            options.guard > 1
            and guarded_size(options.guard, self._display.eyes, self.pipeline.sizes.shown)
            != self.pipeline.sizes.rendered
        ):
            self._rebuild(options)

    def _ladder_for(self, options: LiveOptions) -> Ladder:
        if options.warp != AUTO:
            return Ladder()
        size = options.size or self._display.size
        return ladder_from_file(options.bench, attrs.evolve(options, lens="none", size=size), None)

    def _plans(self, options: LiveOptions, scene: Scene, ladder: Ladder) -> list[Plan]:
        shown = self._display
        told = {"distorts": shown.distorts, "takes_depth": shown.takes_depth}
        return plans_for(attrs.evolve(options, lens=self._lens(options)), shown.headset, scene, ladder.levels, **told)

    def _lens(self, options: LiveOptions) -> str:
        """Where nobody's lens is ours to correct, none; a runtime that corrects its own refuses another."""
        headset = self._display.headset
        if headset is None and not self._display.distorts:
            return "none"
        if options.lens != AUTO:
            return options.lens
        return "radial" if headset is not None and headset.lens is not None else "none"

    def _build(self, options: LiveOptions, scene: Scene, ladder: Ladder) -> Pipeline:
        shown = self._display
        plans = self._plans(options, scene, ladder)
        needs = needs_of(plans)
        refuse_one_eye(needs, len(shown.eyes.views(Pose())))
        size = options.size or shown.size
        guarded_size(options.guard, shown.eyes, size)
        predicted = self.recent.predictor(
            options.predict, expected_age_ns(options, latency_ns(options)), options.horizon_ms
        )
        requested = PoseRequest(self.recent, predicted, size, options.guard, needs, round(options.scanout_ms * 1e6))
        timing = Timing(options.rate_hz or shown.rate_hz, latency_ns(options))
        return build_pipeline(
            shown.gpu, options, scene, shown.eyes, plans, requested, timing, shown.headset, ladder.levels
        )

    def close(self) -> None:
        """Free it."""
        self.pipeline.close()


def refuse_one_eye(needs: Needs, eyes: int) -> None:
    """Errors: InputError where the passes look into the other eye's picture, and there is none."""
    if needs.others.other_eye and eyes < 2:
        raise InputError(
            "the flat view has one eye, and this warp or fill looks into the other eye's picture: use the view of both eyes"
        )
