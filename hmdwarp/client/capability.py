"""What a plan asks of the client: of the scene, and of its graphics."""

from __future__ import annotations

from typing import Any

from ..base import Choice, PlanError, listed
from ..frames.layers import layers
from .classes import Client
from .plan import CLIENT_DEPTH, CLIENT_MODEL, CLIENT_SOFT_BODIES, Plan


def lacking(plan: Plan, client: Client) -> str:
    """Return why the client cannot run the plan, "" if it can."""
    reasons, read = [], [*plan.warp.reads_for(plan.choice.settings), *(n for f in plan.fills for n in f.entry.reads)]
    # Depth, what deforms, and a model of fewer triangles than the scene's, take a reduced scene.
    # Warps and fills whose setting `share` is 1, and those without one, take all of it.
    passes: list[Choice[Any]] = [plan.choice, *plan.fills]
    models = [getattr(choice.settings, "share", 1.0) for choice in passes if CLIENT_MODEL in choice.entry.reads]
    models += [1.0 for planned in plan.effect_passes if CLIENT_MODEL in planned.reads]
    reduced = models or plan.reads(CLIENT_DEPTH) or plan.reads(CLIENT_SOFT_BODIES)
    drawn = "whole" if 1 in models else "reduced" if reduced else "none"
    if not client.has(drawn):
        has = {"none": "nothing of the scene", "reduced": "a reduced scene"}[client.scene]
        takes = {"reduced": "the scene's geometry", "whole": "the whole scene"}[drawn]
        reasons.append(f"it takes {takes} on the client, which has {has}")
    sent = {layer.readable() for layer in layers if layer.drawn_by and not layer.always}
    if not client.more_layers and (names := [name for name in dict.fromkeys(read) if name in sent]):
        reasons.append(f"it takes {listed(names)}, and the client gets colour and depth alone")
    needed = [
        (f"warp '{plan.choice}'", plan.warp.needs_compute),
        *((f"fill '{fill}'", fill.entry.needs_compute_for(fill.settings)) for fill in plan.fills),
        *((f"effect pass '{each.made_by.name}'", each.made_by.needs_compute) for each in plan.effect_passes),
    ]
    if not client.compute_shaders and (names := [name for name, is_needed in needed if is_needed]):
        reasons.append(f"{listed(names)} cannot do without compute shaders, which the client lacks")
    return "; ".join(reasons)


def check_client(plan: Plan, client: Client) -> None:
    """Check that the client can run the plan. Errors: PlanError with the reasons."""
    if why := lacking(plan, client):
        shown = f"warp '{plan.choice}'" + (f" with fill '{plan.fill}'" if plan.fills else "")
        raise PlanError(f"client '{client.name}' cannot run {shown}: {why}")
