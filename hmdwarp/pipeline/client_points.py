"""The points that a client has got, on the GPU."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..frames.layers.points import Cloud
from ..frames.point_blocks import PAGE, Block, PointRoom, unpacked
from ..gpu.context import Gpu
from ..gpu.textures import release_all
from ..scenes import Scene

Array = NDArray[np.float64]
# Words of a point: position; normal; colour.
_WORDS = 3
_CELL_BYTES = 32
NO_CELL = 0xFFFFFFFF
# Radius of a disc in square roots of the part of the surface that is its own: from the middle of a
# triangle with two equal sides and a right angle to its farther corners it is 1.05.
RADIUS = 1.1


class ClientPoints:
    """The client.PointCloud of one Cloud.

    Buffers for all its room are allocated at once: 12 bytes a point, and for each page of PAGE
    points 4 bytes and the 32 of a cell.
    """

    def __init__(self, gpu: Gpu, scene: Scene, cloud: Cloud) -> None:
        pages = cloud.room // PAGE
        self._scene, self._cloud = scene, cloud
        self.points, self.cells = (
            gpu.gl.buffer(reserve=size) for size in (4 * _WORDS * PAGE * pages, _CELL_BYTES * pages)
        )
        # The slot of each page's cell, and the pages from the first to behind the last that the
        # buffer does not hold yet. They are written at once: NVIDIA's driver (580.159) loses all
        # but the first of many writes of 4 bytes before a shader reads them.
        self._slots = np.full(pages, NO_CELL, np.uint32)
        self._changed = (pages, 0)
        self.pages = gpu.gl.buffer(self._slots)
        self._room = PointRoom(cloud.room, self._write, self._clear)
        self.bytes = 0
        self.first_picture_bytes: int | None = None
        # (3, 3) linear light of zenith, horizon and ground; None before the first whole picture, as
        # what is empty may be missing.
        self.sky: Array | None = None

    @property
    def count(self) -> int:
        """How many places for points there are to look at."""
        return self._room.high * PAGE

    def receive(self, content: NDArray[np.uint8]) -> None:
        """Take what a frame brought; frames may come in any order, and more than once."""
        if not len(content):
            return
        complete, sky, blocks = unpacked(content)
        self.bytes += len(content)
        for block in blocks:
            self._room.take(block)
        first, end = self._changed
        if first < end:
            self.pages.write(self._slots[first:end], offset=4 * first)
            self._changed = (len(self._slots), 0)
        if complete and self.first_picture_bytes is None:
            self.first_picture_bytes = self.bytes
        if self.first_picture_bytes is not None:
            self.sky = sky

    def _write(self, block: Block, slot: int, pages: list[int], points: int) -> None:
        rows = np.empty((len(block.positions), _WORDS), np.uint32)
        rows[:, 0] = block.positions
        rows[:, 1] = block.normals.astype(np.uint32) @ np.array([1, 1 << 8], np.uint32)
        rows[:, 2] = block.colours.astype(np.uint32) @ np.array([1, 1 << 8, 1 << 16], np.uint32)
        for number, page in enumerate(pages):
            self.points.write(rows[PAGE * number : PAGE * (number + 1)].tobytes(), offset=4 * _WORDS * PAGE * page)
        self._put(pages, slot)
        # Points between two powers of 2 are spread no better than those up to the lower.
        radius = RADIUS * np.sqrt(block.area / (1 << (points.bit_length() - 1)))
        cell = np.array([*block.low, block.edge, radius, block.body, block.double_sided, 0], np.float32)
        self.cells.write(cell.tobytes(), offset=_CELL_BYTES * slot)

    def _clear(self, pages: list[int]) -> None:
        self._put(pages, NO_CELL)

    def _put(self, pages: list[int], slot: int) -> None:
        self._slots[pages] = slot
        first, end = self._changed
        self._changed = min([first, *pages]), max([end, *(page + 1 for page in pages)])

    def bodies(self, time_ns: int) -> Array:
        """Return (n, 4, 4) float64: world from what stands still, then from each body."""
        still = np.eye(4)
        still[:3, 3] = self._scene.origin_m
        return np.array([still, *(body.motion.state(time_ns).pose.matrix() for body in self._scene.bodies)])

    def weight(self) -> dict[str, Any]:
        """Return what has crossed before packing, in bytes, and what the client holds."""
        return {
            "budget": self._cloud.budget,
            "geometry_bytes": self.points.size + self.pages.size + self.cells.size,
            "texture_bytes": 0,
            "start_up_bytes": 0,
            "first_picture_bytes": self.first_picture_bytes,
            "arrived_bytes": self.bytes,
            "points": self._room.points,
        }

    def close(self) -> None:
        """Free the buffers."""
        release_all(self.points, self.pages, self.cells)
