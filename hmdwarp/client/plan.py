"""The plan: which passes run, in which order and why, decided once from scene and options.

Passes that are not in the plan compile nothing, allocate nothing and cost nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import cached_property, reduce
from operator import or_

import attrs

from ..base import Choice, InputError, PlanError
from ..frames import Needs
from ..frames.layers import PICTURE, layers, readable, readable_names
from ..geometry import Fovea
from ..scenes import CONVERGED
from .effects import EXPANDED, Effect, EffectPass, ExpandPass, RenderedPass, ShownPass, effects
from .fills import Fill, fills
from .lens import LensPass, lenses
from .variants import fill_text, lit_by, parse_fills, parse_warp
from .warps import Warp

# Layers beside PICTURE of every frame, that the client makes itself, and that passes hand on.
OTHERS = "rendered.others"
CLIENT_DEPTH, CLIENT_MODEL = "client.inverse_depth", "client.model"
CLIENT_SOFT_BODIES = "client.soft_bodies"
SHOWN, SHOWN_DEPTH = "shown.colour", "shown.inverse_depth"
PANEL = "panel.colour"
_STEP_SHOWN_DEPTH = "shown depth"


@attrs.frozen
class Step:
    """One pass of the plan."""

    stage: str  # The stage of gpu.timer that its time counts to.
    name: str
    reason: str  # The reason for it.
    reads: tuple[str, ...]
    writes: tuple[str, ...]


@attrs.frozen
class PlannedEffect:
    """One pass that compensates effects."""

    made_by: type[EffectPass]
    effects: tuple[Effect, ...]

    @property
    def needs(self) -> Needs:
        """Layers that frames carry for the effects."""
        return reduce(or_, (effect.needs for effect in self.effects))

    @property
    def is_for_display(self) -> bool:
        """Whether a display can do all of it."""
        return all(effect.for_display for effect in self.effects)

    @property
    def reads(self) -> tuple[str, ...]:
        """Layers that the pass reads for the effects."""
        return self.made_by.reads_for(frozenset(effect.name for effect in self.effects))


@attrs.frozen
class Plan:
    """The ordered passes, and those left out with their reasons."""

    effects: tuple[str, ...]  # Names of the compensated effects, in the order of effect_passes.
    choice: Choice[Warp]  # The warp with its settings.
    fills: tuple[Choice[Fill], ...]  # The chain of fills with theirs.
    lens: type[LensPass]
    fused: bool  # Whether the warp applies the lens itself.
    # Whether the warp gives every row a view of its own: of the panel if it is fused, else of the
    # shown view, as if the lens kept rows where they are (on the DK1 that is off by 2 % of the
    # scan-out on average, 15 % in a corner).
    scanout: bool
    effect_passes: tuple[PlannedEffect, ...]  # In the order they run.
    steps: tuple[Step, ...]
    left_out: tuple[tuple[str, str], ...]  # Names and reasons.
    hands_depth_on: bool = False  # Whether the display reads the depth of what is shown.
    hands_panels_on: bool = False  # Whether the display composes panels.
    handed_on: tuple[PlannedEffect, ...] = ()  # What it compensates alone.
    lit: Needs = Needs()  # The layers that say how the server lights the pictures.
    # The layers that come in place of pictures, coarser away from where the eye looks.
    foveated: Needs = Needs()

    @property
    def warp(self) -> type[Warp]:
        """The warp without its settings."""
        return self.choice.entry

    @property
    def fill(self) -> str:
        """The chain of fills as text, "none" if there is none."""
        return fill_text(self.fills)

    @cached_property
    def warp_needs(self) -> Needs:
        """Layers that the warp alone needs of a frame; through the lens it averages no others."""
        needs = self.warp.needs(self.choice.settings)
        return Needs(**{**needs, "others": attrs.evolve(needs.others, recent=0)}) if self.fused else needs

    @cached_property
    def needs(self) -> Needs:
        """Layers that frames must carry for this plan besides colour and inverse depth."""
        of_fills = (fill.entry.needs(fill.settings) for fill in self.fills)
        of_effects = (effect.needs for effect in (*self.effect_passes, *self.handed_on))
        return reduce(or_, (*of_fills, *of_effects, self.lit, self.foveated), self.warp_needs)

    @property
    def expands(self) -> bool:
        """Whether foveated pictures are expanded; else the warp samples them where they lie."""
        return any(step.name == ExpandPass.name for step in self.steps)

    @property
    def draws_scene(self) -> bool:
        """Whether the client draws something of the scene itself: its own, or by what came."""
        read = {name for step in self.steps for name in step.reads}
        came = {layer.readable() for layer in layers if layer.draws_scene}
        return bool(read & came) or any(name.startswith("client.") for name in read)

    @property
    def draws_client_depth(self) -> bool:
        """Whether the client draws its own depth for this plan."""
        return self.writes(CLIENT_DEPTH)

    @property
    def makes_shown_depth(self) -> bool:
        """Whether the inverse depth of the shown picture is made, for passes that read it."""
        return self.warps_twice or any(step.stage == "warp" and SHOWN_DEPTH in step.writes for step in self.steps)

    @property
    def warps_twice(self) -> bool:
        """Whether the warp runs a second time for it, on the rendered depth."""
        return any(step.name == _STEP_SHOWN_DEPTH for step in self.steps)

    def reads_depth_after(self, fill: Choice[Fill]) -> bool:
        """Return whether a pass after that fill, or the display, reads the shown depth."""
        later = self.fills[self.fills.index(fill) + 1 :]
        passes = [planned.entry.reads for planned in later] + [planned.reads for planned in self.effect_passes]
        return self.hands_depth_on or any(SHOWN_DEPTH in reads for reads in passes)

    def writes(self, name: str) -> bool:
        """Return whether a pass of the plan writes the named layer."""
        return any(name in step.writes for step in self.steps)

    def reads(self, name: str) -> bool:
        """Return whether a pass of the plan reads the named layer."""
        return any(name in step.reads for step in self.steps)

    @property
    def layers(self) -> tuple[str, ...]:
        """The layers that the passes read, by readable name, in the order they are first read."""
        known = {*readable_names()} - {EXPANDED[name] for name in self.foveated}
        return tuple(dict.fromkeys(name for step in self.steps for name in step.reads if name in known))


def needs_of(plans: Iterable[Plan]) -> Needs:
    """Return the layers that frames must carry so that each of the plans can run.

    Errors: InputError for plans with different spacings of older frames: one run has one.
    """
    every = [plan.needs for plan in plans]
    spacings = {needs.others.spacing_ns for needs in every if needs.others.past}
    if len(spacings) > 1:
        apart = " and ".join(f"{ns / 1e6:g} ms" for ns in sorted(spacings))
        raise InputError(
            f"older frames {apart} apart in one run: give all warps that use older frames the same spacing"
        )
    return reduce(or_, every, Needs())


def build_plan(
    declared: Collection[str],
    warp: str,
    fill: str,
    lens: str,
    *,
    client_geometry: bool,
    brings: tuple[str, ...] | None = None,
    fused: bool = False,
    scanout: bool = False,
    named: Collection[str] = (),
    forced: Collection[str] = (),
    forbidden: Collection[str] = (),
    distorts: str = "",
    takes_depth: str = "",
    takes_panels: str = "",
    indirect: str = CONVERGED,
    fovea: Fovea | None = None,
) -> Plan:
    """Return the plan for the named passes.

    warp and fill may carry settings (`mesh:cut=slope`), fill may be a chain (`memory+pyramid`).
    declared: the effects to compensate. client_geometry: whether the client has the scene's
    triangles to draw from. brings: the layers that frames carry, by readable name; None for every
    layer. fused: warp and lens in one resample; then nothing can be composited between them.
    scanout: the display shows its rows one after the other; a warp that cannot follow shows all
    rows as in the middle of the scan-out. named: names of declared effects that were asked for by
    name, which an imposter compensates too. forced, forbidden: names of effects that are declared
    though the scene lacks them, and not declared though it has them; used only in the stated
    reasons. distorts, takes_depth, takes_panels: names of the display parts that correct the lens
    after this plan, that read the shown picture's depth, and that compose panels; "" for none.
    indirect: as parse_indirect takes it. fovea: pictures come coarser away from where the eye
    looks; None for whole ones.

    Errors: UnknownNameError for an unregistered name; PlanError for a pass that reads a layer which
    no pass before it writes, and for passes that cannot be fused; InputError for a setting that the
    warp or fill lacks.
    """
    choice, chain, chosen_lens = parse_warp(warp), parse_fills(fill), lenses.get(lens)
    if distorts and chosen_lens.is_pass:
        raise PlanError(
            f"--lens {lens}: {distorts} corrects the lens by itself, and would do so again; use --lens none"
        )
    chosen_warp, through = choice.entry, chosen_lens if fused else None
    read = {*chosen_warp.reads_for(choice.settings), *(name for each in chain for name in each.entry.reads)}
    why_not = {each.name: _why_not(each, declared, chosen_warp, read, fused, named, forbidden) for each in effects}
    chosen = [effect for effect in effects if not why_not[effect.name]]
    passes = [
        PlannedEffect(made_by, tuple(effect for effect in chosen if effect.made_by is made_by))
        for made_by in dict.fromkeys(effect.made_by for effect in sorted(chosen, key=lambda one: one.order))
    ]
    _refuse(chosen_warp, chain, through, passes)
    rendered = [planned for planned in passes if issubclass(planned.made_by, RenderedPass)]
    # Those whose work the display does.
    handed = [each for each in passes if each not in rendered and takes_panels and each.is_for_display]
    shown = [planned for planned in passes if planned not in (*rendered, *handed)]
    left_out = [(name, why) for name, why in why_not.items() if why]
    for effect in (effect for planned in handed for effect in planned.effects):
        left_out.append((effect.name, f"{takes_panels} composes them by itself, at its newest pose"))
    steps = []
    for planned in (each for each in shown if issubclass(each.made_by, ShownPass) and each.made_by.takes_out):
        own = tuple(name for name in planned.reads if name.startswith("client."))
        steps.append(Step("effects", f"{planned.made_by.name} out", _why(planned, forced), (*PICTURE, *own), PICTURE))
    steps += [
        Step("effects", each.made_by.name, _why(each, forced), each.reads, each.made_by.writes) for each in rendered
    ]
    no_depth = (
        (CLIENT_DEPTH in (brings or ()), "it comes with the pictures"),
        (CLIENT_DEPTH not in chosen_warp.reads, f"warp '{chosen_warp.name}' does not read it"),
        (not client_geometry, "the client has no geometry to draw it from"),
    )
    if not any(holds for holds, _ in no_depth):
        reason = f"warp '{chosen_warp.name}' reads the client's own depth"
        steps.append(Step("client_depth", "client_depth", reason, (), (CLIENT_DEPTH,)))
    left_out += [("client_depth", why) for holds, why in no_depth if holds][:1]
    # Which passes, or which display, read the shown depth.
    readers = [each.entry.name for each in chain if SHOWN_DEPTH in each.entry.reads]
    readers += [planned.made_by.name for planned in shown if SHOWN_DEPTH in planned.reads]
    depth_for = " and ".join(dict.fromkeys([*readers, *([takes_depth] if takes_depth else [])]))
    beside = depth_for if chosen_warp.depth_reads is not None and not fused else ""
    steps.append(_warp_step(choice, through, scanout, beside))
    if scanout and not chosen_warp.scans_out:
        why = f"warp '{chosen_warp.name}' cannot follow it: all rows are shown as in its middle"
        left_out.append(("scan-out", why))
    if depth_for and not beside:  # a second run of a warp that cannot write it along with the colour
        stage = "fill" if any(SHOWN_DEPTH in each.entry.reads for each in chain) else "effects"
        reason = f"needed by {depth_for}: the rendered depth, warped as the colour is"
        steps.append(Step(stage, _STEP_SHOWN_DEPTH, reason, PICTURE[1:], (SHOWN_DEPTH,)))
    for fill_choice, entry in ((each, each.entry) for each in chain):
        steps.append(Step("fill", f"fill {fill_choice}", f"chosen: {entry.summary}", entry.reads, entry.writes))
    left_out += [] if chain else [("fill", f"fill 'none': {fills.get('none').summary}")]
    for planned in shown:  # after a fused warp they work on the display's picture
        some = takes_panels and any(effect.for_display for effect in planned.effects)
        reason = _why(planned, forced) + (f"; {takes_panels} composes those that nothing hides" if some else "")
        reads, writes = (
            tuple(PANEL if fused and name == SHOWN else name for name in names)
            for names in (planned.reads, planned.made_by.writes)
        )
        steps.append(Step("effects", planned.made_by.name, reason, reads, writes))
    if chosen_lens.is_pass and not fused:
        reason = f"chosen: {chosen_lens.summary}"
        steps.append(Step("lens", f"lens {chosen_lens.name}", reason, chosen_lens.reads, (PANEL,)))
    else:
        why = f"{distorts} corrects the lens by itself" if distorts else f"lens 'none': {chosen_lens.summary}"
        left_out.append(
            ("lens", f"warp '{choice}' looks through the lens itself: one resample instead of two" if fused else why)
        )
    foveated = _foveated(fovea, choice, steps, left_out, samples_grid=not passes)
    _refuse_unwritten(steps, readable_names() if brings is None else brings, client_geometry)
    return Plan(
        effects=effects.ordered(effect.name for effect in chosen),
        choice=choice,
        fills=chain,
        lens=chosen_lens,
        fused=fused,
        scanout=scanout and chosen_warp.scans_out,
        effect_passes=(*rendered, *shown),
        steps=tuple(steps),
        left_out=tuple(left_out),
        hands_depth_on=bool(takes_depth),
        hands_panels_on=bool(takes_panels) and any(effect.for_display for effect in chosen),
        handed_on=tuple(handed),
        lit=lit_by(indirect),
        foveated=foveated,
    )


def _refuse(
    warp: type[Warp], chain: tuple[Choice[Fill], ...], through: type[LensPass] | None, passes: Sequence[PlannedEffect]
) -> None:
    """Raise PlanError for passes that cannot be fused with a lens, and for colours in light."""
    light = [effect.name for planned in passes if planned.made_by.of_light for effect in planned.effects]
    colours = [fill for fill in chain if CLIENT_MODEL in fill.entry.reads] if light else []
    bodies = [each for each in passes if CLIENT_SOFT_BODIES in each.reads] if light else []
    if through is not None and not warp.fuses:
        able = "only gather warps can, which ask for every pixel by itself"
        raise PlanError(f"warp '{warp.name}' cannot be fused with the lens: {able}; leave --fused out")
    if through is not None and not through.library:
        remedy = "there is nothing to look through; choose a lens, or leave --fused out"
        raise PlanError(f"--fused with --lens {through.name}: {remedy}")
    if through is not None and chain:
        raise PlanError(
            f"--fused with --fill {fill_text(chain)}: a fill needs the picture between warp and lens; "
            "use --fill none, or leave --fused out"
        )
    if colours:
        raise PlanError(
            f"fill '{colours[0]}' draws the scene in its colours, which --effects {light[0]} would multiply with its "
            "textures once more: use a fill from pictures, such as pyramid"
        )
    if bodies:
        raise PlanError(
            f"--effects {bodies[0].effects[0].name} takes the light of what deforms out of colours, and with "
            f"{light[0]} pictures have none: leave one of them out"
        )


def _refuse_unwritten(steps: list[Step], brings: tuple[str, ...], client_geometry: bool) -> None:
    known = {*brings, *((CLIENT_MODEL, CLIENT_SOFT_BODIES) if client_geometry else ())}
    for step in steps:
        if missing := [name for name in step.reads if name not in known]:
            raise PlanError(f"{step.name} needs {' and '.join(dict.fromkeys(map(_described, missing)))}")
        known.update(step.writes)


def _warp_step(choice: Choice[Warp], lens: type[LensPass] | None, scanout: bool, depth_for: str) -> Step:
    """Return the warp, which writes the shown depth too for what is named in depth_for."""
    warp, reads = choice.entry, choice.entry.reads_for(choice.settings)
    reason = f"chosen: {warp.summary}" + (
        "; every row for the instant it lights up" if scanout and warp.scans_out else ""
    )
    if lens is not None:
        reason += f"; fused with the lens: {lens.summary}"
        return Step("warp", f"warp {choice} + lens {lens.name}", reason, reads, (PANEL,))
    if older := warp.needs(choice.settings).others.recent:
        reason += f"; averages the newest frame with up to {older} before it"
    if depth_for:
        reason += f"; writes the depth of what it shows for {depth_for}"
        reads = tuple(dict.fromkeys((*reads, *(warp.depth_reads or ()))))
    return Step("warp", f"warp {choice}", reason, reads, (SHOWN, SHOWN_DEPTH) if depth_for else (SHOWN,))


def _why_not(
    effect: Effect,
    declared: Collection[str],
    warp: type[Warp],
    read: Collection[str],
    fused: bool,
    named: Collection[str],
    forbidden: Collection[str],
) -> str:
    """Return the first reason for which an effect is not compensated, "" for none."""
    name, made_by = effect.name, effect.made_by
    is_asked, is_before = name in named, issubclass(made_by, RenderedPass)
    instead = next((other for other in effects.ordered(declared) if name in effects.get(other).instead_of), "")
    is_unread = is_before and not {*made_by.writes} & {*read}
    through_lens = "the warp looks through the lens itself, so nothing can be composited between"
    not_by_name = f"warp '{warp.name}' compensates nothing unless requested by name: {effect.without}"
    reasons = (
        (name in forbidden, f"the scene calls for it, but it was forbidden: {effect.without}"),
        (name not in declared and effect.by_name_only and not is_asked, f"only on request: --effects {name}"),
        (name not in declared, "nothing in the scene calls for it"),  # the only place that tests for an effect
        (instead, f"{instead} stands in for it"),
        (
            effect.refines and effect.refines not in declared,
            f"it refines {effect.refines}, which is left out: {effect.without}",
        ),
        (fused and not (effect.fuses or is_before), f"{through_lens}: {effect.without}"),
        (warp.kind == "draw", f"warp '{warp.name}' {warp.without_effects}"),
        (warp.imposter and not is_asked, not_by_name),
        (made_by.carries and not warp.carries, f"warp '{warp.name}' carries nothing along: {effect.without}"),
        (is_unread, f"nothing reads the picture that it would change: {effect.without}"),
    )
    return next((why for holds, why in reasons if holds), "")


def _foveated(
    fovea: Fovea | None, choice: Choice[Warp], steps: list[Step], left_out: list[tuple[str, str]], *, samples_grid: bool
) -> Needs:
    """Let the pictures that steps read come foveated, and be expanded before all of them.

    samples_grid: whether nothing warps other pictures along. A warp that alone reads the colour
    then samples it where it lies, if it can.
    """
    read = {name for step in steps for name in step.reads}
    found = [name for name, picture in EXPANDED.items() if picture in read]
    if fovea is None or not found:
        if fovea is not None:
            left_out.append((ExpandPass.name, "nothing reads the picture that would come foveated"))
        return Needs()
    writes = tuple(EXPANDED[name] for name in found)
    (warp,) = (number for number, step in enumerate(steps) if step.stage == "warp")
    readers = [step for step in steps if {*writes} & {*step.reads}]
    plain = getattr(choice.settings, "resample", "bilinear") == "bilinear" and choice.entry.samples_grid
    if samples_grid and plain and readers == [steps[warp]] and found == ["foveated"]:
        reads = tuple(readable("foveated") if name in writes else name for name in readers[0].reads)
        told = f"{readers[0].reason}; samples frames that come coarser away from where the eye looks ({fovea})"
        steps[warp] = attrs.evolve(readers[0], reads=reads, reason=told)
        return Needs(foveated=fovea)
    reason = f"chosen: frames come coarser away from where the eye looks ({fovea})"
    steps.insert(0, Step("effects", ExpandPass.name, reason, tuple(map(readable, found)), writes))
    return Needs(**dict.fromkeys(found, fovea))


def _why(planned: PlannedEffect, forced: Collection[str]) -> str:
    what = "; ".join(f"{effect.name} ({effect.summary})" for effect in planned.effects)
    names = [effect.name for effect in planned.effects if effect.name in forced]
    if names and all(effect.by_name_only for effect in planned.effects):
        return f"requested by name: {what}"
    if names:
        return f"forced, though the scene has nothing of {' and '.join(names)}: {what}"
    return f"the scene calls for it: {what}"


def _described(name: str) -> str:
    """Return what a pass reads, in words for people who know no names of textures."""
    if name in (CLIENT_DEPTH, CLIENT_MODEL, CLIENT_SOFT_BODIES):
        return "the scene's geometry on the client"
    for layer in layers:
        if layer.readable() == name:
            return f"layer '{layer.name}' from the server ({layer.summary})"
    return f"{name}, which no pass before it writes"
