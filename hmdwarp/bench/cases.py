"""The cases of a bench and the combinations in each."""

from __future__ import annotations

import itertools
from typing import Any

from ..client.effects import effects
from ..client.plan import Plan, build_plan
from ..client.variants import every_warp, fill_text, parse_fills, parse_warp
from ..link import LinkOptions
from ..pipeline.build import refreshes_of
from ..poses import PoseTrack
from ..run.combinations import Case, Combination
from ..run.options import RunOptions
from ..run.schedule import schedule_of
from ..scenes import Scene
from .options import BenchOptions


def cases_of(options: BenchOptions) -> list[Case]:
    """Return all cases, a recording's latencies one after the other, with every server's rate."""
    product = itertools.product(
        options.sizes, options.scenes, options.recordings, options.latencies_ms, options.server_rates_hz or (None,)
    )
    return [Case(scene, recording, latency, size, hz) for size, scene, recording, latency, hz in product]


def warps_of(options: BenchOptions) -> list[str]:
    """Return the warps of the options, or all with their variants, as shortest text, each once.

    Errors: as parse_warp.
    """
    return list(dict.fromkeys(str(parse_warp(text)) for text in (options.warps or every_warp())))


def fills_of(options: BenchOptions) -> list[str]:
    """Return the fills and chains of the options as their shortest text, each once.

    Errors: as parse_fills.
    """
    return list(dict.fromkeys(fill_text(parse_fills(text)) for text in options.fills))


def combinations_of(options: BenchOptions, scene: Scene | None) -> list[Combination]:
    """Return each warp with each fill. Without a scene yet, only the names are checked.

    Errors: as build_plan.
    """
    pairs, lens = itertools.product(warps_of(options), fills_of(options)), options.lens
    return [Combination(w, f, plan_of(options, scene, w, f, lens)) for w, f in pairs]


def plan_of(
    options: BenchOptions, scene: Scene | None, warp: str, fill: str, lens: str, *, fused: bool = False
) -> Plan:
    """Return the plan of a warp and fill in a scene, with the effects of the options.

    Errors: as build_plan.
    """
    selected = effects.selected(options.effects, effects.of(scene) if scene is not None else ())
    named = effects.forced(options.effects)
    return build_plan(selected, warp, fill, lens, client_geometry=True, named=named, fused=fused)


def run_options(options: BenchOptions, case: Case, **changes: Any) -> RunOptions:
    """Return the options of a run of one case.

    Its first refresh does not depend on the latency, so that all latencies have the same head.
    """
    known: dict[str, Any] = {
        "trace": case.recording,
        "scene": case.scene,
        "scene_options": options.scene_options,
        "latency_ms": case.latency_ms,
        "warp": "none",  # the loop's own; the combinations run beside it
        "fill": "none",
        "effects": options.effects,
        "lens": "none",
        "headset": options.headset,
        "size": case.size,
        "rate_hz": options.rate_hz,
        "network": LinkOptions(server_rate_hz=case.server_rate_hz),
        "start_s": options.start_s,
        "seconds": options.seconds,
        "guard": 1.0 if options.rendered_size else options.guard,
        "rendered_size": options.rendered_size,
        "against": "",
        "trace_options": options.trace_options,
        "out": options.out,
        "command": options.command,
    }
    return RunOptions(**{**known, **changes})


def common_start_s(options: BenchOptions, track: PoseTrack, rate_hz: float) -> float:
    """Return the start that suits all latencies; check that each has a frame to show.

    Errors: as schedule_of.
    """
    for latency in options.latencies_ms:
        schedule_of(track, run_options(options, Case("", "", latency, options.sizes[0])), rate_hz)
    return max(options.start_s, refreshes_of(max(options.latencies_ms), rate_hz) / rate_hz)
