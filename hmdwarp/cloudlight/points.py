"""Points: the server samples surfaces that the head may see, the client keeps and projects them.

A scene's plain surfaces are cut into small cells, each sampled as densely as needed.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, PlanError, linear_from_srgb, srgb8_from_linear
from ..client import ClientScene, PassInputs, Store, receiver_of
from ..client.strategies import Strategy, strategies
from ..client.warp_kinds import check_room
from ..client.warps import KEY_BYTES, Warp, warps
from ..frames import Needs
from ..frames.layers import MOST_BUDGET, Book, Delivered, Update, between, layers
from ..geometry import View
from ..gpu.egl import clear_buffer
from ..gpu.textures import Canvas, download, flip_rows, release_all
from ..scenes import Mesh, Scene, Texture, lamps_at, morton
from ..sources.server.parts import (
    FIRST_ROUND_TRIP_NS,
    NEAREST_M,
    DrawContext,
    Drawing,
    Head,
    Sender,
    Sending,
    boxes_at,
    distances,
    parts,
)
from ..sources.server.passes import may_be_seen
from .photons import octahedral
from .radiosity import OFF_M, direct_light, of_atlas, transport_of

Array = NDArray[np.float64]


# A cell of the scene has an endless sequence of points of which any run is spread evenly. A block
# is a run of it with all that the receiver needs, so blocks may come in any order. Where the
# receiver's room runs out, a cell is forgotten as a whole: its age rises, and older blocks mean
# nothing.

# Room is given in pages of so many points.
PAGE = 16
_LARGEST = 128
# Bytes of a point: position, normal, colour.
POINT_BYTES = 9
# Whether all is sent that may be seen, and the background: zenith, horizon, ground.
_SKY = struct.Struct("<B9e")
# Cell, its age, the block, its points, the body, whether double-sided; lowest corner, edge, area.
_HEAD = struct.Struct("<IHHHHH5f")
HEAD_BYTES = _HEAD.size
_SKY_BYTES = _SKY.size
# Any block fits.
LEAST_BUDGET = 2000
# Of the index of a point in a key, see shaders/lib/scatter_depth.glsl.
MOST_POINTS = 1 << 26
_AGES = 1 << 16

Sent = tuple[int, int, int]  # cell, age, block; block -1 for forgetting alone


@attrs.frozen(order=True)
class Cloud:
    """Points that are delivered little by little."""

    # Bytes of each frame, at most, before they are packed.
    budget: int = attrs.field(default=60_000, validator=between(LEAST_BUDGET, MOST_BUDGET))
    # Points that the client has room for. When it is full, what was not seen for longest is
    # forgotten.
    room: int = attrs.field(default=1 << 20, validator=between(1024, MOST_POINTS))
    # Distance of points in pixels of the shown picture, where all have arrived.
    spacing: float = attrs.field(default=1.0, validator=between(1e-3, 1e6))


@layers.register
class PointLayer(Delivered):
    """An Update for each Cloud. The amount is the frozenset of them."""

    name = "points"
    summary = "new points of the surfaces that the head may see, packed: what lacks most first"
    drawn_by = "points"
    draws_scene = True
    something = frozenset({Cloud()})


def block_range(block: int) -> tuple[int, int]:
    """Return first point and number of points: a page, then as many as before up to 128."""
    if block == 0:
        return 0, PAGE
    if PAGE << (block - 1) >= _LARGEST:
        doublings = (_LARGEST // PAGE).bit_length()
        return _LARGEST * (block - doublings + 1), _LARGEST
    return PAGE << (block - 1), PAGE << (block - 1)


@attrs.frozen(eq=False)
class Block:
    """One run of points as received; count 0 where a cell is only forgotten."""

    cell: int
    age: int
    number: int
    body: int
    double_sided: bool
    low: tuple[float, float, float]
    edge: float
    area: float
    # (n,) three times POSITION_BITS from x up, in steps of the cell's edge from its lowest corner.
    positions: NDArray[np.uint32]
    normals: NDArray[np.uint8]  # (n, 2) octahedral, in the axes of the positions
    colours: NDArray[np.uint8]  # (n, 3) sRGB of texture times light, clipped at 1

    def packed(self) -> bytes:
        """Return its bytes."""
        place = (*self.low, self.edge, self.area)
        count = len(self.positions)
        head = _HEAD.pack(self.cell, self.age, self.number % _AGES, count, self.body, self.double_sided, *place)
        return head + b"".join(array.tobytes() for array in (self.positions, self.normals, self.colours))


def packed_sky(colours: NDArray[np.float64], *, complete: bool) -> bytes:
    """Return the start of every update. colours: (3, 3) of zenith, horizon and ground."""
    largest = float(np.finfo(np.float16).max)
    return _SKY.pack(complete, *np.clip(colours, 0, largest).ravel())


def unpacked(content: NDArray[np.uint8]) -> tuple[bool, NDArray[np.float64], list[Block]]:
    """Return whether all that may be seen was sent, the background and the blocks of an update."""
    data, at = content.tobytes(), _SKY_BYTES
    complete, *sky = _SKY.unpack_from(data)
    blocks = []
    while at < len(data):
        cell, age, number, count, body, double, *low, edge, area = _HEAD.unpack_from(data, at)
        at += HEAD_BYTES
        arrays: list[NDArray[Any]] = []
        for kind, columns in ((np.uint32, 1), (np.uint8, 2), (np.uint8, 3)):
            array = np.frombuffer(data, kind, count * columns, at)
            arrays.append(array if columns == 1 else array.reshape(count, columns))
            at += array.nbytes
        blocks.append(Block(cell, age, number, body, bool(double), (low[0], low[1], low[2]), edge, area, *arrays))
    return bool(complete), np.array(sky).reshape(3, 3), blocks


class PointSender(Book):
    """The sender's book: for each cell what is on its way or has arrived.

    It holds some numbers for each cell, and what is on its way until its fate is heard. It never
    counts on room that the receiver may not have yet: forgotten cells take theirs until the
    receiver is known to have heard of it.
    """

    def __init__(self, cells: int, room: int) -> None:
        super().__init__()
        self._room = room // PAGE
        self._age, self._next = np.zeros(cells, np.int64), np.zeros(cells, np.int64)
        # Points sent and not known to be lost.
        self.points = np.zeros(cells, np.int64)
        self._lost: dict[int, set[int]] = {}
        # Cells whose forgetting must still be sent, and pages that they hold until it is heard.
        self._to_forget: dict[int, None] = {}
        self._held: dict[int, int] = {}
        self._used = 0

    @property
    def free(self) -> int:
        """Points that the receiver still has room for."""
        return (self._room - self._used) * PAGE

    @property
    def remembered(self) -> int:
        """How many things it remembers besides its numbers for each cell."""
        lost = sum(map(len, self._lost.values()))
        return lost + len(self._to_forget) + len(self._held) + sum(len(news[2].pieces) for news in self._news)

    def next_block(self, cell: int) -> int:
        """Return the block to send next: the first that was lost, else the first not sent."""
        lost = self._lost.get(cell)
        return min(lost) if lost else int(self._next[cell])

    def sent(self, cell: int) -> Sent:
        """Enter that next_block() is sent; return it with its age."""
        block = self.next_block(cell)
        if block == self._next[cell]:
            self._next[cell] += 1
        else:
            self._lost[cell].discard(block)
            if not self._lost[cell]:
                del self._lost[cell]
        count = block_range(block)[1]
        self.points[cell] += count
        self._used += count // PAGE
        return cell, int(self._age[cell]), block

    def forget(self, cell: int) -> None:
        """Take a cell from the receiver; it can be sent anew at once."""
        self._held[cell] = self._held.get(cell, 0) + int(self.points[cell]) // PAGE
        self._age[cell] = (self._age[cell] + 1) % _AGES
        self._next[cell] = self.points[cell] = 0
        self._lost.pop(cell, None)
        self._to_forget[cell] = None

    def forgetting(self, most: int) -> list[Sent]:
        """Return at most so many things to send so that cells are forgotten; entered as sent."""
        out = [(cell, int(self._age[cell]), -1) for cell in list(self._to_forget)[:most]]
        for cell, *_ in out:
            del self._to_forget[cell]
        return out

    def _settle(self, piece: Sent, *, arrived: bool) -> None:
        cell, age, block = piece
        if age != self._age[cell]:
            return
        if arrived:  # any block of the newest age makes the receiver forget older ones
            self._used -= self._held.pop(cell, 0)
            self._to_forget.pop(cell, None)
        elif block >= 0:
            self._lost.setdefault(cell, set()).add(block)
            count = block_range(block)[1]
            self.points[cell] -= count
            self._used -= count // PAGE
        elif cell in self._held:
            self._to_forget[cell] = None


@attrs.define(eq=False)
class _Cell:
    age: int
    slot: int
    blocks: set[int] = attrs.field(factory=set)
    pages: list[int] = attrs.field(factory=list)
    points: int = 0


class PointRoom:
    """The receiver's book: which pages and slot each cell has. It never takes more than its room.

    write: called with each block that is taken, its slot, its pages, and the points that the cell
    has now. clear: called with pages that hold nothing any more.
    """

    def __init__(
        self, room: int, write: Callable[[Block, int, list[int], int], None], clear: Callable[[list[int]], None]
    ) -> None:
        self._free = list(range(room // PAGE - 1, -1, -1))
        self._slots = list(range(room // PAGE - 1, -1, -1))
        self._cells: dict[int, _Cell] = {}
        # The age of cells that were forgotten.
        self._ages: dict[int, int] = {}
        self._write, self._clear = write, clear
        self.high = 0  # no page from here on was ever used

    @property
    def points(self) -> int:
        """How many points it holds."""
        return sum(cell.points for cell in self._cells.values())

    def take(self, block: Block) -> None:
        """Take a block, unless it came before or is older than what is there."""
        known = self._cells.get(block.cell)
        age = known.age if known is not None else self._ages.get(block.cell, 0)
        newer = (block.age - age) % _AGES
        if newer >= _AGES // 2:
            return
        if newer:
            if known is not None:
                cell = self._cells.pop(block.cell)
                self._clear(cell.pages)
                self._free += cell.pages
                self._slots.append(cell.slot)
            self._ages[block.cell] = block.age
        pages = len(block.positions) // PAGE
        known = self._cells.get(block.cell)
        if not pages or (known is not None and block.number in known.blocks) or pages > len(self._free):
            return
        if known is None:
            known = self._cells[block.cell] = _Cell(block.age, self._slots.pop())
        taken = [self._free.pop() for _ in range(pages)]
        known.pages += taken
        known.blocks.add(block.number)
        known.points += pages * PAGE
        self.high = max(self.high, max(taken) + 1)
        self._write(block, known.slot, taken, known.points)


# A cell is at most so long, or so much of its distance from the viewpoint, whichever is more.
_CELL_M, CELL_SHARE = 0.25, 1 / 8
# Bits of a position on each axis of its cell: the error is at most 1/2046 of the cell's edge.
POSITION_BITS = 10
_STEPS = (1 << POSITION_BITS) - 1
_MOST_SPLITS = 64
# Digits of a place in a triangle, base 4, and of the index of a point, base 2.
_TRIANGLE_DIGITS, _INDEX_BITS = 8, 24
_QUARTERS = 3 * np.vstack([np.zeros(3), np.eye(3)])  # the middle one, and those at the corners


class PointCells:
    """Cells of plain surfaces, each on one side of one mesh and facing about one way.

    What deforms, is see-through or fixed to the head has none. A point's colour is the texture
    times the light, as the server draws it, filtered to the requested spacing: it is rounded to
    8 bits of sRGB, which is off by half a step at most, light beyond 1 is clipped, and what varies
    within the spacing is averaged over squares of texels. Lamps stand where they are at the start,
    and their light is looked up at the corners of triangles no longer than a cell.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        # Of each texture that was looked up, by its id, see _levels; and those made of emissions.
        self._levels: dict[int, list[NDArray[np.float32]]] = {}
        self._shining: dict[int, Texture] = {}
        meshes = [mesh for mesh in scene.meshes if mesh.is_surface and mesh.deformation is None]
        rows, owner = _split(meshes, scene)
        self._meshes = meshes
        corners = rows[:, :, :3]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(across, axis=1) / 2
        keep = area > 0
        rows, owner, area, across = rows[keep], owner[keep], area[keep], across[keep]
        cell = _cells(rows, owner, across, meshes, scene)
        order = np.lexsort((morton(rows[:, :, :3].mean(axis=1)), cell)) if len(cell) else np.argsort(cell)
        self._rows, self._area, cell = rows[order], area[order], cell[order]
        self._normal = across[order] / (2 * self._area[:, None])
        if scene.lamps:
            _light_up(self._rows, self._normal, owner[order], meshes, scene)
        self._texels = _texels_per_metre(self._rows, self._area, owner[order], meshes, scene)
        self.count = int(cell[-1]) + 1 if len(cell) else 0
        self._first = np.searchsorted(cell, np.arange(self.count + 1))
        starts = self._first[:-1]

        def of_cells(reduce: np.ufunc, values: Array) -> Array:
            return reduce.reduceat(values, starts) if self.count else np.zeros((0, *values.shape[1:]))

        low = of_cells(np.minimum, self._rows[:, :, :3].min(axis=1))
        high = of_cells(np.maximum, self._rows[:, :, :3].max(axis=1))
        # (n, 3) lowest corner, half size and middle in metres, relative to the scene's origin or in
        # the frame of the body; (n,) the edge of the cube that holds it, and the area.
        self.low, self.halves = low.astype(np.float32).astype(np.float64), (high - low) / 2
        self.centres = self.low + self.halves
        self.edge = np.maximum((high - self.low).max(axis=1, initial=0), 1e-6).astype(np.float32).astype(np.float64)
        self.area = of_cells(np.add, self._area)
        self._mesh_of = owner[order][starts] if self.count else np.zeros(0, np.int64)
        self.body = np.array([meshes[k].body for k in self._mesh_of], np.int64)
        self.double_sided = np.array([meshes[k].double_sided for k in self._mesh_of], bool)
        # The mean direction that a cell faces, of length 1, and the least cosine to any of its
        # triangles.
        mean = of_cells(np.add, self._normal)
        self.facing = mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-30)
        cosine = np.einsum("ij,ij->i", self._normal, self.facing[cell])
        self.least_cosine = of_cells(np.minimum, cosine)

    def block(self, sent: Sent, spacing: float) -> Block:
        """Return some points of a cell's sequence, as they are sent.

        Any run of the sequence is spread evenly over the cell's surface. spacing: metres over which
        the texture is averaged.
        """
        cell, age, number = sent
        first, count = block_range(number) if number >= 0 else (0, 0)
        own = slice(int(self._first[cell]), int(self._first[cell + 1]))
        ends = np.cumsum(self._area[own])
        # Places from 0 to 1, those of any run far apart: van der Corput's sequence.
        bits = (np.arange(first, first + count)[:, None] >> np.arange(_INDEX_BITS)) & 1
        at = (bits @ 0.5 ** np.arange(1, _INDEX_BITS + 1) + 0.5 ** (_INDEX_BITS + 1)) * ends[-1]
        which = np.minimum(np.searchsorted(ends, at, side="right"), len(ends) - 1)
        weights = _in_triangle(np.clip(1 - (ends[which] - at) / self._area[own][which], 0, 1))
        found = np.einsum("nk,nkc->nc", weights, self._rows[own][which])
        steps = np.rint((found[:, :3] - self.low[cell]) / self.edge[cell] * _STEPS).clip(0, _STEPS).astype(np.uint32)
        packed = steps[:, 0] | steps[:, 1] << np.uint32(POSITION_BITS) | steps[:, 2] << np.uint32(2 * POSITION_BITS)
        mesh, texels = self._meshes[int(self._mesh_of[cell])], self._texels[own][which] * spacing
        light = found[:, 5:8]
        if mesh.texture >= 0:
            texture, uv = self.scene.textures[mesh.texture], found[:, 3:5]
            light = self._looked_up(texture, uv, texels) * light + self._emission(texture, uv, texels)
        colours = srgb8_from_linear(np.minimum(light, 1).astype(np.float32))
        return Block(
            cell, age, number, int(self.body[cell]), bool(self.double_sided[cell]), tuple(self.low[cell].tolist()),
            float(self.edge[cell]), float(self.area[cell]), packed, octahedral(self._normal[own][which]), colours,
        )  # fmt: skip

    def _emission(self, texture: Texture, uv: Array, texels: Array) -> Array | float:
        """Return what its surface emits there; averaged alike."""
        if texture.emission is None:
            return 0.0
        key = id(texture.emission)
        if key not in self._shining:
            self._shining[key] = Texture("emission", texture.emission.image, repeat=texture.emission.repeat)
        ratio = np.sqrt(texture.emission.image[..., 0].size / texture.image[..., 0].size)
        return self._looked_up(self._shining[key], uv, texels * ratio) * texture.emission.factor

    def _looked_up(self, texture: Texture, uv: Array, texels: Array) -> Array:
        """Return the texture's linear colour, averaged over squares of about so many texels."""
        if id(texture) not in self._levels:
            self._levels[id(texture)] = _levels(texture)
        levels = self._levels[id(texture)]
        level = np.clip(np.rint(np.log2(np.maximum(texels, 1e-9))), 0, len(levels) - 1).astype(int)
        out = np.empty((len(uv), 3))
        for number in np.unique(level):
            out[level == number] = _bilinear(levels[number], uv[level == number], repeat=texture.repeat)
        return out


