"""Plans of a run, from its options, its scene and its display."""

from __future__ import annotations

from typing import Any

from ..auto.levels import QualityLevel
from ..client.capability import check_client
from ..client.effects import effects
from ..client.plan import Plan, build_plan
from ..clients import load_client
from ..errors import InputError, PlanError
from ..headsets import Headset
from ..scenes import Scene
from .options import PipelineOptions


def plans_for(
    options: PipelineOptions,
    headset: Headset | None,
    scene: Scene | None,
    levels: tuple[QualityLevel, ...] = (),
    **beyond: Any,
) -> list[Plan]:
    """Return the plans of a run: one, or one for each quality level if it chooses its warp.

    beyond, errors: as build_plan_for.
    """
    if not options.chooses_warp:
        return [build_plan_for(options, headset, scene, **beyond)]
    chosen = [options.with_pair(level.warp, level.fill) for level in levels]
    return [build_plan_for(one, headset, scene, shares_frames=True, **beyond) for one in chosen]


def build_plan_for(
    options: PipelineOptions,
    headset: Headset | None,
    scene: Scene | None,
    *,
    shares_frames: bool = False,
    distorts: str = "",
    takes_depth: str = "",
) -> Plan:
    """Return the plan of a run. Without a scene, only the names are checked.

    headset: the one whose lens is corrected, or None. shares_frames: other warps take turns on the
    same frames, which therefore have no whole picture for an imposter: it compensates what they do.
    distorts, takes_depth: as in build_plan.
    Errors: as build_plan; PlanError for a plan that the client cannot run, and
    for a warp that is not for the scene; InputError for a lens
    correction on a headset without a lens.
    """
    if options.lens != "none" and headset is not None and headset.lens is None:
        raise InputError(
            f"headset '{headset.name}' has no lens, so --lens {options.lens} cannot be applied: use --lens none"
        )
    called_for = effects.of(scene) if scene is not None else ()
    selected = effects.selected(options.effects, called_for)
    plan = build_plan(
        selected,
        options.warp,
        options.fill,
        options.lens,
        client_geometry=True,
        fused=options.fused,
        scanout=options.scanout_ms > 0 and options.follow_scanout,
        named=selected if shares_frames else effects.forced(options.effects),
        forced={*selected} - {*called_for},
        forbidden={*called_for} - {*selected},
        distorts=distorts,
        takes_depth=takes_depth,
    )
    if scene is not None and (why := plan.warp.unsuited(scene)):
        raise PlanError(f"warp '{plan.choice}' is not for scene '{scene.name}': {why}")
    if options.client_name:
        check_client(plan, load_client(options.client_name))
    return plan


def plan_against(warp: str, fill: str) -> Plan:
    """Return the plan of a comparison: without effects and lens."""
    return build_plan((), warp, fill, "none", client_geometry=True)
