"""A scene: meshes, textures, lamps, mirrors, panels and background, checked together."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import SceneError, in_brief
from ..geometry import Mirror, Pose, View, is_a, real
from ..geometry.view import MOST_MIRRORS
from ._mesh import ALPHA_TOLERANCE, MOST_EDGES, Body, Brightness, Mesh, Motion, Quad, Texture
from .input_events import InputLog

MOST_PANELS = 15  # a headset's runtime composes 16 layers at least, of which one is the picture
MOST_LAMPS = 4
ATLAS = (64, 64)  # (w, h) texels of every scene's light atlas
_Rgb = tuple[float, float, float]
NEAREST_M = 0.01  # a surface nearer than this to a lamp gets no more light


@attrs.frozen(eq=False)
class Lamp:
    """A light that may move: a point where its motion is, or a sun far along the -z of its pose."""

    motion: Motion
    colour: _Rgb  # linear, that a white, matt surface shows which faces it: 1 m from a point, anywhere under a sun
    is_sun: bool = False
    cone: tuple[float, float] | None = None  # of a spot, rad about -z: all light up to the first, none at the second
    brightness: Brightness | None = None  # the share of its colour that it sends; None for all of it

    def light(self, time_ns: int) -> _Rgb:
        share = 1.0 if self.brightness is None else self.brightness.share(time_ns)
        red, green, blue = self.colour
        return share * red, share * green, share * blue

    def place(self, time_ns: int) -> NDArray[np.float64]:
        """Return (x, y, z, 1) of a point in the world, or (x, y, z, 0) towards a sun."""
        pose = self.motion.state(time_ns).pose
        if self.is_sun:
            return np.append(pose.rotation.apply((0.0, 0.0, 1.0)), 0.0)
        return np.append(pose.position_m, 1.0)

    def fading(self, time_ns: int) -> NDArray[np.float64]:
        """Return (x, y, z, w): along a unit way d a spot sends clamp(d . xyz + w, 0, 1)^2 of all.

        Source: Khronos 2018, KHR_lights_punctual.
        """
        if self.cone is None:
            return np.array([0.0, 0.0, 0.0, 1.0])
        inner, outer = np.cos(self.cone)
        scale = 1 / max(1e-3, inner - outer)
        ahead = self.motion.state(time_ns).pose.rotation.apply((0.0, 0.0, -scale))
        return np.append(ahead, -outer * scale)


_SAME_DIRECTION = 1e-3  # rad, between the normals of one plane
_SAME_PLANE_M = 1e-3


@attrs.frozen(eq=False)
class SceneMirror:
    """A mirror in world coordinates and the meshes it is made of."""

    shape: Mirror
    meshes: tuple[Mesh, ...]
    normal_map: int  # index of the texture that disturbs the reflection, -1 for none; and by how much
    normal_scale: float


def _plane_of(mesh: Mesh) -> NDArray[np.float64]:
    """Return (4,) unit normal and distance from the scene's origin."""
    normals, positions = mesh.normals.astype(np.float64), mesh.positions.astype(np.float64)
    fault = f"mesh '{mesh.name}': a mirror without a normal"
    remedy = "a plane mirror is flat with one unit normal at all vertices; mark others as curved (curved=True)"
    if not len(mesh.triangles) or np.abs(np.linalg.norm(normals, axis=1) - 1).max() > _SAME_DIRECTION:
        raise SceneError(f"{fault}: it lacks triangles, or its normals are not of length 1; {remedy}")
    mean = normals.mean(axis=0)
    mean /= max(float(np.linalg.norm(mean)), 1e-30)
    apart = np.linalg.norm(normals - mean, axis=1).max()
    if apart > _SAME_DIRECTION:
        degrees = np.degrees(2 * np.arcsin(min(apart / 2, 1)))
        raise SceneError(f"{fault}: its normals differ by up to {degrees:.3g} degrees; {remedy}")
    distances = positions @ mean
    if np.ptp(distances) > _SAME_PLANE_M:
        raise SceneError(
            f"{fault}: its vertices leave a plane by {np.ptp(distances) * 1e3:.3g} mm along its normals; {remedy}"
        )
    a, b, c = (positions[mesh.triangles[:, i]] for i in range(3))
    if (np.cross(b - a, c - a) @ mean < 0).any():
        raise SceneError(f"{fault}: some triangles face away from their normals; {remedy}")
    return np.array([*mean, distances.mean()])


