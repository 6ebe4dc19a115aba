"""From what was asked for to the plan of a run, for one scene and one display."""

from __future__ import annotations

from ..auto.levels import QualityLevel
from ..client.effects import effects
from ..client.plan import Plan, build_plan
from ..errors import InputError
from ..headsets import Headset
from ..scenes import Scene
from .options import AUTO, PipelineOptions


def plans_for(
    options: PipelineOptions,
    headset: Headset | None,
    scene: Scene | None,
    levels: tuple[QualityLevel, ...] = (),
    **beyond: str,
) -> list[Plan]:
    """The plan of a run in a list; of a run that chooses by itself, that of each rung. beyond, errors: as build_plan_for."""
    chosen = [options.with_pair(level.warp, level.fill) for level in levels] if options.warp == AUTO else [options]
    return [build_plan_for(one, headset, scene, **beyond) for one in chosen]


def build_plan_for(
    options: PipelineOptions, headset: Headset | None, scene: Scene | None, *, distorts: str = "", takes_depth: str = ""
) -> Plan:
    """The plan of a run. Without a scene yet, only the names are checked. headset: whose lens is corrected; None where nobody asks.

    distorts, takes_depth: as build_plan has them. Errors: as build_plan; a lens the headset has not.
    """
    if options.lens != "none" and headset is not None and headset.lens is None:
        raise InputError(
            f"headset '{headset.name}' has no lens, so --lens {options.lens} cannot be applied: use --lens none"
        )
    called_for = effects.of(scene) if scene is not None else ()
    selected = effects.selected(options.effects, called_for)
    fused, scanout = options.fused, options.scanout_ms > 0 and options.follow_scanout
    return build_plan(
        selected,
        options.warp,
        options.fill,
        options.lens,
        client_geometry=True,
        fused=fused,
        scanout=scanout,
        forced={*selected} - {*called_for},
        forbidden={*called_for} - {*selected},
        distorts=distorts,
        takes_depth=takes_depth,
    )


def plan_against(warp: str) -> Plan:
    """Of the warp that another is compared with: nothing but the warp, without fill, effects and lens."""
    return build_plan((), warp, "none", "none", client_geometry=True)
