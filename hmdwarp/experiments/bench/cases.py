"""The cases of a bench, the combinations in each, and a case made ready to run."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from typing import Any

import attrs

from ...base import MachineError, PlanError, listed
from ...client import every_baseline, every_warp, fill_text, parse_fills, parse_warp
from ...client.effects import effects
from ...client.plan import CLIENT_MODEL, OTHERS, Plan, build_plan
from ...client.strategies import has_own_link, options_of_strategy
from ...client.warps import warps
from ...frames.layers import PICTURE, layers
from ...geometry import Fovea
from ...headsets import Headset
from ...link import LinkOptions
from ...pipeline import PipelineOptions, Source, guard_band
from ...pipeline.recorded_source import RecordingSource
from ...pipeline.sizes import build_plan_for, check_suited, guarded_size
from ...poses import LoadedTrace, PoseTrack, load_trace
from ...run.measuring import OUTSIDE, PLANLESS, Case, Combination, batches, instants_of, missing, outside_plan
from ...run.options import RunOptions, refuse_one_name
from ...run.run import first_shown_s, schedule_for, schedule_of
from ...scenes import CONVERGED, Scene
from ...sources.sequences import open as open_sequence
from ..sweep.options import RecordedOptions
from .options import FILLS, BenchOptions

# Where everything is compared complete fills, which cost about as much as `iterative`, run with
# these: of the warps that read colour and depth those on a Pareto front at 200 ms
# (docs/results-warps.md), the thesis's, and the baselines that leave holes.
WITH_COMPLETE_FILLS = ("forward", "iterative", "multi", "mesh:grid=64", "mesh:grid=512,ring=0.002")
_INCOMPLETE = FILLS[:2]
_RUN = attrs.fields(RunOptions)


def heads_of(options: RecordedOptions, source: Source) -> dict[str, LoadedTrace]:
    """Load the head of each recording. Errors: as load_trace; InputError for two of one name."""
    heads = {}
    for name in options.recordings:
        head = source.head(load_trace(name, options.trace_options) if name else None)
        if head is not None:
            heads[name] = head
    refuse_one_name("recordings", {text: trace.track.name or trace.path.stem for text, trace in heads.items()})
    return heads


def cases_of(options: BenchOptions) -> list[Case]:
    """Return all cases, a recording's latencies one after the other, with every server's rate."""
    product = itertools.product(
        options.sizes, options.scenes, options.recordings, options.latencies_ms, options.server_rates_hz or (None,)
    )
    return [Case(scene, recording, latency, size, hz) for size, scene, recording, latency, hz in product]


def warps_of(options: BenchOptions) -> list[str]:
    """Return the warps of the options, or all that warp a late picture with variants and baselines.

    Each once, as shortest text; those of other libraries last; the oracle has to be named.
    Errors: as parse_warp; MachineError for one of another library that was named and is missing.
    """
    for name in options.warps:
        if name in PLANLESS and (why := missing(name)):
            raise MachineError(f"--warp {name}: {why}")
    every = [*filter(_warps_pictures, every_warp()), *every_baseline()]
    names = options.warps or [*every, *(name for name in OUTSIDE if not missing(name))]
    own = dict.fromkeys(str(parse_warp(text)) for text in names if text not in PLANLESS)
    return [*own, *(name for name in PLANLESS if name in names)]


def baselines() -> dict[str, str]:
    """Return every warp that does what a published or shipped system does, and which one."""
    return every_baseline() | OUTSIDE


def _warps_pictures(text: str) -> bool:
    """Return whether a warp shows pictures of the server, and draws no scene or points instead."""
    warp = parse_warp(text)
    reads = warp.entry.reads_for(warp.settings)
    return CLIENT_MODEL not in reads and any(layer.formats for layer in layers if layer.readable() in reads)


def notes_on_warps(options: BenchOptions) -> list[str]:
    """Return which warps are left out where all are compared, and why."""
    if options.warps or options.strategies:
        return []
    others = listed([entry.name for entry in warps if not _warps_pictures(entry.name)])
    return [
        f"{others} are left out, which draw what the client has of the scene: 'hmdwarp compare' has them, and --warp "
        "NAME takes them here.",
        *(f"{name} is left out: {why}." for name in OUTSIDE if (why := _left_out(options, name))),
    ]


def _left_out(options: BenchOptions, name: str) -> str:
    return missing(name) or ("" if options.lens == "none" else "it has no lens")


def combinations_of(options: BenchOptions, scene: Scene | None) -> list[Combination]:
    """Return each warp with each fill, and the strategies; without a scene, names are checked."""
    found = []
    for warp, fill in pairs_of(options) if options.warps or not options.strategies else []:
        if warp in PLANLESS:
            found.append(Combination(warp, fill, outside_plan(warp)))
        elif options.warps or not _left_aside(options, scene, warp):
            found.append(Combination(warp, fill, plan_of(options, scene, warp, fill, options.lens)))
    for text in options.strategies:
        if has_own_link(text):
            case = Case(options.scenes[0], options.recordings[0], options.latencies_ms[0], options.sizes[0])
            run = own_run(options, case, strategy=text)
            plan = build_plan_for(run, None, scene)
        else:
            sets, run = options_of_strategy(text), RunOptions.of({"strategy": text}, trace=options.recordings[0])
            more = {"effect_names": ",".join((options.effects, sets["effects"])) if "effects" in sets else ""}
            plan = plan_of(options, scene, run.warp, run.fill, options.lens, indirect=run.indirect, **more)
        found.append(Combination(run.warp, run.fill, plan, text))
    return found


def pairs_of(options: BenchOptions) -> list[tuple[str, str]]:
    """Return each warp with each fill, less what is left out where nothing was named."""
    chosen = bool(options.warps) or options.fills != FILLS
    fills, pairs = dict.fromkeys(fill_text(parse_fills(text)) for text in options.fills), list[tuple[str, str]]()
    for warp, fill in itertools.product(warps_of(options), fills):
        if warp in PLANLESS:
            if not _left_out(options, warp) and (warp, "none") not in pairs:
                pairs.append((warp, "none"))
        elif chosen or fill in _INCOMPLETE or warp in WITH_COMPLETE_FILLS:
            pairs.append((warp, fill))
    return pairs


def _left_aside(options: BenchOptions, scene: Scene | None, warp: str) -> str:
    """Return why a warp is left out where all are compared, "" if it is not."""
    if scene is None:
        return ""
    if options.frames is None:
        return parse_warp(warp).entry.unsuited(scene)
    try:
        plan = plan_of(options, scene, warp, "none", "none")
    except PlanError as error:
        return str(error)
    return "one eye" if plan.needs.others.other_eye else ""


def plan_of(
    options: BenchOptions,
    scene: Scene | None,
    warp: str,
    fill: str,
    lens: str,
    *,
    effect_names: str = "",
    indirect: str = CONVERGED,
) -> Plan:
    """Return the plan of a warp and fill in a scene; effect_names: in place of the options'."""
    wanted = effect_names or options.effects
    selected = effects.selected(wanted, effects.of(scene) if scene is not None else (), scene)
    check_suited(scene, parse_warp(warp), indirect)
    recorded = options.frames is not None
    more: dict[str, Any] = {"brings": (*PICTURE, OTHERS) if recorded else None, "named": effects.forced(wanted)}
    more["fovea"] = None if options.fovea_deg is None else Fovea(options.fovea_deg, options.rim)
    return build_plan(selected, warp, fill, lens, client_geometry=not recorded, indirect=indirect, **more)


