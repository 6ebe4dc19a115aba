"""A picture with holes of a scene that the client has, for the fills that draw a model."""

from __future__ import annotations

import attrs
import numpy as np
from client_scene import ClientScene
from worlds import read

from hmdwarp.client import PassInputs, ShownPicture, parse_fills
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import SCALAR, Canvas, allocate

SIZE = (150, 111)
VIEW = View(Pose((0.05, 1.6, 0.1)), Fov(-0.6, 0.7, -0.55, 0.45))


def picture_of(gpu, size) -> ShownPicture:
    return ShownPicture(Canvas(gpu.gl, size), allocate(gpu.gl, size, SCALAR))


class Shown:
    """A scene seen from VIEW in another light than the one baked into it, with holes. scene: a
    name. tint: of the light. rendered: where the picture is said to come from."""

    def __init__(
        self, gpu, scene: str, tint=(1.0, 1.0, 1.0), size=SIZE, holes=None, share=1.0, rendered: View = VIEW
    ) -> None:
        self.gpu, self.size, self.share, self.rendered = gpu, size, share, rendered
        self.geometry = ClientScene(gpu, scene)
        drawn = self.geometry.server.draw(VIEW, size)
        self.truth = read(drawn.colour) * (*tint, 1)
        self.depth = read(drawn.inverse_depth)[..., 0]
        y, x = np.mgrid[: size[1], : size[0]]
        self.holes = (np.abs(x - 70) < 25) & (np.abs(y - 50) < 30) if holes is None else holes
        self.colour = np.where(self.holes[..., None], 0, self.truth).astype(np.float16).astype(np.float64)
        self.shown_depth = np.where(self.holes, -1, self.depth)

    def fill(self, text: str, *, depth: bool = True, shown_ns: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Colour and inverse depth after a fill."""
        (choice,) = parse_fills(text)
        fill = choice.entry(self.gpu, self.size, self.size, choice.settings, self.geometry)
        picture, into = picture_of(self.gpu, self.size), picture_of(self.gpu, self.size)
        picture.colour.texture.write(self.colour.astype(np.float16).tobytes(), alignment=1)
        picture.inverse_depth.write(self.shown_depth.astype(np.float32).tobytes(), alignment=1)
        rendered = EyeImage(self.rendered, picture.colour.texture, picture.inverse_depth)
        inputs = PassInputs(rendered, VIEW, shown_ns=shown_ns)
        if not depth:
            picture, into = attrs.evolve(picture, inverse_depth=None), attrs.evolve(into, inverse_depth=None)
        fill.run(inputs, picture, into)
        self.gpu.gl.memory_barrier()
        found = read(into.colour.texture), read(into.inverse_depth)[..., 0] if depth else None
        fill.close()
        return found

    def error(self, found: np.ndarray) -> float:
        """Root mean square inside the holes."""
        return float(np.sqrt(((found - self.truth)[self.holes, :3] ** 2).mean()))
