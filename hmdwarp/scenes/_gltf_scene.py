"""A glTF file as parts of a scene: its materials, meshes and lamps where they stand and move.

Source: Khronos 2021, glTF 2.0 Specification; Khronos 2018, KHR_lights_punctual.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import SceneError, linear_from_srgb, srgb8_from_linear
from ..geometry import Pose
from ._draft import MOST_TRIANGLES, Draft, Look, Notes, normals_of
from ._gltf_file import KTX2, LIGHTS, VISIBILITY, GltfFile, check_extensions
from ._gltf_nodes import Driven, NodeMotion, Nodes, is_rigid, skinned
from ._mesh import Body, Emission, Material, Texture
from ._scene import Lamp
from .motions import Still
from .options import numbered

Array = NDArray[np.float64]
Image = NDArray[np.uint8] | None
_Gltf = dict[str, Any]  # an object of the file's JSON
_WHITE = np.full((1, 1, 3), 255, np.uint8)
_REPEAT, _CLAMP = 10497, 33071  # wrapS and wrapT of a sampler


class Looks:
    """Looks of all materials of a file, each made once, and the textures they use."""

    def __init__(self, file: GltfFile, notes: Notes) -> None:
        self._file, self._notes = file, notes
        self._made: dict[tuple[Any, ...], Look | None] = {}
        self.textures: list[Texture] = []

    def look_of(self, primitive: _Gltf, head_locked: bool) -> Look | None:
        key = (primitive.get("material"), head_locked)
        if key not in self._made:
            material = self._file.item("materials", key[0], "a mesh") if key[0] is not None else {}
            self._made[key] = self._look(material, f"material '{material.get('name') or key[0]}'", head_locked)
        return self._made[key]

    def _look(self, gltf: _Gltf, name: str, head_locked: bool) -> Look | None:
        plain = gltf.get("pbrMetallicRoughness") or {}
        image = self._image(plain.get("baseColorTexture") or {}, name)
        factor = np.array(plain.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)), np.float64)
        if factor.shape != (4,) or not np.isfinite(factor).all():
            raise self._file.damaged(f"{name}: base colour {plain.get('baseColorFactor')!r} is not four finite numbers")
        mode, base = gltf.get("alphaMode", "OPAQUE"), plain.get("baseColorTexture") or {}
        alpha = float(np.clip(factor[3], 0, 1)) if mode != "OPAQUE" else 1.0
        if mode == "MASK":
            cutoff = float(gltf.get("alphaCutoff", 0.5))
            if image is None and alpha < cutoff:
                return None
            if image is not None:
                image = image.copy()
                image[..., 3] = np.where(image[..., 3] / 255 * alpha >= cutoff, 255, 0)
            alpha = 1.0
        elif mode != "BLEND" and image is not None:
            image = image[..., :3]
        # A mask without holes, or a blend that lets nothing pass, is a surface like any other.
        see_through = mode in ("MASK", "BLEND") and (
            alpha < 1 or (image is not None and image.shape[2] == 4 and int(image[..., 3].min()) < 255)
        )
        if head_locked:
            material = Material(head_locked=True, opacity=alpha)
        else:
            material = self._material(gltf, name, alpha, factor[:3], see_through=see_through)
        glow, base, emission = self._emission(gltf, name, material, base, is_pictured=image is not None)
        texture = self._add(name, image, srgb=True, repeat=self._repeats(base, name), emission=emission)
        coordinates, transform = _place_of(base)
        (x, y), (across, down) = transform.get("offset", (0.0, 0.0)), transform.get("scale", (1.0, 1.0))
        sine, cosine = np.sin(transform.get("rotation", 0.0)), np.cos(transform.get("rotation", 0.0))
        moved = np.array([(cosine * across, sine * down, x), (-sine * across, cosine * down, y), (0, 0, 1)])
        if not np.isfinite(moved).all():
            raise self._file.damaged(f"{name}: its KHR_texture_transform is not made of finite numbers")
        unlit, both = "KHR_materials_unlit" in (gltf.get("extensions") or {}), bool(gltf.get("doubleSided"))
        glow = glow if emission is None else np.zeros(3)
        colour = np.clip(factor[:3], 0, None)
        return Look(colour, texture, material, both, coordinates, moved, unlit, glow, mode != "OPAQUE")

    def _emission(
        self, gltf: _Gltf, name: str, material: Material, base: _Gltf, *, is_pictured: bool
    ) -> tuple[Array, _Gltf, Emission | None]:
        """Return the light of its own (3,), whose place its pictures have, and it as a picture.

        Source: Khronos 2022, KHR_materials_emissive_strength.
        """
        strength = ((gltf.get("extensions") or {}).get("KHR_materials_emissive_strength") or {}).get("emissiveStrength")
        factor = np.array(gltf.get("emissiveFactor", (0, 0, 0)), np.float64) * (1.0 if strength is None else strength)
        if factor.shape != (3,) or not np.isfinite(factor).all():
            raise self._file.damaged(f"{name}: its emission is not three finite numbers")
        if not (factor > 0).any():
            return np.zeros(3), base, None
        factor, info = np.maximum(factor, 0), gltf.get("emissiveTexture") or {}
        image = self._image(info, name, channels=3)
        is_plain = image is None and not is_pictured and not material.transmission
        if (material.see_through or material.head_locked) and not is_plain:
            self._notes.add("the emission of what is see-through or fixed to the head is left out", name)
            return np.zeros(3), base, None
        if image is None:
            return factor, base, Emission(_WHITE, factor) if is_pictured else None
        base = base if is_pictured else info
        if _place_of(base) != _place_of(info):
            self._notes.add("emission with texture coordinates of its own is drawn at its mean", name)
            image = _mean_of(image)
        return factor, base, Emission(image, factor, self._repeats(info, name))

    def _material(self, gltf: _Gltf, name: str, alpha: float, colour: Array, *, see_through: bool) -> Material:
        passes, reflectivity = self._transmission(gltf, name), self._reflectivity(gltf, name, colour)
        if passes > 0 or see_through:
            if reflectivity:
                self._notes.add("what mirrors and is see-through does not mirror", name)
            return Material(see_through=True, opacity=alpha, transmission=passes)
        if not reflectivity:
            return Material()
        bumps = gltf.get("normalTexture") or {}
        image = self._image(bumps, name, channels=3)
        normal_map = self._add(f"{name}-normal", image, srgb=False, repeat=self._repeats(bumps, name))
        scale, curved = float(bumps.get("scale", 1.0)), bool((gltf.get("extras") or {}).get("curved", False))
        return Material(reflectivity=reflectivity, normal_map=normal_map, normal_scale=scale, curved=curved)

    def _transmission(self, gltf: _Gltf, name: str) -> float:
        """Return the share of light that passes where the surface covers: none of what is metal.

        What alpha does not cover passes untouched. Source: Khronos 2021,
        KHR_materials_transmission.
        """
        glass = (gltf.get("extensions") or {}).get("KHR_materials_transmission") or {}
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

    def _reflectivity(self, gltf: _Gltf, name: str, colour: Array) -> float:
        """Return `reflectivity` of the extras, else the base colour of a polished metal."""
        share, surface = (gltf.get("extras") or {}).get("reflectivity"), gltf.get("pbrMetallicRoughness") or {}
        if share is None:
            metallic, rough = surface.get("metallicFactor", 1.0), surface.get("roughnessFactor", 1.0)
            polished = isinstance(metallic, int | float) and isinstance(rough, int | float)
            polished = polished and metallic >= 0.95 and rough <= 0.05 and "metallicRoughnessTexture" not in surface
            return float(np.clip(colour, 0, 1).mean()) if polished else 0.0
        if not isinstance(share, int | float) or not 0 <= share <= 1:
            raise self._file.error(f"{name}: reflectivity {share!r} in its extras; expected a share of 0 to 1")
        return float(share)

    def _image(self, info: _Gltf, name: str, channels: int = 4) -> Image:
        """Return (h, w, channels) bytes; None, with a note, if the image cannot be decoded."""
        if "index" not in info:
            return None
        texture = self._file.item("textures", info["index"], name)
        extensions = texture.get("extensions") or {}
        source = (extensions.get("EXT_texture_webp") or {}).get("source", texture.get("source"))
        if source is None and KTX2 in extensions:
            what = "KTX2 images are not read, drawn plain ('gltf-transform ktxdecompress' converts them)"
            self._notes.add(what, name)
            return None
        try:
            return self._file.image(source, name)[..., :channels]
        except SceneError as error:
            self._notes.add("images cannot be read, drawn plain", str(error).removeprefix(f"{self._file.path}: "))
            return None

    def _repeats(self, info: _Gltf, name: str) -> bool:
        """Return whether a texture wraps around; else its border is continued."""
        texture = self._file.item("textures", info["index"], name) if "index" in info else {}
        sampler = self._file.item("samplers", texture["sampler"], name) if "sampler" in texture else {}
        ways = {sampler.get(key, _REPEAT) for key in ("wrapS", "wrapT")}
        if not ways <= {_REPEAT, _CLAMP} or len(ways) > 1:
            self._notes.add("textures that are mirrored, or wrap on one axis alone, wrap on both", name)
        return ways != {_CLAMP}

    def _add(self, name: str, image: Image, *, srgb: bool, repeat: bool, emission: Emission | None = None) -> int:
        if image is None and emission is None:
            return -1
        self.textures.append(Texture(name, _WHITE if image is None else image, srgb, repeat, emission))
        return len(self.textures) - 1


def _place_of(info: _Gltf) -> tuple[str, _Gltf]:
    """Return the attribute with a picture's texture coordinates, and its KHR_texture_transform."""
    transform = (info.get("extensions") or {}).get("KHR_texture_transform") or {}
    number = transform.get("texCoord", info.get("texCoord", 0))
    return f"TEXCOORD_{number}", {key: value for key, value in transform.items() if key != "texCoord"}


