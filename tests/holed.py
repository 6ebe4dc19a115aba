"""A random shown picture with holes, for every test of a fill.

Colour, inverse depth, and what a fill is given beside them.
"""

from __future__ import annotations

import attrs
import numpy as np
from client_scene import ClientScene
from worlds import World, read

from hmdwarp.client import CLIENT_MODEL, ShownPicture, parse_fills
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import wide_view
from hmdwarp.gpu import SCALAR, Canvas, allocate


class Holed:
    """colour (h, w, 4), a share `empty` of it holes, and inverse_depth (h, w), -1 in holes.

    Bottom row first. given: of a random world.
    """

    def __init__(self, gpu, seed: int, size: tuple[int, int], empty: float = 0.3) -> None:
        world = World(gpu, seed, size)
        self.size, self.world = size, world
        holes = world.rng.uniform(size=size[::-1]) < empty
        self.colour = world.colour.astype(np.float16).astype(np.float64)
        self.colour[..., 3] = 1
        self.inverse_depth = np.maximum(world.inverse_depth, 0).astype(np.float32).astype(np.float64)
        self.empty(holes)
        # Another picture of the same eye, wider and of any size.
        wide = EyeImage(wide_view(world.rendered_view), *world._textures(gpu, *world._picture()))
        given = world.inputs(None)
        self.inputs = attrs.evolve(given, rendered=given.rendered.having(wide=wide))

    def empty(self, holes: np.ndarray) -> None:
        """Make these pixels holes."""
        self.colour[holes], self.inverse_depth[holes] = 0, -1

    def keep_one(self) -> None:
        """At least one covered pixel, in a corner."""
        self.colour[0, 0], self.inverse_depth[0, 0] = (0.25, 0.5, 0.75, 1), 0.5

    def picture(self, gpu) -> ShownPicture:
        """On the GPU."""
        picture = ShownPicture(Canvas(gpu.gl, self.size), allocate(gpu.gl, self.size, SCALAR))
        picture.colour.texture.write(self.colour.astype(np.float16).tobytes(), alignment=1)
        picture.inverse_depth.write(self.inverse_depth.astype(np.float32).tobytes(), alignment=1)
        return picture

    def fill(self, gpu, name: str, geometry=None) -> tuple[np.ndarray, np.ndarray]:
        """Colour and inverse depth after one fill, the latter unchanged if it writes none.

        Run twice: the second must not differ.
        """
        (choice,) = parse_fills(name)
        if geometry is None and CLIENT_MODEL in choice.entry.reads:
            geometry = ClientScene(gpu)
        self.world.rendered = self.inputs.rendered
        self.world.bring_layers(gpu, choice.entry.reads)
        self.inputs = attrs.evolve(self.inputs, rendered=self.world.rendered)
        fill = choice.entry(gpu, self.size, self.size, choice.settings, geometry)
        picture, into = self.picture(gpu), self.picture(gpu)
        into.colour.clear()
        fill.run(self.inputs, picture, into)
        gpu.gl.memory_barrier()
        first = read(into.colour.texture), read(into.inverse_depth)[..., 0]
        fill.run(self.inputs, picture, into)
        gpu.gl.memory_barrier()
        assert np.array_equal(first[0], read(into.colour.texture)), "two runs differ"
        fill.close()
        return first
