"""Which cases a bench runs, which combinations in each, and which of a recording's refreshes are looked at."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence

import attrs

from ..client.history import History
from ..client.plan import Plan, build_plan
from ..client.variants import every_warp, fill_text, parse_fills, parse_warp
from ..frames import Needs
from ..link import Link, LinkOptions
from ..pipeline.build import refreshes_of
from ..pipeline.options import RunOptions
from ..poses import PoseTrack
from ..run.rig import Timetable, timetable
from ..scenes import Scene
from ..scenes.effects import asked_effects
from .options import BenchOptions, Size

# Of one batch's compensators on a GPU; a software renderer's may take a part of the machine's
# memory instead.
GPU_BATCH_BYTES = 2 << 30
MEMORY_PART = 0.2
_COLOUR_BYTES, _OWN_BYTES = 8, 32  # a canvas' pixel; what a warp keeps for each late pixel: keys, depths, vertices


@attrs.frozen(order=True)
class Case:
    """What all combinations share, so that they may be compared."""

    scene: str
    recording: str
    latency_ms: float
    size: Size


def cases_of(options: BenchOptions) -> list[Case]:
    """All of them, a recording's latencies one after the other."""
    product = itertools.product(options.sizes, options.scenes, options.recordings, options.latencies_ms)
    return [Case(scene, recording, latency, size) for size, scene, recording, latency in product]


@attrs.frozen
class Combination:
    """One warp with its settings and one fill."""

    warp: str
    fill: str
    plan: Plan


def warps_of(options: BenchOptions) -> list[str]:
    """The warps asked for, or all with their variants, in the shortest text that means them, each once. Errors: as parse_warp."""
    return list(dict.fromkeys(str(parse_warp(text)) for text in (options.warps or every_warp())))


def fills_of(options: BenchOptions) -> list[str]:
    """The fills and chains asked for, in the shortest text that means them, each once. Errors: as parse_fills."""
    return list(dict.fromkeys(fill_text(parse_fills(text)) for text in options.fills))


def combinations_of(options: BenchOptions, scene: Scene) -> list[Combination]:
    """Errors: as build_plan."""
    pairs, effects = (
        itertools.product(warps_of(options), fills_of(options)),
        asked_effects(options.effects, scene.effects),
    )
    return [Combination(w, f, build_plan(effects, w, f, options.lens, client_geometry=True)) for w, f in pairs]


def batches(
    combinations: Sequence[Combination], rendered_size: Size, shown_size: Size, most_bytes: float
) -> list[list[Combination]]:
    """Combinations that exist at the same time: those that want their older frames equally far apart, within `most_bytes`.

    All fills of a warp stay together. What wants no older frames goes along with the first.
    """
    spacings = sorted({c.plan.needs.others.spacing_ns for c in combinations if c.plan.needs.others.past})
    first = spacings[0] if spacings else 0
    found: list[list[Combination]] = []
    for spacing in spacings or [first]:
        fitting = [
            c
            for c in combinations
            if (c.plan.needs.others.spacing_ns if c.plan.needs.others.past else first) == spacing
        ]
        current: list[Combination] = []
        for _, group in itertools.groupby(fitting, key=lambda c: c.warp):
            together = list(group)
            if current and sum(_bytes(c, rendered_size, shown_size) for c in (*current, *together)) > most_bytes:
                found.append(current)
                current = []
            current += together
        found.append(current)
    return found


def _bytes(combination: Combination, rendered_size: Size, shown_size: Size) -> int:
    plan = combination.plan
    canvases = 1 + len(plan.fills) + len(plan.effect_passes) + plan.lens.is_pass
    return (
        2 * canvases * _COLOUR_BYTES * shown_size[0] * shown_size[1] + _OWN_BYTES * rendered_size[0] * rendered_size[1]
    )


def run_options(options: BenchOptions, case: Case, **changes: object) -> RunOptions:
    """A run of one case. Its first refresh is the same whatever the latency, so that all latencies see the same head."""
    known = {
        "trace": case.recording,
        "scene": case.scene,
        "latency_ms": case.latency_ms,
        "warp": "none",  # the loop's own; the combinations run beside it
        "fill": "none",
        "effects": options.effects,
        "lens": "none",
        "headset": options.headset,
        "size": case.size,
        "rate_hz": options.rate_hz,
        "start_s": options.start_s,
        "seconds": options.seconds,
        "guard": options.guard,
        "against": "",
        "trace_options": options.trace_options,
        "out": options.out,
        "command": options.command,
    }
    return RunOptions(**{**known, **changes})


def common_start_s(options: BenchOptions, track: PoseTrack, rate_hz: float) -> float:
    """Where all latencies can start, after checking that each has a frame to show in this recording. Errors: as timetable."""
    for latency in options.latencies_ms:
        timetable(track, run_options(options, Case("", "", latency, options.sizes[0])), rate_hz)
    return max(options.start_s, refreshes_of(max(options.latencies_ms), rate_hz) / rate_hz)


def instants_of(count: int, wanted: int) -> list[int]:
    """At most `wanted` of refreshes 0..count-1, evenly spread, each with a refresh before it if there are two."""
    wanted = min(wanted, max(1, count // 2))
    return [min(count - 1, max(1, int((k + 0.5) * count / wanted))) for k in range(wanted)]


@attrs.frozen
class _Drawn:
    drawn_ns: int


def frames_used(times: Timetable, link_ns: int, needs: Needs, looked_at: Iterable[int]) -> set[int]:
    """When the frames were drawn that the refreshes `looked_at` show or look back to; no other need be drawn.

    The link and the history themselves say which, given frames without pictures.
    """
    wanted, used = set(looked_at), set()
    history = History(needs.others.past, needs.others.spacing_ns, lambda frame: None)
    link: Link = LinkOptions().link(link_ns, history.offer)
    for number, instant_ns in numbered(times):
        link.send(_Drawn(instant_ns), instant_ns)
        newest = link.newest(instant_ns)
        if number in wanted and number >= 0:
            used |= {frame.drawn_ns for frame in (newest, *history.frames)}
    return used


def numbered(times: Timetable) -> Iterator[tuple[int, int]]:
    """(number, time_ns) of every refresh; those before the first shown one have numbers below 0."""
    for number, (instant_ns, _) in enumerate(times.instants()):
        yield number - times.age, instant_ns