def _in_triangle(place: Array) -> Array:
    """Return (n, 3) weights of the corners: the place from 0 to 1 on a path through a triangle.

    Each digit, base 4, chooses one of the quarters into which its middles divide it.
    Source: Basu and Owen 2015, Low discrepancy constructions in the triangle.
    """
    count = 4**_TRIANGLE_DIGITS
    return np.asarray(_path_through_triangle()[np.minimum(place * count, count - 1).astype(int)])


@cache
def _path_through_triangle() -> Array:
    """Return the weights of each place with other digits."""
    digits, place = [], np.arange(4**_TRIANGLE_DIGITS) / 4**_TRIANGLE_DIGITS
    for _ in range(_TRIANGLE_DIGITS):
        digits.append(np.floor(4 * place).astype(int))
        place = 4 * place - digits[-1]
    # Three times the middle of the last quarter, in weights of the corners of the one before, and
    # so on back to the triangle's: halves of whole numbers, so exact.
    weights = np.ones((len(place), 3))
    for digit in reversed(digits):
        weights = np.where(digit[:, None] == 0, 3 - weights, weights + _QUARTERS[digit]) / 2
    return np.asarray(weights / 3)


def _limit(centres: Array, lengths: Array, body: NDArray[Any], eye: Array) -> Array:
    """Return the longest edge that a triangle there may have."""
    away = np.maximum(np.linalg.norm(centres - eye, axis=1) - lengths, 0)
    return np.maximum(_CELL_M, np.where(body > 0, 0, CELL_SHARE * away))


