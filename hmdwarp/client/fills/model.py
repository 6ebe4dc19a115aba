"""Draw the client's model into the holes, with its own light or in that around them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...geometry import View, view_map
from ...geometry.view import tangents_of_pixels
from ...gpu import Gpu
from ...gpu.textures import SCALAR, Owner, allocate, bind_images, tiles
from ..inputs import PassInputs, ShownPicture
from ..settings import limited
from . import fills
from ._base import Fill, HolePieces

BLOCK = 8  # pixels, as in shaders/lib/relight.glsl
LIGHT = (4, "f4")  # rgba32f, PARTS texels a block
PARTS = 3
SEED = 0.5
_SAME_DEPTH = SAME_SURFACE = (
    0.05  # the model's surfaces are off by a few hundredths; a smaller tolerance leaves curved objects unlit
)
NEAR, OFF_PLANE = 0.05, 0.06
_SAMPLES = 1  # storage binding


def sample_offsets(count: int, reach_pixels: float) -> NDArray[np.int32]:
    """Return (count, 2) pixel offsets in a disc of that radius, denser towards the middle.

    They are the same for every pixel and picture. A separate pattern for every pixel would be grain
    that crawls when the head moves; with a common one, light changes only as its samples do.
    Source: Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences (R2).
    """
    plastic = 1.32471795724474602596
    k = np.arange(1, count + 1)
    ring, turn = (SEED + k / plastic) % 1, 2 * np.pi * ((SEED + k / plastic**2) % 1)
    places = reach_pixels * ring[:, None] ** 2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    offsets: NDArray[np.int32] = np.rint(places).astype(np.int32)
    return offsets


class BlockLights(Owner):
    """Finds light on blocks of a picture, and holds where a pixel looks for it.

    size: (w, h) of the picture. samples: places from which a pixel takes light; reach: the farthest
    of them, in picture widths.
    """

    def __init__(self, gpu: Gpu, size: tuple[int, int], samples: int, reach: float) -> None:
        self._size, self._blocks = size, tiles(size, BLOCK)
        self._find = gpu.shaders.compute("fills/relight_blocks.comp")
        # What find() writes; read by shaders with lib/relight.glsl.
        self.texture = self.own(allocate(gpu.gl, (PARTS * self._blocks[0], self._blocks[1]), LIGHT))
        offsets = sample_offsets(samples, reach * size[0])
        self._samples = self.own(gpu.gl.buffer(np.pad(offsets, ((0, 0), (0, 2))).tobytes()))

    def find(self, view: View, textures: Sequence[moderngl.Texture]) -> None:
        """Divide the albedo out of a picture where it shows the same surface.

        textures: colour and inverse depth of the picture, then albedo and inverse depth of what the
        client draws; they stay bound to image units 0 to 3, the light to 4.
        """
        names = ("warped", "warped_inverse_depth", "albedo", "model_inverse_depth")
        units = bind_images(dict(zip(names, textures, strict=True)), change={"lights": self.texture})
        limits = {"same_depth": _SAME_DEPTH, "same_surface": SAME_SURFACE, **tangents_of_pixels(view, self._size)}
        self._find.uniforms.set(shown_size=self._size, block_count=self._blocks, **units, **limits)
        self._find.run(*self._blocks)

    def bind_samples(self) -> None:
        """Bind the places for the shader that reads them."""
        self._samples.bind_to_storage_buffer(_SAMPLES)


SHARE = 0.2  # of the scene's triangles, of every fill with a client's model


@attrs.frozen
class ModelSettings:
    share: float = limited(SHARE, 0, 1, above=True)  # Share of the scene's triangles that the client draws, 0 to 1.
    texture: float = limited(1.0, 0, 1, above=True)  # Scale of its textures' resolution on both axes, 0 to 1.
    light: Literal["baked", "off"] = "baked"  # off: the bare albedo, for a client that does not shade.


@fills.register
class Model(Fill):
    """Draw the client's own triangles; the depth buffer keeps them to the holes.

    The thesis's three savings: fewer triangles, smaller textures, no shading.
    """

    name = "model"
    reads = ("shown.colour", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    complete = True
    Settings = ModelSettings
    variants = ("share=0.05",)

    def prepare(self) -> None:
        chosen = self.settings
        self._model = self.model(chosen.share, lit=chosen.light == "baked", texture=chosen.texture)

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

    share: float = limited(SHARE, 0, 1, above=True)  # Share of the scene's triangles that the client draws, 0 to 1.
    samples: int = limited(32, 1, 4096)  # Places from which a pixel of a hole takes light.
    reach: float = limited(0.25, 0, 2, above=True)  # The farthest of them, in picture widths.
    # The model's own light. none: all light comes from the picture. baked: the baked light is
    # divided out with the albedo and multiplied on again, so that only the difference from it is
    # transferred; that is better wherever light is still as baked, or has changed evenly over a
    # wide area.
    light: Literal["baked", "none"] = "baked"


@fills.register
class Relight(Fill):
    """Fill holes with the model, lit by the shown picture.

    Light is the shown colour over the model's albedo (times its baked light, if it has that) where
    both show the same surface. A hole takes light from places that are near in space, lie in its
    plane and face its way. No texture is copied, because albedo is divided out first. The model's
    own baked light has a small weight: it remains where no similar surface is in view.
    """

    name = "relight"
    reads = ("shown.colour", "shown.inverse_depth", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    complete = True
    Settings = RelightSettings
    variants = ("light=none",)

    def prepare(self) -> None:
        (wide, high), chosen, shaders = self.shown_size, self.settings, self.gpu.shaders
        self._lit = self.model(chosen.share, lit=True)
        self._base = self.model(chosen.share, lit=chosen.light == "baked")
        self._albedo = self.picture()
        self._lights = self.own(BlockLights(self.gpu, self.shown_size, chosen.samples, chosen.reach))
        self._holes = self.own(self.gpu.gl.buffer(reserve=16 + 4 * wide * high))
        self._apply = shaders.compute("fills/relight.comp")
        self._list = shaders.compute("fills/hole_list.comp", grid="shown", COPY=0)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        view = inputs.middle
        self._lit.draw_holes(view, picture, into, inputs.shown_ns)
        self._base.draw(view, self._albedo, inputs.shown_ns)
        self.gpu.barrier()
        seen = (picture.colour.texture, picture.depth, self._albedo.colour.texture, self._albedo.depth)
        self._lights.find(view, seen)
        self._lights.bind_samples()
        self._holes.write(bytes(16))
        self._holes.bind_to_storage_buffer(2)
        self._list.uniforms.set(warped=0, shown_size=self.shown_size)
        self._list.run(*self.shown_size)
        self.gpu.barrier()
        units = bind_images(change={"filled": into.colour}, first=5)
        units |= {"albedo": 2, "model_inverse_depth": 3, "lights": 4}  # as find() left them
        limits = {"near": NEAR, "off_plane": OFF_PLANE, "model_weight": MODEL_WEIGHT[self.settings.light]}
        rays = {"shown_size": self.shown_size, **tangents_of_pixels(view, self.shown_size)}
        self._apply.uniforms.set(samples=self.settings.samples, **units, **limits, **rays)
        self._apply.run(WORKERS)


OFFSETS = 4096  # random places to choose from; a power of two
MOST_SAMPLES = 256


@attrs.frozen
class _CompositeSettings:
    """Where light is looked for, and where it counts; the thesis gives none of these numbers."""

    samples: int = limited(16, 1, MOST_SAMPLES)  # Random places for each pixel of a hole.
    radius: float = limited(0.05, 0, 2, above=True)  # The farthest of them, in picture widths.
    # Inverse depths agree if they differ by at most depth * (the smaller one + 0.02 1/m).
    depth: float = limited(0.1)
    normal: float = limited(20.0, 0, 180, "degrees")  # Normals agree up to this angle.
    average: Literal["mean", "median"] = "mean"  # Of the light found.
    seed: int = limited(0, 0, 2**32 - 1)  # Of the random places; every frame draws others from it.


def _random_offsets(seed: int, radius_pixels: float) -> NDArray[np.int32]:
    """Return (OFFSETS, 2) pixel offsets, evenly spread over a disc of that radius."""
    rng = np.random.default_rng(seed)
    away, turn = radius_pixels * np.sqrt(rng.uniform(size=OFFSETS)), rng.uniform(0, 2 * np.pi, OFFSETS)
    return np.rint(np.stack([away * np.cos(turn), away * np.sin(turn)], axis=1)).astype(np.int32)


def frame_seed(seed: int, shown_ns: int, eye: int) -> int:
    """Return the seed of one eye's picture at one instant, 32 bits: the same in every run."""
    return int(np.random.SeedSequence((seed, shown_ns % 2**64, eye)).generate_state(1)[0])


