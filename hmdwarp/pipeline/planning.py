"""From the options to the plan of a run, for one scene and one display."""

from __future__ import annotations

from ..auto.levels import QualityLevel
from ..client.effects import effects
from ..client.plan import Plan, build_plan
from ..errors import InputError
from ..headsets import Headset
from ..scenes import Scene
from .options import PipelineOptions


def plans_for(
    options: PipelineOptions,
    headset: Headset | None,
    scene: Scene | None,
    levels: tuple[QualityLevel, ...] = (),
    **beyond: str,
) -> list[Plan]:
    """Return the plan of a run in a list; of a run that chooses its warp, that of each quality level.

    beyond, errors: as build_plan_for.
    """
    chosen = [options.with_pair(level.warp, level.fill) for level in levels] if options.chooses_warp else [options]
    return [build_plan_for(one, headset, scene, **beyond) for one in chosen]


def build_plan_for(
    options: PipelineOptions, headset: Headset | None, scene: Scene | None, *, distorts: str = "", takes_depth: str = ""
) -> Plan:
    """Return the plan of a run. Without a scene yet, only the names are checked.

    headset: whose lens is corrected, if one is. distorts, takes_depth: as build_plan has them.
    Errors: as build_plan; InputError for a lens correction of a headset without a lens.
    """
    if options.lens != "none" and headset is not None and headset.lens is None:
        raise InputError(
            f"headset '{headset.name}' has no lens, so --lens {options.lens} cannot be applied: use --lens none"
        )
    called_for = effects.of(scene) if scene is not None else ()
    selected = effects.selected(options.effects, called_for)
    return build_plan(
        selected,
        options.warp,
        options.fill,
        options.lens,
        client_geometry=True,
        fused=options.fused,
        scanout=options.scanout_ms > 0 and options.follow_scanout,
        forced={*selected} - {*called_for},
        forbidden={*called_for} - {*selected},
        distorts=distorts,
        takes_depth=takes_depth,
    )


def plan_against(warp: str) -> Plan:
    """Return the plan of a warp that another is compared with: without fill, effects and lens."""
    return build_plan((), warp, "none", "none", client_geometry=True)
