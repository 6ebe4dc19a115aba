"""What a plan asks of the client: of the scene, and of its graphics."""

from __future__ import annotations

from typing import Any

from ..errors import PlanError, listed
from ..frames.layers import layers
from ..options import Choice
from .classes import Client
from .plan import CLIENT_DEPTH, CLIENT_MODEL, CLIENT_SOFT_BODIES, Plan


def scene_drawn(plan: Plan) -> str:
    """Return what of the scene the client draws for the plan, one of clients.SCENES.

    Depth, what deforms, and a model of fewer triangles than the scene's, take a reduced scene. The
    warps and fills whose setting `share` is 1, and those without one, take all of it.
    """
    passes: list[Choice[Any]] = [plan.choice, *plan.fills]
    drawn = [getattr(choice.settings, "share", 1.0) for choice in passes if CLIENT_MODEL in choice.entry.reads]
    of_effects = any(CLIENT_MODEL in planned.reads for planned in plan.effect_passes)
    if of_effects or any(share == 1 for share in drawn):
        return "whole"
    return "reduced" if drawn or plan.reads(CLIENT_DEPTH) or plan.reads(CLIENT_SOFT_BODIES) else "none"


def layers_beyond_picture(plan: Plan) -> list[str]:
    """Return the layers that warp and fills read besides the pictures with depth of all frames."""
    read = dict.fromkeys(
        [*plan.warp.reads_for(plan.choice.settings), *(name for fill in plan.fills for name in fill.entry.reads)]
    )
    sent = {layer.readable() for layer in layers if layer.drawn_by and not layer.always}
    return [name for name in read if name in sent]


def needing_compute(plan: Plan) -> list[str]:
    """Return the names of the plan's passes that cannot do without compute shaders."""
    named = [
        (f"warp '{plan.choice}'", plan.warp.needs_compute),
        *((f"fill '{fill}'", fill.entry.needs_compute_for(fill.settings)) for fill in plan.fills),
        *((f"effect pass '{each.made_by.name}'", each.made_by.needs_compute) for each in plan.effect_passes),
    ]
    return [name for name, needed in named if needed]


def lacking(plan: Plan, client: Client) -> str:
    """Return why the client cannot run the plan, "" if it can."""
    reasons = []
    drawn = scene_drawn(plan)
    if not client.has(drawn):
        has = {"none": "nothing of the scene", "reduced": "a reduced scene"}[client.scene]
        takes = {"reduced": "the scene's geometry", "whole": "the whole scene"}[drawn]
        reasons.append(f"it takes {takes} on the client, which has {has}")
    if not client.more_layers and (names := layers_beyond_picture(plan)):
        reasons.append(f"it takes {listed(names)}, and the client gets colour and depth alone")
    if not client.compute_shaders and (names := needing_compute(plan)):
        reasons.append(f"{listed(names)} cannot do without compute shaders, which the client lacks")
    return "; ".join(reasons)


def check_client(plan: Plan, client: Client) -> None:
    """Check that the client can run the plan. Errors: PlanError with the reasons."""
    if why := lacking(plan, client):
        shown = f"warp '{plan.choice}'" + (f" with fill '{plan.fill}'" if plan.fills else "")
        raise PlanError(f"client '{client.name}' cannot run {shown}: {why}")
