"""A glTF file as parts of a scene: meshes and lamps where they stand and as they move.

Source: Khronos 2021, glTF 2.0 Specification; Khronos 2018, KHR_lights_punctual.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import Pose
from ._draft import MOST_TRIANGLES, Draft, Look, normals_of
from ._gltf_file import LIGHTS, VISIBILITY, GltfFile, check_extensions, instances_of, unpack_draco
from ._gltf_looks import Looks
from ._gltf_nodes import Driven, NodeMotion, Nodes, is_rigid, skinned
from ._mesh import Body
from ._notes import Notes
from ._scene import Lamp
from .motions import Still
from .options import numbered

Array = NDArray[np.float64]


FLAT = 1e-4  # a mirror is a plane if no vertex is farther off than this share of its size
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


class GltfContent:
    """The drawable parts of a glTF file: drafts of its meshes, textures, bodies and notes.

    units: 4x4, from the file's world to metres with +y up. animation: see SceneOptions.
    Errors: SceneError, one line, naming the file and the broken animation, skin or mesh.
    """

    def __init__(self, path: Path, units: Array, animation: str | None, notes: Notes) -> None:
        self.notes = notes
        self.bodies: list[Body] = []
        self._body_numbers: dict[int, int] = {}  # by node
        self._file, self._left = GltfFile.read(path), MOST_TRIANGLES
        check_extensions(self._file, notes)
        self._nodes = Nodes(self._file, notes, animation)
        self._nodes.root = units
        self._looks = Looks(self._file, notes)
        self.textures = self._looks.textures
        own = [bool((node.get("extras") or {}).get("head_locked")) for node in self._file.items("nodes")]
        self._locked = self._nodes.inherited(own)  # to the head, of each node
        self.drafts = [draft for place in self._places() if (draft := self._draft(*place)) is not None]

    @cached_property
    def cameras(self) -> list[tuple[str, int]]:
        """Name and node of each camera that stands in the file."""
        file = self._file
        return [
            (
                str(node.get("name") or file.item("cameras", node["camera"], "a node").get("name") or f"node {index}"),
                index,
            )
            for index, node in enumerate(file.items("nodes"))
            if "camera" in node
        ]

    def camera(self, wanted: str) -> tuple[float, ...]:
        """Return x, y, z and yaw in degrees of a camera. Errors: InputError if unknown."""
        index = numbered([name for name, _ in self.cameras], wanted, "cameras", "--viewpoint", "X,Y,Z[,YAW]")
        matrix = self._nodes.at(self.cameras[index][1], 0)[0]
        ahead = -matrix[:3, 2]
        return (*matrix[:3, 3].tolist(), float(np.degrees(np.arctan2(-ahead[0], -ahead[2]))))

    def lamps(self) -> list[Lamp]:
        """Return the lamps that shine, by candela and lux, where the scene is put.

        Errors: SceneError for a damaged one.
        """
        known = ((self._file.header.get("extensions") or {}).get(LIGHTS) or {}).get("lights", [])
        found = []
        for node in self._shown_nodes:
            said = (self._file.items("nodes")[node].get("extensions") or {}).get(LIGHTS)
            if said is None or self._nodes.hidden[node]:
                continue
            index = said.get("light")
            if not isinstance(index, int) or not 0 <= index < len(known) or not isinstance(known[index], dict):
                raise self._file.damaged(f"node {node} uses light {index!r} of {len(known)}")
            found.append(self._lamp(node, known[index]))
        return [lamp for lamp in found if max(lamp.colour) > 0]

    def _lamp(self, node: int, said: dict[str, Any]) -> Lamp:
        kind, spot = said.get("type"), said.get("spot") or {}
        cone = float(spot.get("innerConeAngle", 0.0)), float(spot.get("outerConeAngle", np.pi / 4))
        light = np.array(said.get("color", (1.0, 1.0, 1.0)), np.float64) * float(said.get("intensity", 1.0))
        sound = light.shape == (3,) and np.isfinite(light).all() and (light >= 0).all()
        if kind not in ("directional", "point", "spot") or not sound or not 0 <= cone[0] < cone[1] <= np.pi / 2:
            raise self._file.error(
                f"node {node}: light '{said.get('name', kind)}' of type {kind!r}, colour times intensity "
                f"{light.tolist()}, cone {cone[0]:g} to {cone[1]:g} rad; expected point, spot or directional, finite "
                "light of 0 or more, inner < outer <= 1.5708"
            )
        if abs(np.linalg.det(self._nodes.at(node, 0)[0][:3, :3])) < 1e-12:
            raise self._file.damaged(f"node {node}: a light in a node of size 0, which has no direction")
        motion = NodeMotion(self._nodes, node)
        placed = motion if self._nodes.moving[node] else Still(motion.state(0).pose)
        return Lamp(placed, tuple(light.tolist()), kind == "directional", cone if kind == "spot" else None)

    def move(self, world_from_file: Pose) -> None:
        """Let everything that moves do so where the scene is put."""
        self._nodes.root = world_from_file.matrix() @ self._nodes.root

    def _places(self) -> list[tuple[str, int, dict[str, Any]]]:
        """Return name, node and primitive of all triangles that the file shows."""
        file, found, hidden, left = self._file, [], 0, MOST_TRIANGLES
        for index in self._shown_nodes:
            node = file.items("nodes")[index]
            if "mesh" not in node:
                continue
            if self._nodes.hidden[index]:
                hidden += 1
                continue
            mesh = file.item("meshes", node["mesh"], f"node {index}")
            for number, primitive in enumerate(mesh.get("primitives", [])):
                name = f"{file.path.stem}-{index}-{number}"
                if primitive.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
                    self.notes.add("points and lines are left out", f"mesh '{name}'")
                elif "POSITION" in primitive.get("attributes", {}):
                    found.append((name, index, primitive))
                    left -= max(file.count(primitive, "indices"), file.count(primitive["attributes"], "POSITION")) // 3
                    if left < 0:
                        raise file.error(f"more than {MOST_TRIANGLES} triangles; simplify the scene")
        if hidden and not found:
            raise file.error(f"{VISIBILITY} hides all {hidden} nodes with a mesh; show some, and export it again")
        return found

    @cached_property
    def _shown_nodes(self) -> list[int]:
        """The nodes of the scene that the file shows first; all if it names no scene."""
        file, nodes = self._file, self._nodes
        if not file.items("scenes"):
            return list(range(len(nodes.parents)))
        taken = file.header.get("scene", 0)
        scene = file.item("scenes", taken, "the file")
        if len(file.items("scenes")) > 1:
            named = f"scene {taken} '{scene['name']}'" if scene.get("name") else f"scene {taken}"
            self.notes.add(f"{len(file.items('scenes'))} scenes in it; {named} is taken, which it shows first")
        roots = set(scene.get("nodes", []))
        for root in roots:
            file.item("nodes", root, "a scene")
        own = [parent < 0 and index in roots for index, parent in enumerate(nodes.parents)]
        return [index for index, is_shown in enumerate(nodes.inherited(own)) if is_shown]

    def _draft(self, name: str, node: int, primitive: dict[str, Any]) -> Draft | None:
        """Return a primitive's draft; None if it lacks triangles or is wholly cut away."""
        file, user, attributes = self._file, f"mesh '{name}'", primitive["attributes"]
        unpack_draco(file, primitive, user, self.notes)
        rest = file.numbers(attributes["POSITION"], user, 3).astype(np.float64)
        triangles = _triangles(file, primitive, user, len(rest))
        nodes = file.items("nodes")
        rest = self._shaped(rest, nodes[node], primitive, user)
        bad = ~np.isfinite(rest).all(axis=1)
        if bad.any():
            raise file.error(
                f"{user}: position {int(np.argmax(bad))} is not a finite number; export it again without it"
            )
        look = self._looks.look_of(primitive, self._locked[node])
        if look is None or not len(triangles):
            return None
        uv = _uv(file, attributes, look, user, len(rest))
        colours = _vertex_colours(file, attributes, user, len(rest))
        if self._looks.has_alpha(primitive) and colours.shape[1] == 4 and (colours[:, 3] < 1).any():
            self.notes.add("the alpha of vertex colours is left out, drawn as 1", user)
        colour = look.colour * np.clip(np.nan_to_num(colours[:, :3]), 0, None)
        skin, instances = nodes[node].get("skin"), instances_of(file, nodes[node], user)
        if instances is not None and skin is None:
            self._left -= len(instances) * len(triangles)
            if self._left < 0:
                raise file.error(f"{user}: {len(instances)} instances of {len(triangles)} triangles; export fewer")
            turns = instances[:, :3, :3]
            first = np.arange(len(instances))[:, None, None] * len(rest)
            rest = (np.einsum("kij,nj->kni", turns, rest) + instances[:, None, :3, 3]).reshape(-1, 3)
            faces = np.where(np.linalg.det(turns)[:, None, None] < 0, triangles[None, :, ::-1], triangles[None])
            triangles = (faces + first).reshape(-1, 3).astype(np.uint32)
            uv, colour = np.tile(uv, (len(instances), 1)), np.tile(colour, (len(instances), 1))
            if not len(triangles):
                return None
        extras = nodes[node].get("extras") or {}
        panel, occluded = bool(extras.get("panel")), bool(extras.get("occluded"))
        if panel and not np.allclose(colour, 1):
            self.notes.add("a panel has the colours of its picture alone", user)
        fixed = "a panel" if panel else "what is fixed to the head" if look.material.head_locked else ""
        positions, body, driven = self._placed(rest, node, skin, primitive, fixed)
        if skin is None and np.linalg.det(self._nodes.at(node, 0)[0][:3, :3]) < 0:
            triangles = triangles[:, ::-1]  # a mirrored node turns them inside out
        if look.material.reflectivity and not look.material.curved:
            sizes = np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)
            curved = len(sizes) == 3 and bool(sizes[-1] > FLAT * sizes[0])
            look = attrs.evolve(look, material=attrs.evolve(look.material, curved=curved))
        normals = normals_of(positions, triangles)
        return Draft(name, positions, look, triangles, normals, uv, colour, body, driven, panel, occluded)

    def _shaped(self, rest: Array, node: dict[str, Any], primitive: dict[str, Any], user: str) -> Array:
        """Return the positions with the morph targets at the weights that the file gives them."""
        targets = primitive.get("targets", [])
        mesh = self._file.item("meshes", node["mesh"], user)
        for target, weight in zip(targets, node.get("weights", mesh.get("weights", [])), strict=False):
            if weight and "POSITION" in target:
                self._left -= self._file.count(target, "POSITION") // 3
                if self._left < 0:
                    raise self._file.error(f"more than {3 * MOST_TRIANGLES} vertices of morph targets; export fewer")
                change = self._file.numbers(target["POSITION"], user, 3)
                if len(change) != len(rest):
                    raise self._file.error(f"{user}: {len(rest)} positions, {len(change)} of a morph target")
                rest = rest + weight * change
        return rest

    def _placed(
        self, rest: Array, node: int, skin: int | None, primitive: dict[str, Any], fixed: str
    ) -> tuple[Array, int, Driven | None]:
        """Return vertices where they are at time 0, and what moves them: a body's number, or more.

        fixed: what it is that never moves, "" for a plain surface.
        """
        nodes = self._nodes
        if skin is not None:
            driven = skinned(self._file, nodes, skin, primitive, rest, self.notes)
            return driven.positions(0), 0, driven if any(nodes.moving[joint] for joint in driven.joints) else None
        matrix = nodes.at(node, 0)[0]
        positions = rest @ matrix[:3, :3].T + matrix[:3, 3]
        if fixed and nodes.moving[node]:
            self.notes.add(f"{fixed} is not animated", f"node {node}")
        if fixed or not nodes.moving[node]:
            return positions, 0, None
        if not is_rigid(nodes, node):
            which, weights = np.zeros((len(rest), 1), np.int64), np.ones((len(rest), 1))
            return positions, 0, Driven(nodes, rest, [node], np.eye(4)[None], which, weights)
        if node not in self._body_numbers:
            name = self._file.items("nodes")[node].get("name") or f"node {node}"
            self.bodies.append(Body(name, NodeMotion(nodes, node)))
            self._body_numbers[node] = len(self.bodies)
        return positions, self._body_numbers[node], None


