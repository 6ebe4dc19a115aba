"""Warps, fills and effects for which a caller's own frames are enough, and warp "auto"."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from statistics import median
from typing import Any

import numpy as np

from ..base import AUTO, InputError, PlanError, in_brief
from ..client import Compensator, PassInputs
from ..client.effects import effects as every_effect
from ..client.fills import fills
from ..client.plan import OTHERS, SHOWN, SHOWN_DEPTH, Plan, build_plan
from ..client.warps import warps
from ..frames.layers import PICTURE, readable
from ..gpu import Gpu
from ..pipeline.governor import QualityLevel, best_within, front
from .picture_textures import KNOWN

# What a caller can pass: pictures with depth, and some layers.
AVAILABLE = (*PICTURE, OTHERS, *map(readable, KNOWN))


def usable_warps() -> list[str]:
    """Return the names of warps that need no more than one picture with depth."""
    return [entry.name for entry in warps if set(entry.reads) <= set(PICTURE)]


def usable_fills() -> list[str]:
    """Return the names of fills that need no more than one picture with depth."""
    return [entry.name for entry in fills if set(entry.reads) <= {*PICTURE, SHOWN, SHOWN_DEPTH}]


def usable_effects() -> list[str]:
    """Return the names of effects that need no more than pictures with depth."""
    return [effect.name for effect in every_effect if set(effect.made_by.reads) <= {*PICTURE, OTHERS}]


def plan_of(
    warp: str, fill: str, effects: str = "none", *, available: tuple[str, ...] = AVAILABLE, depth: bool = False
) -> Plan:
    """Return the plan for a caller's own frames; available: what those are.

    Errors: InputError for what is no name, and for warp "auto"; PlanError for passes that read
    more; UnknownNameError.
    """
    said = {"warp": (warp, usable_warps), "fill": (fill, usable_fills), "effects": (effects, usable_effects)}
    for kind, (name, usable) in said.items():
        if not isinstance(name, str):
            raise InputError(f"{kind} is {in_brief(name)}: expected a name: {', '.join(usable())}")
    if not isinstance(depth, bool | np.bool_):
        raise InputError(f"depth is {in_brief(depth)}: expected True or False; the picture's own is depth_m")
    if warp == AUTO:
        raise InputError(
            f"warp 'auto' is for a hmdwarp.Warper or warp_image with budget_ms; name one: {', '.join(usable_warps())}"
        )
    named, taker = every_effect.selected(effects, ()), "the caller" if depth else ""
    asks: dict[str, Any] = {"brings": available, "named": named, "forced": named, "takes_depth": taker}
    try:
        return build_plan(named, warp, fill, "none", client_geometry=False, **asks)
    except PlanError as error:
        able = f"warps {', '.join(usable_warps())}; fills {', '.join(usable_fills())}"
        able += f"; effects {', '.join(usable_effects())}" if named else ""
        raise PlanError(f"{error}; a single picture has none. Usable are {able}") from error


# Printed by `hmdwarp bench look-around walk --scene room,spheres --latency 100,400
# --warp none,rotation,forward,iterative,mesh --warp mesh:grid=64 --fill none,pyramid,memory+pyramid
# --size 320x200 --samples 4 --instants 2 --rounds 1`, on llvmpipe, less the slowest one.
# The times are measured anew, on the first picture of each Warper.
LEVELS = (
    QualityLevel("none", "none", 1.33, 0.3120),
    QualityLevel("rotation", "none", 1.75, 0.2132),
    QualityLevel("mesh:grid=64", "none", 5.32, 0.1260),
    QualityLevel("iterative:frames=1,resample=bilinear", "pyramid", 23.4, 0.0982),
    QualityLevel("iterative:frames=1,resample=bilinear", "memory+pyramid", 43.6, 0.0827),
)
Size = tuple[int, int]
_ROUNDS = 3  # timed runs of each level on the first picture, after one that warms up


def chosen(
    gpu: Gpu, plans: Mapping[QualityLevel, Plan], sizes: tuple[Size, Size], budget_ms: float | None, inputs: PassInputs
) -> Compensator:
    """Return what runs the most accurate level that draws these inputs within the budget here.

    Errors: InputError where none does.
    """
    took: dict[QualityLevel, list[float]] = {level: [] for level in plans}  # ms here
    with gpu.timer.aside("auto"):
        for level, plan in plans.items():
            with closing(Compensator(gpu, plan, None, *sizes)) as tried:
                for _ in range(1 + _ROUNDS):
                    gpu.timer.lap()
                    tried.run(inputs)
                    took[level].append(sum(ms for _, ms in gpu.timer.collect()))
    levels = front([level.scaled(median(ms[1:]) / level.total_ms) for level, ms in took.items()])
    best = levels[best_within(levels, budget_ms, "budget_ms")]
    plan = next(plan for level, plan in plans.items() if (level.warp, level.fill) == (best.warp, best.fill))
    return Compensator(gpu, plan, None, *sizes)
