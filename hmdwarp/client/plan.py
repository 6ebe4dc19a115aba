"""Which passes run, in which order and why: decided once, from what the scene calls for and what was asked for.

What is not in the plan compiles nothing, allocates nothing and costs nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from operator import or_

import attrs

from ..errors import InputError, PlanError
from ..frame import Needs
from ..scenes.effects import SceneEffect
from .choices import Choice, parse_warp
from .fills import Fill, fills
from .lens import LensPass, lenses
from .warps import Warp

# What a frame brings along, what the client can make by itself, and what the passes hand on.
PICTURE = ("late.colour", "late.inverse_depth")
LATE = (*PICTURE, "late.layers", "late.cube", "late.others")
CLIENT_DEPTH = "client.inverse_depth"
SHOWN = "shown.colour"
PANEL = "panel.colour"

BYTES_PER_PIXEL = {"late.colour": 8, "late.inverse_depth": 4}  # rgba16f and r32f
LAYER_BYTES, CUBE_BYTES = 12, 8  # a pixel of one more layer; of the cube's six faces


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
    """The ordered passes, and those left out with their reasons. choice: the warp with its settings.

    fused: the warp looks through the lens itself. scanout: the warp gives every row a view of its own: of the panel if it is fused, else of
    the shown view, as if the lens kept rows where they are (on the DK1 that is off by 2 % of the scan-out in the mean, 15 % in a corner).
    """

    effects: SceneEffect
    choice: Choice
    fill: type[Fill]
    lens: type[LensPass]
    fused: bool
    scanout: bool
    steps: tuple[Step, ...]
    left_out: tuple[tuple[str, str], ...]

    @property
    def warp(self) -> type[Warp]:
        """The warp without its settings."""
        return self.choice.warp

    @property
    def needs(self) -> Needs:
        """What frames must carry for this plan besides colour and inverse depth."""
        return self.warp.needs(self.choice.settings)

    @property
    def draws_client_depth(self) -> bool:
        """Whether the client draws its own depth for this plan."""
        return any(CLIENT_DEPTH in step.writes for step in self.steps)

    @property
    def layers(self) -> tuple[str, ...]:
        """What a frame must carry for this plan, in the order it is first read."""
        return tuple(dict.fromkeys(name for step in self.steps for name in step.reads if name in LATE))

    def bytes_per_pixel(self) -> int:
        """What one pixel of a frame weighs with the layers this plan reads; a cube is counted apart."""
        return sum(BYTES_PER_PIXEL.get(name, 0) for name in self.layers) + LAYER_BYTES * self.needs.layers


def needs_of(plans: Iterable[Plan]) -> Needs:
    """What frames must carry so that each of the plans can run.

    Errors: InputError for plans that want their older frames unequally far apart: one run keeps one kind.
    """
    wanted = [plan.needs for plan in plans]
    spacings = {needs.past_spacing_ns for needs in wanted if needs.past}
    if len(spacings) > 1:
        told = " and ".join(f"{ns / 1e6:g} ms" for ns in sorted(spacings))
        raise InputError(f"older frames {told} apart in one run: give all warps that use older frames the same spacing")
    return reduce(or_, wanted, Needs())


def build_plan(
    effects: SceneEffect,
    warp: str,
    fill: str,
    lens: str,
    *,
    client_geometry: bool,
    brings: tuple[str, ...] = LATE,
    fused: bool = False,
    scanout: bool = False,
) -> Plan:
    """The plan for the named passes; warp may carry settings (`mesh:cut=slope`).

    client_geometry: whether the client has the scene's triangles to draw depth from. brings: what late pictures come with. fused:
    warp and lens in one resample. scanout: the display shows its rows one after the other; a warp that cannot follow shows them as in
    the middle of it.
    Errors: UnknownNameError for a name in no registry; PlanError for a pass that reads what none before it writes, and for what
    cannot be fused; InputError for a setting the warp has not.
    """
    choice, chosen_fill, chosen_lens = parse_warp(warp), fills.get(fill), lenses.get(lens)
    if fused:
        _refuse_to_fuse(choice.warp, chosen_fill, chosen_lens)
    follows = scanout and choice.warp.scans_out
    steps, left_out = [], []
    if CLIENT_DEPTH in choice.warp.reads and client_geometry:
        steps.append(Step("client_depth", "client_depth", f"warp '{warp}' reads the client's own depth", (), (CLIENT_DEPTH,)))
    else:
        left_out.append(("client_depth", _why_no_client_depth(choice.warp, client_geometry)))
    steps.append(_warp_step(choice, chosen_lens if fused else None, follows))
    if scanout and not follows:
        left_out.append(("scan-out", f"warp '{choice.warp.name}' cannot follow it: all rows are shown as in its middle"))
    for stage, entry, writes in (("fill", chosen_fill, SHOWN), ("lens", chosen_lens, PANEL)):
        if stage == "lens" and fused:
            left_out.append((stage, f"warp '{choice}' looks through the lens itself: one resample instead of two"))
        elif entry.is_pass:
            steps.append(Step(stage, f"{stage} {entry.name}", f"asked for: {entry.summary}", entry.reads, (writes,)))
        else:
            left_out.append((stage, f"{stage} 'none' was asked for: {entry.summary}"))
    if not effects:
        left_out.append(("effects", "the scene calls for none: it is static and matt"))
    _refuse_unwritten(steps, brings)
    return Plan(effects, choice, chosen_fill, chosen_lens, fused, follows, tuple(steps), tuple(left_out))


def _warp_step(choice: Choice, lens: type[LensPass] | None, follows: bool) -> Step:
    reason = f"asked for: {choice.warp.summary}" + ("; every row for the instant it lights up" if follows else "")
    if lens is None:
        return Step("warp", f"warp {choice}", reason, choice.warp.reads, (SHOWN,))
    return Step("warp", f"warp {choice} + lens {lens.name}", f"{reason}; fused with the lens: {lens.summary}", choice.warp.reads, (PANEL,))


def _refuse_to_fuse(warp: type[Warp], fill: type[Fill], lens: type[LensPass]) -> None:
    if not warp.fuses:
        able = "only gather warps can, which ask for every pixel by itself"
        raise PlanError(f"warp '{warp.name}' cannot be fused with the lens: {able}; leave fused out")
    if not lens.look:
        raise PlanError(f"fused with lens '{lens.name}': there is nothing to look through; choose a lens, or leave fused out")
    if fill.is_pass:
        raise PlanError(f"fused with fill '{fill.name}': a fill needs the picture between warp and lens; use fill none, or leave fused out")


def _why_no_client_depth(warp: type[Warp], client_geometry: bool) -> str:
    if CLIENT_DEPTH not in warp.reads:
        return f"warp '{warp.name}' does not read it"
    assert not client_geometry
    return "the client has no geometry to draw it from"


def _refuse_unwritten(steps: list[Step], brings: tuple[str, ...]) -> None:
    known = set(brings)
    for step in steps:
        missing = [name for name in step.reads if name not in known]
        if missing:
            hint = "; it needs the scene's geometry on the client" if CLIENT_DEPTH in missing else ""
            raise PlanError(f"{step.name} reads {', '.join(missing)}, which no pass before it writes{hint}")
        known.update(step.writes)
