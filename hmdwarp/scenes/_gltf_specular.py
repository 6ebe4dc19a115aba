"""Materials of specular and glossiness as those of metal and roughness, which glTF has today.

Source: Khronos 2017, KHR_materials_pbrSpecularGlossiness, its example of a conversion between the
two (https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Archived).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb, srgb8_from_linear

SPECULAR = "KHR_materials_pbrSpecularGlossiness"
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
    metallic = _metallic(_bright(diffuse), _bright(specular), left)
    of_diffuse = diffuse * left / (1 - _DIELECTRIC) / np.maximum(1 - metallic, 1e-6)
    of_specular = (specular - _DIELECTRIC * (1 - metallic)) / np.maximum(metallic, 1e-6)
    share = metallic**2
    return np.clip(of_diffuse * (1 - share) + of_specular * share, 0, 1), metallic


def _bright(colour: Array) -> Array:
    return np.asarray(np.sqrt((colour**2 @ _BRIGHTNESS)[..., None]))


def _metallic(diffuse: Array, specular: Array, left: Array) -> Array:
    """Return the share of metal at which both brightnesses come out."""
    b = diffuse * left / (1 - _DIELECTRIC) + specular - 2 * _DIELECTRIC
    root = np.sqrt(np.maximum(b**2 - 4 * _DIELECTRIC * (_DIELECTRIC - specular), 0))
    found = np.clip((root - b) / (2 * _DIELECTRIC), 0, 1)
    return np.asarray(np.where(specular < _DIELECTRIC, 0.0, found))
