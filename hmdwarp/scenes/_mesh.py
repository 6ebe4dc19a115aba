"""Textures, materials and meshes in plain arrays, checked once, and how bodies and cloth move."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any, Protocol

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import NO_NUMBERS, SceneError
from ..geometry import RigidState

_NO_TINT = (1.0, 1.0, 1.0)


def _rgb(value: Iterable[float]) -> tuple[float, ...]:
    return tuple(map(float, value))


@attrs.frozen
class Material:
    """Surface properties besides baked light. Errors: SceneError for shares outside 0..1."""

    reflectivity: float = 0.0  # share mirrored at normal incidence, to 1 at grazing angles (Schlick 1994)
    curved: bool = False  # a mirror that is not a plane
    normal_map: int = -1  # index of a linear texture of tangent-space normals that disturb the reflection, or -1
    normal_scale: float = 1.0  # factor on the x and y of the normals, as glTF's normalTexture.scale
    see_through: bool = False  # covers what lies behind by opacity times the texture's alpha
    opacity: float = 1.0
    head_locked: bool = False  # in head axes, metres from between the eyes; drawn over everything, never warped
    # Share of the light that passes where a see-through surface covers, coloured by its texture and
    # the mesh's albedo as by coloured glass; the rest is scattered or stopped.
    transmission: float = 0.0
    # Share of each linear colour that passes where a see-through surface does not cover.
    tint: tuple[float, ...] = attrs.field(default=_NO_TINT, converter=_rgb)

    def __attrs_post_init__(self) -> None:
        for name in ("reflectivity", "opacity", "transmission"):
            if not 0 <= getattr(self, name) <= 1:
                raise SceneError(f"material with {name} {getattr(self, name):g}: expected 0 to 1")
        wrong = ""
        if not self.reflectivity and (self.curved or self.normal_map >= 0):
            wrong = "a normal map or a curved mirror, but reflectivity 0: set a reflectivity or remove them"
        elif len(self.tint) != 3 or not all(0 <= share <= 1 for share in self.tint):
            wrong = f"tint {self.tint}: expected three shares, each 0 to 1"
        elif (self.tint != _NO_TINT or self.transmission) and not self.see_through:
            wrong = "a tint or transmission but no light passing through: make it see_through or omit them"
        if wrong:
            raise SceneError(f"material with {wrong}")
        if self.see_through and self.head_locked:
            raise SceneError("material both see-through and head-locked: head-locked surfaces already use the opacity")
        if self.reflectivity and (self.see_through or self.head_locked):
            raise SceneError("material that mirrors and is see-through or head-locked: expected one of these")


class Motion(Protocol):
    """Motion of a rigid body: a pure function of the scene's clock."""

    def state(self, time_ns: int) -> RigidState:
        """Return the pose and its derivatives at `time_ns`."""


class Brightness(Protocol):
    """How bright a lamp is: a function of the scene's clock."""

    def share(self, time_ns: int) -> float:
        """Return the share of its colour that it sends, 0 or more."""


@attrs.frozen(eq=False)
class Body:
    """A rigid body; meshes belong to it by number."""

    name: str
    motion: Motion

    def lit_as(self, time_ns: int) -> bytes:
        """Return what tells its light and shadow of an instant from those of others."""
        return self.motion.state(time_ns).pose.matrix().tobytes()


class Deformation(Protocol):
    """Motion of each vertex of one mesh, such as a flag: a pure function of the scene's clock."""

    def positions(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 3) metres relative to the scene's origin."""

    def velocities(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 3) m/s in world axes."""


# Texels count as fully transparent or opaque within this many bytes of 0 and 255. A cut-out has at
# most this share of texels in between, at its edges.
ALPHA_TOLERANCE, MOST_EDGES = 12, 0.08


def _rows(value: ArrayLike, dtype: type, columns: int) -> NDArray[Any]:
    """Return a read-only (n, columns) array."""
    array: NDArray[Any] = np.ascontiguousarray(value, dtype=dtype)
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


@attrs.frozen(eq=False)
class Emission:
    """Light of a surface's own, which is drawn on top of what the light shows."""

    image: NDArray[np.uint8]  # (h, w, 3) sRGB, top row first, on the texture coordinates of its texture
    factor: tuple[float, ...] = attrs.field(converter=_rgb)  # linear, 0 or more, times the image
    repeat: bool = True  # as of a texture