def _eye(scene: Scene) -> Array:
    return scene.viewpoint.position_m - scene.origin_m


def _light_up(rows: Array, normals: Array, owner: NDArray[np.int64], meshes: list[Mesh], scene: Scene) -> None:
    """Put in place of the albedo at each corner what it shows under the lamps of the start."""
    transport, lamps = transport_of(scene), lamps_at(scene, 0)
    atlas = transport.atlas(transport.indirect(transport.direct(lamps)))
    for number, mesh in enumerate(meshes):
        own = np.flatnonzero(owner == number)
        if mesh.light_uv is None or not len(own):
            continue
        # A little inside: at an edge the next surface begins.
        places = (0.9 * rows[own, :, :3] + 0.1 * rows[own, :, :3].mean(axis=1, keepdims=True)).reshape(-1, 3)
        facing = np.repeat(normals[own], 3, axis=0)
        if mesh.body:
            pose = scene.bodies[mesh.body - 1].motion.state(scene.lit_ns(0)).pose
            places, facing = pose.transform(places) - scene.origin_m, pose.rotation.apply(facing)
        light = direct_light(transport.blockers, places + OFF_M * facing, facing, lamps)
        light += of_atlas(atlas, rows[own, :, 8:].reshape(-1, 2))
        rows[own, :, 5:8] *= light.reshape(-1, 3, 3)


