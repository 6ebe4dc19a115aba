"""Draw the client's model into the holes, with its own light or in that around them."""

from __future__ import annotations

from typing import Literal

import attrs

from ...geometry.view import tangents_of_pixels
from ...gpu.textures import SCALAR, Canvas, allocate, release_all
from ..drawn_scenes import share_of
from ..fill_parts import NEAR, OFF_PLANE, BlockLights
from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

SHARE = 0.2  # of the scene's triangles, of every fill with a client's model


@attrs.frozen
class ModelSettings:
    # Share of the scene's triangles that the client draws, 0 to 1.
    share: float = share_of(SHARE)
    # Scale of its textures' resolution on both axes, 0 to 1.
    texture: float = share_of(1.0)
    # off: the bare albedo, for a client that does not shade.
    light: Literal["baked", "off"] = "baked"


@fills.register
class Model(Fill):
    """Draw the client's own triangles; the depth buffer keeps them to the holes.

    The thesis's three savings: fewer triangles, smaller textures, no shading.
    """

    name = "model"
    summary = "the client draws a model with a fifth of the triangles into the holes, lit as baked"
    reads = ("shown.colour", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "the 2014 thesis's client-side model; Garland and Heckbert 1997, Hoppe 1999 (quadric decimation)"
    complete = True
    Settings = ModelSettings
    variants = ("share=0.05",)

    def prepare(self) -> None:
        chosen = self.settings
        self._model = self.model(chosen.share, lit=chosen.light == "baked", texture=chosen.texture)
        self._model.reserve(self.shown_size)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        self._model.draw_holes(inputs.middle, picture, into, inputs.shown_ns)


WORKERS = 1 << 14  # invocations that share the list of holes
# Weight of the model's own light, by the light that the model is drawn with. Best by FLIP is 0.03
# to 0.1 unlit and 0.003 baked (`room`, `walk` and `look-around`, 400 ms); ten times less or more
# costs 1 to 2 %. After warp `mesh`, whose holes are wide, unlit is 0.3 % worse than fill `model` by
# FLIP, and baked 0.9 % better; after `forward`, they are 1.5 and 5 % better.
MODEL_WEIGHT = {"none": 0.03, "baked": 0.003}


@attrs.frozen
class RelightSettings:
    """How the model is drawn and lit."""

    # Share of the scene's triangles that the client draws, 0 to 1.
    share: float = share_of(SHARE)
    samples: int = 32  # Places from which a pixel of a hole takes light.
    reach: float = 0.25  # The farthest of them, in picture widths.
    # The model's own light. none: all light comes from the picture. baked: the baked light is
    # divided out with the albedo and multiplied on again, so that only the difference from it is
    # transferred; that is better wherever light is still as baked, or has changed evenly over a
    # wide area.
    light: Literal["baked", "none"] = "baked"

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.samples <= 4096:
            raise ValueError(f"samples is {self.samples}: expected 1 to 4096")
        if not 0 < self.reach <= 2:
            raise ValueError(f"reach is {self.reach:g}: expected more than 0 and at most 2")


@fills.register
class Relight(Fill):
    """Fill holes with the model, lit by the shown picture.

    Light is the shown colour over the model's albedo (times its baked light, if it has that) where
    both show the same surface. A hole takes light from places that are near in space, lie in its
    plane and face its way, so from the background. Because albedo is divided out first, no texture
    is copied. The model's own baked light has a small weight: it remains where no similar surface
    is in view.
    """

    name = "relight"
    summary = "the client draws a model into the holes, in the light of what is shown around them on the same surface"
    reads = ("shown.colour", "shown.inverse_depth", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    source = (
        "this project's, in place of the 2014 thesis's composite; Barrow and Tenenbaum 1978 (albedo and light apart); "
        "Roberts 2018 (samples)"
    )
    complete = True
    Settings = RelightSettings
    variants = ("light=none",)

    def prepare(self) -> None:
        gl, (wide, high), chosen = self.gpu.gl, self.shown_size, self.settings
        self._lit = self.model(chosen.share, lit=True)
        self._base = self.model(chosen.share, lit=chosen.light == "baked")
        for model in (self._lit, self._base):
            model.reserve(self.shown_size)
        self._albedo = ShownPicture(Canvas(gl, self.shown_size), allocate(gl, self.shown_size, SCALAR))
        self._lights = BlockLights(self.gpu, self.shown_size, chosen.samples, chosen.reach)
        self._holes = gl.buffer(reserve=16 + 4 * wide * high)
        self._apply = self.gpu.shaders.compute("fills/relight.comp")
        self._list = self.gpu.shaders.compute("fills/hole_list.comp", grid="shown", COPY=0)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        view = inputs.middle
        self._lit.draw_holes(view, picture, into, inputs.shown_ns)
        self._base.draw(view, self._albedo, inputs.shown_ns)
        self.gpu.barrier()
        seen = (picture.colour.texture, picture.depth, self._albedo.colour.texture, self._albedo.depth)
        self._lights.find(view, seen)
        self._lights.bind_samples()
        into.colour.texture.bind_to_image(4, read=True, write=True)
        self._holes.write(bytes(16))
        self._holes.bind_to_storage_buffer(2)
        self._list.uniforms.set(warped=0, shown_size=self.shown_size)
        self._list.run(*self.shown_size)
        self.gpu.barrier()
        self._apply.uniforms.set(
            albedo=2, model_inverse_depth=3, lights=5, filled=4, **tangents_of_pixels(view, self.shown_size),
            shown_size=self.shown_size, near=NEAR, off_plane=OFF_PLANE, model_weight=MODEL_WEIGHT[self.settings.light],
            samples=self.settings.samples,
        )  # fmt: skip
        self._apply.run(WORKERS)

    def close(self) -> None:
        self._lights.close()
        release_all(self._albedo.colour, self._albedo.depth, self._holes)
