"""The client keeps points of the scene's surfaces and projects them: none of it is late."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, PlanError
from ...frames import Needs
from ...frames.layers.points import LEAST_BUDGET, PAGE, Block, Cloud, PointRoom, unpacked
from ...geometry import View
from ...gpu.raw_gl import clear_buffer
from ...gpu.textures import Canvas, release_all
from ..client_scene import ClientScene, Store, receiver_of
from ..inputs import PassInputs
from ..warp_kinds import check_room
from . import KEY_BYTES, warps
from ._base import COLOUR_BYTES, DEPTH_BYTES, Warp

_COLOUR, _DEPTH = 0, 1  # image units
_DEFAULT = Cloud()
_WINNER_BYTES, _NOBODY = 4, 0xFFFFFFFF
# Of the index of a point in a key, see shaders/lib/scatter_depth.glsl.
MOST_POINTS = 1 << 26

# Words of a point: position; normal; colour.
_WORDS = 3
_CELL_BYTES = 32
NO_CELL = 0xFFFFFFFF
# Radius of a disc in square roots of the part of the surface that is its own: from the middle of a
# triangle with two equal sides and a right angle to its farther corners it is 1.05.
RADIUS = 1.1


@attrs.frozen
class PointsSettings:
    # Bytes of each frame, at most, before they are packed.
    budget: int = attrs.field(default=_DEFAULT.budget, validator=attrs.validators.ge(LEAST_BUDGET))
    # Points that the client has room for. When it is full, what was not seen for longest is
    # forgotten.
    room: int = attrs.field(
        default=_DEFAULT.room,
        validator=attrs.validators.and_(attrs.validators.ge(1024), attrs.validators.le(MOST_POINTS)),
    )
    # Distance of points in shown pixels, where all have arrived.
    spacing: float = attrs.field(default=_DEFAULT.spacing, validator=attrs.validators.gt(0))
    # Factor on the radius of discs; 0 draws one pixel for each point.
    size: float = attrs.field(default=1.0, validator=attrs.validators.ge(0))
    # The largest radius of a disc in pixels.
    largest: int = attrs.field(default=16, validator=attrs.validators.ge(1))


@receiver_of("points")
class KeptPoints(Store):
    """The points of one Cloud that have arrived, in pages, and the cells that they belong to.

    The buffers of warps/points.comp are allocated at once for all its room: 12 bytes a point, and
    for each page of PAGE points 4 bytes and the 32 of a cell.
    """

    def __init__(self, client: ClientScene, wanted: Cloud) -> None:
        super().__init__(client, wanted)
        gpu, pages = client.gpu, wanted.room // PAGE
        self.points, self.cells = (
            gpu.gl.buffer(reserve=size) for size in (4 * _WORDS * PAGE * pages, _CELL_BYTES * pages)
        )
        # The slot of each page's cell, and the pages from the first to behind the last that the
        # buffer does not hold yet. They are written at once: NVIDIA's driver (580.159) loses all
        # but the first of many writes of 4 bytes before a shader reads them.
        self._slots = np.full(pages, NO_CELL, np.uint32)
        self._changed = (pages, 0)
        self.pages = gpu.gl.buffer(self._slots)
        self._room = PointRoom(wanted.room, self._write, self._clear)
        self.bytes = 0
        self.first_picture_bytes: int | None = None
        # (3, 3) linear light of zenith, horizon and ground; None before the first whole picture, as
        # what is empty may be missing.
        self.sky: NDArray[np.float64] | None = None

    @property
    def count(self) -> int:
        """How many places for points there are to look at."""
        return self._room.high * PAGE

    def receive(self, content: NDArray[np.uint8]) -> None:
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

    def bodies(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 4, 4) float64: world from what stands still, then from each body."""
        still = np.eye(4)
        still[:3, 3] = self.client.scene.origin_m
        return np.array([still, *(body.motion.state(time_ns).pose.matrix() for body in self.client.scene.bodies)])

    def eye_from(self, view: View, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 4, 4) as bodies(), to the eye."""
        return eye_from(self.bodies(time_ns), view)

    def weights(self) -> list[dict[str, Any]]:
        """Return what has crossed before packing, in bytes, and what the client holds."""
        weight = {
            "budget": self.wanted.budget,
            "geometry_bytes": self.points.size + self.pages.size + self.cells.size,
            "texture_bytes": 0,
            "start_up_bytes": 0,
            "first_picture_bytes": self.first_picture_bytes,
            "arrived_bytes": self.bytes,
            "points": self._room.points,
        }
        return [weight]

    def close(self) -> None:
        release_all(self.points, self.pages, self.cells)


@warps.register
class Points(Warp):
    """Project all points at the shown view, as discs that face along their normals.

    The nearest disc wins; of discs on one surface the one whose middle is nearest to the pixel.
    """

    name = "points"
    summary = (
        "the client keeps points of all surfaces seen so far and projects them at the newest pose; no picture is sent"
    )
    kind = "draw"
    reads = ("rendered.points",)
    exact_when = "never; geometry is right to half a pixel where points are one pixel apart"
    gets_wrong = (
        "cracks and blur where points have not arrived yet or the eye comes nearer; mirrors, glass, overlays and what "
        "deforms have no points"
    )
    source = "the 2014 thesis, section 3.1 [14]; Pfister et al. 2000, Zwicker et al. 2001 (surface splats)"
    Settings = PointsSettings
    resamples = True
    variants = ("spacing=2.0", "size=0.0")
    depth_reads = ()
    carries = False
    without_effects = "shows points alone, of plain surfaces, where they are now"

    @classmethod
    def needs(cls, settings: PointsSettings) -> Needs:
        return Needs(points=frozenset({_cloud(settings)}))

    @classmethod
    def bytes_moved(cls, rendered_pixels: int, shown_pixels: int, settings: Any) -> int:
        # One point a pixel, 12 bytes read twice; keys and winners cleared, raised (read, written)
        # and read; the result.
        return shown_pixels * (2 * 12 + 4 * (KEY_BYTES + _WINNER_BYTES) + COLOUR_BYTES + DEPTH_BYTES)

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError("warp 'points' needs points from a server; for single pictures use 'iterative'")
        self._cloud = self.geometry.store(KeptPoints, _cloud(self.settings))
        if self._cloud.points.size > self.gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]:
            raise InputError(
                f"room for {self.settings.room} points: this GPU's buffers hold "
                f"{self.gpu.gl.info['GL_MAX_SHADER_STORAGE_BLOCK_SIZE'] // 12}; use a smaller room"
            )
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES + _WINNER_BYTES)
        shaders, depth = self.gpu.shaders, {"WRITES_DEPTH": 1} if self.output.depth else {}
        self._offer = shaders.compute("warps/points.comp")
        self._resolve = shaders.compute("warps/points_resolve.comp", **depth)
        pixels = self.shown_size[0] * self.shown_size[1]
        self._keys, self._winners = (self.gpu.gl.buffer(reserve=4 * pixels) for _ in range(2))
        self._bodies = self.gpu.gl.buffer(reserve=64 * len(self._cloud.bodies(0)))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        cloud, view = self._cloud, inputs.middle
        clear_buffer(self._keys, 0)
        clear_buffer(self._winners, _NOBODY)
        into.bind_for_writing(_COLOUR)
        if self.depth_into is not None:
            self.depth_into.bind_to_image(_DEPTH, read=False, write=True)
        self._bodies.write(cloud.eye_from(view, inputs.shown_ns).transpose(0, 2, 1).astype(np.float32).tobytes())
        for binding, buffer in enumerate(
            (self._keys, self._winners, cloud.points, cloud.pages, cloud.cells, self._bodies)
        ):
            buffer.bind_to_storage_buffer(binding)
        uniforms = self._uniforms(view)
        for turn in range(2):
            self._offer.uniforms.set_declared(turn=turn, **uniforms)
            if cloud.count:
                self._offer.run(min(cloud.count, 1 << 14), -(-cloud.count >> 14))
            self.gpu.barrier()
        self._resolve.uniforms.set_declared(**uniforms)
        self._resolve.run(*self.shown_size)

    def _uniforms(self, view: View) -> dict[str, object]:
        left, right, down, up = view.fov.tangents
        (w, h), sky = self.shown_size, self._cloud.sky
        turn = view.pose.rotation_matrix[1]
        return {
            "shown_size": (w, h),
            "lowest": (left, down),
            "pixels": (w / (right - left), h / (up - down)),
            "count": self._cloud.count,
            "size": self.settings.size,
            "largest": float(self.settings.largest),
            "up": tuple(turn.tolist()),
            "has_sky": int(self._cloud.sky is not None),
            "shown_colour": _COLOUR,
            "shown_inverse_depth": _DEPTH,
            **{name: tuple(row) for name, row in zip(("zenith", "horizon", "ground"), _light(sky), strict=True)},
        }

    def close(self) -> None:
        super().close()
        for buffer in (self._keys, self._winners, self._bodies):
            buffer.release()


def _light(sky: NDArray[np.float64] | None) -> list[list[float]]:
    return [[0.0] * 3] * 3 if sky is None else sky.tolist()


def _cloud(settings: PointsSettings) -> Cloud:
    return Cloud(settings.budget, settings.room, settings.spacing)


def eye_from(bodies: NDArray[np.float64], view: View) -> NDArray[np.float64]:
    """Return (n, 4, 4): the eye from the frame of each body. Positions are subtracted first."""
    out = bodies.copy()
    out[:, :3, 3] -= view.pose.position_m
    out[:, :3] = view.pose.rotation_matrix.T @ out[:, :3]
    return out