@attrs.define(eq=False, frozen=True, slots=False)
class Texture:
    """An image on a surface. Errors: SceneError."""

    name: str
    # What `image` returns, or what paints it when it is first used: a plan needs no pictures.
    _source: NDArray[np.uint8] | Callable[[], NDArray[np.uint8]] = attrs.field(alias="image")
    srgb: bool = True  # values are sRGB, else linear
    repeat: bool = True  # wraps around outside 0..1, else its border is continued
    emission: Emission | None = None  # what shines on the surfaces that have this texture

    def __attrs_post_init__(self) -> None:
        if not callable(self._source):
            self.image  # noqa: B018 (raises at once if it cannot be used)

    @cached_property
    def image(self) -> NDArray[np.uint8]:
        """(h, w, 3 or 4) uint8, top row first; the server adds mipmaps."""
        try:
            image = np.asarray(self._source() if callable(self._source) else self._source)
        except NO_NUMBERS as error:
            raise SceneError(f"texture '{self.name}': expected (h, w, 3 or 4) uint8: {error}") from error
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] not in (3, 4) or 0 in image.shape:
            raise SceneError(f"texture '{self.name}': expected (h, w, 3 or 4) uint8, found {image.shape} {image.dtype}")
        return image


@attrs.frozen(eq=False)
class Mesh:
    """Triangles with one texture and one material; the server draws texture x light.

    Errors: SceneError for arrays of the wrong shape or not finite, and for what cannot be drawn.
    """

    name: str
    # (n, 3) metres relative to the scene's origin; in the frame of its body if it belongs to one;
    # at rest if it deforms.
    positions: NDArray[np.float32] = attrs.field(converter=_triples)
    normals: NDArray[np.float32] = attrs.field(converter=_triples)  # (n, 3) unit vectors, in the same axes
    uv: NDArray[np.float32] = attrs.field(converter=_pairs)  # (n, 2), origin bottom left, +v up
    light: NDArray[np.float32] = attrs.field(converter=_triples)  # (n, 3) baked linear light times colour, 0 or more
    # (m, 3) indices, counter-clockwise seen from the front
    triangles: NDArray[np.uint32] = attrs.field(converter=_indices)
    texture: int = -1  # index into the scene's textures, -1 for white
    double_sided: bool = False
    material: Material = Material()
    body: int = 0  # 0 for what stands still, else 1 + index into the scene's bodies
    deformation: Deformation | None = None
    # (n, 3) linear colour of the material alone: `light` under light of 1. None if unknown.
    albedo: NDArray[np.float32] | None = attrs.field(default=None, converter=attrs.converters.optional(_triples))
    # (n, 2) texels of the scene's light atlas. With them the scene's lamps light it instead of
    # `light`, and it stops their light, wherever its body is; without, it shines by `light` and
    # stops nothing.
    light_uv: NDArray[np.float32] | None = attrs.field(default=None, converter=attrs.converters.optional(_pairs))

    def __attrs_post_init__(self) -> None:
        count = len(self.positions)
        for field in ("positions", "normals", "uv", "light", "albedo", "light_uv"):
            array: NDArray[Any] | None = getattr(self, field)
            if array is None:
                continue
            if len(array) != count:
                raise SceneError(f"mesh '{self.name}': {count} positions but {len(array)} {field}")
            if (bad := ~np.isfinite(array).all(axis=1)).any():
                raise SceneError(f"mesh '{self.name}': {field} of vertex {int(np.argmax(bad))} are not finite numbers")
        if self.triangles.size and (most := int(self.triangles.max())) >= count:
            raise SceneError(f"mesh '{self.name}': a triangle uses vertex {most}, but there are only {count}")
        if self.body and self.deformation is not None:
            raise SceneError(f"mesh '{self.name}' belongs to body {self.body} and deforms by itself: expected only one")

    @property
    def is_surface(self) -> bool:
        return not (self.material.see_through or self.material.head_locked)

    @property
    def stands_still(self) -> bool:
        return not self.body and self.deformation is None


CHUNK_TRIANGLES = 1024


