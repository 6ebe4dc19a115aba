"""Light-only frames: the picture is light alone, and the client draws its textures at once."""

from __future__ import annotations

from ...frames import Needs
from ...gpu.textures import Canvas
from ..drawn_scenes import ReducedModel
from ..inputs import PassInputs, ShownPicture
from . import effects
from ._base import Effect, ShownPass


class LightPass(ShownPass):
    """Draw the scene's albedo at the newest pose; multiply it with the warped and filled light.

    What textures emit is drawn by itself, and added after: no light falls on it.
    """

    name = "light times albedo"
    reads = ("shown.colour", "rendered.light", "client.model")
    of_light = True

    def prepare(self) -> None:
        geometry = self.tools.geometry
        self._program = self.gpu.shaders.compute("effects/light.comp", grid="shown")
        store = None if geometry is None else geometry.store(ReducedModel, (1.0, 1.0))
        self._model = None if store is None else store.drawn(lit=False)
        self._shining = None if store is None else store.shining()
        self._albedo = ShownPicture(Canvas(self.gpu.gl, self.shown_size), None)
        self._emitted = ShownPicture(Canvas(self.gpu.gl, self.shown_size), None) if self._shining else self._albedo
        for model in (self._model, self._shining):
            if model is not None:
                model.reserve(self.shown_size)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        assert self._model is not None, "a plan that reads client.model is for a client with geometry"
        self._model.draw(inputs.middle, self._albedo, inputs.shown_ns)
        if self._shining is not None:
            self._shining.draw(inputs.middle, self._emitted, inputs.shown_ns)
        self.gpu.barrier()
        picture.colour.texture.bind_to_image(0, read=True, write=False)
        self._albedo.colour.texture.bind_to_image(1, read=True, write=False)
        self._emitted.colour.texture.bind_to_image(2, read=True, write=False)
        into.bind_for_writing(3)
        shines = self._shining is not None
        self._program.uniforms.set(light=0, albedo=1, emitted=2, written=3, shines=shines, shown_size=into.size)
        self._program.run(*into.size)

    def close(self) -> None:
        for canvas in {self._albedo.colour, self._emitted.colour}:
            canvas.release()


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
