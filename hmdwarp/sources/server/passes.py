"""Draw a scene's surfaces and its background into any framebuffer, near chunks first."""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from typing import Any, ClassVar

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...base import SceneError
from ...geometry import Fov, Pose, View
from ...geometry.cube import FACES, face_views
from ...gpu import Draw, Gpu, Uniforms
from ...gpu.textures import COLOUR, Owner, allocate, check_size, drawing_into, flip_rows, release_all
from ...scenes import ATLAS, MOST_LAMPS, Mesh, Scene, Texture, blocking, chunks_of, indirect_atlas, lamps_at

NEAR_M = 0.02  # closer than an eye comes to anything but its own lens
_IDENTITY, _LAST = np.eye(4), (0, 0, -1, 0)

Array = NDArray[np.float64]


def eye_from_scene(view: View, origin_m: Array) -> Array:
    """Return 4x4: metres relative to `origin_m`, subtracted before rotating, to the eye."""
    out = _IDENTITY.copy()
    out[:3, :3] = view.pose.rotation_matrix.T
    out[:3, 3] = out[:3, :3] @ (origin_m - view.pose.position_m)
    return out


def _projection(fov: Fov) -> tuple[Array, Array]:
    """Return 4x4 clip_from_eye and 3x3 eye_from_ndc, read-only, and keep them."""
    left, right, down, up = fov.tangents
    wide, high, across, along = right - left, up - down, right + left, up + down
    clip = np.array([[2 / wide, 0, across / wide, 0], [0, 2 / high, along / high, 0], [0, 0, -1, -2 * NEAR_M], _LAST])
    eye_from_ndc = np.array([[wide / 2, 0, across / 2], [0, high / 2, along / 2], [0, 0, -1]])
    clip.flags.writeable = eye_from_ndc.flags.writeable = False
    fov.matrices["clip"] = clip, eye_from_ndc
    return clip, eye_from_ndc


def clip_from_eye(fov: Fov) -> Array:
    """Return the read-only 4x4 projection with an infinite far plane; w is metres along -z."""
    return (fov.matrices.get("clip") or _projection(fov))[0]


def world_from_ndc(view: View) -> Array:
    """Return 3x3: device coordinates (x, y, 1) to a direction of length 1 along -z."""
    return view.pose.rotation_matrix @ (view.fov.matrices.get("clip") or _projection(view.fov))[1]


def boxes_of(centres: Array, half_sizes: Array) -> Array:
    """Return (7, n) boxes for `visible` and `nearest_first`: centre x, y, z, 1, half sizes."""
    return np.concatenate([centres.T, np.ones((1, len(centres))), half_sizes.T])


def _boxes_around(low: Array, high: Array) -> Array:
    return boxes_of((low + high) / 2, (high - low) / 2)


def _side_planes(clip: Array) -> Array:
    """Return planes (5, 4), n . (x, y, z, 1) >= 0 inside. Source: Gribb and Hartmann 2001."""
    planes = np.empty((5, 4))
    np.add(clip[3], clip[:3], out=planes[:3])
    np.subtract(clip[3], clip[:2], out=planes[3:])
    return planes


def visible(boxes: Array, clip: Array, slack: Array | float = 0.0) -> NDArray[np.bool_]:
    """Return which boxes may reach into `clip` (4x4), with slack (5, n) outside each plane."""
    planes = _side_planes(clip)
    within = np.concatenate([planes, np.abs(planes[:, :3])], axis=1) @ boxes + slack
    inside: NDArray[np.bool_] = within.min(axis=0) >= 0
    return inside


def may_be_seen(
    centres: Array, halves: Array, view: View, origin_m: Array, metres: float, radians: float
) -> NDArray[np.bool_]:
    """Return which boxes an eye may see that moves and turns so far; relative to `origin_m`."""
    # How far outside each plane of the view a visible box may be, (5, n). Of a point p:
    # |n . (R (p - e) - R' (p - e'))| <= |n| (|R - R'| |p - e'| + |e - e'|), e' the view's.
    clip = clip_from_eye(view.fov)
    steep = np.linalg.norm(_side_planes(clip)[:, :3], axis=1)
    reach = np.linalg.norm(centres - (view.pose.position_m - origin_m), axis=1) + np.linalg.norm(halves, axis=1)
    slack = steep[:, None] * (radians * reach + metres)
    return visible(boxes_of(centres, halves), clip @ eye_from_scene(view, origin_m), slack)


