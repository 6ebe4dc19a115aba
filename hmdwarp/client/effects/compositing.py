"""Layers over the shown picture: what is fixed to the head, glass, and light times albedo."""

from __future__ import annotations

import attrs

from ...frames import Needs
from ...gpu.textures import Canvas, bind_images
from ...scenes import is_cutout
from ..client_scene import ReducedModel
from ..inputs import PassInputs, ShownPicture, as_image
from ..warps.gather import GatherWarp, last_centre
from ..warps.iterative import OF_A_PART, IterativeSettings, Seeds
from . import effects
from ._base import ShownPass


class OverlayPass(ShownPass):
    """Composite the overlay, which the server drew for exactly this field of view and size."""

    name = "overlay compositing"
    reads = ("shown.colour", "rendered.overlay")

    def prepare(self) -> None:
        self._program = self.gpu.shaders.compute("effects/overlay.comp", grid="shown")

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        read = {"picture": picture.colour, "overlay": inputs.rendered["overlay"]}
        self._program.uniforms.set(shown_size=into.size, **bind_images(read, {"written": into}))
        self._program.run(*into.size)


effects.declare("overlay", OverlayPass, Needs(overlay=True), applies=lambda _, mesh: mesh.material.head_locked)


# The shown depth of a warp that runs twice for it has been through two half floats: each rounds by
# 2^-11 of it (truncation makes things farther away). A sheet that lies on a surface must not
# flicker; in exchange, a sheet 1.5 mm behind its frame at 1.5 m is drawn over the frame.
NEARER = 1 + 2.0**-10


class _Veil(GatherWarp):
    """The warp `iterative` with its own settings, for the veil, which it composites directly."""

    Settings = IterativeSettings
    rows = 4
    behind: ShownPicture  # the picture under the veil; set before run()

    def prepare(self) -> None:
        self._program = self.gather("effects/veil.comp", PLAIN=self.settings.steps - self.settings.slanted)
        with self.gpu.shaders.hidden.skipping(False):  # one invocation for 16 pixels: little to save
            self._seeds = self.own(Seeds(self.gpu, self.rendered_size, self.shown_size))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        """Composite the veil over `behind`. inputs.rendered: the picture as it arrived."""
        layer, settings = inputs.rendered["transparent"], self.settings
        inputs = attrs.evolve(inputs.at_once(), rendered=as_image(inputs.rendered, layer.veil))
        surface = bind_images({"rendered_inverse_depth": inputs.rendered.inverse_depth}, first=1)
        surface |= {"depth_tolerance": settings.tolerance, "depth_floor": settings.floor}
        surface |= last_centre(self.rendered_size)
        self._seeds.find(inputs, surface)
        below = bind_images({"picture": self.behind.colour, "shown_inverse_depth": self.behind.depth}, first=2)
        passing = attrs.evolve(inputs, rendered=attrs.evolve(inputs.rendered, colour=layer.passing))
        self.bind_colour(passing, 1, self.maps(inputs, inputs.rendered.view))
        below |= {"rendered_passing": 1, "nearer": NEARER, "most_pixels": settings.converged}
        self.run_gather(self._program, inputs, into, cells=self._seeds.cells, **surface, **below)


class TransparencyPass(ShownPass):
    """Warps all sheets of a rendered pixel as one surface at the depth of the nearest.

    Sheets behind it move with it. Occlusion of the veil is tested in the shown view. If the server
    tested it in the rendered view, the shown depth would not be needed (some warps run twice for
    it), but in `greenhouse` after 400 ms FLIP is 5 % higher on look-around (0.0632 instead of
    0.0605); on walk it is the same (0.0392).
    """

    name = "transparency compositing"
    reads = ("shown.colour", "shown.inverse_depth", "rendered.transparent")

    def prepare(self) -> None:
        self._veil = self.own(_Veil(self.gpu, self.rendered_size, self.shown_size, OF_A_PART))

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        self._veil.behind = picture
        self._veil.run(inputs, into)


effects.declare(
    "transparency",
    TransparencyPass,
    Needs(transparent=True),
    applies=lambda scene, mesh: mesh.material.see_through and not is_cutout(scene, mesh),
)


class _LightPass(ShownPass):
    """Draw the scene's albedo at the newest pose; multiply it with the warped and filled light.

    What textures emit is drawn by itself, and added after: no light falls on it.
    """

    name = "light times albedo"
    reads = ("shown.colour", "rendered.light", "client.model")
    of_light = True

    def prepare(self) -> None:
        geometry, gl = self.tools.geometry, self.gpu.gl
        self._program = self.gpu.shaders.compute("effects/light.comp", grid="shown")
        store = None if geometry is None else geometry.store(ReducedModel, (1.0, 1.0))
        self._model = None if store is None else store.drawn(lit=False)
        self._shining = None if store is None else store.shining()
        self._albedo = ShownPicture(self.own(Canvas(gl, self.shown_size)))
        self._emitted = ShownPicture(self.own(Canvas(gl, self.shown_size))) if self._shining else self._albedo
        for model in (self._model, self._shining):
            if model is not None:
                model.reserve(self.shown_size)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        assert self._model is not None, "a plan that reads client.model is for a client with geometry"
        self._model.draw(inputs.middle, self._albedo, inputs.shown_ns)
        if self._shining is not None:
            self._shining.draw(inputs.middle, self._emitted, inputs.shown_ns)
        self.gpu.barrier()
        read = {"light": picture.colour, "albedo": self._albedo.colour, "emitted": self._emitted.colour}
        units = bind_images(read, {"written": into})
        self._program.uniforms.set(shines=self._shining is not None, shown_size=into.size, **units)
        self._program.run(*into.size)


effects.declare("light_only", _LightPass, Needs(light=True), applies=lambda scene, mesh: True)
