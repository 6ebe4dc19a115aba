"""Warps that draw the scene which the client has, in place of warping a picture."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Literal

import attrs
import moderngl

from ...base import PlanError
from ...frames import Needs
from ...frames.layers.scene_parts import Delivery, Simplified
from ...geometry import View, view_map
from ...gpu.textures import SCALAR, Canvas, allocate, bind_images
from ...scenes import Scene
from ...sources.server import BYTES_BINDING, display_bytes
from ..client_scene import ArrivingScene, ClientScene, WholeScene
from ..inputs import PassInputs, ShownPicture
from ..settings import limited
from . import warps
from ._base import Warp
from .gather import USUAL_LIMITS


class ClientDrawing(Warp):
    """Draw for the shown view and instant, with a depth buffer of its own where none is given.

    A subclass draws in run_with_depth().
    """

    kind = "draw"
    needs_compute = False
    depth_reads = ()
    carries = False
    for_moving_light: ClassVar[bool] = False  # Whether it is only for scenes whose light moves.

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        still = cls.for_moving_light and not scene.lamps
        return "its light stands still, so that 'model' with baked light is exact" if still else ""

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError(f"warp '{self.name}' needs the scene on the client; for frames without one use 'iterative'")
        # Target for depth that is not read; it keeps near surfaces before far ones.
        self._own_depth = self.own(allocate(self.gpu.gl, self.shown_size, SCALAR))
        self.prepare_scene(self.geometry)

    @abstractmethod
    def prepare_scene(self, geometry: ClientScene) -> None:
        """Take what is drawn from the client."""

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.run_with_depth(inputs, into, self._own_depth)


@attrs.frozen
class ModelSettings:
    # Share of the triangles of the scene's plain surfaces that the client has, 0 to 1. Mirrors and
    # what is see-through or fixed to the head keep theirs.
    share: float = limited(1.0, 0, 1, above=True)
    texture: float = limited(1.0, 0, 1, above=True)  # Scale of its textures' resolution on both axes, 0 to 1.
    light: Literal["baked", "off"] = "baked"  # off: the bare albedo, for a client that does not shade.
    # How it comes. whole: it is there at the start. progressive: in pieces with every frame, what
    # the head sees or is about to see first; stand-ins are shown until then.
    arrives: Literal["whole", "progressive"] = "whole"
    budget: int = limited(20_000, 1)  # Bytes of each frame, at most, where it comes in pieces.


@warps.register
class Model(ClientDrawing):
    """Draw the client's own scene for the shown view and instant, bodies where they are then."""

    name = "model"
    reads = ("client.model",)
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


@attrs.frozen
class _DifferenceSettings:
    """The simplified scene, and what is done with the difference."""

    # Share of the triangles, 0 to 1, and scale of the textures' resolution on both axes.
    share: float = limited(0.2, 0, 1, above=True)
    texture: float = limited(1.0, 0, 1, above=True)
    light: Literal["baked", "off"] = "baked"  # off: the bare albedo, for a client that does not shade.
    # off: the picture as it was drawn, like an imposter: the source's own form.
    warped: Literal["on", "off"] = "on"


@warps.register
class Difference(Warp):
    """Draw the simplified scene, and add what the late picture had more than it."""

    name = "difference"
    kind = "draw"
    reads = ("rendered.difference", "client.model")
    Settings = _DifferenceSettings
    variants = ("warped=off",)
    depth_reads = ()
    carries = False

    @classmethod
    def needs(cls, settings: _DifferenceSettings) -> Needs:
        return Needs(difference=frozenset({_simplified(settings)}))

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError("warp 'difference' needs a scene on the client; for frames without one use 'iterative'")
        self._scene = self.geometry.store(WholeScene, _simplified(self.settings))
        self._warped = self.settings.warped == "on"
        defines = {"WARPED": int(self._warped), **({"WRITES_DEPTH": 1} if self.output.depth else {})}
        self._program = self.gpu.shaders.compute("warps/difference.comp", **defines)
        self._bytes = self.own(display_bytes(self.gpu.gl))
        self._then = self._picture(self.rendered_size)
        self._now = self._picture(self.shown_size) if self._warped else self._then

    def _picture(self, size: tuple[int, int]) -> ShownPicture:
        gl = self.gpu.gl
        return ShownPicture(self.own(Canvas(gl, size)), self.own(allocate(gl, size, SCALAR)))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        difference = inputs.rendered.get("difference", {}).get(_simplified(self.settings))
        if difference is None:
            raise PlanError("warp 'difference' needs the layer 'difference', which this frame lacks")
        rendered, shown, program = inputs.rendered.view, inputs.middle, self._program
        self._scene.draw(rendered, self._then, inputs.rendered.drawn_ns)
        read = {"difference": difference, "rendered_model_depth": self._then.depth}
        if self._warped:
            self._scene.draw(shown, self._now, inputs.shown_ns)
            to_rendered = view_map(shown, self.shown_size, rendered, self.rendered_size)
            read |= {"shown_model": self._now.colour.texture, "shown_model_depth": self._now.depth}
            program.uniforms.set(e=to_rendered.e, **USUAL_LIMITS)
        else:  # as if the head had not moved: at its place in the field of view
            here = View(rendered.pose, shown.fov)
            to_rendered = view_map(here, self.shown_size, rendered, self.rendered_size)
            read["rendered_model"] = self._then.colour.texture
            program.uniforms.set(whole_pixels=to_rendered.moves_whole_pixels())
        self.gpu.barrier()
        depth = {} if self.depth_into is None else {"shown_inverse_depth": self.depth_into}
        units = bind_images(read, {"written": into, **depth})
        self._bytes.bind_to_storage_buffer(BYTES_BINDING)
        program.uniforms.set(H=to_rendered.H, shown_size=self.shown_size, rendered_size=self.rendered_size, **units)
        program.run(*self.shown_size)


def _simplified(settings: _DifferenceSettings) -> Simplified:
    return Simplified(settings.share, settings.texture, settings.light == "baked")
