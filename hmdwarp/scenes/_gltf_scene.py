"""A GLB with more to it than plain surfaces that stand still, as a scene: what each thing calls for follows from the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import Pose
from ._content import Body
from ._gltf_file import GltfFile
from ._gltf_materials import Look, look_of
from ._gltf_moving import Driven, NodeMotion, driven_by_node, is_rigid, skinned
from ._gltf_nodes import Nodes
from ._model import Mesh, Texture

Array = NDArray[np.float64]
FLAT = 1e-4  # a mirror is a plane if nothing of it is farther off than that share of its size
_TRIANGLES = 4


@attrs.define(eq=False)
class RichParts:
    """Meshes in world coordinates, float64 until the scene's origin is known; textures, bodies and notes."""

    drafts: list[Draft] = attrs.field(factory=list)
    textures: list[Texture] = attrs.field(factory=list)
    bodies: list[Body] = attrs.field(factory=list)
    notes: list[str] = attrs.field(factory=list)


@attrs.frozen(eq=False)
class Draft:
    """A mesh on its way. positions, normals: (n, 3) at time 0 in the world, or in head axes; uv, colour: (n, 2), (n, 3)."""

    name: str
    positions: Array
    look: Look
    triangles: NDArray[np.uint32]
    normals: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    uv: Array = attrs.field(factory=lambda: np.empty((0, 2)))
    colour: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    body: int = 0
    rest: Pose | None = None
    driven: Driven | None = None

    def mesh(self, origin: Array, light_of: Callable[[Array, bool], Array]) -> Mesh:
        """The finished mesh of a scene with that origin; one of a body in the body's frame, which is at `rest` at time 0."""
        positions, normals = self.positions - origin, self.normals
        if self.look.material.head_locked:
            positions = self.positions
        elif self.rest is not None:
            positions, normals = (
                self.rest.inverse().transform(self.positions),
                self.rest.rotation.inv().apply(self.normals),
            )
        glows = self.look.material.head_locked  # no lamp of the world shines on it
        lit = np.ones(len(normals)) if glows else light_of(self.normals, self.look.double_sided)
        return Mesh(
            self.name,
            positions,
            normals,
            self.uv,
            self.colour * lit[:, None],
            self.triangles,
            self.look.texture,
            self.look.double_sided,
            self.look.material,
            self.body,
            self.driven.seen_from(origin) if self.driven is not None else None,
            self.colour,
        )


def rich_parts(
    path: Path, normals_of: Callable[[Array, NDArray], Array], is_closed: Callable[[Array, NDArray], bool]
) -> RichParts:
    """All that can be drawn of a file. Errors: SceneError, one line, naming the file and the animation, skin or mesh that is broken."""
    file = GltfFile.read(path)
    parts = RichParts()
    nodes = Nodes(file, parts.notes)
    looks: dict[tuple, Look | None] = {}
    for index in _shown_nodes(file, nodes):
        told = file.listed("nodes")[index]
        if "mesh" not in told:
            continue
        mesh = file.one("meshes", told["mesh"], f"node {index}")
        for number, primitive in enumerate(mesh.get("primitives", [])):
            if primitive.get("mode", _TRIANGLES) == _TRIANGLES and "POSITION" in primitive.get("attributes", {}):
                name = f"{path.stem}-{index}-{number}"
                draft = _draft(file, nodes, parts, looks, _Place(name, index, told.get("skin"), primitive))
                if draft is not None:
                    look = draft.look
                    if not look.double_sided and not is_closed(draft.positions, draft.triangles):
                        look = attrs.evolve(
                            look, double_sided=True
                        )  # a single sheet may be meant to be seen from both sides
                    parts.drafts.append(
                        attrs.evolve(draft, look=look, normals=normals_of(draft.positions, draft.triangles))
                    )
    return parts


@attrs.frozen
class _Place:
    name: str
    node: int
    skin: int | None
    primitive: dict


def _shown_nodes(file: GltfFile, nodes: Nodes) -> list[int]:
    """Those of the scene that the file shows first; all where it names none."""
    scenes = file.listed("scenes")
    if not scenes:
        return list(range(len(nodes.parents)))
    roots = set(file.one("scenes", file.told.get("scene", 0), "the file").get("nodes", []))
    for root in roots:
        file.one("nodes", root, "a scene")
    return [index for index in range(len(nodes.parents)) if nodes.line(index)[0] in roots]


