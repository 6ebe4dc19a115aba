"""One case of a bench made ready: its run, its combinations, and how many refreshes it measures."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import attrs

from ...headsets import Headset
from ...pipeline.options import PipelineOptions
from ...pipeline.recorded_source import RecordingSource
from ...pipeline.sizes import guarded_size
from ...pipeline.source import Source
from ...poses import load_trace
from ...run.combinations import Case, Combination, batches, instants_of
from ...run.options import RunOptions
from ...run.schedule import schedule_for
from ...sources.sequences import open as open_sequence
from .cases import cases_of, combinations_of, own_run, run_options
from .options import BenchOptions


@attrs.frozen(eq=False)
class BenchCase:
    """A case with its run, its combinations and the number of its measured instants."""

    # With this case alone.
    options: BenchOptions
    case: Case
    headset: Headset
    run: RunOptions
    combinations: tuple[Combination, ...]
    instants: int

    @property
    def warped(self) -> list[Combination]:
        """The combinations that compare warps with each other."""
        return [c for c in self.combinations if not c.is_outside and not c.strategy and not c.has_own_frames]

    def run_of(self, batch: Sequence[Combination]) -> RunOptions:
        """Return the run that draws the late frames of a batch: its own, or the shared one."""
        if not any(c.has_own_frames for c in batch):
            return self.run
        (combination,) = batch
        if combination.strategy:
            return own_run(self.options, self.case, strategy=combination.strategy)
        return own_run(self.options, self.case, warp=combination.warp, fill=combination.fill)

    def batched(self, most_bytes: float, pictures: int = 0) -> list[list[Combination]]:
        """Return the combinations that fit in so many bytes together, each with some pictures."""
        rendered = guarded_size(self.options.guard_band, self.headset, self.case.size)
        return batches(self.combinations, rendered, self.case.size, most_bytes, pictures)


def options_of_case(options: BenchOptions, case: Case, start_s: float) -> BenchOptions:
    """Return the options that have this case alone; start_s: of all latencies of its recording."""
    return attrs.evolve(
        options,
        scenes=(case.scene,),
        recordings=(case.recording,),
        latencies_ms=(case.latency_ms,),
        sizes=(case.size,),
        server_rates_hz=() if case.server_rate_hz is None else (case.server_rate_hz,),
        start_s=start_s,
        budget_ms=None,
        grid=False,
        fused=False,
        parquet=False,
    )


def prepared(options: BenchOptions) -> BenchCase:
    """Return the one case of these options made ready. Errors: InputError and its kin."""
    (case,) = cases_of(options)
    source = source_of(options, case.scene)
    headset = source.headset
    guarded_size(options.guard_band, headset, case.size)
    run = run_options(options, case)
    trace = source.head(load_trace(case.recording, options.trace_options) if case.recording else None)
    assert trace is not None, "a case without a recording has a source with a head"
    count = schedule_for(run, source, trace, options.rate_hz or headset.refresh_hz).count
    combinations = _combinations(_of_scene(options))
    return BenchCase(options, case, headset, run, combinations, len(instants_of(count, options.instants)))


def source_of(options: BenchOptions, scene: str) -> Source:
    """Return the recorded frames of the options, or one of their scenes."""
    if options.frames is not None:
        return RecordingSource(open_sequence(options.frames, options.sequence_options))
    return Source(PipelineOptions(scene=scene, scene_options=options.scene_options, headset=options.headset))


def _of_scene(options: BenchOptions) -> BenchOptions:
    """Return the options that the combinations depend on: those of all cases of a scene are one."""
    fields = attrs.fields(BenchOptions)
    same = {name: getattr(fields, name).default for name in ("sizes", "latencies_ms", "start_s", "out", "command")}
    return attrs.evolve(options, server_rates_hz=(), **same)


@functools.lru_cache(maxsize=8)
def _combinations(options: BenchOptions) -> tuple[Combination, ...]:
    (name,) = options.scenes
    return tuple(combinations_of(options, source_of(options, name).scene))