def run_options(options: BenchOptions, case: Case, **changes: Any) -> RunOptions:
    """Return the options of a run of one case, whose head does not depend on the latency."""
    same = ("effects", "fovea_deg", "rim", "start_s", "predict", "horizon_ms")
    known: dict[str, Any] = options.of_run(*same, "out", "command") | {
        "trace": case.recording,
        "scene": case.scene,
        "latency_ms": case.latency_ms,
        "warp": "none",  # the loop's own; the combinations run alongside
        "fill": "none",
        "lens": "none",
        "size": case.size,
        "network": LinkOptions(server_rate_hz=case.server_rate_hz),
        "guard": options.guard,
        "against": "",
    }
    if options.frames is not None:
        known |= {"frames": options.frames, "scene": _RUN.scene.default}
    return RunOptions(**{**known, **changes})


def own_run(options: BenchOptions, case: Case, *, strategy: str = "", warp: str = "", fill: str = "") -> RunOptions:
    """Return the options of a run of one case for a strategy, or a warp and fill, by itself.

    Its instants, heads and truth are those of `run_options`. Errors: as RunOptions.
    """
    shared = run_options(options, case, lens=options.lens)
    if not strategy:
        return attrs.evolve(shared, warp=warp, fill=fill)
    own = RunOptions.of({"strategy": strategy}, trace=case.recording)
    own = own.over(case.latency_ms, shared.network, shared.coding)
    taken = ["warp", "fill", "indirect", "latency_ms", "proxy", "network", "coding"]
    taken += ["effects"] if "effects" in options_of_strategy(strategy) else []
    return attrs.evolve(shared, strategy=strategy, **{name: getattr(own, name) for name in taken})