def _mean_of(image: Image) -> NDArray[np.uint8]:
    assert image is not None
    return srgb8_from_linear(linear_from_srgb(image).mean(axis=(0, 1), keepdims=True))


FLAT = 1e-4  # a mirror is a plane if no vertex is farther off than this share of its size
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


class GltfContent:
    """The drawable parts of a glTF file: drafts of its meshes, textures, bodies and notes.

    units: 4x4, to metres with +y up. animation: see SceneOptions. Errors: SceneError.
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
        file, found = self._file, []
        for index, node in enumerate(file.items("nodes")):
            if "camera" in node:
                own = file.item("cameras", node["camera"], "a node").get("name")
                found.append((str(node.get("name") or own or f"node {index}"), index))
        return found

    def camera(self, wanted: str) -> tuple[float, ...]:
        index = numbered([name for name, _ in self.cameras], wanted, "cameras", "--viewpoint", "X,Y,Z[,YAW]")
        matrix = self._nodes.at(self.cameras[index][1], 0)[0]
        ahead = -matrix[:3, 2]
        return (*matrix[:3, 3].tolist(), float(np.degrees(np.arctan2(-ahead[0], -ahead[2]))))

    def lamps(self) -> list[Lamp]:
        """Return the lamps that shine, by candela and lux, Errors: SceneError."""
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

    def _lamp(self, node: int, said: _Gltf) -> Lamp:
        kind, spot = said.get("type"), said.get("spot") or {}
        cone = float(spot.get("innerConeAngle", 0.0)), float(spot.get("outerConeAngle", np.pi / 4))
        light = np.array(said.get("color", (1.0, 1.0, 1.0)), np.float64) * float(said.get("intensity", 1.0))
        sound = light.shape == (3,) and np.isfinite(light).all() and (light >= 0).all()
        if kind not in ("directional", "point", "spot") or not sound or not 0 <= cone[0] < cone[1] <= np.pi / 2:
            what = f"light '{said.get('name', kind)}' of type {kind!r}, colour times intensity {light.tolist()}, cone"
            wanted = "point, spot or directional, finite light of 0 or more, inner < outer <= 1.5708"
            raise self._file.error(f"node {node}: {what} {cone[0]:g} to {cone[1]:g} rad; expected {wanted}")
        if abs(np.linalg.det(self._nodes.at(node, 0)[0][:3, :3])) < 1e-12:
            raise self._file.damaged(f"node {node}: a light in a node of size 0, which has no direction")
        motion = NodeMotion(self._nodes, node)
        placed = motion if self._nodes.moving[node] else Still(motion.state(0).pose)
        return Lamp(placed, tuple(light.tolist()), kind == "directional", cone if kind == "spot" else None)

    def move(self, world_from_file: Pose) -> None:
        self._nodes.root = world_from_file.matrix() @ self._nodes.root

    def _places(self) -> list[tuple[str, int, _Gltf]]:
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

    def _draft(self, name: str, node: int, primitive: _Gltf) -> Draft | None:
        file, user, attributes = self._file, f"mesh '{name}'", primitive["attributes"]
        rest = file.numbers(attributes["POSITION"], user, 3).astype(np.float64)
        triangles = _triangles(file, primitive, user, len(rest))
        nodes = file.items("nodes")
        rest = self._shaped(rest, nodes[node], primitive, user)
        bad = ~np.isfinite(rest).all(axis=1)
        if bad.any():
            at = int(np.argmax(bad))
            raise file.error(f"{user}: position {at} is not a finite number; export it again without it")
        look = self._looks.look_of(primitive, self._locked[node])
        if look is None or not len(triangles):
            return None
        uv = _uv(file, attributes, look, user, len(rest))
        colours = _vertex_colours(file, attributes, user, len(rest))
        if look.has_alpha and colours.shape[1] == 4 and (colours[:, 3] < 1).any():
            self.notes.add("the alpha of vertex colours is left out, drawn as 1", user)
        colour = look.colour * np.clip(np.nan_to_num(colours[:, :3]), 0, None)
        skin, extras = nodes[node].get("skin"), nodes[node].get("extras") or {}
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

    def _shaped(self, rest: Array, node: _Gltf, primitive: _Gltf, user: str) -> Array:
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
        self, rest: Array, node: int, skin: int | None, primitive: _Gltf, fixed: str
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


def _triangles(file: GltfFile, primitive: _Gltf, user: str, count: int) -> NDArray[np.uint32]:
    listed = "indices" in primitive
    indices = file.numbers(primitive["indices"], user, 1)[:, 0].astype(np.int64) if listed else np.arange(count)
    if len(indices) and (indices.max() >= count or indices.min() < 0):
        raise file.error(f"{user}: a triangle uses vertex {int(indices.max())} of {count}; the file is damaged")
    mode, ends = primitive.get("mode", _TRIANGLES), (indices[1:-1], indices[2:])
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3).astype(np.uint32)
    if len(indices) < 3:
        return np.empty((0, 3), np.uint32)
    if mode == _FAN:
        return np.column_stack([np.full(len(indices) - 2, indices[0]), *ends]).astype(np.uint32)
    strip = np.column_stack([indices[:-2], *ends])
    strip[1::2] = strip[1::2][:, [1, 0, 2]]  # every second one runs the other way round
    return strip.astype(np.uint32)


def _uv(file: GltfFile, attributes: _Gltf, look: Look, user: str, count: int) -> Array:
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


def _vertex_colours(file: GltfFile, attributes: _Gltf, user: str, count: int) -> Array:
    if "COLOR_0" not in attributes:
        return np.ones((count, 3))
    colours = _as_shares(file.numbers(attributes["COLOR_0"], user))
    if len(colours) != count or colours.shape[1] < 3:
        raise file.damaged(f"{user}: {count} positions and {colours.shape} colours")
    return colours


def _as_shares(values: NDArray[Any]) -> Array:
    """Return floats; integers count as normalised even where the file omits the flag."""
    return values / np.iinfo(values.dtype).max if values.dtype.kind in "iu" else values.astype(np.float64)
