"""A GLB with more than plain, still surfaces, as parts of a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import Pose
from ._content import Body
from ._gltf_file import GltfFile
from ._gltf_materials import Look, Looks
from ._gltf_moving import Driven, NodeMotion, driven_by_node, is_rigid, skinned
from ._gltf_nodes import Nodes
from ._mesh import Mesh

Array = NDArray[np.float64]
FLAT = 1e-4  # a mirror is a plane if no vertex is farther off than this share of its size
_TRIANGLES = 4


@attrs.frozen(eq=False)
class Draft:
    """A mesh in float64, before the scene's origin is known."""

    name: str
    # (n, 3) at time 0 in the world; in head axes if head-locked.
    positions: Array
    look: Look
    triangles: NDArray[np.uint32]
    # (n, 3), in the same axes.
    normals: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    uv: Array = attrs.field(factory=lambda: np.empty((0, 2)))
    # (n, 3) linear.
    colour: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    # Number of the body, 0 for none, and its pose at time 0.
    body: int = 0
    rest: Pose | None = None
    driven: Driven | None = None

    def mesh(self, origin: Array, light_of: Callable[[Array, bool], Array]) -> Mesh:
        """Return the mesh in a scene with that origin; in the body's frame if it has a body."""
        positions, normals = self.positions - origin, self.normals
        locked = self.look.material.head_locked
        if locked:
            positions = self.positions
        elif self.rest is not None:
            inverse = self.rest.inverse()
            positions, normals = inverse.transform(self.positions), self.rest.rotation.inv().apply(self.normals)
        # No lamp of the world shines on what is fixed to the head.
        lit = np.ones(len(normals)) if locked else light_of(self.normals, self.look.double_sided)
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


class RichFile:
    """The drawable parts of a GLB: drafts of its meshes, textures, bodies and notes.

    Errors: SceneError, one line, naming the file and the broken animation, skin or mesh.
    """

    def __init__(
        self, path: Path, normals_of: Callable[[Array, NDArray], Array], is_closed: Callable[[Array, NDArray], bool]
    ) -> None:
        self.notes: list[str] = []
        self.bodies: list[Body] = []
        self._body_numbers: dict[int, int] = {}  # by node
        self._file = GltfFile.read(path)
        self._nodes = Nodes(self._file, self.notes)
        self._looks = Looks(self._file, self.notes)
        self.textures = self._looks.textures
        self.drafts = []
        for draft in filter(None, (self._draft(*place) for place in self._places())):
            look = draft.look
            if not look.double_sided and not is_closed(draft.positions, draft.triangles):
                look = attrs.evolve(look, double_sided=True)  # a single sheet may be meant to be seen from both sides
            self.drafts.append(attrs.evolve(draft, look=look, normals=normals_of(draft.positions, draft.triangles)))

    def _places(self) -> list[tuple[str, int, dict]]:
        """Return name, node and primitive of all triangles that the file shows."""
        found = []
        for index in self._shown_nodes():
            node = self._file.items("nodes")[index]
            if "mesh" not in node:
                continue
            mesh = self._file.item("meshes", node["mesh"], f"node {index}")
            for number, primitive in enumerate(mesh.get("primitives", [])):
                if primitive.get("mode", _TRIANGLES) == _TRIANGLES and "POSITION" in primitive.get("attributes", {}):
                    found.append((f"{self._file.path.stem}-{index}-{number}", index, primitive))
        return found

    def _shown_nodes(self) -> list[int]:
        """Return the nodes of the scene that the file shows first; all if it names no scene."""
        file, nodes = self._file, self._nodes
        if not file.items("scenes"):
            return list(range(len(nodes.parents)))
        roots = set(file.item("scenes", file.header.get("scene", 0), "the file").get("nodes", []))
        for root in roots:
            file.item("nodes", root, "a scene")
        return [index for index in range(len(nodes.parents)) if nodes.line(index)[0] in roots]

    def _draft(self, name: str, node: int, primitive: dict) -> Draft | None:
        """Return a primitive's draft; None if it lacks triangles or is wholly cut away."""
        file, user, attributes = self._file, f"mesh '{name}'", primitive["attributes"]
        rest = file.numbers(attributes["POSITION"], user, 3).astype(np.float64)
        triangles = _triangles(file, primitive, user, len(rest))
        bad = ~np.isfinite(rest).all(axis=1)
        if bad.any():
            raise file.error(
                f"{user}: position {int(np.argmax(bad))} is not a finite number; export it again without it"
            )
        nodes = file.items("nodes")
        locked = any((nodes[one].get("extras") or {}).get("head_locked") for one in self._nodes.line(node))
        look = self._looks.look_of(primitive, locked)
        if look is None or not len(triangles):
            return None
        skin = nodes[node].get("skin")
        draft = self._placed(Draft(name, rest, look, triangles), node, skin, primitive)
        if skin is None and np.linalg.det(self._nodes.at(node, 0)[0][:3, :3]) < 0:
            draft = attrs.evolve(draft, triangles=triangles[:, ::-1])  # a mirrored node turns its triangles inside out
        if look.material.reflectivity and not look.material.curved and not _is_flat(draft.positions):
            draft = attrs.evolve(draft, look=attrs.evolve(look, material=attrs.evolve(look.material, curved=True)))
        colour = look.colour * _vertex_colours(file, attributes, user, len(rest))
        return attrs.evolve(draft, uv=_uv(file, attributes, look, user, len(rest)), colour=colour)

    def _placed(self, draft: Draft, node: int, skin: int | None, primitive: dict) -> Draft:
        """Return the draft with its vertices where they are at time 0, and how they move."""
        rest, nodes = draft.positions, self._nodes
        if skin is not None:
            driven = skinned(self._file, nodes, skin, primitive, rest)
            return attrs.evolve(draft, positions=driven.positions(0), driven=driven)
        matrix = nodes.at(node, 0)[0]
        draft = attrs.evolve(draft, positions=rest @ matrix[:3, :3].T + matrix[:3, 3])
        if not nodes.moves(node):
            return draft
        if draft.look.material.head_locked:
            self.notes.append(f"{self._file.path}: node {node} is fixed to the head; its animation is left out")
            return draft
        if not is_rigid(nodes, node):
            return attrs.evolve(draft, driven=driven_by_node(nodes, node, rest))
        if node not in self._body_numbers:
            name = self._file.items("nodes")[node].get("name") or f"node {node}"
            self.bodies.append(Body(name, NodeMotion(nodes, node)))
            self._body_numbers[node] = len(self.bodies)
        number = self._body_numbers[node]
        return attrs.evolve(draft, body=number, rest=self.bodies[number - 1].motion.state(0).pose)


