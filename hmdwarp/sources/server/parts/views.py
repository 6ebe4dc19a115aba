"""Layers: motion, further pictures of an eye, and what clients get that draw the scene.

Further pictures leave the least empty. Source: the 2014 thesis, section 3.5: together they must
cover every pixel; how far apart they are follows from how far the eye can move.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ....base import InputError
from ....frames import BodyIds, EyeImage, Needs
from ....frames.layers import Outbox, Update
from ....frames.layers.pictures import FoveatedPicture
from ....frames.layers.scene_parts import Delivery, Simplified
from ....geometry import Fovea, Pose, View, WarpMap, cube_size, wide_size, wide_view
from ....gpu.textures import COLOUR, NUMBER, SCALAR, Owner, download, drawing_into, flip_rows
from ....scenes import COARSE, FULL, HALF, Scene, partial_scene, pieces_of
from ..passes import SAME_SURFACE, DeformingMesh, Moving, MovingBody, ScenePasses, draw_cube, draw_moving, may_be_seen
from ..targets import BYTES_BINDING, MOST_SETTINGS, LastUsed, Renderer, display_bytes
from . import NEAREST_M, DrawContext, Drawing, Head, Part, Sender, Sending, boxes_at, distances, parts


@parts.register
class Motion(Part):
    name, order = "motion", 90

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._made: dict[str, _Shown] = {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        for name, kind in (("ids", MovingBody), ("velocity", DeformingMesh)):
            if name in drawing.needs and name not in self._made:
                moving = [one for one in self.context.colour.moving if isinstance(one, kind)]
                self._made[name] = self.own(_Shown(self.context, moving, velocity=name == "velocity"))
        if "ids" in drawing.needs:
            bodies = tuple(body.motion.state(drawing.time_ns) for body in self.context.scene.bodies)
            eye = eye.having(ids=BodyIds(self._made["ids"].draw(eye), bodies))
        return eye.having(velocity=self._made["velocity"].draw(eye)) if "velocity" in drawing.needs else eye


class _Shown(Owner):
    """Draws body numbers (r16ui) or velocities (rgba16f) where the picture shows what moves."""

    def __init__(self, context: DrawContext, moving: Sequence[Moving], *, velocity: bool) -> None:
        self._context, self._moving, self._is_velocity = context, moving, velocity
        shaders, gl = context.gpu.shaders, context.gpu.gl
        self._draw = shaders.draw("server/moving.vert", "server/moving.frag", VELOCITY=int(velocity))
        none = shaders.draw("server/background.vert", "server/moving_none.frag")
        self._empty = self.own(gl.vertex_array(none.program, []))
        deforming = [one for one in moving if velocity and isinstance(one, DeformingMesh)]
        sizes = {one: 12 * len(one.mesh.positions) for one in deforming}
        self._velocities = {one: self.own(gl.buffer(reserve=size, dynamic=True)) for one, size in sizes.items()}
        self._vertices = []
        for one in moving:
            more = [(self._velocities[one], "3f4", "in_velocity")] if one in self._velocities else []
            self._vertices.append(self.own(one.buffers.vertex_array(gl, self._draw.program, *more, colour=False)))
        self._written_ns: int | None = None

    def draw(self, eye: EyeImage) -> moderngl.Texture:
        gl, time_ns = self._context.gpu.gl, eye.drawn_ns
        into = self._context.acquire(eye.size, COLOUR if self._is_velocity else NUMBER, depth=False).colour
        framebuffer = self._context.framebuffers.over(into)
        if time_ns != self._written_ns:
            for deforming, buffer in self._velocities.items():
                deforming.set_time(time_ns)
                buffer.write(np.ascontiguousarray(deforming.velocities()).tobytes())
            self._written_ns = time_ns
        if self._is_velocity:
            self._draw.uniforms.set(eye_from_world=eye.view.pose.rotation_matrix.T)
        with drawing_into(framebuffer, moderngl.NOTHING):
            if self._is_velocity:
                framebuffer.clear()
            else:
                self._empty.render(moderngl.TRIANGLES, vertices=3)
            for one, vertices in zip(self._moving, self._vertices, strict=True):
                if isinstance(one, MovingBody):
                    self._draw.uniforms.set(body=one.number)
                # In any order: of two surfaces, only one has the picture's depth.
                eye.inverse_depth.use(0)
                self._draw.uniforms.set(picture=0, same=SAME_SURFACE)
                draw_moving(gl, self._draw, one, vertices, eye.view, time_ns, textured=False)
        return into


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

    name, order = "views", 130
    of_client = True

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        plain = context.colour
        passes = ScenePasses(context.gpu, context.scene, plain.buffers, colour=False, moving=plain.moving)
        self._passes = self.own(passes)
        self._before: tuple[Array, int] | None = None
        self._ways: list[Array] = []

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        first, place = views[0], np.mean([view.pose.position_m for view in views], axis=0)
        before, self._before = self._before, (place, drawing.time_ns)
        passed_s = (drawing.time_ns - before[1]) * 1e-9 if before is not None else 0.0
        velocity = (place - before[0]) / passed_s if before is not None and passed_s > 0 else np.zeros(3)
        motion = motion_of(first, velocity, drawing.age_ns * 1e-9)
        size = (max(1, drawing.size[0] // _COARSE), max(1, drawing.size[1] // _COARSE))
        count = drawing.needs.get("views", 0)

        def depth_of(view: View) -> Array:
            depth = self.kept("depth", size, SCALAR, depth=False).colour
            self._passes.draw(view, self.context.framebuffers.over(depth), drawing.time_ns)
            return flip_rows(download(depth)).astype(np.float64)

        self._ways = chosen(first, size, motion, count, depth_of) if count else []
        return {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        size, views = eye.size, [moved(eye.view, way) for way in self._ways]
        return eye.having(views=tuple(self.context.draw(view, size, drawing.of_light(view, size)) for view in views))


def motion_of(view: View, velocity_m_s: Array, age_s: float) -> tuple[Array, Array]:
    """Return how far an eye goes, at least LEAST_M: metres along its way, and across it, level."""
    way = np.asarray(velocity_m_s, np.float64) * age_s
    length = float(np.linalg.norm(way))
    right, _, back = view.pose.rotation_matrix.T
    along = way / length if length > 1e-9 else right  # at rest to the right
    across = np.cross(along, _UP)
    if np.linalg.norm(across) < 1e-3:
        across = right
    elif length <= 1e-9:
        across = back
    reach = max(length, LEAST_M)
    return reach * along, reach * across / np.linalg.norm(across)


def moved(view: View, way: Array) -> View:
    pose = Pose(view.pose.position_m + way, view.pose.orientation_xyzw)
    return View(pose, view.fov, view.head_from_eye)


def chosen(
    view: View, size: Size, motion: tuple[Array, Array], count: int, depth_of: Callable[[View], Array]
) -> list[Array]:
    """Return the places of `count` further pictures, relative to the eye, the most useful first.

    Each is the candidate that leaves the least of the expected pictures unseen, the nearer of two.
    depth_of: returns inverse depth of (w, h) `size`, -1 for none, the bottom row first.
    """
    along, across = motion
    targets = [moved(view, ahead * along + aside * across) for ahead, aside in EXPECTED]
    expected = [(target, depth_of(target)) for target in targets]

    def seen_from(way: Array) -> NDArray[np.bool_]:
        place = moved(view, way)
        held = depth_of(place)
        return np.stack([seen(place, held, target, wanted, size) for target, wanted in expected])

    candidates = [ring * way for ring in RINGS for way in (along, -along, across, -across)]
    known, left = seen_from(np.zeros(3)), [(way, seen_from(way)) for way in candidates]
    ways = []
    for _ in range(count):
        best = max(range(len(left)), key=lambda index: (int((known | left[index][1]).sum()), -index))
        way, shows = left.pop(best)
        known = known | shows
        ways.append(way)
    return ways


def seen(view: View, held: Array, target: View, wanted: Array, size: Size) -> NDArray[np.bool_]:
    """Return (h, w): which pixels of a target a picture shows; both with the bottom row first."""
    wide, high = size
    y, x = np.mgrid[:high, :wide]
    pixels = np.stack([x + 0.5, y + 0.5], axis=-1)
    places, depths, _ = WarpMap.between(target, size, view, size).apply(pixels, np.maximum(wanted, 0))
    with np.errstate(invalid="ignore"):  # places behind are NaN, and not inside
        column, row = np.floor(places[..., 0]), np.floor(places[..., 1])
        inside = (column >= 0) & (column < wide) & (row >= 0) & (row < high)
        found = held[np.where(inside, row, 0).astype(int), np.where(inside, column, 0).astype(int)]
        nearer = found - depths > _NEARER * depths + _FLOOR
    shown: NDArray[np.bool_] = inside & ~nearer
    return shown


@parts.register
class Cube(Part):
    """Colour of the six faces of geometry.cube, as sharp as the picture. Errors: InputError."""

    name, order = "cube", 110

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

    name, order = "wide", 120

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        view, size = wide_view(drawing.view), wide_size(drawing.view.fov, drawing.size)
        wide = drawing.of_light(view, size)
        wide = attrs.evolve(wide, needs=wide.needs | Needs(overlay=drawing.needs.get("overlay")))
        return eye.having(wide=self.context.draw(view, size, wide))


_KINDS = {"foveated": COLOUR, "foveated_depth": SCALAR}


@parts.register
class Foveated(Part):
    """Made when the picture is complete, of colour and of inverse depth where each is needed."""

    name, order = "foveated", 195

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        fovea: Fovea = next(drawing.needs[name] for name in _KINDS if name in drawing.needs)
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


@parts.register
class SceneUpdate(Sending[Delivery, "_Sender"]):
    name, order = "scene_update", 200

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._head = Head()

    def make_sender(self, wanted: Delivery) -> _Sender:
        return _Sender(self.context.scene, wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        needed = self.needed(drawing)
        if not needed:
            return {}
        self._head.see(views[0], drawing.time_ns)
        updates = {each: self.sender(each).update(views, self._head, drawing.time_ns) for each in needed}
        return {"scene_update": updates}


class _Sender(Sender):
    def __init__(self, scene: Scene, delivery: Delivery) -> None:
        self._budget = delivery.budget
        self._pieces = pieces_of(scene, delivery.share, delivery.texture, lit=delivery.lit)
        self.book: Outbox = Outbox(self._pieces.things)
        pieces, meshes = self._pieces, self._pieces.meshes
        sizes = [len(pieces.things[pieces.number_of_mesh(index)]) for index in range(len(meshes))]
        self._bytes = np.array(sizes, float)
        extremes = [(mesh.positions.min(axis=0), mesh.positions.max(axis=0)) for mesh in meshes]
        low, high = np.array(extremes, np.float64).reshape(-1, 2, 3).transpose(1, 0, 2)
        self._centres, self._halves = (low + high) / 2, (high - low) / 2
        # Textures that cross: of the pieces, and of mirrors alone.
        cross = {texture for texture, _ in self._pieces.levels}
        self._of_pieces = cross & {mesh.texture for mesh in self._pieces.meshes}
        self._of_mirrors = sorted(cross - self._of_pieces)
        self._bodies = np.array([mesh.body for mesh in self._pieces.meshes], int)

    def has_more(self, now_ns: int) -> bool:
        self.book.settle(now_ns)
        return bool(self.book.waiting)

    def update(self, views: Sequence[View], head: Head, now_ns: int) -> Update:
        order = self._order(views, head, now_ns) if self.has_more(now_ns) else iter(())
        return self.book.update(order, self._budget, now_ns)

    def _order(self, views: Sequence[View], head: Head, now_ns: int) -> Iterator[int]:
        """Yield what to send: first what makes a whole picture."""
        # Then what is visible from wherever the head can be until it arrives, what covers most for
        # its bytes first, coarse textures before sharper ones; then the rest.
        yield from self._pieces.first
        scene, origin = self._pieces.scene, self._pieces.scene.origin_m
        centres, halves = boxes_at(scene, self._bodies, self._centres, self._halves, now_ns)
        metres, radians = head.reach(self.book.round_trip_ns)
        seen = np.any([may_be_seen(centres, halves, view, origin, metres, radians) for view in views], axis=0)
        eye = np.mean([view.pose.position_m for view in views], axis=0) - origin
        away = distances(eye, centres, halves)
        looks = np.minimum(np.linalg.norm(halves, axis=1) / np.maximum(away - metres, NEAREST_M), 1.0)
        by_size = np.argsort(-(looks**2) / self._bytes, kind="stable")
        shown, rest = by_size[seen[by_size]].tolist(), by_size[~seen[by_size]].tolist()
        steps = [(shown, COARSE), (shown, HALF), (rest, COARSE), (shown, FULL), (rest, HALF), (rest, FULL)]
        for group, scale in steps:
            left = set(self._of_pieces)
            for index in group:  # the meshes, and the texture of each where it first occurs
                yield self._pieces.number_of_mesh(index)
                texture = self._pieces.meshes[index].texture
                if texture in left:
                    left.remove(texture)
                    yield self._pieces.number_of_level(texture, scale)
            if group is shown:
                yield from (self._pieces.number_of_level(texture, scale) for texture in self._of_mirrors)


@parts.register
class Difference(Part):
    """Drawn when the picture is complete: the simplified scene for the same view and instant."""

    name, order = "difference", 190

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._program = context.gpu.shaders.compute("server/difference.comp")
        self._bytes = self.own(display_bytes(context.gpu.gl))
        self._renderers: LastUsed[Simplified, Renderer] = LastUsed()

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needed: frozenset[Simplified] = drawing.needs.get("difference", frozenset())
        if not needed:
            return eye
        made = {}
        for each in sorted(needed):
            target = self.kept("simplified", eye.size)
            self._renderers.made(each, functools.partial(self._renderer_of, each)).draw(
                eye.view, eye.size, target, drawing.time_ns
            )
            made[each] = self.context.acquire(eye.size, COLOUR, depth=False).colour
            self.context.gpu.barrier()
            for unit, texture in enumerate((eye.colour, target.colour)):
                texture.bind_to_image(unit, read=True, write=False)
            made[each].bind_to_image(2, read=False, write=True)
            self._bytes.bind_to_storage_buffer(BYTES_BINDING)
            self._program.uniforms.set(full=0, simplified=1, difference=2, rendered_size=eye.size)
            self._program.run(*eye.size)
            self.context.gpu.barrier()
        for unused in self._renderers.beyond(max(MOST_SETTINGS, len(needed))):
            unused.close()
        return eye.having(difference=made)

    def _renderer_of(self, each: Simplified) -> Renderer:
        return self.context.renderer(partial_scene(self.context.scene, each.share, each.texture, lit=each.lit))

    def close(self) -> None:
        super().close()
        for renderer in self._renderers.values():
            renderer.close()
