"""What a scene is made of: plain float32 arrays, checked once when they are put together."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from ..geometry import Pose
from ..registry import Registry
from ._content import Body, Deformation, Material
from .effects import SceneEffect

if TYPE_CHECKING:
    from ._mirrors import SceneMirror

Array = NDArray


def _frozen(dtype: type, columns: int) -> Callable[[ArrayLike], Array]:
    def convert(value: ArrayLike) -> Array:
        array = np.ascontiguousarray(value, dtype=dtype)
        if array.ndim != 2 or array.shape[1] != columns:
            raise SceneError(f"wanted an (n, {columns}) array, found shape {array.shape}")
        array = array.view()
        array.flags.writeable = False
        return array

    return convert


def _frozen_vector(value: ArrayLike) -> Array:
    array = np.array(value, dtype=np.float64).reshape(3)
    array.flags.writeable = False
    return array


@attrs.frozen(eq=False)
class Texture:
    """A picture on a surface: `image` (h, w, 3 or 4) uint8, top row first; `srgb` says whether its values are sRGB or linear.

    `repeat`: wraps around outside 0..1, else its border is continued. The server adds mipmaps.
    """

    name: str
    image: Array
    srgb: bool = True
    repeat: bool = True

    def __attrs_post_init__(self) -> None:
        image = self.image
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] not in (3, 4) or 0 in image.shape:
            raise SceneError(f"texture '{self.name}': wanted (h, w, 3 or 4) uint8, found {image.shape} {image.dtype}")


@attrs.frozen(eq=False)
class Mesh:
    """Triangles that share one texture and one way of culling; what is drawn is texture x light.

    positions: (n, 3) metres, relative to the scene's origin. normals: (n, 3) unit. uv: (n, 2), origin bottom left, +v up.
    light: (n, 3) baked linear light times colour, 0 or more. triangles: (m, 3) indices, counter-clockwise seen from the front.
    texture: index into the scene's textures, -1 for none (white). double_sided: drawn from behind too. material: what the surface does
    besides. body: 0 for what stands still, else 1 + index into the scene's bodies; positions and normals are in that body's frame then.
    deformation: how the vertices move by themselves, None where they do not; `positions` are those at rest then. albedo: (n, 3) linear
    colour of the material alone, what `light` would be in light of 1; None where the two are not known apart.
    Errors: SceneError for arrays of the wrong shape, values that are not finite, indices beyond the vertices, and a mesh of a body that
    deforms besides.
    """

    name: str
    positions: Array = attrs.field(converter=_frozen(np.float32, 3))
    normals: Array = attrs.field(converter=_frozen(np.float32, 3))
    uv: Array = attrs.field(converter=_frozen(np.float32, 2))
    light: Array = attrs.field(converter=_frozen(np.float32, 3))
    triangles: Array = attrs.field(converter=_frozen(np.uint32, 3))
    texture: int = -1
    double_sided: bool = False
    material: Material = Material()
    body: int = 0
    deformation: Deformation | None = None
    albedo: Array | None = attrs.field(default=None, converter=attrs.converters.optional(_frozen(np.float32, 3)))

    def __attrs_post_init__(self) -> None:
        count = len(self.positions)
        for field in ("positions", "normals", "uv", "light", *(("albedo",) if self.albedo is not None else ())):
            array = getattr(self, field)
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
            raise SceneError(
                f"mesh '{self.name}' belongs to body {self.body} and deforms by itself: wanted one of the two"
            )

    @property
    def is_surface(self) -> bool:
        """Whether it hides what is behind it and stands in the world."""
        return not (self.material.see_through or self.material.head_locked)


@attrs.frozen
class Background:
    """What lies infinitely far: linear RGB straight up, at the horizon (two, just above and just below) and straight down.

    The colour of a direction is mixed by the square root of how far it points up (or down), so the horizon's haze is thin.
    """

    zenith: tuple[float, float, float] = (0.0, 0.0, 0.0)
    horizon: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ground: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def uniform(cls, colour: tuple[float, float, float]) -> Background:
        """The same linear RGB in every direction."""
        return cls(colour, colour, colour)


@attrs.define(eq=False, frozen=True, slots=False)
class Scene:
    """Everything the server needs to draw, and where a viewer may stand. What it calls for (`effects`) follows from its meshes.

    origin_m: float64 (3,) in the world; every mesh is relative to it, so a scene 1e6 m away keeps its float32 digits.
    viewpoint: world_from_head of a viewer at rest. walk_bounds_m: (2, 3) world box, lowest and highest corner, a head may
    move in without passing through things. notes: what was wrong but survivable in a foreign file, one line each.
    bodies: what moves as a whole; a mesh belongs to one by its number.
    Errors: SceneError for a mesh with an unknown texture or body, and for a mirror without a normal.
    """

    name: str
    summary: str
    meshes: tuple[Mesh, ...] = attrs.field(converter=tuple)
    textures: tuple[Texture, ...] = attrs.field(default=(), converter=tuple)
    background: Background = Background()
    bodies: tuple[Body, ...] = attrs.field(default=(), converter=tuple)
    origin_m: Array = attrs.field(default=(0.0, 0.0, 0.0), converter=_frozen_vector)
    viewpoint: Pose = attrs.field(factory=lambda: Pose((0.0, 1.6, 0.0)))
    walk_bounds_m: Array = attrs.field(
        default=((-1.0, 0.8, -1.0), (1.0, 2.0, 1.0)), converter=lambda v: np.array(v, np.float64)
    )
    notes: tuple[str, ...] = attrs.field(default=(), converter=tuple)

    def __attrs_post_init__(self) -> None:
        for mesh in self.meshes:
            if not -1 <= mesh.texture < len(self.textures):
                raise SceneError(f"mesh '{mesh.name}' wants texture {mesh.texture}, the scene has {len(self.textures)}")
            if not -1 <= mesh.material.normal_map < len(self.textures):
                wanted, found = mesh.material.normal_map, len(self.textures)
                raise SceneError(f"mesh '{mesh.name}' wants texture {wanted} as its normal map, the scene has {found}")
            if not 0 <= mesh.body <= len(self.bodies):
                raise SceneError(f"mesh '{mesh.name}' belongs to body {mesh.body}, the scene has {len(self.bodies)}")
        self.mirrors  # noqa: B018 (what is wrong with a mirror is told now)

    @cached_property
    def effects(self) -> SceneEffect:
        """What its content calls for."""
        from ._declared import effects_of

        return effects_of(self)

    @cached_property
    def mirrors(self) -> tuple[SceneMirror, ...]:
        """What of it mirrors. Errors: SceneError, told when the scene is made."""
        from ._mirrors import mirrors_of

        return mirrors_of(self)

    @property
    def triangle_count(self) -> int:
        """Triangles of all meshes together."""
        return sum(len(mesh.triangles) for mesh in self.meshes)


@attrs.frozen(eq=False)
class SceneSource:
    """A registered scene before it is built: listing costs nothing, `build()` makes the arrays (the same ones every time)."""

    name: str
    summary: str
    build: Callable[[], Scene]
    effects: SceneEffect = SceneEffect.NONE


scenes: Registry[SceneSource] = Registry("scene", "hmdwarp.scenes.library")