def _triangles(file: GltfFile, primitive: dict[str, Any], user: str, count: int) -> NDArray[np.uint32]:
    listed = "indices" in primitive
    indices = file.numbers(primitive["indices"], user, 1)[:, 0].astype(np.int64) if listed else np.arange(count)
    if len(indices) and (indices.max() >= count or indices.min() < 0):
        raise file.error(f"{user}: a triangle uses vertex {int(indices.max())} of {count}; the file is damaged")
    mode = primitive.get("mode", _TRIANGLES)
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3).astype(np.uint32)
    if len(indices) < 3:
        return np.empty((0, 3), np.uint32)
    if mode == _FAN:
        first = np.full(len(indices) - 2, indices[0])
        return np.column_stack([first, indices[1:-1], indices[2:]]).astype(np.uint32)
    strip = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
    strip[1::2] = strip[1::2][:, [1, 0, 2]]  # every second one runs the other way round
    return strip.astype(np.uint32)


def _uv(file: GltfFile, attributes: dict[str, Any], look: Look, user: str, count: int) -> Array:
    """Return texture coordinates with their origin bottom left; glTF has it top left."""
    if look.texcoords not in attributes:
        return np.zeros((count, 2))
    uv = file.numbers(attributes[look.texcoords], user, 2)
    # Quantised ones are meant as they are, and a transform makes them shares.
    uv = uv.astype(np.float64) if "KHR_mesh_quantization" in file.header.get("extensionsUsed", []) else _as_shares(uv)
    if len(uv) != count:
        raise file.damaged(f"{user}: {count} positions and {len(uv)} texture coordinates")
    if not np.array_equal(look.uv_transform, np.eye(3)):
        uv = uv @ look.uv_transform[:2, :2].T + look.uv_transform[:2, 2]
    return np.where(np.isfinite(uv), uv * (1, -1) + (0, 1), 0.0)


def _vertex_colours(file: GltfFile, attributes: dict[str, Any], user: str, count: int) -> Array:
    """Return (n, 3) or, with alpha, (n, 4) as they are in the file."""
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    colours = _as_shares(file.numbers(attributes["COLOR_0"], user))
    if len(colours) != count or colours.shape[1] < 3:
        raise file.damaged(f"{user}: {count} positions and {colours.shape} colours")
    return colours


def _as_shares(values: NDArray[Any]) -> Array:
    """Return floats; integers count as normalised even where the file omits the flag."""
    return values / np.iinfo(values.dtype).max if values.dtype.kind in "iu" else values.astype(np.float64)
