"""The client has the scene and draws it: nothing of it is late."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import attrs

from ...errors import PlanError
from ...frames import Needs
from ...frames.layers.scene_update import Delivery
from ...gpu.textures import SCALAR, allocate
from ..settings import share_of
from ..shown_picture import ShownPicture
from . import warps
from ._base import Warp

if TYPE_CHECKING:
    import moderngl

    from ...gpu.textures import Canvas
    from ..inputs import PassInputs


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
class Model(Warp):
    """Draw the client's own scene for the shown view and instant; read nothing of the frame.

    Bodies and what deforms are drawn where they are at that instant: the client knows how they
    move.
    """

    name = "model"
    summary = "the client has the scene, or a reduced one, and draws it at the newest pose; no picture is sent"
    kind = "draw"
    needs_compute = False
    reads = ("client.model",)
    exact_when = "to the last bit, with all triangles and texels, lit, once all has arrived, in light that stands still"
    gets_wrong = (
        "takes the whole scene, and a renderer for it, on the client; fewer triangles round outlines off, smaller "
        "textures blur; lamps that move are baked where they are at the start"
    )
    source = "the 2014 thesis, section 3.1 (GLX, partial models); Garland and Heckbert 1997, 1998 (fewer triangles)"
    Settings = ModelSettings
    variants = ("share=0.2",)
    depth_reads = ()
    carries = False

    @classmethod
    def needs(cls, settings: ModelSettings) -> Needs:
        if settings.arrives == "whole":
            return Needs()
        return Needs(scene_update=frozenset({_delivery(settings)}))

    @classmethod
    def reads_for(cls, settings: ModelSettings) -> tuple[str, ...]:
        return cls.reads if settings.arrives == "whole" else (*cls.reads, "rendered.scene_update")

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError("warp 'model' needs the scene on the client; for frames without one use 'iterative'")
        chosen = self.settings
        if chosen.arrives == "progressive":
            self._scene = self.geometry.arriving(_delivery(chosen))
        else:
            self._scene = self.geometry.scene(chosen.share, lit=chosen.light == "baked", texture=chosen.texture)
        # Where the depth goes that nobody reads; it keeps near surfaces before far ones.
        self._own_depth = allocate(self.gpu.gl, self.shown_size, SCALAR)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.run_with_depth(inputs, into, self._own_depth)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        self._scene.draw(inputs.middle, ShownPicture(into, depth), inputs.shown_ns)

    def close(self) -> None:
        super().close()
        self._own_depth.release()


def _delivery(settings: ModelSettings) -> Delivery:
    return Delivery(settings.share, settings.texture, settings.light == "baked", settings.budget)
