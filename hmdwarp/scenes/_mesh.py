"""Textures and meshes: plain arrays, checked once when they are made."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from ._content import Deformation, Material

# Texels count as fully transparent or opaque within this many bytes of 0 and 255. A cut-out has at
# most this share of texels in between, at its edges.
ALPHA_TOLERANCE, MOST_EDGES = 12, 0.08


def _rows(value: ArrayLike, dtype: type, columns: int) -> NDArray:
    """Return a read-only (n, columns) array."""
    array: NDArray = np.ascontiguousarray(value, dtype=dtype)
    if array.ndim != 2 or array.shape[1] != columns:
        raise SceneError(f"expected an (n, {columns}) array, found shape {array.shape}")
    array = array.view()
    array.flags.writeable = False
    return array


def _pairs(value: ArrayLike) -> NDArray[np.float32]:
    return _rows(value, np.float32, 2)


def _triples(value: ArrayLike) -> NDArray[np.float32]:
    return _rows(value, np.float32, 3)


def _indices(value: ArrayLike) -> NDArray[np.uint32]:
    return _rows(value, np.uint32, 3)


@attrs.define(eq=False, frozen=True, slots=False)
class Texture:
    """An image on a surface.

    Errors: SceneError for a wrong shape or type; of a painter's image where it is first used.
    """

    name: str
    # What `image` returns, or what paints it when it is first used: a plan needs no pictures.
    _source: NDArray[np.uint8] | Callable[[], NDArray[np.uint8]] = attrs.field(alias="image")
    # Values are sRGB, else linear.
    srgb: bool = True
    # Wraps around outside 0..1, else its border is continued.
    repeat: bool = True

    def __attrs_post_init__(self) -> None:
        if not callable(self._source):
            self.image  # noqa: B018 (raises at once if it cannot be used)

    @cached_property
    def image(self) -> NDArray[np.uint8]:
        """(h, w, 3 or 4) uint8, top row first; the server adds mipmaps."""
        image = self._source() if callable(self._source) else self._source
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] not in (3, 4) or 0 in image.shape:
            raise SceneError(f"texture '{self.name}': expected (h, w, 3 or 4) uint8, found {image.shape} {image.dtype}")
        return image


@attrs.frozen(eq=False)
class Mesh:
    """Triangles with one texture and one material; the server draws texture x light.

    Errors: SceneError for arrays of the wrong shape, values that are not finite, indices beyond the
    vertices, and a mesh that both belongs to a body and deforms.
    """

    name: str
    # (n, 3) metres relative to the scene's origin; in the frame of its body if it belongs to one;
    # at rest if it deforms.
    positions: NDArray[np.float32] = attrs.field(converter=_triples)
    # (n, 3) unit vectors, in the same axes.
    normals: NDArray[np.float32] = attrs.field(converter=_triples)
    # (n, 2), origin bottom left, +v up.
    uv: NDArray[np.float32] = attrs.field(converter=_pairs)
    # (n, 3) baked linear light times colour, 0 or more.
    light: NDArray[np.float32] = attrs.field(converter=_triples)
    # (m, 3) indices, counter-clockwise seen from the front.
    triangles: NDArray[np.uint32] = attrs.field(converter=_indices)
    # Index into the scene's textures, -1 for white.
    texture: int = -1
    double_sided: bool = False
    material: Material = Material()
    # 0 for what stands still, else 1 + index into the scene's bodies.
    body: int = 0
    deformation: Deformation | None = None
    # (n, 3) linear colour of the material alone: `light` under light of 1. None if unknown.
    albedo: NDArray[np.float32] | None = attrs.field(default=None, converter=attrs.converters.optional(_triples))
    # (n, 2) texels of the scene's light atlas. With them the scene's lamps light it instead of
    # `light`, and it stops their light, wherever its body is; without, it shines by `light` and
    # stops nothing.
    light_uv: NDArray[np.float32] | None = attrs.field(default=None, converter=attrs.converters.optional(_pairs))

    def __attrs_post_init__(self) -> None:
        count = len(self.positions)
        optional = [name for name in ("albedo", "light_uv") if getattr(self, name) is not None]
        for field in ("positions", "normals", "uv", "light", *optional):
            array: NDArray[Any] = getattr(self, field)
            if len(array) != count:
                raise SceneError(f"mesh '{self.name}': {count} positions but {len(array)} {field}")
            bad = ~np.isfinite(array).all(axis=1)
            if bad.any():
                raise SceneError(f"mesh '{self.name}': {field} of vertex {int(np.argmax(bad))} are not finite numbers")
        if self.triangles.size and int(self.triangles.max()) >= count:
            raise SceneError(
                f"mesh '{self.name}': a triangle uses vertex {int(self.triangles.max())}, but there are only {count}"
            )
        if self.body and self.deformation is not None:
            raise SceneError(f"mesh '{self.name}' belongs to body {self.body} and deforms by itself: expected only one")

    @property
    def is_surface(self) -> bool:
        """Whether it stands in the world and hides what is behind it."""
        return not (self.material.see_through or self.material.head_locked)

    @property
    def stands_still(self) -> bool:
        """Whether it belongs to no body and does not deform."""
        return not self.body and self.deformation is None
