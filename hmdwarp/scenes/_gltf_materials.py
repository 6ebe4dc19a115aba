"""Materials of a glTF file: colour and texture of a surface, what it mirrors, what it lets pass."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ._content import Material
from ._draft import Look
from ._gltf_extensions import KTX2
from ._gltf_file import GltfFile, is_mirror
from ._mesh import Texture
from ._notes import Notes

Array = NDArray[np.float64]
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
        self._made: dict[tuple, Look | None] = {}
        self.textures: list[Texture] = []

    def look_of(self, primitive: dict, head_locked: bool) -> Look | None:
        """Return the look of a primitive; None if it is wholly cut away."""
        key = (primitive.get("material"), head_locked)
        if key not in self._made:
            material = self._file.item("materials", key[0], "a mesh") if key[0] is not None else {}
            self._made[key] = self._look(material, f"material '{material.get('name') or key[0]}'", head_locked)
        return self._made[key]

    def has_alpha(self, primitive: dict) -> bool:
        """Return whether alpha counts in a primitive's material."""
        number = primitive.get("material")
        return number is not None and self._file.items("materials")[number].get("alphaMode", "OPAQUE") != "OPAQUE"

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

    def _material(self, gltf: dict, name: str, blend: _Blend) -> Material:
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

    def _transmission(self, gltf: dict, name: str, glass: dict) -> float:
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