def _split(meshes: list[Mesh], scene: Scene) -> tuple[Array, NDArray[np.int64]]:
    """Return (m, 3, 10) of small triangles, and their meshes.

    Positions, uv, light (albedo where lamps light it) and place in the light atlas.
    """
    parts = []
    for mesh in meshes:
        lit = scene.lamps and mesh.light_uv is not None
        light = mesh.albedo if lit and mesh.albedo is not None else mesh.light
        places = mesh.light_uv if mesh.light_uv is not None else np.zeros_like(mesh.uv)
        parts.append(np.concatenate([mesh.positions, mesh.uv, light, places], axis=1)[mesh.triangles])
    rows = np.concatenate([np.zeros((0, 3, 10)), *parts])
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.triangles) for mesh in meshes])
    body = np.array([mesh.body for mesh in meshes], np.int64)
    done: list[tuple[Array, NDArray[Any]]] = []
    for _ in range(_MOST_SPLITS):
        edges = np.linalg.norm(np.roll(rows, -1, axis=1)[:, :, :3] - rows[:, :, :3], axis=2)
        longest = edges.max(axis=1, initial=0)
        large = longest > _limit(rows[:, :, :3].mean(axis=1), longest, body[owner], _eye(scene))
        done.append((rows[~large], owner[~large]))
        rows, owner, start = rows[large], owner[large], edges[large].argmax(axis=1)
        if not len(rows):
            break
        a, b, c = (rows[np.arange(len(rows)), (start + k) % 3] for k in range(3))
        middle = (a + b) / 2
        rows = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        owner = np.concatenate([owner, owner])
    return np.concatenate([one for one, _ in done]), np.concatenate([one for _, one in done])


