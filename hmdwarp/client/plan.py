"""Which passes run, in which order and why: decided once, from what the scene calls for and what was asked for.

What is not in the plan compiles nothing, allocates nothing and costs nothing.
"""

from __future__ import annotations

import attrs

from ..errors import PlanError
from ..scenes.effects import SceneEffect
from .fills import Fill, fills
from .lens import LensPass, lenses
from .warps import Warp, warps

# What a frame brings along, what the client can make by itself, and what the passes hand on.
LATE = ("late.colour", "late.inverse_depth")
CLIENT_DEPTH = "client.inverse_depth"
SHOWN = "shown.colour"
PANEL = "panel.colour"

BYTES_PER_PIXEL = {"late.colour": 8, "late.inverse_depth": 4}  # rgba16f and r32f


@attrs.frozen
class Step:
    """One pass of the plan: when it runs, what it reads and writes, and the reason it is there."""

    stage: str
    name: str
    reason: str
    reads: tuple[str, ...]
    writes: tuple[str, ...]


@attrs.frozen
class Plan:
    """The ordered passes, and those left out with their reasons."""

    effects: SceneEffect
    warp: type[Warp]
    fill: type[Fill]
    lens: type[LensPass]
    steps: tuple[Step, ...]
    left_out: tuple[tuple[str, str], ...]

    @property
    def draws_client_depth(self) -> bool:
        """Whether the client draws its own depth for this plan."""
        return any(CLIENT_DEPTH in step.writes for step in self.steps)

    @property
    def layers(self) -> tuple[str, ...]:
        """What a frame must carry for this plan, in the order it is first read."""
        return tuple(dict.fromkeys(name for step in self.steps for name in step.reads if name in LATE))

    def bytes_per_pixel(self) -> int:
        """What one pixel of a frame weighs with the layers this plan reads."""
        return sum(BYTES_PER_PIXEL[name] for name in self.layers)


def build_plan(effects: SceneEffect, warp: str, fill: str, lens: str, *, client_geometry: bool) -> Plan:
    """The plan for the named passes. client_geometry: whether the client has the scene's triangles to draw depth from.

    Errors: UnknownNameError for a name in no registry; PlanError for a pass that reads what none before it writes.
    """
    chosen = (warps.get(warp), fills.get(fill), lenses.get(lens))
    steps, left_out = [], []
    if CLIENT_DEPTH in chosen[0].reads and client_geometry:
        steps.append(Step("client_depth", "client_depth", f"warp '{warp}' reads the client's own depth", (), (CLIENT_DEPTH,)))
    else:
        left_out.append(("client_depth", _why_no_client_depth(chosen[0], client_geometry)))
    steps.append(Step("warp", f"warp {warp}", f"asked for: {chosen[0].summary}", chosen[0].reads, (SHOWN,)))
    for stage, entry, writes in (("fill", chosen[1], SHOWN), ("lens", chosen[2], PANEL)):
        if entry.is_pass:
            steps.append(Step(stage, f"{stage} {entry.name}", f"asked for: {entry.summary}", entry.reads, (writes,)))
        else:
            left_out.append((stage, f"{stage} 'none' was asked for: {entry.summary}"))
    if not effects:
        left_out.append(("effects", "the scene calls for none: it is static and matt"))
    _refuse_unwritten(steps)
    return Plan(effects, *chosen, tuple(steps), tuple(left_out))


def _why_no_client_depth(warp: type[Warp], client_geometry: bool) -> str:
    if CLIENT_DEPTH not in warp.reads:
        return f"warp '{warp.name}' does not read it"
    assert not client_geometry
    return "the client has no geometry to draw it from"


def _refuse_unwritten(steps: list[Step]) -> None:
    known = set(LATE)
    for step in steps:
        missing = [name for name in step.reads if name not in known]
        if missing:
            hint = "; it needs the scene's geometry on the client" if CLIENT_DEPTH in missing else ""
            raise PlanError(f"{step.name} reads {', '.join(missing)}, which no pass before it writes{hint}")
        known.update(step.writes)