def nearest_first(boxes: Array, eye: Array, classes: int = 4) -> NDArray[np.intp]:
    """Return a class 0 .. classes - 1 for each box, as many in each, by its farthest corner."""
    # Near surfaces drawn first occlude others before they are textured: 1.6 textured pixels per
    # pixel of the room become 1.3. Finer classes mean more draw calls and gained nothing.
    corner = np.abs(boxes[:3] - eye[:, None])
    corner += boxes[4:]
    x, y, z = corner * corner
    farthest = np.sqrt(x + y + z)
    # The borders between classes of equal size: np.quantile's numbers without its 65 us of checks.
    ordered, edges = np.sort(farthest).tolist(), []
    for k in range(1, classes if ordered else 0):
        place = (len(ordered) - 1) * (k / classes)
        below = int(place)
        low, high, share = ordered[below], ordered[min(below + 1, len(ordered) - 1)], place - below
        edges.append(high - (high - low) * (1 - share) if share >= 0.5 else low + (high - low) * share)
    found: NDArray[np.intp] = np.array(edges).searchsorted(farthest, side="left")
    return found


_Spans = tuple[tuple[int, int], ...]  # (first index, number of indices) of each draw call
Draws = tuple[tuple[int, _Spans], ...]  # (batch, its spans), in the order they are drawn


@attrs.frozen(eq=False)
class Chunks:
    first: NDArray[np.int64]  # (n,) index ranges, with the next
    count: NDArray[np.int64]
    batch: NDArray[np.int64]  # (n,) the batch each belongs to
    boxes: NDArray[np.float64]  # (7, n) as projection.boxes_of returns them, relative to the scene's origin


def draws_of(chunks: Chunks, seen: NDArray[np.bool_], eye: Array) -> Draws:
    found = seen.nonzero()[0]
    if not len(found):
        return ()
    group = nearest_first(chunks.boxes, eye)[found] * (int(chunks.batch.max()) + 1) + chunks.batch[found]
    order = group.argsort(kind="stable")
    found, group = found[order], group[order]
    first = chunks.first[found]
    end = first + chunks.count[found]
    breaks = (((first[1:] != end[:-1]) | (group[1:] != group[:-1])).nonzero()[0] + 1).tolist()
    # Plain numbers: a NumPy one costs as much as the rest.
    batches, starts, ends = chunks.batch[found].tolist(), first.tolist(), end.tolist()
    spans = zip([0, *breaks], [*breaks, len(ends)], strict=True)
    out: list[tuple[int, list[tuple[int, int]]]] = []
    for i, j in spans:
        if not out or out[-1][0] != batches[i]:
            out.append((batches[i], []))
        out[-1][1].append((starts[i], ends[j - 1] - starts[i]))
    return tuple([(batch, tuple(spans)) for batch, spans in out])


# A view is replaced by the middle of its cell: of 1/32 in each part of its quaternion, and of 1/8 m
# in each coordinate of its eye. A head that turns at 30 degrees/s enters a new cell at one refresh
# of ten, and a tenth more triangles are drawn than are visible.
_TURN_STEP, EYE_STEP_M = 1 / 32, 1 / 8
# Two unit quaternions within half a step in each of four parts differ by a step at most, those of
# the cell's middle, once normalised, by little more: 1.02 for this step. That is a turn of twice
# the angle, and a chord is no longer than its arc.
TURN_RAD = 2 * 1.05 * _TURN_STEP
_EYE_OFF_M = math.sqrt(3) / 2 * EYE_STEP_M
KEPT = 64


class Visibility:
    """The draws of static chunks, computed once for all views of a cell, so reproducible."""

    def __init__(self, chunks: Chunks) -> None:
        self._draws = functools.lru_cache(KEPT)(functools.partial(_draws_of_cell, chunks))

    def near(self, turn: tuple[float, float, float, float], eye: Array, fov: Fov) -> Draws:
        """Return the draws for an eye: quaternion xyzw to the chunks' space, (3,) metres in it."""
        sign = 1 if turn[3] >= 0 else -1
        turned = np.rint(np.array(turn) * (sign / _TURN_STEP)).tolist()
        return self._draws(*turned, *np.rint(eye / EYE_STEP_M).tolist(), fov)


