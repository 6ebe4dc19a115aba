"""A glTF file as parts of a scene: materials, and meshes where they stand and as they move."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..geometry import Pose
from ._draft import Draft, Look, normals_of
from ._gltf_file import KTX2, GltfFile, check_extensions, instances_of, is_mirror, unpack_draco
from ._gltf_nodes import NodeMotion, Nodes, driven_by_node, is_rigid, skinned
from ._mesh import Body, Material, Texture
from ._notes import Notes
from .options import numbered

Array = NDArray[np.float64]
IsClosed = Callable[[Array, NDArray[np.uint32]], bool]
_REPEAT, _CLAMP = 10497, 33071  # wrapS and wrapT of a sampler


@attrs.frozen(eq=False)
class _Blend:
    alpha: float
    see_through: bool
    head_locked: bool
    colour: Array


class Looks:
    """Looks of all materials of a file, each made once, and the textures they use."""

    def __init__(self, file: GltfFile, notes: Notes) -> None:
        self._file, self._notes = file, notes
        self._made: dict[tuple[Any, ...], Look | None] = {}
        self.textures: list[Texture] = []

    def look_of(self, primitive: dict[str, Any], head_locked: bool) -> Look | None:
        """Return the look of a primitive; None if it is wholly cut away."""
        key = (primitive.get("material"), head_locked)
        if key not in self._made:
            material = self._file.item("materials", key[0], "a mesh") if key[0] is not None else {}
            self._made[key] = self._look(material, f"material '{material.get('name') or key[0]}'", head_locked)
        return self._made[key]

    def has_alpha(self, primitive: dict[str, Any]) -> bool:
        """Return whether alpha counts in a primitive's material."""
        number = primitive.get("material")
        return number is not None and self._file.items("materials")[number].get("alphaMode", "OPAQUE") != "OPAQUE"

    def _look(self, gltf: dict[str, Any], name: str, head_locked: bool) -> Look | None:
        plain = gltf.get("pbrMetallicRoughness") or {}
        factor = np.array(plain.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)), np.float64)
        if factor.shape != (4,) or not np.isfinite(factor).all():
            raise self._file.error(
                f"{name}: base colour {plain.get('baseColorFactor')!r} is not four finite numbers; export it again"
            )
        mode, base = gltf.get("alphaMode", "OPAQUE"), plain.get("baseColorTexture") or {}
        image = self._image(base, name)
        alpha = float(np.clip(factor[3], 0, 1)) if mode != "OPAQUE" else 1.0
        if mode == "MASK":
            cutoff = float(gltf.get("alphaCutoff", 0.5))
            if image is None and alpha < cutoff:
                return None
            image, alpha = (None if image is None else _cut(image, alpha, cutoff)), 1.0
        elif mode != "BLEND" and image is not None:
            image = image[..., :3]
        # A mask without holes, or a blend that lets nothing pass, is a surface like any other.
        see_through = mode in ("MASK", "BLEND") and (
            alpha < 1 or (image is not None and image.shape[2] == 4 and int(image[..., 3].min()) < 255)
        )
        material = self._material(gltf, name, _Blend(alpha, see_through, head_locked, factor[:3]))
        texture = self._add(name, image, srgb=True, repeat=self._repeats(base, name))
        colour = np.clip(factor[:3], 0, None)
        transform = (base.get("extensions") or {}).get("KHR_texture_transform") or {}
        return Look(
            colour,
            texture,
            material,
            bool(gltf.get("doubleSided")),
            f"TEXCOORD_{transform.get('texCoord', base.get('texCoord', 0))}",
            self._uv_transform(transform, name),
            "KHR_materials_unlit" in (gltf.get("extensions") or {}),
        )

    def _uv_transform(self, found: dict[str, Any], name: str) -> Array:
        """Return (3, 3) of KHR_texture_transform."""
        (x, y), (across, down) = found.get("offset", (0.0, 0.0)), found.get("scale", (1.0, 1.0))
        sine, cosine = np.sin(found.get("rotation", 0.0)), np.cos(found.get("rotation", 0.0))
        matrix = np.array([(cosine * across, sine * down, x), (-sine * across, cosine * down, y), (0, 0, 1)])
        if not np.isfinite(matrix).all():
            raise self._file.error(f"{name}: its KHR_texture_transform is not made of finite numbers; export it again")
        return matrix

    def _material(self, gltf: dict[str, Any], name: str, blend: _Blend) -> Material:
        if blend.head_locked:
            return Material(head_locked=True, opacity=blend.alpha)
        extensions, extras = (gltf.get(key) or {} for key in ("extensions", "extras"))
        passes = self._transmission(gltf, name, extensions.get("KHR_materials_transmission") or {})
        reflectivity = self._reflectivity(gltf, name, blend.colour)
        if passes > 0 or blend.see_through:
            if reflectivity:
                self._notes.add("what mirrors and is see-through does not mirror", name)
            return Material(see_through=True, opacity=blend.alpha, transmission=passes)
        if not reflectivity:
            return Material()
        bumps = gltf.get("normalTexture") or {}
        image = self._image(bumps, name, channels=3)
        normal_map = self._add(f"{name}-normal", image, srgb=False, repeat=self._repeats(bumps, name))
        return Material(
            reflectivity=reflectivity,
            normal_map=normal_map,
            normal_scale=float(bumps.get("scale", 1.0)),
            curved=bool(extras.get("curved", False)),
        )

    def _transmission(self, gltf: dict[str, Any], name: str, glass: dict[str, Any]) -> float:
        """Return the share of light that passes where the surface covers: none of what is metal.

        The blend of alpha is apart from it: what alpha does not cover passes untouched.
        Source: Khronos 2021, KHR_materials_transmission; glTF 2.0 Specification, B.2 (materials).
        """
        passes = float(np.clip(glass.get("transmissionFactor", 0.0), 0, 1))
        if not passes:
            return 0.0
        if "transmissionTexture" in glass:
            self._notes.add("a transmission texture is left out, drawn with its factor everywhere", name)
        surface = gltf.get("pbrMetallicRoughness") or {}
        image = self._image(surface.get("metallicRoughnessTexture") or {}, name, channels=3)
        metal = float(np.clip(surface.get("metallicFactor", 1.0), 0, 1))
        metal *= 1.0 if image is None else float(image[..., 2].mean()) / 255
        if metal == 1:
            self._notes.add("a metal transmits no light: what its alpha leaves free passes, nothing else", name)
        return passes * (1 - metal)

    def _reflectivity(self, gltf: dict[str, Any], name: str, colour: Array) -> float:
        """Return `reflectivity` of the extras, else the base colour of a polished metal."""
        share = (gltf.get("extras") or {}).get("reflectivity")
        if share is None:
            return float(np.clip(colour, 0, 1).mean()) if is_mirror(gltf) else 0.0
        if not isinstance(share, int | float) or not 0 <= share <= 1:
            raise self._file.error(f"{name}: reflectivity {share!r} in its extras; expected a share of 0 to 1")
        return float(share)

    def _image(self, info: dict[str, Any], name: str, channels: int = 4) -> NDArray[np.uint8] | None:
        """Return (h, w, channels) bytes; None, with a note, if the image cannot be decoded."""
        if "index" not in info:
            return None
        texture = self._file.item("textures", info["index"], name)
        extensions = texture.get("extensions") or {}
        source = (extensions.get("EXT_texture_webp") or {}).get("source", texture.get("source"))
        if source is None and KTX2 in extensions:
            self._notes.add(
                "KTX2 images are not read, drawn plain ('gltf-transform ktxdecompress' converts them)", name
            )
            return None
        try:
            return self._file.image(source, name)[..., :channels]
        except SceneError as error:
            self._notes.add("images cannot be read, drawn plain", str(error).removeprefix(f"{self._file.path}: "))
            return None

    def _repeats(self, info: dict[str, Any], name: str) -> bool:
        """Return whether a texture wraps around; else its border is continued."""
        texture = self._file.item("textures", info["index"], name) if "index" in info else {}
        sampler = self._file.item("samplers", texture["sampler"], name) if "sampler" in texture else {}
        ways = {sampler.get(key, _REPEAT) for key in ("wrapS", "wrapT")}
        if not ways <= {_REPEAT, _CLAMP} or len(ways) > 1:
            self._notes.add("textures that are mirrored, or wrap on one axis alone, wrap on both", name)
        return ways != {_CLAMP}

    def _add(self, name: str, image: NDArray[np.uint8] | None, *, srgb: bool, repeat: bool) -> int:
        if image is None:
            return -1
        self.textures.append(Texture(name, image, srgb=srgb, repeat=repeat))
        return len(self.textures) - 1


