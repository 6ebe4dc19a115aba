"""Plans of a run, from its options, its scene and its display."""

from __future__ import annotations

from typing import Any

import attrs

from ..client.capability import check_client
from ..client.classes import load_client
from ..client.effects import effects
from ..client.plan import Plan, build_plan
from ..client.variants import parse_indirect
from ..client.warps import Warp
from ..errors import InputError, PlanError
from ..headsets import Headset
from ..options import AUTO, Choice
from ..scenes import CONVERGED, Scene
from .options import PipelineOptions
from .proxy_options import PROXY, RECORDING, ProxyOptions


def plans_for(
    options: PipelineOptions,
    headset: Headset | None,
    scene: Scene | None,
    **beyond: Any,
) -> list[Plan]:
    """Return the plans of a run: one, or one for each level that it chooses from.

    beyond, errors: as build_plan_for.
    """
    if options.warp != AUTO:
        return [build_plan_for(options, headset, scene, **beyond)]
    chosen = [options.with_pair(level.warp, level.fill) for level in options.levels]
    return [build_plan_for(run, headset, scene, shares_frames=True, **beyond) for run in chosen]


def build_plan_for(
    options: PipelineOptions,
    headset: Headset | None,
    scene: Scene | None,
    *,
    shares_frames: bool = False,
    distorts: str = "",
    takes_depth: str = "",
    takes_panels: str = "",
) -> Plan:
    """Return the plan of a run. Without a scene, only the names are checked.

    headset: the one whose lens is corrected, or None. shares_frames: other warps take turns on the
    same frames, which therefore have no whole picture for an imposter: it compensates what they do.
    distorts, takes_depth, takes_panels: as in build_plan.
    Errors: as build_plan; PlanError for a plan that the client cannot run, and for a warp that is
    not for the scene; InputError for a lens correction on a headset without a lens.
    """
    if options.lens != "none" and headset is not None and headset.lens is None:
        raise InputError(
            f"headset '{headset.name}' has no lens, so --lens {options.lens} cannot be applied: use --lens none"
        )
    plan = (
        _plan_behind_proxy(options, scene, distorts)
        if options.source_kind is PROXY
        else _plan_of_all(
            options,
            scene,
            shares_frames=shares_frames,
            distorts=distorts,
            takes_depth=takes_depth,
            takes_panels=takes_panels,
        )
    )
    check_suited(scene, plan.choice, options.indirect)
    if options.client_name:
        check_client(plan, load_client(options.client_name))
    return plan


def check_suited(scene: Scene | None, warp: Choice[Warp], indirect: str) -> None:
    """Check that a scene calls for them. Errors: PlanError."""
    if scene is None:
        return
    if why := warp.entry.unsuited(scene):
        raise PlanError(f"warp '{warp}' is not for scene '{scene.name}': {why}")
    light = parse_indirect(indirect)
    if light is not None and (why := light.entry.unsuited(scene)):
        raise PlanError(f"indirect light '{indirect}' is not for scene '{scene.name}': {why}")


def _plan_of_all(options: PipelineOptions, scene: Scene | None, *, shares_frames: bool, **beyond: str) -> Plan:
    """Return the plan of who gets the server's frames. beyond: as in build_plan."""
    called_for, kind = effects.of(scene) if scene is not None else (), options.source_kind
    # What recorded frames show is not known, so that what is forced is never without content.
    selected = effects.selected(options.effects, called_for, scene if kind is not RECORDING else None)
    try:
        plan = build_plan(
            selected,
            options.warp,
            options.fill,
            options.lens,
            client_geometry=kind.has_geometry,
            brings=kind.layers,
            fused=options.fused,
            scanout=options.scanout_ms > 0 and options.follow_scanout,
            named=selected if shares_frames else effects.forced(options.effects),
            forced={*selected} - {*called_for},
            forbidden={*called_for} - {*selected},
            indirect=options.indirect,
            fovea=options.fovea,
            **beyond,
        )
    except PlanError as error:
        if not kind.limits:
            raise
        raise PlanError(f"{error}{kind.limits}") from error
    for planned in plan.effect_passes:
        if kind.eyes < 2 and planned.needs.others.other_eye:
            raise PlanError(
                f"--effects {planned.effects[0].name} looks into the other eye's picture{kind.limits}: leave it out"
            )
    return plan


def proxy_plan_for(options: PipelineOptions, scene: Scene | None) -> Plan:
    """Return the plan of the proxy: it compensates all, and leaves the lens to the client.

    Errors: as build_plan_for.
    """
    alone = attrs.evolve(
        options,
        strategy="",
        proxy=ProxyOptions(),
        warp=options.proxy.warp,
        fill=options.proxy.fill,
        lens="none",
        fused=False,
        scanout_ms=0.0,
        client="",
    )
    return build_plan_for(alone, None, scene)


def _plan_behind_proxy(options: PipelineOptions, scene: Scene | None, distorts: str) -> Plan:
    """Return the plan of a client that gets the proxy's finished picture. Errors: as build_plan."""
    done = f"the proxy compensates it, as far as its warp '{options.proxy.warp}' can"
    compensated = proxy_plan_for(options, scene).effects
    try:
        plan = build_plan(
            (),
            options.warp,
            options.fill,
            options.lens,
            client_geometry=False,
            brings=options.source_kind.layers,
            fused=options.fused,
            scanout=options.scanout_ms > 0 and options.follow_scanout,
            distorts=distorts,
        )
    except PlanError as error:
        raise PlanError(
            f"{error}; a proxy sends the finished picture alone: show it by --warp none or rotation"
        ) from error
    left_out = ((name, done if name in compensated else why) for name, why in plan.left_out)
    return attrs.evolve(plan, left_out=tuple(left_out))


def plan_against(options: PipelineOptions, warp: str, fill: str) -> Plan:
    """Return the plan of a comparison on the same frames: without effects and lens.

    Errors: as build_plan.
    """
    kind = options.source_kind
    light, fovea = (CONVERGED, None) if kind is PROXY else (options.indirect, options.fovea)
    known: dict[str, Any] = {"client_geometry": kind.has_geometry, "brings": kind.layers, "indirect": light}
    return build_plan((), warp, fill, "none", fovea=fovea, **known)
