"""Content fixed to the head, composited after everything else and never warped."""

from __future__ import annotations

from ...frames import Needs
from ...gpu.textures import Canvas
from ..inputs import PassInputs, ShownPicture
from . import effects
from ._base import Effect, ShownPass


class OverlayPass(ShownPass):
    """Composite the overlay, which the server drew for exactly this field of view and size."""

    name = "overlay compositing"
    reads = ("shown.colour", "rendered.overlay")

    def prepare(self) -> None:
        self._program = self.gpu.shaders.compute("effects/overlay.comp", grid="shown")

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        picture.colour.texture.bind_to_image(0, read=True, write=False)
        inputs.rendered["overlay"].bind_to_image(1, read=True, write=False)
        into.bind_for_writing(2)
        self._program.uniforms.set(picture=0, overlay=1, written=2, shown_size=into.size)
        self._program.run(*into.size)


effects.register(
    Effect(
        name="overlay",
        order=90,
        summary="a HUD is put over the shown picture and never warped",
        applies=lambda _, mesh: mesh.material.head_locked,
        made_by=OverlayPass,
        needs=Needs(overlay=True),
        without="what is fixed to the head is warped with the world, so that it swims and tears",
        source="Porter and Duff 1984, Compositing Digital Images; the quad layers of OpenXR, XrCompositionLayerQuad "
        "in view space",
    )
)