def chunks_of(mesh: Mesh) -> list[NDArray[np.uint32]]:
    """Return the mesh's triangles in compact pieces of at most CHUNK_TRIANGLES."""
    triangles = mesh.triangles
    if len(triangles) <= CHUNK_TRIANGLES:
        return [triangles] if len(triangles) else []
    order = np.argsort(morton(mesh.positions[triangles].mean(axis=1)), kind="stable")
    return np.array_split(triangles[order], -(-len(triangles) // CHUNK_TRIANGLES))


def morton(points: NDArray[Any]) -> NDArray[np.uint64]:
    """Return the Z-order of points, 10 bits per axis: close in order is close in space."""
    low, high = points.min(axis=0), points.max(axis=0)
    cell = ((points - low) / max(float((high - low).max()), 1e-30) * 1023).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cell[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return code


Triple = tuple[float, float, float]


@attrs.frozen
class Quad:
    """A parallelogram, front along right x up; corners (-,-), (+,-), (+,+), (-,+) of both."""

    centre: Triple  # metres
    right: Triple  # half edges, metres
    up: Triple
    texture: int = 0
    light: Triple = (1.0, 1.0, 1.0)
    repeats: tuple[float, float] = (1.0, 1.0)  # uv runs from 0 to this over the quad

    @property
    def normal(self) -> NDArray[np.float64]:
        across = np.cross(self.right, self.up)
        return across / np.linalg.norm(across)

    def mesh(self, name: str) -> Mesh:
        """Return two triangles, seen from both sides."""
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float64)
        places = np.array(self.centre) + signs[:, :1] * np.array(self.right) + signs[:, 1:] * np.array(self.up)
        normals, light = np.tile(self.normal, (4, 1)), np.tile(self.light, (4, 1))
        uv, two = (signs + 1) / 2 * self.repeats, [(0, 1, 2), (0, 2, 3)]
        return Mesh(name, places, normals, uv, light, two, self.texture, double_sided=True, albedo=light)


@attrs.frozen
class Ball:
    """A sphere with a texture around it, lit from above."""

    centre: Triple  # metres
    radius: float
    texture: int = 0
    colour: Triple = (1.0, 1.0, 1.0)

    def mesh(self, name: str, rings: int = 48) -> Mesh:
        """Return a grid of `rings` x 2 `rings` cells, with vertices on the sphere."""
        theta = np.linspace(0, np.pi, rings + 1)
        phi = np.linspace(0, 2 * np.pi, 2 * rings + 1)
        tt, pp = np.meshgrid(theta, phi, indexing="ij")
        normals = np.stack([np.sin(tt) * np.sin(pp), np.cos(tt), np.sin(tt) * np.cos(pp)], axis=-1).reshape(-1, 3)
        corner = (np.arange(rings)[:, None] * len(phi) + np.arange(2 * rings)).ravel()
        down, across_down = corner + len(phi), corner + len(phi) + 1
        triangles = np.stack([corner, down, across_down, corner, across_down, corner + 1], axis=1).reshape(-1, 3)
        uv = np.stack([pp / (2 * np.pi) * 2, 1 - tt / np.pi], axis=-1).reshape(-1, 2)
        places, albedo = np.array(self.centre) + self.radius * normals, np.tile(self.colour, (len(normals), 1))
        light = np.array(self.colour) * (0.55 + 0.45 * normals[:, 1:2])
        return Mesh(name, places, normals, uv, light, triangles, self.texture, albedo=albedo)


def checker(
    cells: int, cell_px: int, dark: tuple[int, int, int], bright: tuple[int, int, int], seed: int
) -> NDArray[np.uint8]:
    """Return a (n, n, 3) checkerboard with noise, so that no two places look alike.

    Parameters
    ----------
    cells, cell_px : int
        Fields on each side, and pixels on each side of one: n is their product.
    dark, bright : tuple of int
        sRGB, 0 to 255.
    seed : int
        Of the noise.
    """
    index = np.arange(cells * cell_px) // cell_px
    board = ((index[:, None] + index) % 2)[..., None]
    noise = np.random.default_rng(seed).integers(-24, 25, (len(index), len(index), 1))
    return np.clip(np.where(board, bright, dark) + noise, 0, 255).astype(np.uint8)
