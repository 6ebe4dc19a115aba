"""The pipeline of one display, and its changes during a live run."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import attrs

from ..client.plan import Plan, needs_of
from ..display import Display
from ..geometry import GuardBand, Pose
from ..options import AUTO
from ..pipeline.build import Pipeline
from ..pipeline.layers_read import Reads
from ..pipeline.link_times import check_held, expected_age_ns, latency_ns
from ..pipeline.loop import Loop
from ..pipeline.planning import plans_for
from ..pipeline.sizes import guarded_size
from ..pipeline.source import Source
from ..pipeline.source_choice import check_names, source_of
from ..poses import Origin, PoseSample
from ..poses.track import LoopedSource, Moment
from .bench_levels import levels_from_file
from .options import OFFSCREEN, LiveOptions
from .pose_request import RecentPoses
from .setup import EmulatedScreen, RunSetup


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
        lens = "radial" if headset is not None and headset.lens is not None else "none"
    if options.bench is not None:
        sized = attrs.evolve(options, lens="none", size=options.size or screen.size)
        options = attrs.evolve(options, levels=levels_from_file(options.bench, sized, None).levels)
    return attrs.evolve(options, lens=lens)


class PipelineHost:
    """The pipeline for `options` on a display, rebuilt only as far as a change requires.

    A change of latency alone affects the link: frames in transit arrive as scheduled. A change of
    warp or fill whose frames carry the same exchanges the passes. Any other change builds a new
    pipeline, which shows nothing until its first frame arrives.

    Where frames come from elsewhere the latency is the measured one, and there is no scene to
    choose. source: if it is open already. say: called with each line about the connection.
    Errors: InputError and its subclasses for options that cannot run; the old pipeline then stays.
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
        self.source = source or source_of(options)
        with ExitStack() as unfinished:
            unfinished.callback(self.source.close)
            options = self.source.fitted(options)
            setup = self._set_up(options, self.source)
            head = PoseSample(0, Pose((0, 1.6, 0)), Origin.MEASURED)
            # A display whose clock stands still between pictures waits for the server's.
            setup = setup.measured(head, holds=options.source == OFFSCREEN, say=say)
            self.options = attrs.evolve(options, latency_ms=setup.options.latency_ms)
            self.pipeline = self._build(setup)
            unfinished.pop_all()

    @property
    def notice(self) -> str:
        """What is to be shown over the picture about where it comes from, "" for nothing."""
        return self.source.notice

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
        self.source.check_change(before, options)
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
        if AUTO in (before.warp, options.warp) or attrs.evolve(options, **same) != before:
            return False
        (plan,) = self._set_up(options, self.source).plans
        carried = self.pipeline.requested
        if not carried.needs.serve(plan.needs) or not Reads.of([plan]).pictures <= carried.pictures:
            return False
        self.pipeline.exchange(plan)
        return True

    def _rebuild(self, options: LiveOptions) -> None:
        same = options.scene_key == self.options.scene_key
        source = self.source if same else source_of(options)
        made = self._seen(options, source)
        self.pipeline.close()
        self.pipeline, self.source = made, source

    def _seen(self, options: LiveOptions, source: Source) -> Pipeline:
        """Build for the view of these options; on failure, restore the display's view."""
        before = self.options.view
        if options.view == before:
            return self._build(self._set_up(options, source))
        self._display.set_view(options.view)
        try:
            return self._build(self._set_up(options, source))
        except BaseException:
            self._display.set_view(before)
            raise

    def fit(self) -> None:
        """Rebuild if the shown field of view has changed enough to resize the rendered frames."""
        options, sizes = self.options, self.pipeline.sizes
        guard = options.guard_band
        if guard == GuardBand() or "guard" in self.source.kind.sets:
            return
        if guarded_size(guard, self._display.eyes, sizes.shown) != sizes.rendered:
            self._rebuild(options)

    def _set_up(self, options: LiveOptions, source: Source) -> RunSetup[LiveOptions]:
        return RunSetup.of(on_screen(options, self._display), source, self._display)

    def _build(self, setup: RunSetup[LiveOptions]) -> Pipeline:
        shown, link_ns, poses = self._display, latency_ns(setup.options), self._display.source
        moment_of = poses.moment if isinstance(poses, LoopedSource) else Moment
        recent = self._recent
        return setup.build(shown.gpu, recent, recent.track_until, link_ns, link_ns, moment_of=moment_of)

    def close(self) -> None:
        """Free the pipeline, and hang up."""
        self.pipeline.close()
        self.source.close()