def _shape(meshes: list[Mesh], origin_m: NDArray[np.float64]) -> Mirror:
    positions = np.concatenate([mesh.positions for mesh in meshes]).astype(np.float64)
    reflectivity = meshes[0].material.reflectivity
    if meshes[0].material.curved:
        centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
        radius = float(np.linalg.norm(positions - centre, axis=1).max())
        if not radius:
            raise SceneError(f"mesh '{meshes[0].name}': a curved mirror of no size; expected a ball or similar")
        return Mirror(centre + origin_m, radius_m=radius, reflectivity=reflectivity)
    normal = _plane_of(meshes[0])[:3]
    # Along which u grows, a normal map's x; any without.
    places = np.column_stack([meshes[0].uv, np.ones(len(meshes[0].uv))]).astype(np.float64)
    right = np.linalg.lstsq(places, meshes[0].positions.astype(np.float64), rcond=None)[0][0]
    right -= normal * (right @ normal)
    if np.linalg.norm(right) < 1e-9:
        right = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    right = right / np.linalg.norm(right)
    up = np.cross(normal, right)
    low, high = (np.array([extreme(positions @ axis) for axis in (right, up)]) for extreme in (np.min, np.max))
    across, along = (high - low) / 2
    middle = (low + high) / 2
    centre = right * middle[0] + up * middle[1] + normal * float((positions @ normal).mean())
    return Mirror(centre + origin_m, right * max(across, 1e-6), up * max(along, 1e-6), reflectivity=reflectivity)