def _draws_of_cell(chunks: Chunks, *cell: Any) -> Draws:
    turn, eye, boxes = np.array(cell[:4]) * _TURN_STEP, np.array(cell[4:7]) * EYE_STEP_M, chunks.boxes
    middle = View(Pose(eye, turn), cell[7])
    seen = may_be_seen(boxes[:3].T, boxes[4:].T, middle, np.zeros(3), _EYE_OFF_M, TURN_RAD)
    return draws_of(chunks, seen, eye)


SRGB8_ALPHA8 = 0x8C43


# What the surfaces with a texture emit: a texture of its own times a linear colour.
_Shine = tuple[moderngl.Texture, tuple[float, ...]]


@attrs.frozen(eq=False)
class _Batch:
    texture: moderngl.Texture
    double_sided: bool  # whether both sides of a triangle are visible; else back faces are culled
    emission: _Shine


def _upload_texture(gpu: Gpu, texture: Texture) -> moderngl.Texture:
    size, data = texture.image.shape[1::-1], _texels(texture.image)
    check_size(gpu.gl, size)
    made = gpu.gl.texture(size, 4, data, internal_format=SRGB8_ALPHA8 if texture.srgb else None)
    made.build_mipmaps()
    made.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    made.repeat_x = made.repeat_y = texture.repeat
    return made