def _cells(rows: Array, owner: NDArray[Any], across: Array, meshes: list[Mesh], scene: Scene) -> NDArray[np.int64]:
    """Return the number of each triangle's cell."""
    body = np.array([mesh.body for mesh in meshes], np.int64)
    centres = rows[:, :, :3].mean(axis=1)
    level = np.floor(np.log2(_limit(centres, np.zeros(len(rows)), body[owner], _eye(scene)) / _CELL_M)).astype(np.int64)
    place = np.floor(centres / (_CELL_M * 2.0**level)[:, None]).astype(np.int64)
    axis = np.abs(across).argmax(axis=1)
    side = 2 * axis + (across[np.arange(len(across)), axis] < 0)
    keys = np.column_stack([owner, side, level, place])
    return np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _texels_per_metre(rows: Array, area: Array, owner: NDArray[Any], meshes: list[Mesh], scene: Scene) -> Array:
    texels = [0 if m.texture < 0 else np.prod(scene.textures[m.texture].image.shape[:2]) for m in meshes]
    (ax, ay), (bx, by) = ((rows[:, k, 3:5] - rows[:, 0, 3:5]).T for k in (1, 2))
    on_texture = np.abs(ax * by - ay * bx) / 2 * np.array([*texels, 0], float)[owner]
    return np.asarray(np.sqrt(on_texture / area))