@fills.register
class Composite(Fill):
    """Algorithm 3 of the thesis, as it is written there.

    Light is a shown colour not divided by its albedo: textures are copied, and with new random
    places in every frame the result flickers. Pixels that find no light stay empty. `relight` is
    free of all three. The scene is drawn whole; its normals are those of its depth.
    """

    name = "composite"
    reads = ("shown.colour", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    Settings = _CompositeSettings
    variants = ("average=median",)

    def prepare(self) -> None:
        gl, chosen = self.gpu.gl, self.settings
        self._model, self._unlit = self.model(1.0, lit=False), self.picture()
        self._pieces = self.own(HolePieces(self.gpu, self.name, self.shown_size, with_depth=True))
        offsets = _random_offsets(chosen.seed, chosen.radius * self.shown_size[0])
        self._offsets = self.own(gl.buffer(offsets.tobytes()))
        median = chosen.samples if chosen.average == "median" else 0
        self._program = self.gpu.shaders.compute("fills/composite.comp", MEDIAN=median)
        # Where no pass reads depth: what lies outside their one pixel reads 0 and is not stored.
        self._no_depth = [self.own(allocate(gl, (1, 1), SCALAR)) for _ in range(2)]

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        if picture.inverse_depth is None:
            picture, into = (
                attrs.evolve(one, inverse_depth=depth)
                for one, depth in zip((picture, into), self._no_depth, strict=True)
            )
        view, chosen = inputs.middle, self.settings
        self._model.draw(view, self._unlit, inputs.shown_ns)
        self._pieces.find(picture, into)
        read = {"warped": picture.colour, "unlit": self._unlit.colour, "model_inverse_depth": self._unlit.depth}
        units = bind_images(read, {"filled": into.colour, "filled_depth": into.depth})
        self._offsets.bind_to_storage_buffer(2)
        # The rendered eye through the shown field of view, so that only the head's motion counts as
        # a move, not a guard band or another size.
        back = view_map(view, self.shown_size, View(inputs.rendered.view.pose, view.fov), self.shown_size)
        units |= {"H": back.H, "e": back.e, "shown_size": self.shown_size, **tangents_of_pixels(view, self.shown_size)}
        limits = {"same_depth": chosen.depth, "same_way": float(np.cos(np.deg2rad(chosen.normal)))}
        seed = frame_seed(chosen.seed, inputs.shown_ns, inputs.eye)
        self._program.uniforms.set(samples=chosen.samples, frame_seed=seed, **units, **limits)
        self._pieces.run(self._program)