def common_start_s(options: BenchOptions, track: PoseTrack, rate_hz: float) -> float:
    """Return the start that suits all latencies: each has a frame. Errors: as schedule_of."""
    first = [options.start_s]
    for latency in options.latencies_ms:
        case = Case("", options.recordings[0], latency, options.sizes[0])
        own = [own_run(options, case, strategy=text) for text in options.strategies if has_own_link(text)]
        for run in (run_options(options, case), *own):
            schedule_of(track, run, rate_hz)
            first.append(first_shown_s(run, rate_hz))
    return max(first)


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

    def run_of(self, batch: Sequence[Combination]) -> RunOptions:
        """Return the run that draws the late frames of a batch: its own, or the shared one."""
        if not any(c.has_own_frames for c in batch):
            return self.run
        (one,) = batch
        of = {"strategy": one.strategy} if one.strategy else {"warp": one.warp, "fill": one.fill}
        return own_run(self.options, self.case, **of)

    def batched(self, most_bytes: float) -> list[list[Combination]]:
        """Return the combinations that fit in so many bytes together."""
        rendered = guarded_size(guard_band(self.options.guard), self.headset, self.case.size)
        return batches(self.combinations, rendered, self.case.size, most_bytes)


def options_of_case(options: BenchOptions, case: Case, start_s: float) -> BenchOptions:
    """Return the options that have this case alone; start_s: of all latencies of its recording."""
    return attrs.evolve(
        options,
        also=(),
        scenes=(case.scene,),
        recordings=(case.recording,),
        latencies_ms=(case.latency_ms,),
        sizes=(case.size,),
        server_rates_hz=() if case.server_rate_hz is None else (case.server_rate_hz,),
        start_s=start_s,
    )


def prepared(options: BenchOptions) -> BenchCase:
    """Return the one case of these options made ready. Errors: InputError and its kin."""
    (case,) = cases_of(options)
    source = source_of(options, case.scene)
    headset = source.headset
    guarded_size(guard_band(options.guard), headset, case.size)
    run = run_options(options, case)
    (head,) = heads_of(options, source).values()
    count = schedule_for(run, source, head, options.rate_hz or headset.refresh_hz).count
    fields = attrs.fields(BenchOptions)
    same = {name: getattr(fields, name).default for name in ("sizes", "latencies_ms", "start_s", "out", "command")}
    combinations = _combinations(attrs.evolve(options, server_rates_hz=(), **same))
    return BenchCase(options, case, headset, run, combinations, len(instants_of(count, options.instants)))


def source_of(options: BenchOptions, scene: str) -> Source:
    """Return the recorded frames of the options, or one of their scenes."""
    if options.frames is not None:
        return RecordingSource(open_sequence(options.frames, options.sequence_options), guard_band(options.guard))
    return Source(PipelineOptions(scene=scene, scene_options=options.scene_options, headset=options.headset))


@functools.lru_cache(maxsize=8)
def _combinations(options: BenchOptions) -> tuple[Combination, ...]:
    (name,) = options.scenes
    return tuple(combinations_of(options, source_of(options, name).scene))
