"""One scatter warp run on pictures whose pixels say their index, so that a test can ask who won
where."""

from __future__ import annotations

import numpy as np
from worlds import read

from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate

FOV = Fov.from_tangents([-1, 1, -1, 1])
FAR = 2.0**-20  # 1/m: farther pixels are ordered by their index alone


def numbered(size: tuple[int, int]) -> np.ndarray:
    """A picture in which each pixel says its index: (column, row, 0) with coverage 1. Both below
    2048 are exact as half floats."""
    y, x = np.mgrid[: size[1], : size[0]]
    return np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1).astype(np.float16)


class Scatter:
    """One scatter warp of fixed sizes, run on several depth pictures in turn (bottom row first)."""

    def __init__(
        self, gpu, size, shown_size, rendered_pose: Pose | None = None, shown_pose: Pose | None = None, spec="forward"
    ) -> None:
        self.gpu, self.size, self.shown_size = gpu, size, shown_size
        self.rendered_view, self.shown_view = View(rendered_pose or Pose(), FOV), View(shown_pose or Pose(), FOV)
        choice = parse_warp(spec)
        self.warp, self.canvas = choice.entry(gpu, size, shown_size, choice.settings), Canvas(gpu.gl, shown_size)
        colour, self.depth = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
        colour.write(numbered(size).tobytes(), alignment=1)
        self.rendered = EyeImage(self.rendered_view, colour, self.depth)

    def run(self, depth: np.ndarray) -> np.ndarray:
        """(h, w) index of the drawn pixel that each shown pixel shows, -1 for none."""
        self.depth.write(np.ascontiguousarray(depth, np.float32).tobytes(), alignment=1)
        self.warp.run(PassInputs(self.rendered, self.shown_view), self.canvas)
        self.gpu.gl.memory_barrier()
        return self.winners(self.canvas)

    def winners(self, canvas: Canvas) -> np.ndarray:
        """The same, of any picture made of this one's pixels."""
        out = read(canvas.texture).astype(np.int64)
        return np.where(out[..., 3] > 0, out[..., 1] * self.size[0] + out[..., 0], -1)

    def wanted(self, depth: np.ndarray) -> np.ndarray:
        """The same by sorting, for `forward`; only for maps whose w does not depend on the pixel.
        Equal depths stay equal in float32."""
        forward = WarpMap.between(self.rendered_view, self.size, self.shown_view, self.shown_size)
        assert np.array_equal(forward.H[2], [0, 0, 1])
        y, x = (a.ravel() for a in np.mgrid[: self.size[1], : self.size[0]])
        flat = np.asarray(depth, np.float32).astype(np.float64).ravel()
        pixels, shown_depth, w = forward.apply(np.stack([x, y], axis=-1) + 0.5, flat)
        # Sizes are chosen so that nothing lands near a border between pixels: rounding decides
        # nothing here.
        apart = np.abs(pixels - np.round(pixels))[(flat >= 0) & (w > 0)]
        assert apart.size == 0 or apart.min() > 1e-3
        key_depth = np.where(shown_depth < FAR, 0, np.minimum(shown_depth, 2.0**11 * (1 - 2.0**-24)))
        tie = np.where(key_depth > 0, (y % 4) * 4 + x % 4, 0)
        lands = (flat >= 0) & (w > 0) & (pixels >= 0).all(axis=1) & (pixels < self.shown_size).all(axis=1)
        source = np.flatnonzero(lands)
        slot = np.floor(pixels[source]).astype(int) @ [1, self.shown_size[0]]
        order = np.lexsort((source, tie[source], -key_depth[source], slot))
        first = np.unique(slot[order], return_index=True)
        out = np.full(self.shown_size[0] * self.shown_size[1], -1)
        out[first[0]] = source[order][first[1]]
        return out.reshape(self.shown_size[::-1])

    def check(self, depth: np.ndarray) -> np.ndarray:
        got = self.run(depth)
        assert np.array_equal(got, self.wanted(depth))
        return got