def _levels(texture: Texture) -> list[NDArray[np.float32]]:
    """Return the linear image and its halves, down to one texel."""
    image = texture.image[..., :3]
    linear = linear_from_srgb(image) if texture.srgb else image / 255
    levels: list[NDArray[np.float32]] = [np.asarray(linear, np.float32)]
    while max(levels[-1].shape[:2]) > 1:
        last: NDArray[np.floating] = levels[-1]
        for axis in (0, 1):
            if last.shape[axis] > 1:
                pairs = last.take(range(last.shape[axis] // 2 * 2), axis)
                last = (
                    pairs.take(range(0, pairs.shape[axis], 2), axis) + pairs.take(range(1, pairs.shape[axis], 2), axis)
                ) / 2
        levels.append(last)
    return levels


def _bilinear(image: Array, uv: Array, *, repeat: bool) -> Array:
    height, width = image.shape[:2]
    at = np.column_stack([uv[:, 0] * width, (1 - uv[:, 1]) * height]) - 0.5
    low = np.floor(at)
    share = at - low
    out = np.zeros((len(uv), 3))
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        corner = low.astype(np.int64) + (dx, dy)
        x, y = (
            corner[:, k] % size if repeat else corner[:, k].clip(0, size - 1) for k, size in enumerate((width, height))
        )
        weight = (share[:, 0] if dx else 1 - share[:, 0]) * (share[:, 1] if dy else 1 - share[:, 1])
        out += weight[:, None] * image[y, x]
    return out


# What the head does not see yet gets points of this share of the density, with what is left.
AHEAD = 1 / 16
_MOST_OF_CELL = 1 << 16  # of a cell
# What hides what is looked up in a picture of so many pixels a side. A cell counts as hidden if it
# lies behind all within so many of its own pixels at its middle and around it; one that looks
# larger than that never does.
_HIDING, AROUND = 96, 5


@parts.register
class PointPart(Sending[Cloud, "PointSource"]):
    """One sender for each Cloud that frames need."""

    name = "points"
    order = 201

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._head = Head()

    def make_sender(self, wanted: Cloud) -> PointSource:
        return PointSource(_cells_of(self.context.scene), wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        needed = self.needed(drawing)
        if not needed:
            return {}
        self._head.see(views[0], drawing.time_ns)
        left, right, *_ = drawing.view.fov.tangents
        pixel = (right - left) / (drawing.shown_size or drawing.size)[0]
        from scipy.ndimage import minimum_filter

        # Of each view, the least inverse depth around each pixel of a small picture.
        nearest, hiding = [], self.kept("hiding", (_HIDING, _HIDING))
        for view in views:
            into = self.context.framebuffers.over(hiding.colour, hiding.inverse_depth)
            self.context.colour.draw(view, into, drawing.time_ns)
            nearest.append(minimum_filter(flip_rows(download(hiding.inverse_depth)), AROUND, mode="nearest"))
        updates = {
            cloud: self.sender(cloud).update(views, nearest, self._head, pixel, drawing.time_ns) for cloud in needed
        }
        return {"points": updates}


# One object for a scene: clients share what takes longest to make.
_cells_of = lru_cache(maxsize=2)(PointCells)


class PointSource(Sender):
    """What one Cloud still lacks, and in which order it is sent."""

    def __init__(self, cells: PointCells, cloud: Cloud) -> None:
        self._cells, self._cloud = cells, cloud
        self.book = PointSender(cells.count, cloud.room)
        # When each cell was last requested, by number of update.
        self._wanted_at = np.zeros(cells.count, np.int64)
        self._updates = 0

    def update(self, views: Sequence[View], nearest: Sequence[Array], head: Head, pixel: float, now_ns: int) -> Update:
        """Return what a frame drawn now brings.

        nearest: what hides the rest, for each view. pixel: its size at a distance of 1.
        """
        self.book.settle(now_ns)
        self._updates += 1
        spacing, seen, shown, looks = self._needs(views, nearest, head, pixel, now_ns)
        self._wanted_at[seen] = self._updates
        need = np.minimum(self._cells.area / spacing**2, _MOST_OF_CELL)
        # First come notes of what is forgotten: half of the bytes at most.
        sent = self.book.forgetting(self._cloud.budget // (2 * HEAD_BYTES))
        left = self._cloud.budget - _SKY_BYTES - HEAD_BYTES * len(sent)
        for who, share in ((shown, 1.0), (seen & ~shown, 1.0), (~seen, AHEAD)):
            more, left = self._send(np.where(who, share * need, 0), looks, left, may_forget=who is shown)
            sent += more
        lacks = shown & (self.book.points < need)
        self.complete = not lacks.any()
        # Closer than a pixel, each has the mean of a pixel: the texture between them is not seen.
        apart = spacing * max(1.0, 1 / self._cloud.spacing)
        content = b"".join(self._cells.block(block, float(apart[block[0]])).packed() for block in sent)
        background = self._cells.scene.background
        sky = packed_sky(np.array([background.zenith, background.horizon, background.ground]), complete=self.complete)
        return Update(np.frombuffer(sky + content, np.uint8).copy(), tuple(sent), now_ns)

    def _send(self, wanted: Array, looks: Array, left: int, *, may_forget: bool) -> tuple[list[Sent], int]:
        """Enter blocks of cells that lack points as sent; return them, and bytes left.

        looks: how large each cell looks; first go those whose points lie farthest apart.
        """
        book = self.book
        out: list[Sent] = []
        while True:
            lacks = np.flatnonzero(book.points < wanted)
            apart = looks[lacks] / np.maximum(book.points[lacks], 0.1)
            for cell in lacks[np.argsort(-apart, kind="stable")].tolist():
                count = block_range(book.next_block(cell))[1]
                size = HEAD_BYTES + POINT_BYTES * count
                if size > left:
                    return out, left
                if count > book.free:
                    if may_forget:
                        self._make_room()
                    return out, left
                out.append(book.sent(cell))
                left -= size
            if not len(lacks) or left <= 0:
                return out, left

    def _make_room(self) -> None:
        """Forget what has not been seen for longest: an eighth of the room."""
        held = np.flatnonzero((self.book.points > 0) & (self._wanted_at < self._updates))
        freed = 0
        for cell in held[np.argsort(self._wanted_at[held], kind="stable")].tolist():
            if freed >= self._cloud.room // 8:
                break
            freed += int(self.book.points[cell])
            self.book.forget(cell)

    def _needs(
        self, views: Sequence[View], nearest: Sequence[Array], head: Head, pixel: float, now_ns: int
    ) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_], Array]:
        """Return how far apart each cell's points may lie, in metres, and which may be seen.

        Then which of them nothing hides now, and the solid angle of each. Seen from any place that
        the head can reach until the news of this frame returns.
        """
        cells = self._cells
        origin = cells.scene.origin_m
        centres, halves = boxes_at(cells.scene, cells.body, cells.centres, cells.halves, now_ns)
        facing = cells.facing.copy()
        for number in set(cells.body.tolist()) - {0}:
            own = cells.body == number
            turn = cells.scene.bodies[number - 1].motion.state(now_ns).pose.matrix()[:3, :3]
            facing[own] = facing[own] @ turn.T
        metres, radians = head.reach(self.book.round_trip_ns or FIRST_ROUND_TRIP_NS)
        eye = np.mean([view.pose.position_m for view in views], axis=0) - origin
        away = distances(eye, centres, halves) - metres
        seen = np.zeros(cells.count, bool)
        for view in views:
            seen |= may_be_seen(centres, halves, view, origin, metres, radians)
        # A cell turns its back if all places of the head are behind the planes of all triangles.
        to_eye = eye - centres
        slack = np.linalg.norm(halves, axis=1) + metres
        distance = np.linalg.norm(to_eye, axis=1)
        cosine = np.einsum("ij,ij->i", to_eye, facing) / np.maximum(distance, 1e-9)
        spread = np.arccos(np.clip(cells.least_cosine, -1, 1)) + np.arcsin(
            np.clip(slack / np.maximum(distance, 1e-9), 0, 1)
        )
        turned = (np.arccos(np.clip(cosine, -1, 1)) - spread > np.pi / 2) & ~cells.double_sided
        seen &= ~turned
        hidden = np.ones(cells.count, bool)
        for view, one in zip(views, nearest, strict=True):
            hidden &= _hidden(centres - (view.pose.position_m - origin), np.linalg.norm(halves, axis=1), view, one)
        looks = cells.area * np.maximum(np.abs(cosine), 0.05) / np.maximum(distance, NEAREST_M) ** 2
        return pixel * self._cloud.spacing * np.maximum(away, NEAREST_M), seen, seen & ~hidden, looks


def _hidden(offsets: Array, radii: Array, view: View, nearest: Array) -> NDArray[np.bool_]:
    """Return which balls, at offsets from the eye, lie behind all that is around their middle.

    nearest: (h, w) the least inverse depth around each pixel. What lies outside is not hidden.
    """
    height, width = nearest.shape
    eye = offsets @ view.pose.rotation_matrix
    left, right, down, up = view.fov.tangents
    depth = np.maximum(-eye[:, 2], NEAREST_M)
    at = np.column_stack([(eye[:, 0] / depth - left) / (right - left), (eye[:, 1] / depth - down) / (up - down)])
    inside = (-eye[:, 2] > radii) & ((at >= 0) & (at < 1)).all(axis=1)
    small = radii / depth * max(width / (right - left), height / (up - down)) < AROUND / 2
    column, row = (at.clip(0, 0.999999) * (width, height)).astype(int).T
    hidden: NDArray[np.bool_] = inside & small & (nearest[row, column] * np.maximum(depth - radii, NEAREST_M) > 1)
    return hidden


_COLOUR, _DEPTH = 0, 1  # image units
_WINNER_BYTES, _NOBODY = 4, 0xFFFFFFFF
# Words of a point: position; normal; colour.
_WORDS = 3
_CELL_BYTES = 32
_NO_CELL = 0xFFFFFFFF
# Radius of a disc in square roots of the part of the surface that is its own: from the middle of a
# triangle with two equal sides and a right angle to its farther corners it is 1.05.
RADIUS = 1.1


@attrs.frozen
class _PointSettings(Cloud):
    # Factor on the radius of discs; 0 draws one pixel for each point.
    size: float = attrs.field(default=1.0, validator=attrs.validators.ge(0))
    # The largest radius of a disc in pixels.
    largest: int = attrs.field(default=16, validator=attrs.validators.ge(1))

    @property
    def wanted(self) -> Cloud:
        return Cloud(self.budget, self.room, self.spacing)


@receiver_of("points")
class KeptPoints(Store):
    """The points of one Cloud that have arrived, in pages, and the cells that they belong to.

    The buffers of cloudlight/points.comp are allocated at once for all its room: 12 bytes a point,
    and for each page of PAGE points 4 bytes and the 32 of a cell.
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
        self._slots = np.full(pages, _NO_CELL, np.uint32)
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
        self._put(pages, _NO_CELL)

    def _put(self, pages: list[int], slot: int) -> None:
        self._slots[pages] = slot
        first, end = self._changed
        self._changed = min([first, *pages]), max([end, *(page + 1 for page in pages)])

    def eye_from(self, view: View, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 4, 4): the eye from what stands still, then from each body.

        Positions are subtracted first.
        """
        scene = self.client.scene
        still = np.eye(4)
        still[:3, 3] = scene.origin_m
        out = np.array([still, *(body.motion.state(time_ns).pose.matrix() for body in scene.bodies)])
        out[:, :3, 3] -= view.pose.position_m
        out[:, :3] = view.pose.rotation_matrix.T @ out[:, :3]
        return out

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
class PointWarp(Warp):
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
    Settings = _PointSettings
    resamples = True
    variants = ("spacing=2.0", "size=0.0")
    depth_reads = ()
    carries = False
    without_effects = "shows points alone, of plain surfaces, where they are now"

    @classmethod
    def needs(cls, settings: _PointSettings) -> Needs:
        return Needs(points=frozenset({settings.wanted}))

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError("warp 'points' needs points from a server; for single pictures use 'iterative'")
        self._cloud = self.geometry.store(KeptPoints, self.settings.wanted)
        if self._cloud.points.size > self.gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"]:
            raise InputError(
                f"room for {self.settings.room} points: this GPU's buffers hold "
                f"{self.gpu.gl.info['GL_MAX_SHADER_STORAGE_BLOCK_SIZE'] // 12}; use a smaller room"
            )
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES + _WINNER_BYTES)
        shaders, depth = self.gpu.shaders, {"WRITES_DEPTH": 1} if self.output.depth else {}
        self._offer = shaders.compute("cloudlight/points.comp")
        self._resolve = shaders.compute("cloudlight/points_resolve.comp", **depth)
        pixels = self.shown_size[0] * self.shown_size[1]
        self._keys, self._winners = (self.gpu.gl.buffer(reserve=4 * pixels) for _ in range(2))
        self._bodies = self.gpu.gl.buffer(reserve=64 * (1 + len(self.geometry.scene.bodies)))

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
        left, right, down, up = view.fov.tangents
        w, h = self.shown_size
        sky = np.zeros((3, 3)) if cloud.sky is None else cloud.sky
        uniforms: dict[str, object] = {
            "shown_size": (w, h),
            "lowest": (left, down),
            "pixels": (w / (right - left), h / (up - down)),
            "count": cloud.count,
            "size": self.settings.size,
            "largest": float(self.settings.largest),
            "up": tuple(view.pose.rotation_matrix[1].tolist()),
            "has_sky": int(cloud.sky is not None),
            "shown_colour": _COLOUR,
            "shown_inverse_depth": _DEPTH,
            **{name: tuple(row) for name, row in zip(("zenith", "horizon", "ground"), sky.tolist(), strict=True)},
        }
        for turn in range(2):
            self._offer.uniforms.set_declared(turn=turn, **uniforms)
            if cloud.count:
                self._offer.run(min(cloud.count, 1 << 14), -(-cloud.count >> 14))
            self.gpu.barrier()
        self._resolve.uniforms.set_declared(**uniforms)
        self._resolve.run(*self.shown_size)

    def close(self) -> None:
        super().close()
        for buffer in (self._keys, self._winners, self._bodies):
            buffer.release()


@strategies.register
class PointStrategy(Strategy):
    """What is on the client is never late; what comes into view first has to cross."""

    name = "points"
    summary = "the server sends new points of what the head may see; the client keeps and projects all of them"
    crosses = "points of surfaces, each once"
    client = "projects its points as discs at the newest pose, fills the cracks"
    late = "what was not sent yet"
    classes = (3,)
    source = "the 2014 thesis, section 3.1 [14]"
    warp, fill = "points", "pyramid"