def _texels(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    texels = np.full((*image.shape[:2], 4), 255, np.uint8)
    for channel in range(image.shape[2]):  # all at once takes three times as long
        texels[..., channel] = flip_rows(image)[..., channel]
    return texels


_WHITE = Texture("white", np.full((1, 1, 3), 255, np.uint8), srgb=False)


class SceneTextures:
    """A scene's textures on the GPU, by index; -1 is white. lent: unchanging, and shared."""

    def __init__(self, gpu: Gpu, scene: Scene, *, lent: bool = False) -> None:
        def made(one: Texture) -> moderngl.Texture:
            make = functools.partial(_upload_texture, gpu, one)
            return gpu.lend(one.image, (one.srgb, one.repeat), make) if lent else make()

        self._gpu, self.revision = gpu, 0  # it counts changes
        self._made = [made(texture) for texture in (*scene.textures, _WHITE)]
        self._shines = {
            index: (_upload_texture(gpu, Texture("emission", one.image, repeat=one.repeat)), one.factor)
            for index, one in ((index, texture.emission) for index, texture in enumerate(scene.textures))
            if one
        }

    def __getitem__(self, index: int) -> moderngl.Texture:
        return self._made[index]

    def shine(self, index: int) -> _Shine:
        return self._shines.get(index) or (self._made[-1], (0.0, 0.0, 0.0))

    def put(self, index: int, image: NDArray[np.uint8]) -> None:
        self._made[index].write(_texels(image))
        self._made[index].build_mipmaps()
        self.revision += 1

    def close(self) -> None:
        release_all(*(texture for texture in self._made if not self._gpu.hand_back(texture)))
        release_all(*(texture for texture, _ in self._shines.values()))


class SceneBuffers(Owner):
    """Some meshes of a scene on the GPU: a vertex buffer, an index buffer and chunks."""

    def __init__(self, gpu: Gpu, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.batches: list[_Batch] = []
        self.meshes, self.revision = list(meshes), 0  # it counts changes
        self.chunks: Chunks  # those that are drawn
        self.visibility: Visibility
        self._starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
        groups: dict[tuple[bool, int], list[int]] = {}
        for number, mesh in enumerate(meshes):
            groups.setdefault((mesh.double_sided, mesh.texture), []).append(number)
        # Of all chunks: the mesh of each, its indices, and which are drawn.
        owner, self._order = [], []  # type: list[int], list[NDArray[np.uint32]]
        batch_of, boxes = [], []
        for (double_sided, texture), members in sorted(groups.items(), key=lambda item: item[0]):
            for number in members:
                for chunk in chunks_of(meshes[number]):
                    boxes.append(_extremes(meshes[number], chunk))
                    self._order.append(chunk.ravel() + np.uint32(self._starts[number]))
                    batch_of.append(len(self.batches))
                    owner.append(number)
            self.batches.append(_Batch(textures[texture], double_sided, textures.shine(texture)))
        count = np.array([len(part) for part in self._order], np.int64)
        around = _boxes_around(*np.array(boxes, np.float64).reshape(-1, 2, 3).transpose(1, 0, 2))
        self._all = Chunks(np.cumsum(count) - count, count, np.array(batch_of, np.int64), around)
        self._owner = np.array(owner, np.int64)
        self.draw_only(range(len(meshes)))
        self._vertices = self.own(gpu.gl.buffer(_vertex_rows(meshes).tobytes() or b"\0" * 32))
        indices = np.concatenate([np.empty(0), *self._order]).astype(np.uint32)
        self._indices = self.own(gpu.gl.buffer(indices.tobytes() or b"\0" * 12))

    def move_to(self, positions: NDArray[np.float32]) -> None:
        """Move all vertices, (n, 3) in the order of the meshes; visibility follows."""
        if not self._order:
            return
        rows = _vertex_rows(self.meshes)
        rows[:, :3] = positions
        self._vertices.write(rows.tobytes())
        corners = positions[np.concatenate(self._order)].astype(np.float64)
        low, high = (extreme.reduceat(corners, self._all.first, axis=0) for extreme in (np.minimum, np.maximum))
        self._all = attrs.evolve(self._all, boxes=_boxes_around(low, high))
        self._choose()

    def put(self, number: int, mesh: Mesh) -> None:
        """Replace the arrays of a mesh by as many others, at rest until they are moved."""
        start = int(self._starts[number])
        self.meshes[number] = mesh
        self._vertices.write(_vertex_rows([mesh]).tobytes(), offset=_ROW_BYTES * start)
        boxes = self._all.boxes.copy()
        for chunk, triangles in zip(np.flatnonzero(self._owner == number).tolist(), chunks_of(mesh), strict=True):
            self._order[chunk] = indices = triangles.ravel() + np.uint32(start)
            self._indices.write(indices.astype(np.uint32).tobytes(), offset=4 * int(self._all.first[chunk]))
            boxes[:, [chunk]] = _boxes_around(*(corner[None] for corner in _extremes(mesh, triangles)))
        self._all = attrs.evolve(self._all, boxes=boxes)
        self._choose()

    def draw_only(self, numbers: Collection[int]) -> None:
        self._drawn = np.isin(self._owner, list(numbers))
        self._choose()

    def _choose(self) -> None:
        every, drawn = self._all, self._drawn
        self.chunks = Chunks(every.first[drawn], every.count[drawn], every.batch[drawn], every.boxes[:, drawn])
        self.visibility = Visibility(self.chunks)
        self.revision += 1

    def vertex_array(
        self, gl: moderngl.Context, program: moderngl.Program, *more: tuple[Any, ...], colour: bool
    ) -> moderngl.VertexArray:
        names = ("in_position", "in_uv", "in_light") if colour else ("in_position",)
        layout = "3f4 2f4 3f4" if colour else "3f4 20x1"
        return gl.vertex_array(program, [(self._vertices, layout, *names), *more], self._indices, index_element_size=4)


def _extremes(mesh: Mesh, triangles: NDArray[np.uint32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    corners = mesh.positions[triangles.ravel()].astype(np.float64)
    return corners.min(axis=0), corners.max(axis=0)


_ROW_BYTES = 4 * (3 + 2 + 3)


def _vertex_rows(meshes: Sequence[Mesh]) -> NDArray[np.float32]:
    rows = [np.concatenate([mesh.positions, mesh.uv, mesh.light], axis=1) for mesh in meshes]
    return np.concatenate([np.empty((0, 8)), *rows]).astype(np.float32)


_STAYS = np.eye(4)
_STAYS.flags.writeable = False


@attrs.frozen(eq=False)
class Place:
    """An eye in the space that positions are relative to."""

    eye_from_here: NDArray[np.float64]  # 4x4
    eye: NDArray[np.float64]  # (3,) metres


class Moving(Owner, ABC):
    layer: ClassVar[str]  # the layer that describes its motion: the client of a frame with that layer moves it
    buffers: SceneBuffers  # its triangles

    @abstractmethod
    def set_time(self, time_ns: int) -> None:
        """Move it to its place at that instant; do nothing for the same instant again."""

    @abstractmethod
    def place(self, view: View) -> Place:
        """Return the place of the view's eye at the instant set last."""

    def scene_from_here(self, time_ns: int) -> NDArray[np.float64]:
        """Return the 4x4 that takes its positions to the scene's axes at an instant."""
        return _STAYS


class MovingBody(Moving):
    layer = "ids"

    def __init__(self, gpu: Gpu, scene: Scene, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.number = meshes[0].body
        self.buffers = self.own(SceneBuffers(gpu, meshes, textures))
        self._body, self._origin_m = scene.bodies[self.number - 1], scene.origin_m

    def set_time(self, time_ns: int) -> None:
        # Not kept for the next time: what people did by that instant may have come since.
        self._pose = self._body.motion.state(time_ns).pose

    def place(self, view: View) -> Place:
        return Place(self._pose.relative_to(view.pose).matrix(), view.pose.relative_to(self._pose).position_m)

    def scene_from_here(self, time_ns: int) -> NDArray[np.float64]:
        matrix = self._body.motion.state(time_ns).pose.matrix()
        matrix[:3, 3] -= self._origin_m
        return matrix


class DeformingMesh(Moving):
    layer = "velocity"

    def __init__(self, gpu: Gpu, scene: Scene, mesh: Mesh, textures: SceneTextures) -> None:
        self.buffers = self.own(SceneBuffers(gpu, [mesh], textures))
        assert mesh.deformation is not None
        self.mesh, self._deformation, self._origin_m = mesh, mesh.deformation, scene.origin_m
        self._set_ns: int | None = None
        self._moved = mesh  # the arrays that were moved, which may be replaced

    def set_time(self, time_ns: int) -> None:
        if time_ns != self._set_ns or self.buffers.meshes[0] is not self._moved:
            self.buffers.move_to(self.positions(time_ns))
            self._set_ns, self._moved = time_ns, self.buffers.meshes[0]

    def positions(self, time_ns: int) -> NDArray[np.float32]:
        """Return its vertices, (n, 3) metres relative to the scene's origin, at any instant."""
        return _checked(self.mesh, "positions", self._deformation.positions(time_ns))

    def velocities(self) -> NDArray[np.float32]:
        """Return its vertices' velocities, (n, 3) m/s in world axes, at the last set instant."""
        assert self._set_ns is not None
        return _checked(self.mesh, "velocities", self._deformation.velocities(self._set_ns))

    def place(self, view: View) -> Place:
        return Place(eye_from_scene(view, self._origin_m), view.pose.position_m - self._origin_m)


def _checked(mesh: Mesh, what: str, values: NDArray[Any]) -> NDArray[np.float32]:
    array = np.ascontiguousarray(values, np.float32)
    if array.shape != mesh.positions.shape:
        why = f"its deformation gives {what} of shape {array.shape}, expected {mesh.positions.shape}"
        raise SceneError(f"mesh '{mesh.name}': {why}")
    if not np.isfinite(array).all():
        raise SceneError(f"mesh '{mesh.name}': its deformation gives {what} that are not finite numbers")
    return array


def moving_parts(gpu: Gpu, scene: Scene, textures: SceneTextures) -> tuple[Moving, ...]:
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
    numbers = sorted({mesh.body for mesh in surfaces if mesh.body})
    of_bodies = [[mesh for mesh in surfaces if mesh.body == number] for number in numbers]
    bodies = [MovingBody(gpu, scene, meshes, textures) for meshes in of_bodies]
    return (*bodies, *(DeformingMesh(gpu, scene, mesh, textures) for mesh in surfaces if mesh.deformation is not None))


_EMISSION_UNIT = 3  # above those of lib/lamps.glsl, which scenes without emission alone have
_INDIRECT_UNIT, BLOCKERS_UNIT = 6, 7
Viewport = tuple[int, int, int, int]  # x, y, w, h in pixels


class Lighting(Owner):
    """Direct light of lamps; subclasses add the rest. most_blockers: triangles in its way."""

    defines: ClassVar[tuple[str, ...]] = ("LAMPS",)  # of shaders, for where it is
    coloured: ClassVar[bool] = True  # whether colours are drawn, or data in their place

    def __init__(self, gpu: Gpu, scene: Scene, most_blockers: int | None = None) -> None:
        self._gl, self._scene = gpu.gl, scene
        if most_blockers is None:
            most_blockers = len(blocking(scene))
        self._blockers = self.own(gpu.gl.texture((3, max(1, most_blockers)), 4, dtype="f4"))
        self._written = b""
        self._blockers.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._buffers: list[tuple[Sequence[Mesh], moderngl.Buffer]] = []

    def _rows(self, time_ns: int) -> NDArray[np.float64]:
        return blocking(self._scene, time_ns)

    def more(self, meshes: Sequence[Mesh], *, albedo: bool = True) -> tuple[Any, ...]:
        """Return further inputs of the vertex stage, as moderngl takes them, albedo if read."""
        buffer = self.own(self._gl.buffer(_all_rows(meshes)))
        self._buffers.append((meshes, buffer))
        if not albedo:
            return (buffer, "3f4 2f4 12x1", "in_normal", "in_light_uv")
        return (buffer, "3f4 2f4 3f4", "in_normal", "in_light_uv", "in_albedo")

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        """Set the uniforms and bind the textures for a view at an instant."""
        raise NotImplementedError

    def use_atlas(self, uniforms: Uniforms, atlas: moderngl.Texture) -> None:
        """Take indirect light from an atlas, as fine as the scene's or finer."""
        uniforms.set(indirect=_INDIRECT_UNIT, texels=atlas.width / ATLAS[0])
        atlas.use(_INDIRECT_UNIT)

    def use_lamps(self, uniforms: Uniforms, time_ns: int) -> bytes:
        """Set what direct light takes, for an instant; return what tells its light apart."""
        blocking = self._rows(time_ns)
        rows = blocking.astype(np.float32).tobytes()
        if rows != self._written:
            self._blockers.write(rows, viewport=(0, 0, 3, len(blocking)))
            self._written = rows
        lamps = lamps_at(self._scene, time_ns)
        places, cones, colours = np.zeros((3, MOST_LAMPS, 4), np.float32)
        for number, (place, colour) in enumerate(lamps):
            places[number], cones[number], colours[number, :3] = place[:4], place[4:], colour
        uniforms.set(
            **{"lamp_place": places.ravel(), "lamp_cone": cones.ravel(), "lamp_colour": colours.ravel()},
            **{"lamp_count": len(lamps), "blocker_count": len(blocking), "blockers": BLOCKERS_UNIT},
        )
        self._blockers.use(BLOCKERS_UNIT)
        return places.tobytes() + cones.tobytes() + colours.tobytes() + rows


class ConvergedLight(Lighting):
    """With indirect light that is solved for the instant that is drawn."""

    def __init__(self, gpu: Gpu, scene: Scene, most_blockers: int | None = None) -> None:
        super().__init__(gpu, scene, most_blockers)
        self._indirect = self.own(allocate(gpu.gl, ATLAS, COLOUR))
        self._light = b""

    def _atlas(self, time_ns: int) -> NDArray[np.float16]:
        return indirect_atlas(self._scene, time_ns)

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        light = self.use_lamps(uniforms, time_ns)
        if self._light != light:
            self._indirect.write(self._atlas(time_ns).tobytes())
            self._light = light
        self.use_atlas(uniforms, self._indirect)


class ArrivingLight(ConvergedLight):
    """Light of a scene whose meshes arrive and stop its still lamps' light. atlas: of the whole."""

    def __init__(self, gpu: Gpu, scene: Scene, atlas: NDArray[np.float16], most_blockers: int) -> None:
        super().__init__(gpu, scene, most_blockers)
        self._whole, self._here = atlas, np.empty((0, 3, 4))

    def put(self, meshes: Sequence[Mesh]) -> None:
        """Light, and shade by, these meshes from now on; buffers have theirs already."""
        self._here = blocking(self._scene, meshes=meshes)
        for those, buffer in self._buffers:
            buffer.write(_all_rows(those))

    def _rows(self, time_ns: int) -> NDArray[np.float64]:
        return self._here

    def _atlas(self, time_ns: int) -> NDArray[np.float16]:
        return self._whole


def _all_rows(meshes: Sequence[Mesh]) -> bytes:
    """Return the rows of all meshes; of none, those of one vertex that no triangle has."""
    rows = [np.empty((0, 8))]  # normal, place in the light atlas (-1 for none) and albedo
    for mesh in meshes:
        count = len(mesh.positions)
        places = mesh.light_uv if mesh.light_uv is not None else np.full((count, 2), -1.0)
        albedo = mesh.albedo if mesh.albedo is not None else np.full((count, 3), 0.5)
        rows.append(np.concatenate([mesh.normals, places, albedo], axis=1))
    return np.concatenate(rows).astype(np.float32).tobytes() or b"\0" * 32


# A surface must not peel out from under itself. It is drawn with the same bits again; 2^-16 leaves
# room for drivers that round differently.
SAME_SURFACE = 2.0**-16


class ScenePasses(Owner):
    """The two draws of a picture: surfaces (those of `buffers`, then `moving`), and the background.

    colour: with inverse depth, else that alone. peel: only what lies behind an earlier picture, see
    shaders/lib/peel.glsl. light: kind of the lamps' light; lighting: in its place, the caller's.
    """

    vertex: ClassVar[str] = "server/scene.vert"
    fragment: ClassVar[str] = "server/scene.frag"

    def __init__(
        self,
        gpu: Gpu,
        scene: Scene,
        buffers: SceneBuffers,
        *,
        colour: bool,
        peel: bool = False,
        moving: Sequence[Moving] = (),
        light: type[Lighting] = ConvergedLight,
        lighting: Lighting | None = None,
    ) -> None:
        self._gpu, self._gl, self.scene, self.buffers = gpu, gpu.gl, scene, buffers
        self._colour, self.moving = colour, tuple(moving)
        # Where the light of the scene's lamps comes from; baked light needs none.
        if colour and scene.lamps and lighting is None:
            lighting = self.own(light(gpu, scene))
        self.lighting = lighting
        defines = ({"COLOUR": 1} if colour else {}) | ({"PEEL": 1} if peel else {})
        # What colours are made of; data in their place have none.
        self._coloured = colour and (self.lighting is None or self.lighting.coloured)
        shown = defines if self._coloured else {name: one for name, one in defines.items() if name != "COLOUR"}
        lit, self._emits = self._lit_defines(), self._coloured and any(one.emission for one in scene.textures)
        self._is_lit, shining = bool(lit), {"EMISSION": 1} if self._emits else {}
        self._surface = gpu.shaders.draw(self.vertex, self.fragment, **shown, **lit, **shining)
        self._background = gpu.shaders.draw("server/background.vert", "server/background.frag", **defines)
        self._vertices = [
            self.own(each.vertex_array(gpu.gl, self._surface.program, *self._more(each), colour=self._coloured))
            for each in (buffers, *(drawing.buffers for drawing in self.moving))
        ]
        self._empty = self.own(gpu.gl.vertex_array(self._background.program, []))

    def _lit_defines(self) -> Mapping[str, object]:
        return dict.fromkeys(self.lighting.defines, 1) if self.lighting is not None else {}

    def _more(self, buffers: SceneBuffers) -> list[tuple[Any, ...]]:
        return [self.lighting.more(buffers.meshes, albedo=self._coloured)] if self.lighting is not None else []

    def peeling(self, moving: Sequence[Moving]) -> ScenePasses:
        return ScenePasses(
            self._gpu, self.scene, self.buffers, colour=True, peel=True, moving=moving, lighting=self.lighting
        )

    @property
    def revision(self) -> int:
        return self.buffers.revision + sum(drawing.buffers.revision for drawing in self.moving)

    def draw(self, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0, **uniforms: object) -> None:
        clear_depth(self._gl, framebuffer)
        if view.hidden is not None:
            self._gpu.shaders.hidden.cover(view, framebuffer, -1.0, **({"COLOUR": 1} if self._colour else {}))
        self.draw_into(view, framebuffer, None, time_ns, **uniforms)

    def draw_into(
        self, view: View, onto: moderngl.Framebuffer, viewport: Viewport | None, time_ns: int = 0, **uniforms: object
    ) -> None:
        """Draw `view` into a viewport of a framebuffer whose depth is clear, None for all of it."""
        whole = viewport if viewport is not None else (0, 0, *onto.size)
        if uniforms:
            self._surface.uniforms.set(**uniforms)
            self._background.uniforms.set(**uniforms)
        if self._colour:
            sky = self.scene.background
            light = {"zenith": sky.zenith, "horizon": sky.horizon, "ground": sky.ground}
            self._background.uniforms.set(world_from_ndc=self._world_from_ndc(view), **light)
        for drawing in self.moving:
            drawing.set_time(time_ns)
        if self.lighting is not None:
            self.lighting.use(self._surface.uniforms, view, whole, time_ns)
        gl, onto.viewport, origin_m = self._gl, whole, self.scene.origin_m
        with drawing_into(onto, moderngl.DEPTH_TEST):
            gl.depth_func = "<="  # the background lies exactly at the far end
            for one, vertices in zip((None, *self.moving), self._vertices, strict=True):
                buffers, place = self.buffers, Place(eye_from_scene(view, origin_m), view.pose.position_m - origin_m)
                if one is not None:
                    buffers, place = one.buffers, one.place(view)
                if self._is_lit:
                    lit = _STAYS if one is None else one.scene_from_here(self.scene.lit_ns(time_ns))
                    self._surface.uniforms.set(scene_from_here=lit)
                seen_from = self._seen_from(view, place)
                clip = clip_from_eye(view.fov) @ seen_from.eye_from_here
                self._surface.uniforms.set(clip_from_scene=clip)
                if one is None and seen_from is place:  # it is static in the world's axes
                    draws = buffers.visibility.near(view.pose.unit_quaternion, place.eye, view.fov)
                else:
                    draws = draws_of(buffers.chunks, visible(buffers.chunks.boxes, clip), seen_from.eye)
                uniforms_of_surface = self._surface.uniforms if self._coloured else None
                _draw_chunks(vertices, buffers, draws, uniforms_of_surface, emits=self._emits)
            self._draw_background()
            gl.depth_func = "<"
        onto.viewport = (0, 0, *onto.size)

    def _draw_background(self) -> None:
        self._gl.disable(moderngl.CULL_FACE)
        self._empty.render(moderngl.TRIANGLES, vertices=3)

    def _seen_from(self, view: View, place: Place) -> Place:
        return place

    def _world_from_ndc(self, view: View) -> Array:
        return world_from_ndc(view)


def _draw_chunks(
    vertices: moderngl.VertexArray, buffers: SceneBuffers, draws: Draws, uniforms: Uniforms | None, *, emits: bool
) -> None:
    """Draw chunks. uniforms: where textures are sampled, on unit 0. emits: emission too."""
    gl = vertices.ctx
    culled = None
    for index, spans in draws:
        batch = buffers.batches[index]
        if batch.double_sided is culled or culled is None:
            culled = not batch.double_sided
            (gl.enable if culled else gl.disable)(moderngl.CULL_FACE)
        if uniforms is not None:
            batch.texture.use(0)
            if emits:
                batch.emission[0].use(_EMISSION_UNIT)
                uniforms.set(emission=_EMISSION_UNIT, emission_factor=batch.emission[1])
        for first, count in spans:
            vertices.render(moderngl.TRIANGLES, vertices=count, first=first)


def draw_moving(
    gl: moderngl.Context,
    draw: Draw,
    one: Moving,
    vertices: moderngl.VertexArray,
    view: View,
    time_ns: int,
    *,
    textured: bool = True,
    emitting: bool = False,
) -> None:
    """Draw one moving thing by a program that takes clip_from_scene, textures on unit 0."""
    one.set_time(time_ns)
    place = one.place(view)
    clip = clip_from_eye(view.fov) @ place.eye_from_here
    draw.uniforms.set(clip_from_scene=clip)
    chunks = one.buffers.chunks
    draws = draws_of(chunks, visible(chunks.boxes, clip), place.eye)
    _draw_chunks(vertices, one.buffers, draws, draw.uniforms if textured else None, emits=emitting)


def clear_depth(gl: moderngl.Context, framebuffer: moderngl.Framebuffer) -> None:
    """Clear depth alone: surfaces or the background write every colour anyway."""
    before, nothing, count = framebuffer.color_mask, (False,) * 4, len(framebuffer.color_attachments)
    framebuffer.color_mask = nothing if count == 1 else (nothing,) * count  # type: ignore[assignment]
    with drawing_into(framebuffer):
        framebuffer.clear(depth=1.0)
    # Outside the scope: moderngl 5.13 applies a mask only when it binds the framebuffer again.
    framebuffer.color_mask = before


def draw_cube(
    gl: moderngl.Context, passes: ScenePasses, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0
) -> None:
    """Draw the six faces of geometry.cube around the eye of `view` into 3n x 2n pixels."""
    side = framebuffer.size[0] // 3
    clear_depth(gl, framebuffer)
    for face, seen in zip(FACES, face_views(view, side), strict=True):
        passes.draw_into(seen, framebuffer, (face.column * side, face.row * side, side, side), time_ns)