def _cut(image: NDArray[np.uint8], alpha: float, cutoff: float) -> NDArray[np.uint8]:
    out = image.copy()
    out[..., 3] = np.where(image[..., 3] / 255 * alpha >= cutoff, 255, 0)
    return out


FLAT = 1e-4  # a mirror is a plane if no vertex is farther off than this share of its size
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
MOST_TRIANGLES = 50_000_000  # of instances together; 50 million take about 10 GB here


class GltfContent:
    """The drawable parts of a glTF file: drafts of its meshes, textures, bodies and notes.

    units: 4x4, from the file's world to metres with +y up. animation: see SceneOptions.
    Errors: SceneError, one line, naming the file and the broken animation, skin or mesh.
    """

    def __init__(
        self,
        path: Path,
        units: Array,
        animation: str | None,
        notes: Notes,
        is_closed: Callable[[Array, NDArray[Any]], bool],
    ) -> None:
        self.notes = notes
        self.bodies: list[Body] = []
        self._body_numbers: dict[int, int] = {}  # by node
        self._file = GltfFile.read(path)
        check_extensions(self._file, notes)
        self._nodes = Nodes(self._file, notes, animation)
        self._nodes.root = units
        self._looks = Looks(self._file, notes)
        self.textures = self._looks.textures
        self.drafts = []
        for draft in filter(None, (self._draft(*place) for place in self._places())):
            look = draft.look
            if not look.double_sided and not is_closed(draft.positions, draft.triangles):
                look = attrs.evolve(look, double_sided=True)  # a single sheet may be meant to be seen from both sides
            self.drafts.append(attrs.evolve(draft, look=look, normals=normals_of(draft.positions, draft.triangles)))

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

    def move(self, world_from_file: Pose) -> None:
        """Let everything that moves do so where the scene is put."""
        self._nodes.root = world_from_file.matrix() @ self._nodes.root

    def _places(self) -> list[tuple[str, int, dict[str, Any]]]:
        """Return name, node and primitive of all triangles that the file shows."""
        found = []
        for index in self._shown_nodes():
            node = self._file.items("nodes")[index]
            if "mesh" not in node:
                continue
            mesh = self._file.item("meshes", node["mesh"], f"node {index}")
            for number, primitive in enumerate(mesh.get("primitives", [])):
                name = f"{self._file.path.stem}-{index}-{number}"
                if primitive.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
                    self.notes.add("points and lines are left out", f"mesh '{name}'")
                elif "POSITION" in primitive.get("attributes", {}):
                    found.append((name, index, primitive))
        return found

    def _shown_nodes(self) -> list[int]:
        """Return the nodes of the scene that the file shows first; all if it names no scene."""
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
        return [index for index in range(len(nodes.parents)) if nodes.line(index)[0] in roots]

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
        locked = any((nodes[n].get("extras") or {}).get("head_locked") for n in self._nodes.line(node))
        look = self._looks.look_of(primitive, locked)
        if look is None or not len(triangles):
            return None
        uv = _uv(file, attributes, look, user, len(rest))
        colours = _vertex_colours(file, attributes, user, len(rest))
        if self._looks.has_alpha(primitive) and colours.shape[1] == 4 and (colours[:, 3] < 1).any():
            self.notes.add("the alpha of vertex colours is left out, drawn as 1", user)
        colour = look.colour * np.clip(np.nan_to_num(colours[:, :3]), 0, None)
        skin, instances = nodes[node].get("skin"), instances_of(file, nodes[node], user)
        if instances is not None and skin is None:
            if len(instances) * len(triangles) > MOST_TRIANGLES:
                raise file.error(f"{user}: {len(instances)} instances of {len(triangles)} triangles; export fewer")
            rest, triangles = _repeated(rest, triangles, instances)
            uv, colour = np.tile(uv, (len(instances), 1)), np.tile(colour, (len(instances), 1))
            if not len(triangles):
                return None
        draft = self._placed(Draft(name, rest, look, triangles, uv=uv, colour=colour), node, skin, primitive)
        if skin is None and np.linalg.det(self._nodes.at(node, 0)[0][:3, :3]) < 0:
            draft = attrs.evolve(draft, triangles=draft.triangles[:, ::-1])  # a mirrored node turns them inside out
        if look.material.reflectivity and not look.material.curved and not _is_flat(draft.positions):
            draft = attrs.evolve(draft, look=attrs.evolve(look, material=attrs.evolve(look.material, curved=True)))
        return draft

    def _shaped(self, rest: Array, node: dict[str, Any], primitive: dict[str, Any], user: str) -> Array:
        """Return the positions with the morph targets at the weights that the file gives them."""
        targets = primitive.get("targets", [])
        mesh = self._file.item("meshes", node["mesh"], user)
        for target, weight in zip(targets, node.get("weights", mesh.get("weights", [])), strict=False):
            if weight and "POSITION" in target:
                change = self._file.numbers(target["POSITION"], user, 3)
                if len(change) != len(rest):
                    raise self._file.error(f"{user}: {len(rest)} positions, {len(change)} of a morph target")
                rest = rest + weight * change
        return rest

    def _placed(self, draft: Draft, node: int, skin: int | None, primitive: dict[str, Any]) -> Draft:
        """Return the draft with its vertices where they are at time 0, and how they move."""
        rest, nodes = draft.positions, self._nodes
        if skin is not None:
            driven = skinned(self._file, nodes, skin, primitive, rest, self.notes)
            moves = any(nodes.moves(joint) for joint in driven.joints)
            return attrs.evolve(draft, positions=driven.positions(0), driven=driven if moves else None)
        matrix = nodes.at(node, 0)[0]
        draft = attrs.evolve(draft, positions=rest @ matrix[:3, :3].T + matrix[:3, 3])
        if not nodes.moves(node):
            return draft
        if draft.look.material.head_locked:
            self.notes.add("what is fixed to the head is not animated", f"node {node}")
            return draft
        if not is_rigid(nodes, node):
            return attrs.evolve(draft, driven=driven_by_node(nodes, node, rest))
        if node not in self._body_numbers:
            name = self._file.items("nodes")[node].get("name") or f"node {node}"
            self.bodies.append(Body(name, NodeMotion(nodes, node)))
            self._body_numbers[node] = len(self.bodies)
        return attrs.evolve(draft, body=self._body_numbers[node])


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


