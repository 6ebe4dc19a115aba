"""Further pictures of an eye: from places that it may come to, wide, all around, and foveated.

Those places leave the least empty there. Source: the 2014 thesis, section 3.5: the views must
together cover every pixel, so that the second is neither too far nor too near; how far follows from
how far the eye can move.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ....errors import InputError
from ....frames import EyeImage, Needs
from ....frames.layers.foveated import FoveatedPicture
from ....geometry import Fovea, Pose, View, WarpMap
from ....geometry.cube import cube_size, wide_size, wide_view
from ....gpu.textures import COLOUR, SCALAR, download, flip_rows
from ..passes import ScenePasses, draw_cube
from . import DrawContext, Drawing, Part, parts

Array = NDArray[np.float64]
Size = tuple[int, int]

RINGS = (0.1, 0.4, 1.0)  # candidates stand at these parts of how far the eye moves while a frame is under way
LEAST_M = 0.02  # an eye that stands still may begin to move
# Where the eye may be when the frame is seen, in the same unit: along its motion and across it.
EXPECTED = ((1.0, 0.0), (0.5, 0.0), (0.75, 0.25), (0.75, -0.25))
# By how much more a held inverse depth is that of something else: of itself, and in 1/m. Between
# pixels an eighth as dense, that of a floor seen aslant differs by less.
_NEARER, _FLOOR = 0.1, 0.02
_UP = np.array([0.0, 1.0, 0.0])
_COARSE = 8  # the choice is made at this part of the resolution, on both axes


@parts.register
class Views(Part):
    """Whole pictures from the places of chosen(), by the first eye's depth and the head's speed."""

    name = "views"
    order = 130
    of_client = True

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        plain = context.colour
        self._passes = ScenePasses(context.gpu, context.scene, plain.buffers, colour=False, moving=plain.moving)
        self._before: tuple[Array, int] | None = None
        self._ways: list[Array] = []

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        first, place = views[0], np.mean([view.pose.position_m for view in views], axis=0)
        before, self._before = self._before, (place, drawing.time_ns)
        passed_s = (drawing.time_ns - before[1]) * 1e-9 if before is not None else 0.0
        velocity = (place - before[0]) / passed_s if before is not None and passed_s > 0 else np.zeros(3)
        motion = Motion.of(first, velocity, drawing.age_ns * 1e-9)
        size = (max(1, drawing.size[0] // _COARSE), max(1, drawing.size[1] // _COARSE))
        count = drawing.needs.get("views", 0)
        self._ways = (
            chosen(first, size, motion, count, lambda view: self._depth_of(view, size, drawing.time_ns))
            if count
            else []
        )
        return {}

    def _depth_of(self, view: View, size: tuple[int, int], time_ns: int) -> Array:
        depth = self.kept("depth", size, SCALAR, depth=False).colour
        self._passes.draw(view, self.context.framebuffers.over(depth), time_ns)
        return flip_rows(download(depth)).astype(np.float64)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        views = [moved(eye.view, way) for way in self._ways]
        return eye.having(
            views=tuple(self.context.draw(view, eye.size, drawing.of_light(view, eye.size)) for view in views)
        )

    def close(self) -> None:
        self._passes.close()
        super().close()


@attrs.frozen(eq=False)
class Motion:
    """How far an eye goes while a frame is under way: two vectors in the world, in metres."""

    along: Array
    across: Array

    @classmethod
    def of(cls, view: View, velocity_m_s: Array, age_s: float) -> Motion:
        """Return the motion of an eye, at least LEAST_M, across it level; at rest to the right."""
        way = np.asarray(velocity_m_s, np.float64) * age_s
        length = float(np.linalg.norm(way))
        right, _, back = view.pose.rotation_matrix.T
        along = way / length if length > 1e-9 else right
        across = np.cross(along, _UP)
        if np.linalg.norm(across) < 1e-3:
            across = right
        elif length <= 1e-9:
            across = back
        reach = max(length, LEAST_M)
        return cls(reach * along, reach * across / np.linalg.norm(across))

    def candidates(self) -> list[Array]:
        ways = (self.along, -self.along, self.across, -self.across)
        return [ring * way for ring in RINGS for way in ways]

    def expected(self) -> list[Array]:
        return [along * self.along + across * self.across for along, across in EXPECTED]


def moved(view: View, way: Array) -> View:
    """Return the view from a place that is moved by `way`, (3,) metres in the world."""
    pose = Pose(view.pose.position_m + way, view.pose.orientation_xyzw)
    return View(pose, view.fov, view.head_from_eye)


def chosen(view: View, size: Size, motion: Motion, count: int, depth_of: Callable[[View], Array]) -> list[Array]:
    """Return the places of `count` further pictures, relative to the eye, the most useful first.

    size: (w, h) of the pictures of depth. depth_of: returns inverse depth (h, w), -1 for none, the
    bottom row first. One after the other, each is the candidate that leaves the smallest share of
    the expected pictures unseen by the newest picture and by those chosen before it; the nearer one
    of equals.
    """
    expected = [(target, depth_of(target)) for way in motion.expected() for target in [moved(view, way)]]

    def seen_from(way: Array) -> NDArray[np.bool_]:
        place = moved(view, way)
        held = depth_of(place)
        return np.stack([seen(place, held, target, wanted, size) for target, wanted in expected])

    known, left = seen_from(np.zeros(3)), [(way, seen_from(way)) for way in motion.candidates()]
    ways = []
    for _ in range(count):
        best = max(range(len(left)), key=lambda index: (int((known | left[index][1]).sum()), -index))
        way, shows = left.pop(best)
        known = known | shows
        ways.append(way)
    return ways


def seen(view: View, held: Array, target: View, wanted: Array, size: Size) -> NDArray[np.bool_]:
    """Return (h, w): which pixels of a target a picture shows, by the depth of both.

    held, wanted: inverse depth (h, w) of the picture and of the target, the bottom row first. A
    point is hidden if the nearest pixel of the picture holds something clearly nearer.
    """
    wide, high = size
    y, x = np.mgrid[:high, :wide]
    pixels = np.stack([x + 0.5, y + 0.5], axis=-1)
    places, depths, _ = WarpMap.between(target, size, view, size).apply(pixels, np.maximum(wanted, 0))
    column, row = (np.floor(np.nan_to_num(places[..., axis], nan=-1.0, posinf=-1.0, neginf=-1.0)) for axis in (0, 1))
    inside = (column >= 0) & (column < wide) & (row >= 0) & (row < high)
    found = held[np.where(inside, row, 0).astype(int), np.where(inside, column, 0).astype(int)]
    nearer = found - np.nan_to_num(depths) > _NEARER * np.nan_to_num(depths) + _FLOOR
    shown: NDArray[np.bool_] = inside & ~nearer
    return shown


@parts.register
class Cube(Part):
    """Colour of the six faces of geometry.cube, as sharp as the picture. Errors: InputError."""

    name = "cube"
    order = 110

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        context = self.context
        size = cube_size(eye.view.fov, eye.size)
        if max(size) > (limit := context.gpu.max_texture_size):
            raise InputError(
                f"a cube map as sharp as a picture of {eye.size[0]}x{eye.size[1]} would have {size[0]}x{size[1]} "
                f"pixels: expected at most {limit} on each side (this GPU's limit); "
                "use a smaller size, a wider field of view or another warp"
            )
        cube = context.acquire(size, depth=False).colour
        draw_cube(context.gpu.gl, context.passes_for(drawing), eye.view, context.framebuffers.over(cube), eye.drawn_ns)
        return eye.having(cube=cube)


@parts.register
class Wide(Part):
    """As wide as geometry.wide says, around the view without guard band, overlay apart."""

    name = "wide"
    order = 120

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        view, size = wide_view(drawing.view), wide_size(drawing.view.fov, drawing.size)
        wide = drawing.of_light(view, size)
        wide = attrs.evolve(wide, needs=wide.needs | Needs(overlay=drawing.needs.get("overlay")))
        return eye.having(wide=self.context.draw(view, size, wide))


_KINDS = {"foveated": COLOUR, "foveated_depth": SCALAR}


@parts.register
class Foveated(Part):
    """Made when the picture is complete, of colour and of inverse depth where each is needed."""

    name = "foveated"
    order = 195

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needs = [drawing.needs[name] for name in _KINDS if name in drawing.needs]
        fovea: Fovea = needs[0]
        grid = fovea.grid(eye.view, eye.size)
        made: dict[str, Any] = {}
        for number, (name, kind) in enumerate(_KINDS.items()):
            if name in drawing.needs:
                into = self.context.acquire(grid.small, kind, depth=False).colour
                (eye.inverse_depth if number else eye.colour).bind_to_image(0, read=True, write=False)
                into.bind_to_image(1, read=False, write=True)
                program = self.context.gpu.shaders.compute("server/foveate.comp", DEPTH=number)
                program.uniforms.set(picture=0, foveated=1, **grid.uniforms)
                program.run(*grid.small)
                made[name] = FoveatedPicture(into, grid)
        self.context.gpu.barrier()
        return eye.having(**made)
