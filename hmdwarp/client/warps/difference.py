"""Difference image: the client draws a simplified scene, the server sends what it lacks."""

from __future__ import annotations

from typing import Literal

import attrs

from ...errors import PlanError
from ...frames import Needs
from ...frames.layers.scene_parts import Simplified
from ...geometry import View, view_map
from ...gpu.textures import SCALAR, Canvas, allocate
from ...sources.server import BYTES_BINDING, display_bytes
from ..drawn_scenes import WholeScene, share_of
from ..inputs import PassInputs, ShownPicture
from ..warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE
from . import warps
from ._base import Warp

_DIFFERENCE, _MODEL, _MODEL_DEPTH, _RENDERED_DEPTH, _WRITTEN, _DEPTH = range(6)  # image units


@attrs.frozen
class DifferenceSettings:
    """The simplified scene, and what is done with the difference."""

    # Share of the triangles, 0 to 1, and scale of the textures' resolution on both axes.
    share: float = share_of(0.2)
    texture: float = share_of(1.0)
    # off: the bare albedo, for a client that does not shade.
    light: Literal["baked", "off"] = "baked"
    # off: the picture as it was drawn, like an imposter: the source's own form.
    warped: Literal["on", "off"] = "on"


@warps.register
class Difference(Warp):
    """Draw the simplified scene, and add what the late picture had more than it."""

    name = "difference"
    summary = "the client draws a simplified scene at the newest pose and adds what the server's picture had more"
    kind = "draw"
    reads = ("rendered.difference", "client.model")
    exact_when = (
        "the head is still and no codec runs: the picture is the server's to the last byte; with all triangles and "
        "texels always"
    )
    gets_wrong = (
        "detail that the late picture did not see stays that of the simplified scene; highlights and what moves are "
        "added where they were; takes a scene on the client"
    )
    source = "Levoy 1995, Polygon-Assisted JPEG and MPEG Compression of Synthetic Images; warped: our own"
    Settings = DifferenceSettings
    variants = ("warped=off",)
    depth_reads = ()
    carries = False

    @classmethod
    def needs(cls, settings: DifferenceSettings) -> Needs:
        return Needs(difference=frozenset({_simplified(settings)}))

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError("warp 'difference' needs a scene on the client; for frames without one use 'iterative'")
        gl, chosen = self.gpu.gl, self.settings
        self._warped = chosen.warped == "on"
        self._scene = self.geometry.store(WholeScene, _simplified(chosen))
        defines = {"WARPED": int(self._warped), **({"WRITES_DEPTH": 1} if self.output.depth else {})}
        self._program = self.gpu.shaders.compute("warps/difference.comp", **defines)
        self._bytes = display_bytes(gl)
        self._then = ShownPicture(Canvas(gl, self.rendered_size), allocate(gl, self.rendered_size, SCALAR))
        self._now = None
        if self._warped:
            self._now = ShownPicture(Canvas(gl, self.shown_size), allocate(gl, self.shown_size, SCALAR))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        difference = inputs.rendered.get("difference", {}).get(_simplified(self.settings))
        if difference is None:
            raise PlanError("warp 'difference' needs the layer 'difference', which this frame lacks")
        rendered, shown = inputs.rendered.view, inputs.middle
        self._scene.draw(rendered, self._then, inputs.rendered.drawn_ns)
        if self._now is not None:
            self._scene.draw(shown, self._now, inputs.shown_ns)
        self.gpu.barrier()
        program = self._program
        model = self._now if self._now is not None else self._then
        difference.bind_to_image(_DIFFERENCE, read=True, write=False)
        model.colour.texture.bind_to_image(_MODEL, read=True, write=False)
        if self._now is not None:
            model.depth.bind_to_image(_MODEL_DEPTH, read=True, write=False)
        self._then.depth.bind_to_image(_RENDERED_DEPTH, read=True, write=False)
        into.bind_for_writing(_WRITTEN)
        self._bytes.bind_to_storage_buffer(BYTES_BINDING)
        if self.depth_into is not None:
            self.depth_into.bind_to_image(_DEPTH, read=False, write=True)
            program.uniforms.set(shown_inverse_depth=_DEPTH)
        if self._now is not None:
            to_rendered = view_map(shown, self.shown_size, rendered, self.rendered_size)
            limits = {"depth_tolerance": DEPTH_TOLERANCE, "depth_floor": DEPTH_FLOOR}
            program.uniforms.set(shown_model=_MODEL, shown_model_depth=_MODEL_DEPTH, e=to_rendered.e, **limits)
        else:  # as if the head had not moved: at its place in the field of view
            here = View(rendered.pose, shown.fov)
            to_rendered = view_map(here, self.shown_size, rendered, self.rendered_size)
            program.uniforms.set(rendered_model=_MODEL, whole_pixels=to_rendered.moves_whole_pixels())
        program.uniforms.set(
            difference=_DIFFERENCE,
            rendered_model_depth=_RENDERED_DEPTH,
            written=_WRITTEN,
            H=to_rendered.H,
            shown_size=self.shown_size,
            rendered_size=self.rendered_size,
        )
        program.run(*self.shown_size)

    def close(self) -> None:
        super().close()
        for picture in filter(None, (self._then, self._now)):
            picture.colour.release()
            picture.depth.release()
        self._bytes.release()


def _simplified(settings: DifferenceSettings) -> Simplified:
    return Simplified(settings.share, settings.texture, settings.light == "baked")