def _repeated(rest: Array, triangles: NDArray[np.uint32], instances: Array) -> tuple[Array, NDArray[np.uint32]]:
    """Return positions and triangles of all instances together, in the axes of their node."""
    places = np.einsum("kij,nj->kni", instances[:, :3, :3], rest) + instances[:, None, :3, 3]
    first = np.arange(len(instances), dtype=np.uint32)[:, None, None] * len(rest)
    faces = np.where(np.linalg.det(instances[:, :3, :3])[:, None, None] < 0, triangles[None, :, ::-1], triangles[None])
    return places.reshape(-1, 3), (faces + first).reshape(-1, 3).astype(np.uint32)


def _uv(file: GltfFile, attributes: dict[str, Any], look: Look, user: str, count: int) -> Array:
    """Return texture coordinates with their origin bottom left; glTF has it top left."""
    if look.texcoords not in attributes:
        return np.zeros((count, 2))
    uv = file.numbers(attributes[look.texcoords], user, 2)
    # Quantised ones are meant as they are, and a transform makes them shares.
    uv = uv.astype(np.float64) if "KHR_mesh_quantization" in file.header.get("extensionsUsed", []) else _as_shares(uv)
    if len(uv) != count:
        raise file.error(f"{user}: {count} positions and {len(uv)} texture coordinates; export it again")
    if not np.array_equal(look.uv_transform, np.eye(3)):
        uv = uv @ look.uv_transform[:2, :2].T + look.uv_transform[:2, 2]
    return np.where(np.isfinite(uv), uv * (1, -1) + (0, 1), 0.0)


def _vertex_colours(file: GltfFile, attributes: dict[str, Any], user: str, count: int) -> Array:
    """Return (n, 3) or, with alpha, (n, 4) as they are in the file."""
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    colours = _as_shares(file.numbers(attributes["COLOR_0"], user))
    if len(colours) != count or colours.shape[1] < 3:
        raise file.error(f"{user}: {count} positions and {colours.shape} colours; export it again")
    return colours


def _as_shares(values: NDArray[Any]) -> Array:
    """Return floats; integers count as normalised even where the file omits the flag."""
    return values / np.iinfo(values.dtype).max if values.dtype.kind in "iu" else values.astype(np.float64)


def _is_flat(positions: Array) -> bool:
    middle = positions - positions.mean(axis=0)
    sizes = np.linalg.svd(middle, compute_uv=False)
    return bool(sizes[-1] <= FLAT * sizes[0]) if len(sizes) == 3 else True
