"""Materials of a GLB: colour and texture of a surface, what it mirrors and what it lets through."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ._content import Material
from ._gltf_file import GltfFile, is_mirror
from ._mesh import Texture

Array = NDArray[np.float64]


@attrs.frozen(eq=False)
class Look:
    """Appearance of a primitive."""

    # (3,) linear.
    colour: Array
    # Index of its texture, -1 for none.
    texture: int
    material: Material
    double_sided: bool
    # Name of the attribute with its texture coordinates.
    texcoords: str


@attrs.frozen(eq=False)
class _Blend:
    alpha: float
    see_through: bool
    head_locked: bool
    colour: Array


class Looks:
    """Looks of all materials of a file, each made once, and the textures they use."""

    def __init__(self, file: GltfFile, notes: list[str]) -> None:
        self._file, self._notes = file, notes
        self._made: dict[tuple, Look | None] = {}
        self.textures: list[Texture] = []

    def look_of(self, primitive: dict, head_locked: bool) -> Look | None:
        """Return the look of a primitive; None if it is wholly cut away."""
        key = (primitive.get("material"), head_locked)
        if key not in self._made:
            material = self._file.item("materials", key[0], "a mesh") if key[0] is not None else {}
            self._made[key] = self._look(material, f"material '{material.get('name') or key[0]}'", head_locked)
        return self._made[key]

    def _look(self, gltf: dict, name: str, head_locked: bool) -> Look | None:
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
        texture = self._add(name, image, srgb=True)
        colour = np.clip(factor[:3], 0, None)
        return Look(colour, texture, material, bool(gltf.get("doubleSided")), f"TEXCOORD_{base.get('texCoord', 0)}")

    def _material(self, gltf: dict, name: str, blend: _Blend) -> Material:
        if blend.head_locked:
            return Material(head_locked=True, opacity=blend.alpha)
        extensions, extras = (gltf.get(key) or {} for key in ("extensions", "extras"))
        passes = self._transmission(gltf, name, extensions.get("KHR_materials_transmission") or {})
        reflectivity = self._reflectivity(gltf, name, blend.colour)
        if passes > 0 or blend.see_through:
            if reflectivity:
                self._notes.append(f"{self._file.path}: {name} mirrors and is see-through; it does not mirror")
            return Material(see_through=True, opacity=blend.alpha, transmission=passes)
        if not reflectivity:
            return Material()
        image = self._image(gltf.get("normalTexture") or {}, name, channels=3)
        normal_map = self._add(f"{name}-normal", image, srgb=False)
        return Material(reflectivity=reflectivity, normal_map=normal_map, curved=bool(extras.get("curved", False)))

    def _transmission(self, gltf: dict, name: str, glass: dict) -> float:
        """Return the share of light that passes where the surface covers: none of what is metal.

        The blend of alpha is apart from it: what alpha does not cover passes untouched.
        Source: Khronos 2021, KHR_materials_transmission; glTF 2.0 Specification, B.2 (materials).
        """
        passes = float(np.clip(glass.get("transmissionFactor", 0.0), 0, 1))
        if not passes:
            return 0.0
        if "transmissionTexture" in glass:
            self._notes.append(
                f"{self._file.path}: {name} has a transmission texture; drawn with its factor everywhere"
            )
        surface = gltf.get("pbrMetallicRoughness") or {}
        image = self._image(surface.get("metallicRoughnessTexture") or {}, name, channels=3)
        metal = float(np.clip(surface.get("metallicFactor", 1.0), 0, 1))
        metal *= 1.0 if image is None else float(image[..., 2].mean()) / 255
        if metal == 1:
            self._notes.append(f"{self._file.path}: {name} transmits light but is a metal; no light passes it")
        return passes * (1 - metal)

    def _reflectivity(self, gltf: dict, name: str, colour: Array) -> float:
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
        if "KHR_texture_transform" in (info.get("extensions") or {}):
            self._notes.append(
                f"{self._file.path}: {name} shifts or scales its texture (KHR_texture_transform); drawn without"
            )
        try:
            return self._file.image(texture.get("source"), name)[..., :channels]
        except SceneError as error:
            self._notes.append(f"{error}; drawn plain")
            return None

    def _add(self, name: str, image: NDArray[np.uint8] | None, *, srgb: bool) -> int:
        if image is None:
            return -1
        self.textures.append(Texture(name, image, srgb=srgb))
        return len(self.textures) - 1


def _cut(image: NDArray[np.uint8], alpha: float, cutoff: float) -> NDArray[np.uint8]:
    out = image.copy()
    out[..., 3] = np.where(image[..., 3] / 255 * alpha >= cutoff, 255, 0)
    return out
