"""Run a plan on the GPU: one eye's rendered picture in, what the eye should see now out."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager

import attrs
import moderngl

from ..geometry import Fov, Hidden, View
from ..gpu import Gpu
from ..gpu.hidden import Grid, SeenView, Strips
from ..gpu.textures import SCALAR, Canvas, Owner, allocate
from ..headsets import Headset
from .carry import Carry, PictureOf, ShownDepth, images_read, pictures_read
from .client_scene import ClientScene
from .effects import ExpandPass, RenderedPass, ShownPass, Tools
from .effects.text import HeldPanel, PanelsPass, held_panels
from .inputs import PassInputs, ShownPicture
from .lens import LensPass, SeenPanel
from .plan import SHOWN_DEPTH, Plan
from .warps import Output

Stages = Sequence[tuple[str, float]]


@attrs.frozen(eq=False)
class EyeResult:
    """The results of a plan for one eye.

    A warp that is fused with the lens makes the panel alone; the others are None then. The textures
    belong to the compensator, which overwrites them at the next frame of that eye.
    """

    view: View  # The shown view, at the middle of the scan-out if the display has one.
    warped: Canvas | None  # After the warp, with the coverage before the fill.
    shown: Canvas | None  # Before the lens.
    panel: Canvas  # The picture for the display.
    filled: tuple[tuple[str, Canvas], ...] = ()  # After each fill of the chain, by its name.
    # r32f, of `shown`, -1 where it is unknown; None unless the plan makes it.
    inverse_depth: moderngl.Texture | None = None
    panels: tuple[HeldPanel, ...] = ()  # Those that the display composes, the farthest first.


@attrs.frozen(eq=False)
class _Pictures:
    """One eye's pictures after the warp, each fill, each effect and on the panel."""

    warped: ShownPicture | None
    filled: tuple[ShownPicture, ...]
    by_fill: tuple[tuple[str, Canvas], ...]  # of those, as EyeResult has them
    effects: tuple[Canvas, ...]
    panel: Canvas