def _draft(file: GltfFile, nodes: Nodes, parts: RichParts, looks: dict, place: _Place) -> Draft | None:
    """A primitive; None for one without triangles, or wholly cut away."""
    told, attributes = f"mesh '{place.name}'", place.primitive["attributes"]
    rest = file.numbers(attributes["POSITION"], told, 3).astype(np.float64)
    triangles = _triangles(file, place.primitive, told, len(rest))
    bad = ~np.isfinite(rest).all(axis=1)
    if bad.any():
        raise file.wrong(f"{told}: position {int(np.argmax(bad))} is not a finite number; export it again without it")
    locked = any((file.listed("nodes")[one].get("extras") or {}).get("head_locked") for one in nodes.line(place.node))
    look = look_of(file, parts, looks, place.primitive, locked)
    if look is None or not len(triangles):
        return None
    draft = _moved(file, nodes, parts, place, Draft(place.name, rest, look, triangles))
    if place.skin is None and np.linalg.det(nodes.at(place.node, 0)[0][:3, :3]) < 0:
        draft = attrs.evolve(draft, triangles=triangles[:, ::-1])  # a mirrored node turns its triangles inside out
    if look.material.reflectivity and not look.material.curved and not _is_flat(draft.positions):
        draft = attrs.evolve(draft, look=attrs.evolve(look, material=attrs.evolve(look.material, curved=True)))
    colour = look.colour * _vertex_colours(file, attributes, told, len(rest))
    return attrs.evolve(draft, uv=_uv(file, attributes, look, told, len(rest)), colour=colour)


def _moved(file: GltfFile, nodes: Nodes, parts: RichParts, place: _Place, draft: Draft) -> Draft:
    """The vertices where they are at time 0, and how they move."""
    rest = draft.positions
    if place.skin is not None:
        driven = skinned(file, nodes, place.skin, place.primitive, rest)
        return attrs.evolve(draft, positions=driven.positions(0), driven=driven)
    matrix = nodes.at(place.node, 0)[0]
    draft = attrs.evolve(draft, positions=rest @ matrix[:3, :3].T + matrix[:3, 3])
    if not nodes.moves(place.node):
        return draft
    if draft.look.material.head_locked:
        parts.notes.append(f"{file.path}: node {place.node} is fixed to the head; its animation is left out")
        return draft
    if not is_rigid(nodes, place.node):
        return attrs.evolve(draft, driven=driven_by_node(nodes, place.node, rest))
    known = [body.motion.node for body in parts.bodies]
    if place.node not in known:
        name = file.listed("nodes")[place.node].get("name") or f"node {place.node}"
        parts.bodies.append(Body(name, NodeMotion(nodes, place.node)))
        known.append(place.node)
    number = known.index(place.node) + 1
    return attrs.evolve(draft, body=number, rest=parts.bodies[number - 1].motion.state(0).pose)


def _triangles(file: GltfFile, primitive: dict, told: str, count: int) -> NDArray[np.uint32]:
    listed = "indices" in primitive
    indices = file.numbers(primitive["indices"], told, 1)[:, 0].astype(np.int64) if listed else np.arange(count)
    if len(indices) and (indices.max() >= count or indices.min() < 0):
        raise file.wrong(f"{told}: a triangle uses vertex {int(indices.max())} of {count}; the file is damaged")
    return indices[: len(indices) // 3 * 3].reshape(-1, 3).astype(np.uint32)


def _uv(file: GltfFile, attributes: dict, look: Look, told: str, count: int) -> Array:
    """Origin bottom left; a file has it at the top."""
    if look.texcoords not in attributes:
        return np.zeros((count, 2))
    uv = _as_shares(file.numbers(attributes[look.texcoords], told, 2))
    if len(uv) != count:
        raise file.wrong(f"{told}: {count} positions and {len(uv)} texture coordinates; export it again")
    return np.where(np.isfinite(uv), uv * (1, -1) + (0, 1), 0.0)


def _vertex_colours(file: GltfFile, attributes: dict, told: str, count: int) -> Array:
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    colours = _as_shares(file.numbers(attributes["COLOR_0"], told))
    if len(colours) != count or colours.shape[1] < 3:
        raise file.wrong(f"{told}: {count} positions and {colours.shape} colours; export it again")
    return np.clip(np.nan_to_num(colours[:, :3]), 0, None)


def _as_shares(values: NDArray) -> Array:
    """Integers that a file forgot to call normalised count as that."""
    return values / np.iinfo(values.dtype).max if values.dtype.kind in "iu" else values.astype(np.float64)


def _is_flat(positions: Array) -> bool:
    middle = positions - positions.mean(axis=0)
    sizes = np.linalg.svd(middle, compute_uv=False)
    return bool(sizes[-1] <= FLAT * sizes[0]) if len(sizes) == 3 else True
