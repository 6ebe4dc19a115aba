"""Materials of a glTF file as looks: base colour, emission, alpha, glass and mirrors.

Those of specular and glossiness become those of metal and roughness, which glTF has today.
Source: Khronos 2017, KHR_materials_pbrSpecularGlossiness, its example of a conversion between the
two (https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Archived).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb, srgb8_from_linear
from ..errors import SceneError
from ._draft import Look
from ._gltf_file import KTX2, SPECULAR, GltfFile
from ._mesh import Emission, Material, Texture
from ._notes import Notes

Array = NDArray[np.float64]

Image = NDArray[np.uint8] | None
_DIELECTRIC = 0.04  # the specular colour of every glTF material that is not a metal
_BRIGHTNESS = np.array([0.299, 0.587, 0.114])


def as_metal(
    found: dict[str, Any], diffuse_image: Image, specular_image: Image
) -> tuple[dict[str, Any], NDArray[np.uint8] | None]:
    """Return `pbrMetallicRoughness` and the picture of its base colour, None for none.

    found: the extension of a material, with the (h, w, 4) pictures that it names, None for none;
    that of specular colour is scaled to the other's size.
    """
    factor = np.array(found.get("diffuseFactor", (1.0, 1.0, 1.0, 1.0)), np.float64)
    specular = np.array(found.get("specularFactor", (1.0, 1.0, 1.0)), np.float64)
    if factor.shape != (4,) or specular.shape != (3,):
        return {"baseColorFactor": found.get("diffuseFactor")}, None  # refused as any wrong base colour
    size = next((image.shape[:2] for image in (diffuse_image, specular_image) if image is not None), (1, 1))
    base, metallic = _base_of(factor[:3] * _linear(diffuse_image, size), specular * _linear(specular_image, size))
    rough = 1 - float(found.get("glossinessFactor", 1.0))
    surface: dict[str, Any] = {"metallicFactor": float(metallic.mean()), "roughnessFactor": rough}
    if specular_image is not None:
        surface["roughnessFactor"] = max(rough, 0.5)  # rough here and there, so never a mirror
    if diffuse_image is None and specular_image is None:
        return surface | {"baseColorFactor": [*base[0, 0].tolist(), factor[3]]}, None
    alpha = np.full((*size, 1), 255, np.uint8) if diffuse_image is None else diffuse_image[..., 3:]
    image = np.concatenate([srgb8_from_linear(base), alpha], axis=2)
    return surface | {"baseColorFactor": [1.0, 1.0, 1.0, factor[3]]}, image


def _linear(image: Image, size: tuple[int, int]) -> Array:
    """Return the linear colours of a picture at that size, (1, 1, 3) of 1 without one."""
    from PIL import Image as Pictures

    if image is None:
        return np.ones((1, 1, 3))
    if image.shape[:2] != size:
        image = np.asarray(Pictures.fromarray(image).resize(size[::-1], Pictures.Resampling.BILINEAR))
    return linear_from_srgb(image[..., :3]).astype(np.float64)


def _base_of(diffuse: Array, specular: Array) -> tuple[Array, Array]:
    """Return base colour (h, w, 3) and how much is metal (h, w, 1)."""
    diffuse, specular = np.broadcast_arrays(diffuse, specular)
    left = 1 - specular.max(axis=2, keepdims=True)
    # The share of metal at which both brightnesses come out.
    b = _bright(diffuse) * left / (1 - _DIELECTRIC) + (bright := _bright(specular)) - 2 * _DIELECTRIC
    root = np.sqrt(np.maximum(b**2 - 4 * _DIELECTRIC * (_DIELECTRIC - bright), 0))
    metallic = np.where(bright < _DIELECTRIC, 0.0, np.clip((root - b) / (2 * _DIELECTRIC), 0, 1))
    of_diffuse = diffuse * left / (1 - _DIELECTRIC) / np.maximum(1 - metallic, 1e-6)
    of_specular = (specular - _DIELECTRIC * (1 - metallic)) / np.maximum(metallic, 1e-6)
    share = metallic**2
    return np.clip(of_diffuse * (1 - share) + of_specular * share, 0, 1), metallic


def _bright(colour: Array) -> Array:
    return np.asarray(np.sqrt((colour**2 @ _BRIGHTNESS)[..., None]))


_WHITE = np.full((1, 1, 3), 255, np.uint8)
_REPEAT, _CLAMP = 10497, 33071  # wrapS and wrapT of a sampler


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
        gltf, image = self._surface(gltf, name)
        plain = gltf.get("pbrMetallicRoughness") or {}
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
        return Look(
            np.clip(factor[:3], 0, None),
            texture,
            material,
            bool(gltf.get("doubleSided")),
            coordinates,
            self._uv_transform(transform, name),
            "KHR_materials_unlit" in (gltf.get("extensions") or {}),
            glow if emission is None else np.zeros(3),
        )

    def _surface(self, gltf: dict[str, Any], name: str) -> tuple[dict[str, Any], NDArray[np.uint8] | None]:
        """Return the material by metal and roughness, and the picture of its base colour."""
        found = (gltf.get("extensions") or {}).get(SPECULAR)
        if found is None:
            return gltf, self._image((gltf.get("pbrMetallicRoughness") or {}).get("baseColorTexture") or {}, name)
        infos = [found.get(key) or {} for key in ("diffuseTexture", "specularGlossinessTexture")]
        images = [self._image(info, name) for info in infos]
        if all(image is not None for image in images) and _place_of(infos[0]) != _place_of(infos[1]):
            self._notes.add("a specular picture with texture coordinates of its own is drawn at its mean", name)
            images[1] = _mean_of(images[1])
        surface, image = as_metal(found, images[0], images[1])
        info = next((info for info, one in zip(infos, images, strict=True) if one is not None), {})
        return gltf | {"pbrMetallicRoughness": surface | {"baseColorTexture": info}}, image

    def _emission(
        self, gltf: dict[str, Any], name: str, material: Material, base: dict[str, Any], *, is_pictured: bool
    ) -> tuple[Array, dict[str, Any], Emission | None]:
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

    def _uv_transform(self, found: dict[str, Any], name: str) -> Array:
        """Return (3, 3) of KHR_texture_transform."""
        (x, y), (across, down) = found.get("offset", (0.0, 0.0)), found.get("scale", (1.0, 1.0))
        sine, cosine = np.sin(found.get("rotation", 0.0)), np.cos(found.get("rotation", 0.0))
        matrix = np.array([(cosine * across, sine * down, x), (-sine * across, cosine * down, y), (0, 0, 1)])
        if not np.isfinite(matrix).all():
            raise self._file.damaged(f"{name}: its KHR_texture_transform is not made of finite numbers")
        return matrix

    def _material(self, gltf: dict[str, Any], name: str, alpha: float, colour: Array, *, see_through: bool) -> Material:
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
        return Material(
            reflectivity=reflectivity,
            normal_map=normal_map,
            normal_scale=float(bumps.get("scale", 1.0)),
            curved=bool((gltf.get("extras") or {}).get("curved", False)),
        )

    def _transmission(self, gltf: dict[str, Any], name: str) -> float:
        """Return the share of light that passes where the surface covers: none of what is metal.

        The blend of alpha is apart from it: what alpha does not cover passes untouched.
        Source: Khronos 2021, KHR_materials_transmission; glTF 2.0 Specification, B.2 (materials).
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

    def _reflectivity(self, gltf: dict[str, Any], name: str, colour: Array) -> float:
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

    def _add(
        self, name: str, image: NDArray[np.uint8] | None, *, srgb: bool, repeat: bool, emission: Emission | None = None
    ) -> int:
        if image is None and emission is None:
            return -1
        self.textures.append(Texture(name, _WHITE if image is None else image, srgb, repeat, emission))
        return len(self.textures) - 1


def _place_of(info: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the attribute with a picture's texture coordinates, and its KHR_texture_transform."""
    transform = (info.get("extensions") or {}).get("KHR_texture_transform") or {}
    number = transform.get("texCoord", info.get("texCoord", 0))
    return f"TEXCOORD_{number}", {key: value for key, value in transform.items() if key != "texCoord"}


def _mean_of(image: NDArray[np.uint8] | None) -> NDArray[np.uint8]:
    """Return one pixel: the mean of an sRGB picture in linear light."""
    assert image is not None
    return srgb8_from_linear(linear_from_srgb(image).mean(axis=(0, 1), keepdims=True))
