"""The client has the scene and draws it: nothing of it is late."""

from __future__ import annotations

from typing import Literal

import attrs
import moderngl

from ...frames import Needs
from ...frames.layers.scene_parts import Delivery, Simplified
from ...gpu.textures import Canvas
from ..client_scene import ClientScene
from ..drawn_scenes import ArrivingScene, WholeScene, share_of
from ..inputs import PassInputs, ShownPicture
from ..warp_kinds import ClientDrawing
from . import warps


@attrs.frozen
class ModelSettings:
    # Share of the triangles of the scene's plain surfaces that the client has, 0 to 1. Mirrors and
    # what is see-through or fixed to the head keep theirs.
    share: float = share_of(1.0)
    # Scale of its textures' resolution on both axes, 0 to 1.
    texture: float = share_of(1.0)
    # off: the bare albedo, for a client that does not shade.
    light: Literal["baked", "off"] = "baked"
    # How it comes. whole: it is there at the start. progressive: in pieces with every frame, what
    # the head sees or is about to see first; stand-ins are shown until then.
    arrives: Literal["whole", "progressive"] = "whole"
    # Bytes of each frame, at most, where it comes in pieces.
    budget: int = attrs.field(default=20_000, validator=attrs.validators.ge(1))


@warps.register
class Model(ClientDrawing):
    """Draw the client's own scene for the shown view and instant; read nothing of the frame.

    Bodies and what deforms are drawn where they are at that instant: the client knows how they
    move.
    """

    name = "model"
    summary = "the client has the scene, or a reduced one, and draws it at the newest pose; no picture is sent"
    reads = ("client.model",)
    exact_when = "to the last bit, with all triangles and texels, lit, once all has arrived, in light that stands still"
    gets_wrong = (
        "takes the whole scene, and a renderer for it, on the client; fewer triangles round outlines off, smaller "
        "textures blur; lamps that move are baked where they are at the start"
    )
    source = "the 2014 thesis, section 3.1 (GLX, partial models); Garland and Heckbert 1997, 1998 (fewer triangles)"
    Settings = ModelSettings
    variants = ("share=0.2",)

    @classmethod
    def needs(cls, settings: ModelSettings) -> Needs:
        if settings.arrives == "whole":
            return Needs()
        return Needs(scene_update=frozenset({_delivery(settings)}))

    @classmethod
    def reads_for(cls, settings: ModelSettings) -> tuple[str, ...]:
        return cls.reads if settings.arrives == "whole" else (*cls.reads, "rendered.scene_update")

    def prepare_scene(self, geometry: ClientScene) -> None:
        chosen = self.settings
        self._scene: ArrivingScene | WholeScene
        if chosen.arrives == "progressive":
            self._scene = geometry.store(ArrivingScene, _delivery(chosen))
        else:
            wanted = Simplified(chosen.share, chosen.texture, chosen.light == "baked")
            self._scene = geometry.store(WholeScene, wanted)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        self._scene.draw(inputs.middle, ShownPicture(into, depth), inputs.shown_ns)


def _delivery(settings: ModelSettings) -> Delivery:
    return Delivery(settings.share, settings.texture, settings.light == "baked", settings.budget)