class Compensator(Owner):
    """The passes of one plan for one pair of sizes.

    Everything is compiled and allocated at the start; run() only sets uniforms and dispatches.
    headset: whose lens is applied; None if the plan has no lens. geometry: what the client can draw
    by itself; required only if a pass reads it. hides: whether lenses hide a part of the views,
    which is then not warped; without, it is warped and blackened.
    """

    def __init__(
        self,
        gpu: Gpu,
        plan: Plan,
        headset: Headset | None,
        rendered_size: tuple[int, int],
        shown_size: tuple[int, int],
        geometry: ClientScene | None = None,
        *,
        hides: bool = False,
    ) -> None:
        self.gpu, self.plan, self.shown_size = gpu, plan, shown_size
        self._blackened: dict[int, tuple[Hidden, Fov]] = {}
        self._panels_seen: dict[int, SeenPanel] = {}
        # What a pass writes is visible to the next pass, to copies and to read-backs.
        self._depth_stage = next((step.stage for step in plan.steps if SHOWN_DEPTH in step.writes), "")
        names = ("effects", "client_depth", "fill", "lens", "carry", self._depth_stage)
        self._stages: dict[str, AbstractContextManager[object]] = {
            name: gpu.timer.stage(name, barrier=True) for name in names
        }
        self._plan_others, self._warp_others = plan.needs.others, plan.warp_needs.others
        self._geometry = geometry
        sizes = rendered_size, shown_size
        with gpu.shaders.hidden.skipping(hides):
            drawn = allocate(gpu.gl, shown_size, SCALAR) if plan.draws_client_depth else None
            self._client_depth = self.own(drawn)
            lens: LensPass | None = None
            if plan.lens.is_pass:
                assert headset is not None, "a plan with a lens is for a headset"
                lens = self.own(plan.lens(gpu, headset, shown_size))
            fused_lens = lens if plan.fused else None
            self._lens = None if plan.fused else lens
            # Whose lens leaves out a part of the panel.
            self._hiding = headset if hides and lens is not None else None
            makes_depth = plan.makes_shown_depth and not plan.warps_twice
            foveated = None if plan.expands else plan.foveated.get("foveated")
            output = Output(fused_lens, plan.scanout, makes_depth, foveated)
            self._warp = self.own(plan.warp(gpu, *sizes, plan.choice.settings, output, geometry))
            self._stages["warp"] = self._warp.stage()
            pictures, self._carry = pictures_read(plan.warp_needs), Carry(self._warp)
            self._depth = self.own(ShownDepth(gpu, self._carry, pictures, *sizes)) if plan.warps_twice else None
            self._fills = []
            for fill in plan.fills:
                read = plan.reads_depth_after(fill)
                self._fills.append(self.own(fill.entry(gpu, *sizes, fill.settings, geometry, depth_read=read)))
            tools = Tools(self._carry, pictures, images_read(plan.needs), geometry, fused_lens, plan.hands_panels_on)
            parts = frozenset(plan.foveated)
            self._expand = self.own(ExpandPass(gpu, parts, *sizes, tools)) if plan.expands else None
            made = [
                self.own(planned.made_by(gpu, frozenset(effect.name for effect in planned.effects), *sizes, tools))
                for planned in plan.effect_passes
            ]
            self._rendered = [effect_pass for effect_pass in made if isinstance(effect_pass, RenderedPass)]
            self._shown = [effect_pass for effect_pass in made if isinstance(effect_pass, ShownPass)]
            self._eyes = [self._pictures_of_one_eye() for _ in range(2)]

    def _pictures_of_one_eye(self) -> _Pictures:
        if self.plan.fused:
            return _Pictures(None, (), (), (), self._canvas())
        has_depth = self.plan.makes_shown_depth
        last = warped = ShownPicture(self._canvas(), self._scalar() if has_depth else None)
        filled = []
        for fill in self._fills:
            own_depth = has_depth and SHOWN_DEPTH in fill.writes
            depth = self._scalar() if own_depth and fill.depth_read else None
            last = ShownPicture(self._canvas(), depth if own_depth else last.inverse_depth)
            filled.append(last)
        effects = tuple(self._canvas() for _ in self._shown)
        shown = effects[-1] if effects else last.colour
        by_fill = tuple((fill.entry.name, each.colour) for fill, each in zip(self.plan.fills, filled, strict=True))
        return _Pictures(warped, tuple(filled), by_fill, effects, self._canvas() if self._lens else shown)

    def _canvas(self) -> Canvas:
        return self.own(Canvas(self.gpu.gl, self.shown_size))

    def _scalar(self) -> moderngl.Texture:
        return self.own(allocate(self.gpu.gl, self.shown_size, SCALAR))

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run every pass of the plan for one eye, each timed as a stage of gpu.timer."""
        made, inputs = self._eyes[inputs.eye], self._prepared(inputs)
        self._set_views(inputs)
        if self._rendered:
            inputs = attrs.evolve(inputs, drawn=inputs.rendered)
        for effect_pass in self._rendered:
            with self._stages["effects"]:
                inputs = effect_pass.run(inputs)
        if inputs.others:
            others = self._warp_others.of(self._plan_others, inputs.others)
            inputs = attrs.evolve(inputs, others=others) if len(others) < len(inputs.others) else inputs
        if self._client_depth is not None:
            assert self._geometry is not None, "a plan that draws the client's depth is for a client with geometry"
            with self._stages["client_depth"]:
                self._geometry.server.draw_depth(inputs.shown, self.shown_size, self._client_depth, inputs.shown_ns)
            inputs = attrs.evolve(inputs, client_inverse_depth=self._client_depth)
        with self._stages["warp"]:
            warped = made.warped
            if warped is None or warped.inverse_depth is None or self._depth is not None:
                self._warp.run(inputs, made.panel if warped is None else warped.colour)
            else:
                self._warp.run_with_depth(inputs, warped.colour, warped.inverse_depth)
            if inputs.shown.hidden is not None or made.warped is None:
                self._hide(inputs.shown, inputs.eye, made)
        panels: tuple[HeldPanel, ...] = ()
        if self.plan.hands_panels_on:  # without those that ask to be hidden, if a pass can
            hides = any(isinstance(shown, PanelsPass) for shown in self._shown)
            found = held_panels(inputs, self._geometry)
            panels = tuple(each for each in found if not (hides and each.panel.occluded))
        if warped is None:
            for shown in self._shown:
                with self._stages["effects"]:
                    shown.run_through_lens(inputs, made.panel)
            return EyeResult(inputs.middle, None, None, made.panel)
        return self._finish(inputs, made, warped, panels)

    def learn(self, inputs: PassInputs) -> None:
        """Let fills that remember learn from a rendered picture as run() does; show nothing."""
        inputs = self._prepared(inputs)
        with self._stages["fill"]:
            for fill in self._fills:
                fill.learn(inputs)

    def _prepared(self, inputs: PassInputs) -> PassInputs:
        """Return the inputs with the rendered picture whole, and without what panels take out."""
        if inputs.shown_last is not None and not self.plan.scanout:
            inputs = inputs.at_once()
        if self._expand is not None:
            with self._stages["effects"]:
                inputs = self._expand.run(inputs)
        for shown in self._shown:
            if shown.takes_out:
                with self._stages["effects"]:
                    inputs = shown.take_out(inputs)
        return inputs

    def _hide(self, view: View, eye: int, made: _Pictures) -> None:
        """Blacken what the lens hides in the warped picture, and once in those that follow.

        Later passes leave it as it is, or copy it; a gather only writes up to its outline.
        """
        if made.warped is None or view.hidden is None:
            self._hide_panel(made.panel)
            return
        self.gpu.barrier()
        hide = self.gpu.shaders.hidden.hide
        of: Strips = "edge" if self._warp.kind == "gather" else "hidden"
        if self._blackened.get(eye) != (view.hidden, view.fov):
            self._blackened[eye], of = (view.hidden, view.fov), "hidden"
            for picture in (*made.filled, *map(ShownPicture, made.effects)):
                hide(view, picture.colour, picture.inverse_depth)
        hide(view, made.warped.colour, made.warped.inverse_depth, of)

    def _set_views(self, inputs: PassInputs) -> None:
        """Let the hidden areas of these views count for the passes that follow."""
        shown = inputs.shown
        views: dict[Grid, SeenView] = {"rendered": inputs.rendered.view, "shown": shown}
        if self._hiding is not None and shown.hidden is not None:
            panel = self._panels_seen.get(inputs.eye)
            if panel is None or (panel.fov, panel.area) != (shown.fov, shown.hidden):
                self._eyes[inputs.eye].panel.clear()
                panel = self._panels_seen[inputs.eye] = SeenPanel(self._hiding, inputs.eye, shown.fov, shown.hidden)
            views["panel"] = panel
        self.gpu.shaders.hidden.views = views

    def _hide_panel(self, panel: Canvas) -> None:
        """Blacken what the lens has written beyond the outline of what is seen."""
        if (seen := self.gpu.shaders.hidden.views.get("panel")) is not None:
            self.gpu.barrier()
            self.gpu.shaders.hidden.hide(seen, panel, None, "edge")

    def _finish(
        self, inputs: PassInputs, made: _Pictures, warped: ShownPicture, panels: tuple[HeldPanel, ...]
    ) -> EyeResult:
        """Run everything after the warp."""
        if self._depth is not None and warped.inverse_depth is not None:
            with self._stages[self._depth_stage]:
                self._depth.run(inputs, warped.inverse_depth)
        picture = warped
        for fill, into in zip(self._fills, made.filled, strict=True):
            with self._stages["fill"]:
                fill.run(inputs, picture, into)
            picture = into
        shown = picture.colour
        for one, onto in zip(self._shown, made.effects, strict=True):
            with self._stages["effects"]:
                one.run(inputs, ShownPicture(shown, picture.inverse_depth), onto)
            shown = onto
        if self._lens is not None:
            with self._stages["lens"]:
                self._lens.run(shown, inputs.shown.fov, inputs.eye, made.panel)
                if self._hiding is not None:
                    self._hide_panel(made.panel)
        return EyeResult(inputs.middle, warped.colour, shown, made.panel, made.by_fill, picture.inverse_depth, panels)

    def carry(self, inputs: PassInputs, picture_of: PictureOf, into: Canvas) -> None:
        """Warp further pictures as the colour of the same inputs is; see Carry.along."""
        self._set_views(inputs)
        with self._stages["carry"]:
            self._carry.along(inputs, picture_of, into)

    def renew(self) -> None:
        """Take the next frame for a new one, even if it is the last one again: for timing."""
        for fill in self._fills:
            fill.renew()

    def record_timings(self, stages: Sequence[Stages]) -> None:
        """Ignore the stage times: a single plan has nothing to decide."""