def _triangles(file: GltfFile, primitive: dict, user: str, count: int) -> NDArray[np.uint32]:
    listed = "indices" in primitive
    indices = file.numbers(primitive["indices"], user, 1)[:, 0].astype(np.int64) if listed else np.arange(count)
    if len(indices) and (indices.max() >= count or indices.min() < 0):
        raise file.error(f"{user}: a triangle uses vertex {int(indices.max())} of {count}; the file is damaged")
    return indices[: len(indices) // 3 * 3].reshape(-1, 3).astype(np.uint32)


def _uv(file: GltfFile, attributes: dict, look: Look, user: str, count: int) -> Array:
    """Return texture coordinates with their origin bottom left; glTF has it top left."""
    if look.texcoords not in attributes:
        return np.zeros((count, 2))
    uv = _as_shares(file.numbers(attributes[look.texcoords], user, 2))
    if len(uv) != count:
        raise file.error(f"{user}: {count} positions and {len(uv)} texture coordinates; export it again")
    return np.where(np.isfinite(uv), uv * (1, -1) + (0, 1), 0.0)


def _vertex_colours(file: GltfFile, attributes: dict, user: str, count: int) -> Array:
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    colours = _as_shares(file.numbers(attributes["COLOR_0"], user))
    if len(colours) != count or colours.shape[1] < 3:
        raise file.error(f"{user}: {count} positions and {colours.shape} colours; export it again")
    return np.clip(np.nan_to_num(colours[:, :3]), 0, None)


def _as_shares(values: NDArray) -> Array:
    """Return floats; integers count as normalised even where the file omits the flag."""
    return values / np.iinfo(values.dtype).max if values.dtype.kind in "iu" else values.astype(np.float64)


def _is_flat(positions: Array) -> bool:
    middle = positions - positions.mean(axis=0)
    sizes = np.linalg.svd(middle, compute_uv=False)
    return bool(sizes[-1] <= FLAT * sizes[0]) if len(sizes) == 3 else True
