"""Light-only frames: the picture is light alone, and the client draws its textures at once."""

from __future__ import annotations

from ...frames import Needs
from ...gpu.textures import Canvas
from ..drawn_scenes import ReducedModel
from ..inputs import PassInputs, ShownPicture
from . import effects
from ._base import Effect, ShownPass


class LightPass(ShownPass):
    """Draw the scene's albedo at the newest pose; multiply it with the warped and filled light."""

    name = "light times albedo"
    reads = ("shown.colour", "rendered.light", "client.model")
    of_light = True

    def prepare(self) -> None:
        geometry = self.tools.geometry
        self._program = self.gpu.shaders.compute("effects/light.comp")
        self._model = None if geometry is None else geometry.store(ReducedModel, (1.0, 1.0)).drawn(lit=False)
        self._albedo = ShownPicture(Canvas(self.gpu.gl, self.shown_size), None)
        if self._model is not None:
            self._model.reserve(self.shown_size)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        assert self._model is not None, "a plan that reads client.model is for a client with geometry"
        self._model.draw(inputs.middle, self._albedo, inputs.shown_ns)
        self.gpu.barrier()
        picture.colour.texture.bind_to_image(0, read=True, write=False)
        self._albedo.colour.texture.bind_to_image(1, read=True, write=False)
        into.bind_for_writing(2)
        self._program.uniforms.set(light=0, albedo=1, written=2, shown_size=into.size)
        self._program.run(*into.size)

    def close(self) -> None:
        self._albedo.colour.release()

    @classmethod
    def bytes_moved(cls, rendered_pixels: int, shown_pixels: int) -> int:
        """Return the bytes of the albedo written and read, of the light and of the result."""
        return 4 * 8 * shown_pixels


effects.register(
    Effect(
        name="light_only",
        order=5,
        summary="frames hold light as if every surface were white; the client draws the textures at the newest pose",
        applies=lambda scene, mesh: True,
        by_name_only=True,
        made_by=LightPass,
        needs=Needs(light=True),
        without="textures are resampled with the light, so that they blur, and are late as it is",
        source="the 2014 thesis's outlook, section 7; Barrow and Tenenbaum 1978, Recovering Intrinsic Scene "
        "Characteristics from Images",
    )
)
