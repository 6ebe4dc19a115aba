"""The thesis's composite: the client draws the scene unlit, and estimates the light of holes."""

from __future__ import annotations

from typing import Literal

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import View, view_map
from ...geometry.view import tangents_of_pixels
from ...gpu.textures import SCALAR, Canvas, allocate, release_all
from ..fill_parts import HolePieces
from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

OFFSETS = 4096  # random places to choose from; a power of two
MOST_SAMPLES = 256
LEAST_MOVE = 0.5  # pixels, as in shaders/fills/composite.comp
_WARPED, _UNLIT, _MODEL_DEPTH, _FILLED, _FILLED_DEPTH = range(5)  # image units


@attrs.frozen
class CompositeSettings:
    """Where light is looked for, and where it counts; the thesis gives none of these numbers."""

    samples: int = 16  # Random places for each pixel of a hole.
    radius: float = 0.05  # The farthest of them, in picture widths.
    # Inverse depths agree if they differ by at most depth * (the smaller one + 0.02 1/m).
    depth: float = 0.1
    normal: float = 20.0  # Normals agree up to this angle, in degrees.
    average: Literal["mean", "median"] = "mean"  # Of the light found.
    seed: int = 0  # Of the random places; every frame draws others from it.

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.samples <= MOST_SAMPLES:
            raise ValueError(f"samples is {self.samples}: expected 1 to {MOST_SAMPLES}")
        if not 0 < self.radius <= 2:
            raise ValueError(f"radius is {self.radius:g}: expected more than 0 and at most 2")
        if not 0 <= self.depth < float("inf"):
            raise ValueError(f"depth is {self.depth:g}: expected 0 or more")
        if not 0 <= self.normal <= 180:
            raise ValueError(f"normal is {self.normal:g}: expected 0 to 180 degrees")
        if not 0 <= self.seed < 2**32:
            raise ValueError(f"seed is {self.seed}: expected 0 to {2**32 - 1}")


def random_offsets(seed: int, radius_pixels: float) -> NDArray[np.int32]:
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

    The light of a hole's pixel is the shown colour of places around it, not divided by their
    albedo: textures are copied, and with new random places in every frame the result flickers.
    Pixels that find no light stay empty, so black. `relight` is free of all three. The scene is
    drawn whole; its normals are those of its depth.
    """

    name = "composite"
    summary = (
        "the thesis's: the client draws the scene unlit, in the mean light of random places of like depth and normal"
    )
    reads = ("shown.colour", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "the 2014 thesis's lighting-estimating composite (its algorithm 3); O'Neill 2014, PCG (the hash)"
    Settings = CompositeSettings
    variants = ("average=median",)

    def prepare(self) -> None:
        gl, chosen = self.gpu.gl, self.settings
        self._model = self.model(1.0, lit=False)
        self._model.reserve(self.shown_size)
        self._unlit = ShownPicture(Canvas(gl, self.shown_size), allocate(gl, self.shown_size, SCALAR))
        self._pieces = HolePieces(self.gpu, self.name, self.shown_size, with_depth=True)
        offsets = random_offsets(chosen.seed, chosen.radius * self.shown_size[0])
        self._offsets = gl.buffer(offsets.tobytes())
        median = chosen.samples if chosen.average == "median" else 0
        self._program = self.gpu.shaders.compute("fills/composite.comp", MEDIAN=median)
        # Where no pass reads depth: what lies outside their one pixel reads 0 and is not stored.
        self._no_depth = [allocate(gl, (1, 1), SCALAR) for _ in range(2)]

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        if picture.inverse_depth is None:
            picture, into = (
                attrs.evolve(one, inverse_depth=depth)
                for one, depth in zip((picture, into), self._no_depth, strict=True)
            )
        view, chosen = inputs.middle, self.settings
        self._model.draw(view, self._unlit, inputs.shown_ns)
        self._pieces.find(picture, into)
        picture.colour.texture.bind_to_image(_WARPED, read=True, write=False)
        self._unlit.colour.texture.bind_to_image(_UNLIT, read=True, write=False)
        self._unlit.depth.bind_to_image(_MODEL_DEPTH, read=True, write=False)
        into.colour.bind_for_writing(_FILLED)
        into.depth.bind_to_image(_FILLED_DEPTH, read=False, write=True)
        self._offsets.bind_to_storage_buffer(2)
        # The rendered eye through the shown field of view, so that only the head's motion counts as
        # a move, not a guard band or another size.
        was = View(inputs.rendered.view.pose, view.fov)
        back = view_map(view, self.shown_size, was, self.shown_size)
        units = {"warped": _WARPED, "unlit": _UNLIT, "model_inverse_depth": _MODEL_DEPTH}
        units |= {"filled": _FILLED, "filled_depth": _FILLED_DEPTH}
        limits = {"same_depth": chosen.depth, "same_way": float(np.cos(np.deg2rad(chosen.normal)))}
        self._program.uniforms.set(
            H=back.H, e=back.e, **tangents_of_pixels(view, self.shown_size), shown_size=self.shown_size,
            samples=chosen.samples, frame_seed=frame_seed(chosen.seed, inputs.shown_ns, inputs.eye), **units, **limits,
        )  # fmt: skip
        self._pieces.run(self._program)

    def close(self) -> None:
        self._pieces.close()
        release_all(self._unlit.colour, self._unlit.depth, self._offsets, *self._no_depth)
