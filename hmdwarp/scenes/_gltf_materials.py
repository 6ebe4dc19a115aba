"""What the materials of a GLB say of a surface: how it looks, whether it mirrors, what it lets through."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ._content import Material
from ._gltf_file import GltfFile, is_mirror
from ._model import Texture

if TYPE_CHECKING:
    from ._gltf_scene import RichParts

Array = NDArray[np.float64]


@attrs.frozen(eq=False)
class Look:
    """How a primitive looks: linear colour (3,), texture and normal map by index (-1: none), material."""

    colour: Array
    texture: int
    material: Material
    double_sided: bool
    texcoords: str


def look_of(file: GltfFile, parts: RichParts, looks: dict, primitive: dict, locked: bool) -> Look | None:
    """How a primitive looks; None for what is wholly cut away."""
    key = (primitive.get("material"), locked)
    if key not in looks:
        told = file.one("materials", key[0], "a mesh") if key[0] is not None else {}
        looks[key] = _look(file, parts, told, f"material '{told.get('name') or key[0]}'", locked)
    return looks[key]


def _look(file: GltfFile, parts: RichParts, told: dict, name: str, locked: bool) -> Look | None:
    plain = told.get("pbrMetallicRoughness") or {}
    factor = np.array(plain.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0)), np.float64)
    if factor.shape != (4,) or not np.isfinite(factor).all():
        raise file.wrong(
            f"{name}: base colour {plain.get('baseColorFactor')!r} is not four finite numbers; export it again"
        )
    mode, base = told.get("alphaMode", "OPAQUE"), plain.get("baseColorTexture") or {}
    image = _image(file, parts, base, name)
    alpha = float(np.clip(factor[3], 0, 1)) if mode != "OPAQUE" else 1.0
    if mode == "MASK":
        cutoff = float(told.get("alphaCutoff", 0.5))
        if image is None and alpha < cutoff:
            return None
        image, alpha = (None if image is None else _cut(image, alpha, cutoff)), 1.0
    elif mode != "BLEND" and image is not None:
        image = image[..., :3]
    # What is cut out of nothing, or blended without letting anything pass, is a surface like any other.
    sees_through = mode in ("MASK", "BLEND") and (
        alpha < 1 or (image is not None and image.shape[2] == 4 and image[..., 3].min() < 255)
    )
    material = _material(file, parts, told, name, _Asked(alpha, sees_through, locked, factor[:3]))
    texture = _filed(parts, name, image, srgb=True)
    shown = np.clip(factor[:3], 0, None)
    return Look(shown, texture, material, bool(told.get("doubleSided")), f"TEXCOORD_{base.get('texCoord', 0)}")


@attrs.frozen(eq=False)
class _Asked:
    alpha: float
    sees_through: bool
    locked: bool
    colour: Array


def _material(file: GltfFile, parts: RichParts, told: dict, name: str, asked: _Asked) -> Material:
    if asked.locked:
        return Material(head_locked=True, opacity=asked.alpha)
    extensions, extras = (told.get(key) or {} for key in ("extensions", "extras"))
    passes = float(np.clip((extensions.get("KHR_materials_transmission") or {}).get("transmissionFactor", 0.0), 0, 1))
    reflects = _reflectivity(file, told, name, asked.colour)
    if passes > 0 or asked.sees_through:
        if reflects:
            parts.notes.append(f"{file.path}: {name} mirrors and is see-through; it does not mirror")
        tint = tuple(np.clip(asked.colour, 0, 1)) if passes > 0 else (1.0, 1.0, 1.0)
        return Material(see_through=True, opacity=asked.alpha * (1 - passes), tint=tint)
    if not reflects:
        return Material()
    normal = _filed(
        parts, f"{name}-normal", _image(file, parts, told.get("normalTexture") or {}, name, channels=3), srgb=False
    )
    return Material(reflectivity=reflects, normal_map=normal, curved=bool(extras.get("curved", False)))


def _reflectivity(file: GltfFile, told: dict, name: str, colour: Array) -> float:
    """What the file says by `reflectivity` in a material's extras; else that of a polished metal, whose base colour it is."""
    said = (told.get("extras") or {}).get("reflectivity")
    if said is None:
        return float(np.clip(colour, 0, 1).mean()) if is_mirror(told) else 0.0
    if not isinstance(said, int | float) or not 0 <= said <= 1:
        raise file.wrong(f"{name}: reflectivity {said!r} in its extras; wanted a share of 0 to 1")
    return float(said)


def _image(file: GltfFile, parts: RichParts, told: dict, name: str, channels: int = 4) -> NDArray[np.uint8] | None:
    """(h, w, channels) bytes; None, with a note, for a picture that cannot be read."""
    if "index" not in told:
        return None
    texture = file.one("textures", told["index"], name)
    if "KHR_texture_transform" in (told.get("extensions") or {}):
        parts.notes.append(f"{file.path}: {name} shifts or scales its texture (KHR_texture_transform); drawn without")
    try:
        return file.image(texture.get("source"), name)[..., :channels]
    except SceneError as error:
        parts.notes.append(f"{error}; drawn plain")
        return None


def _cut(image: NDArray[np.uint8], alpha: float, cutoff: float) -> NDArray[np.uint8]:
    out = image.copy()
    out[..., 3] = np.where(image[..., 3] / 255 * alpha >= cutoff, 255, 0)
    return out


def _filed(parts: RichParts, name: str, image: NDArray[np.uint8] | None, *, srgb: bool) -> int:
    if image is None:
        return -1
    parts.textures.append(Texture(name, image, srgb=srgb))
    return len(parts.textures) - 1