def _tuple(values: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(values)


def _array(value: ArrayLike) -> NDArray[np.float64]:
    return np.array(value, np.float64)


def _vector(value: ArrayLike) -> NDArray[np.float64]:
    array = np.array(value, dtype=np.float64).reshape(3)
    array.flags.writeable = False
    return array


@attrs.frozen
class Background:
    """Light from infinitely far, linear RGB.

    The colour of a direction is mixed by the square root of how far it points up or down, which
    keeps the haze at the horizon thin.
    """

    zenith: _Rgb = (0.0, 0.0, 0.0)  # straight up
    horizon: _Rgb = (0.0, 0.0, 0.0)  # at the horizon
    ground: _Rgb = (0.0, 0.0, 0.0)  # straight down

    @classmethod
    def uniform(cls, colour: _Rgb) -> Background:
        return cls(colour, colour, colour)


def _pictures(value: Any) -> tuple[Texture, ...]:
    found = value if isinstance(value, tuple | list) else (value,)
    return tuple(each if isinstance(each, Texture) else Texture("panel", each, repeat=False) for each in found)


def _size(value: Any) -> tuple[float, float]:
    try:
        width, height = map(float, value)
    except (TypeError, ValueError, OverflowError) as error:
        raise SceneError(f"a panel's size is {in_brief(value)}: expected width and height in metres") from error
    if not (0 < width < np.inf and 0 < height < np.inf):
        raise SceneError(f"a panel is {width:g} x {height:g} m: expected finite lengths above 0")
    return width, height


@attrs.frozen(eq=False)
class Panel:
    """A picture in the world or fixed to the head, seen from +z of its pose.

    Parameters
    ----------
    pictures : (h, w, 3 or 4) array_like of uint8, or several, which take turns
        sRGB, the top row first.
    pose : Pose
        Of its middle: world_from_panel, or head_from_panel if it is `head_locked`.
    size_m : (float, float)
        Along the pose's x and y, above 0.
    occluded : bool
        What is nearer in the picture hides it.
    seconds : float
        How long each picture stays, above 0.

    Raises
    ------
    SceneError
    """

    pictures: tuple[Texture, ...] = attrs.field(converter=_pictures)
    pose: Pose = attrs.field(validator=is_a(Pose))
    size_m: tuple[float, float] = attrs.field(converter=_size)
    head_locked: bool = False
    occluded: bool = False
    seconds: float = attrs.field(default=1.0, converter=real)

    def __attrs_post_init__(self) -> None:
        if not self.pictures or not 0 < self.seconds < np.inf:
            found = f"a panel of {len(self.pictures)} pictures for {self.seconds:g} s each"
            raise SceneError(f"{found}: expected one or more, and a finite time above 0")

    def showing(self, time_ns: int) -> int:
        return int(time_ns // max(1, round(self.seconds * 1e9))) % len(self.pictures)

    def eye_from_panel(self, view: View) -> Pose:
        """Return where it is to an eye, without passing the world's origin."""
        return self.pose.relative_to(view.head_from_eye if self.head_locked else view.pose)

    def away_m(self, view: View) -> float:
        return float(np.linalg.norm(self.eye_from_panel(view).position_m))

    @property
    def quad(self) -> Quad:
        width, height = self.size_m
        return Quad((0.0, 0.0, 0.0), (width / 2, 0.0, 0.0), (0.0, height / 2, 0.0))


@attrs.define(eq=False, frozen=True, slots=False)
class Scene:
    """Everything the server needs to draw, and where a viewer may stand. Errors: SceneError."""

    name: str
    summary: str
    meshes: tuple[Mesh, ...] = attrs.field(converter=_tuple)
    textures: tuple[Texture, ...] = attrs.field(default=(), converter=_tuple)
    background: Background = Background()
    bodies: tuple[Body, ...] = attrs.field(default=(), converter=_tuple)  # meshes have their numbers, from 1
    # (3,) in the world. Meshes are relative to it: float32 keeps its digits 1e6 m away.
    origin_m: NDArray[np.float64] = attrs.field(default=(0.0, 0.0, 0.0), converter=_vector)
    viewpoint: Pose = attrs.field(factory=lambda: Pose((0.0, 1.6, 0.0)))  # world_from_head of a viewer at rest
    # (2, 3) lowest and highest corner of the world box that a head may move in.
    walk_bounds_m: NDArray[np.float64] = attrs.field(default=((-1.0, 0.8, -1.0), (1.0, 2.0, 1.0)), converter=_array)
    notes: tuple[str, ...] = attrs.field(default=(), converter=_tuple)  # faults of a foreign file, one line each
    lamps: tuple[Lamp, ...] = attrs.field(default=(), converter=_tuple)  # without them all light is baked
    panels: tuple[Panel, ...] = attrs.field(default=(), converter=_tuple)
    inputs: InputLog | None = None  # what people do in it; None for a scene that does not react
    light_ns: int | None = None  # of which instant the lamps' light is, whatever moves; None for that which is drawn

    def __attrs_post_init__(self) -> None:
        textures, bodies = len(self.textures), len(self.bodies)
        shining = next((texture.name for texture in self.textures if texture.emission is not None), None)
        for mesh in self.meshes:
            name, normal_map = f"mesh '{mesh.name}'", mesh.material.normal_map
            if not -1 <= mesh.texture < textures:
                raise SceneError(f"{name} uses texture {mesh.texture}, the scene has {textures}")
            if not -1 <= normal_map < textures:
                raise SceneError(f"{name} uses texture {normal_map} as its normal map, the scene has {textures}")
            if not 0 <= mesh.body <= bodies:
                raise SceneError(f"{name} belongs to body {mesh.body}, the scene has {bodies}")
            if mesh.light_uv is not None and mesh.deformation is not None:
                raise SceneError(f"{name} has a place in the light atlas and deforms: expected one that is rigid")
            if self.lamps and mesh.material.reflectivity:
                raise SceneError(f"{name} mirrors: in a scene with lamps, expected matt surfaces")
        if self.lamps and shining is not None:
            raise SceneError(f"texture '{shining}' shines: in a scene with lamps, expected textures without emission")
        for found, most, what in ((self.panels, MOST_PANELS, "panels"), (self.lamps, MOST_LAMPS, "lamps")):
            if len(found) > most:
                raise SceneError(f"{len(found)} {what}: expected at most {most}")
        self.mirrors  # noqa: B018 (raises at once if a mirror cannot be drawn)

    @cached_property
    def mirrors(self) -> tuple[SceneMirror, ...]:
        """Mirrors, plane ones first; each curved mesh is its own, the ball around its vertices.

        Errors: SceneError for a plane mirror that is not flat, one that moves, and too many.
        """
        groups: dict[tuple[Any, ...], list[Mesh]] = {}
        for index, mesh in enumerate(self.meshes):
            if not mesh.material.reflectivity:
                continue
            if mesh.body or mesh.deformation is not None:
                raise SceneError(f"mesh '{mesh.name}': a mirror that moves; keep it still or set its reflectivity to 0")
            what = mesh.material.reflectivity, mesh.material.normal_map, mesh.material.normal_scale
            key = (1, index) if mesh.material.curved else (0, *np.round(_plane_of(mesh), 3).tolist())
            groups.setdefault((*key, *what), []).append(mesh)
        if len(groups) > MOST_MIRRORS:
            raise SceneError(
                f"scene '{self.name}' has {len(groups)} mirrors: expected at most {MOST_MIRRORS}; one plane counts once"
            )
        ordered = sorted(groups.values(), key=lambda group: group[0].material.curved)
        return tuple(
            SceneMirror(_shape(group, self.origin_m), tuple(group), like.normal_map, like.normal_scale)
            for group, like in ((group, group[0].material) for group in ordered)
        )

    def lit_ns(self, time_ns: int) -> int:
        """Return of which instant the light is in which the scene is seen at an instant."""
        return time_ns if self.light_ns is None else self.light_ns

    @property
    def lit_moves(self) -> bool:
        return any(mesh.light_uv is not None and mesh.body for mesh in self.meshes)

    @property
    def is_still(self) -> bool:
        """Whether there is something, and all of it looks the same at all times from everywhere."""
        plain = (mesh.is_surface and mesh.stands_still and not mesh.material.reflectivity for mesh in self.meshes)
        return bool(self.meshes) and not self.lamps and not self.panels and all(plain)

    @property
    def triangle_count(self) -> int:
        return sum(len(mesh.triangles) for mesh in self.meshes)


def is_cutout(scene: Scene, mesh: Mesh) -> bool:
    """Return whether a see-through sheet, such as a fence, is opaque or empty but for its edges."""
    material = mesh.material
    if not material.see_through or mesh.texture < 0 or material.opacity < 1 or material.transmission:
        return False
    alpha = scene.textures[mesh.texture].image[..., 3:]
    between = (alpha > ALPHA_TOLERANCE) & (alpha < 255 - ALPHA_TOLERANCE)
    return alpha.size > 0 and float(between.mean()) < MOST_EDGES
