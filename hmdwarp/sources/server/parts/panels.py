"""Panels: drawn into the picture as rectangles of the world, or sent once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from ....frames import EyeImage
from ....frames.layers import Outbox, Update
from ....frames.layers.panels import PanelDelivery, first_things, things_of, with_showing
from ....geometry import View
from ....scenes import Material, Panel, Scene
from ..passes import SAME_SURFACE
from ..sending import Sender, Sending
from ..upload import SceneTextures
from . import DrawContext, Drawing, parts
from ._sheets import MOST, OVER_KEEPING_COVERAGE, Sheets


@parts.register
class Panels(Sending[PanelDelivery, "_Sender"]):
    """Sheets at their own places, the farthest first; in the world with a depth of their own."""

    name = "panels"
    order = 88

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._drawn: list[_Drawn] | None = None

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return bool(scene.panels)

    def make_sender(self, wanted: PanelDelivery) -> _Sender:
        return _Sender(self.context.scene.panels, wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        updates = {wanted: self.sender(wanted).update(drawing.time_ns) for wanted in self.needed(drawing)}
        return {"panels": updates} if updates else {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "panels" not in drawing.needs:
            if self._drawn is None:
                self._drawn = [_Drawn(self.context, panel) for panel in self.context.scene.panels]
            for drawn in sorted(self._drawn, key=lambda one: -one.panel.away_m(eye.view)):
                drawn.draw(eye)
        return eye

    def close(self) -> None:
        for drawn in self._drawn or ():
            drawn.close()
        super().close()


class _Drawn:
    """One panel as sheets of a scene of its own, whose origin is the panel's place."""

    def __init__(self, context: DrawContext, panel: Panel) -> None:
        self.panel, self._gpu, self._framebuffers = panel, context.gpu, context.framebuffers
        origin = (0.0, 0.0, 0.0) if panel.head_locked else panel.pose.position_m
        of_pose = panel.pose if panel.head_locked else attrs.evolve(panel.pose, position_m=(0.0, 0.0, 0.0))
        material = Material(see_through=not panel.head_locked, head_locked=panel.head_locked)
        mesh = panel.quad.mesh("panel")
        mesh = attrs.evolve(
            mesh, positions=of_pose.transform(mesh.positions), double_sided=False, material=material, albedo=None
        )
        meshes = [attrs.evolve(mesh, texture=index) for index in range(len(panel.pictures))]
        scene = Scene("panel", "", meshes, panel.pictures, origin_m=origin)
        self._textures = SceneTextures(context.gpu, scene, lent=True)
        own = attrs.evolve(context, scene=scene, textures=self._textures)
        self._sheets = [Sheets(own, [mesh]) for mesh in scene.meshes]

    def draw(self, eye: EyeImage) -> None:
        """Draw it over the picture of an eye, whose inverse depth is bound."""
        sheets, panel = self._sheets[self.panel.showing(eye.drawn_ns)], self.panel
        program = sheets.colour(tests=int(panel.occluded))
        if panel.occluded:
            eye.inverse_depth.use(1)
            program.uniforms.set(picture=1, keep=1 - SAME_SURFACE)
        over = self._framebuffers.over(eye.colour)
        sheets.draw(program, eye.view, eye.drawn_ns, over, OVER_KEEPING_COVERAGE)
        if not panel.head_locked:
            near = self._framebuffers.over(eye.inverse_depth)
            sheets.draw(sheets.program("cutout"), eye.view, eye.drawn_ns, near, MOST)
            self._gpu.barrier()  # llvmpipe lets shaders read inverse depth as it was before

    def close(self) -> None:
        for sheets in self._sheets:
            sheets.close()
        self._textures.close()


class _Sender(Sender):
    """The pictures of all panels that one PanelDelivery still has to send."""

    def __init__(self, panels: Sequence[Panel], wanted: PanelDelivery) -> None:
        self._panels, self._wanted = panels, wanted
        self._first = first_things(panels)
        self.book = Outbox(things_of(panels))

    def _needed(self, now_ns: int) -> list[int]:
        shown = (first + each.showing(now_ns) for first, each in zip(self._first, self._panels, strict=True))
        return [0, *shown] if self._panels else []

    def has_more(self, now_ns: int) -> bool:
        self.book.settle(now_ns)
        return not self.book.waiting.isdisjoint(self._needed(now_ns))

    def update(self, now_ns: int) -> Update:
        self.book.settle(now_ns)
        update = self.book.update(self._needed(now_ns), self._wanted.budget, now_ns)
        return with_showing(update, now_ns, [each.showing(now_ns) for each in self._panels])
