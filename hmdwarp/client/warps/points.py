"""The client keeps points of the scene's surfaces and projects them: none of it is late."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, PlanError
from ...frames import Needs
from ...frames.layers.points import Cloud
from ...frames.point_blocks import LEAST_BUDGET
from ...gpu.raw_gl import clear_buffer
from ..warp_kinds import check_room
from . import KEY_BYTES, warps
from ._base import COLOUR_BYTES, DEPTH_BYTES, Warp

if TYPE_CHECKING:
    from ...geometry import View
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs

_COLOUR, _DEPTH = 0, 1  # image units
_DEFAULT = Cloud()
_WINNER_BYTES, _NOBODY = 4, 0xFFFFFFFF
# Of the index of a point in a key, see shaders/lib/scatter_depth.glsl.
MOST_POINTS = 1 << 26


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
        self._cloud = self.geometry.points(_cloud(self.settings))
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
        self._bodies.write(
            eye_from(cloud.bodies(inputs.shown_ns), view).transpose(0, 2, 1).astype(np.float32).tobytes()
        )
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
