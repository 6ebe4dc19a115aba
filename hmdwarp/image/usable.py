"""Warps, fills and effects for which a caller's own frames are enough."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..client.effects import effects as every_effect
from ..client.fills import fills
from ..client.plan import CLIENT_DEPTH, OTHERS, SHOWN, SHOWN_DEPTH, Plan, build_plan
from ..client.warps import warps
from ..errors import InputError, PlanError, in_brief
from ..frames.layers import PICTURE, readable
from ..options import AUTO

# What a caller can pass: pictures with depth, the depth of what is to be shown, and some layers.
LAYERS = ("velocity", "ids", "overlay", "peeled", "transparent", "reflection", "panels")
AVAILABLE = (*PICTURE, OTHERS, CLIENT_DEPTH, *map(readable, LAYERS))


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
    """Return the plan for a caller's own frames.

    effects: names separated by commas, or "none". available: what the caller has. depth:
    whether the depth of what is shown is wanted.
    Errors: InputError for what is no name, and for warp "auto"; PlanError for passes that read
    more; UnknownNameError.
    """
    for kind, name, usable in (
        ("warp", warp, usable_warps),
        ("fill", fill, usable_fills),
        ("effects", effects, usable_effects),
    ):
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
