"""A scene: meshes, textures, moving bodies and background, checked when put together."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SceneError
from ..geometry import Pose
from ..registry import Registry
from ._content import Body
from ._lamps import Lamp, problem_with
from ._mesh import ALPHA_TOLERANCE, MOST_EDGES, Mesh, Texture
from ._mirrors import SceneMirror, mirrors_of

Rgb = tuple[float, float, float]


def _meshes(values: Iterable[Mesh]) -> tuple[Mesh, ...]:
    return tuple(values)


def _textures(values: Iterable[Texture]) -> tuple[Texture, ...]:
    return tuple(values)


def _bodies(values: Iterable[Body]) -> tuple[Body, ...]:
    return tuple(values)


def _lamps(values: Iterable[Lamp]) -> tuple[Lamp, ...]:
    return tuple(values)


def _notes(values: Iterable[str]) -> tuple[str, ...]:
    return tuple(values)


def _vector(value: ArrayLike) -> NDArray[np.float64]:
    array = np.array(value, dtype=np.float64).reshape(3)
    array.flags.writeable = False
    return array


def _bounds(value: ArrayLike) -> NDArray[np.float64]:
    return np.array(value, np.float64)


@attrs.frozen
class Background:
    """Light from infinitely far, linear RGB.

    The colour of a direction is mixed by the square root of how far it points up or down, which
    keeps the haze at the horizon thin.
    """

    # Straight up.
    zenith: Rgb = (0.0, 0.0, 0.0)
    # At the horizon.
    horizon: Rgb = (0.0, 0.0, 0.0)
    # Straight down.
    ground: Rgb = (0.0, 0.0, 0.0)

    @classmethod
    def uniform(cls, colour: Rgb) -> Background:
        """Return a background of the same linear RGB in every direction."""
        return cls(colour, colour, colour)


@attrs.define(eq=False, frozen=True, slots=False)
class Scene:
    """Everything the server needs to draw, and where a viewer may stand.

    Errors: SceneError for a mesh with an unknown texture or body, and for mirrors that cannot be
    drawn (see `mirrors`).
    """

    name: str
    summary: str
    meshes: tuple[Mesh, ...] = attrs.field(converter=_meshes)
    textures: tuple[Texture, ...] = attrs.field(default=(), converter=_textures)
    background: Background = Background()
    # Meshes belong to a body by its number, which starts at 1.
    bodies: tuple[Body, ...] = attrs.field(default=(), converter=_bodies)
    # Float64 (3,) in the world. Meshes are relative to it: float32 keeps its digits 1e6 m away.
    origin_m: NDArray[np.float64] = attrs.field(default=(0.0, 0.0, 0.0), converter=_vector)
    # World_from_head of a viewer at rest.
    viewpoint: Pose = attrs.field(factory=lambda: Pose((0.0, 1.6, 0.0)))
    # (2, 3) lowest and highest corner of the world box that a head may move in.
    walk_bounds_m: NDArray[np.float64] = attrs.field(default=((-1.0, 0.8, -1.0), (1.0, 2.0, 1.0)), converter=_bounds)
    # Survivable faults of a foreign file, one line each.
    notes: tuple[str, ...] = attrs.field(default=(), converter=_notes)
    # Light that moves; without lamps all light is baked.
    lamps: tuple[Lamp, ...] = attrs.field(default=(), converter=_lamps)
    # Of which instant the lamps' light is, whatever moves; None for that which is drawn.
    light_ns: int | None = None

    def __attrs_post_init__(self) -> None:
        for mesh in self.meshes:
            count, normal_map = len(self.textures), mesh.material.normal_map
            if not -1 <= mesh.texture < count:
                raise SceneError(f"mesh '{mesh.name}' uses texture {mesh.texture}, the scene has {count}")
            if not -1 <= normal_map < count:
                raise SceneError(
                    f"mesh '{mesh.name}' uses texture {normal_map} as its normal map, the scene has {count}"
                )
            if not 0 <= mesh.body <= len(self.bodies):
                raise SceneError(f"mesh '{mesh.name}' belongs to body {mesh.body}, the scene has {len(self.bodies)}")
        if problem := problem_with(self.meshes, self.lamps):
            raise SceneError(problem)
        self.mirrors  # noqa: B018 (raises at once if a mirror cannot be drawn)

    @cached_property
    def mirrors(self) -> tuple[SceneMirror, ...]:
        """Mirrors, plane ones first; see mirrors_of for its errors."""
        return mirrors_of(self.name, self.meshes, self.origin_m)

    def lit_ns(self, time_ns: int) -> int:
        """Return of which instant the light is in which the scene is seen at an instant."""
        return time_ns if self.light_ns is None else self.light_ns

    @property
    def lit_moves(self) -> bool:
        """Whether something moves that lamps light, and that stops their light."""
        return any(mesh.light_uv is not None and mesh.body for mesh in self.meshes)

    @property
    def is_still(self) -> bool:
        """Whether there is something, and all of it looks the same at all times from everywhere."""
        plain = (mesh.is_surface and mesh.stands_still and not mesh.material.reflectivity for mesh in self.meshes)
        return bool(self.meshes) and not self.lamps and all(plain)

    @property
    def triangle_count(self) -> int:
        """Triangles of all meshes together."""
        return sum(len(mesh.triangles) for mesh in self.meshes)


def is_cutout(scene: Scene, mesh: Mesh) -> bool:
    """Return whether a see-through sheet is opaque or fully transparent but for its edges.

    Such a sheet, a fence for instance, has a depth of its own in the picture.
    """
    material = mesh.material
    if not material.see_through or mesh.texture < 0 or material.opacity < 1 or material.transmission:
        return False
    alpha = scene.textures[mesh.texture].image[..., 3:]
    between = (alpha > ALPHA_TOLERANCE) & (alpha < 255 - ALPHA_TOLERANCE)
    return alpha.size > 0 and float(between.mean()) < MOST_EDGES


@attrs.frozen(eq=False)
class SceneSource:
    """A registered scene before it is built; listing scenes builds nothing."""

    name: str
    summary: str
    # Makes the scene, the same arrays every time.
    build: Callable[[], Scene]
    # Names of the effects that the built scene's content calls for.
    effects: tuple[str, ...] = ()


scenes: Registry[SceneSource] = Registry("scene", "hmdwarp.scenes.library", group="scenes")
