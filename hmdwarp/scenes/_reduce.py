"""Scenes with fewer triangles and texels, for a client that draws for itself."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache, partial
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb, srgb8_from_linear
from ..errors import SceneError
from ..resources import import_extra
from ._mesh import Deformation, Material, Mesh, Texture
from ._scene import Background, Scene

UNKNOWN_ALBEDO = 0.5
# Black is drawn as this, so that what glows on it has a light: 1.2 % of white in sRGB.
LEAST_ALBEDO = 2.0**-10
WHITE = -1  # index of the texture that is 1 everywhere
LEAST_TRIANGLES = 2000  # cheap to draw for any client, and a fifth of ten triangles would leave things out
# What a change by 1 along a metre weighs, as a change of position by that many metres; a texture's
# change is in metres on it. Tuned on the pictures of four scenes with 20 % and 5 % of their
# triangles: weights of 0.1 lose 5 dB, twice these 1 dB.
WEIGHT_OF_LIGHT, WEIGHT_OF_TEXTURE, WEIGHT_OF_NORMAL = 1.5, 0.7, 0.2
ASIDE = 1e-4  # of the scene's size, between parts that move apart
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB

Triangles = list[NDArray[np.uint32]]


def reduced(
    scene: Scene, share: float, *, texture: float = 1.0, least: int = LEAST_TRIANGLES, matt: bool = True
) -> Scene:
    """Return the scene's surfaces with about `share` of their triangles, and baked light.

    Bodies and deformations move as before.
    matt: mirrors stay as plain surfaces; what is see-through or fixed to the head is left out. Else
    all of these stay as they are, with all their triangles.
    texture: scale of the textures' resolution on both axes, averaged in linear light; every texture
    keeps a texel. They are made when they are first used, as the scene's own.
    least: number of triangles that no scene is reduced below.
    Errors: SceneError for a share or a scale that is not above 0 and at most 1; MachineError
    without meshoptimizer.
    """
    if not 0 < texture <= 1:
        raise SceneError(f"textures at {texture:g} of their resolution: expected more than 0 and at most 1")
    if not 0 < share <= 1:
        raise SceneError(f"share {share:g} of a scene's triangles: expected more than 0 and at most 1")
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface and (matt or not mesh.material.reflectivity)]
    share = max(share, min(1.0, least / max(1, sum(len(mesh.triangles) for mesh in surfaces))))
    triangles = fewer_triangles(surfaces, share)
    fewer = {
        id(mesh): with_triangles(mesh, kept, matt=matt) if len(kept) else None
        for mesh, kept in zip(surfaces, triangles, strict=True)
    }
    meshes = [one for mesh in scene.meshes if (one := fewer.get(id(mesh), None if matt else mesh)) is not None]
    textures = [
        one if texture == 1 else Texture(one.name, partial(scaled, one, texture), one.srgb, one.repeat, one.emission)
        for one in scene.textures
    ]
    return attrs.evolve(scene, meshes=meshes, textures=textures)


def scaled(texture: Texture, scale: float) -> NDArray[np.uint8]:
    """Return its image at that scale, averaged in linear light; a side has one texel at least."""
    from PIL import Image

    image = texture.image
    if scale == 1:
        return image
    size = tuple(max(1, round(scale * side)) for side in image.shape[1::-1])
    linear = image / np.float32(255)
    if texture.srgb:
        linear[..., :3] = linear_from_srgb(image[..., :3])
    channels = [Image.fromarray(np.ascontiguousarray(linear[..., k])) for k in range(image.shape[2])]
    made = np.stack([np.asarray(channel.resize(size, Image.Resampling.BOX)) for channel in channels], axis=-1)
    smaller = np.rint(255 * made).astype(np.uint8)
    if texture.srgb:
        smaller[..., :3] = srgb8_from_linear(made[..., :3])
    return np.asarray(smaller)


def unlit(scene: Scene) -> Scene:
    """Return the scene under light of 1: every surface's texture times its material's colour.

    Where a mesh lacks an albedo, its baked colour at a luminance of 0.5 replaces it: hue of
    material and light together. Black is at least LEAST_ALBEDO.
    """
    meshes = [attrs.evolve(mesh, light=_albedo(mesh)) for mesh in scene.meshes]
    return attrs.evolve(scene, meshes=meshes, lamps=())


def only_light(scene: Scene) -> Scene:
    """Return the scene as `unlit` leaves it out: white surfaces and sky under the light there is.

    A vertex that glows by itself does so in the light; for textures see `only_emission`. Per
    vertex, the light times the albedo of `unlit` is the baked colour: exact over a triangle with
    one albedo or one light.
    """
    meshes = [
        attrs.evolve(mesh, light=mesh.light / _albedo(mesh), texture=WHITE, albedo=np.ones_like(mesh.light))
        for mesh in scene.meshes
    ]
    sky = attrs.evolve(scene.background, zenith=(1.0, 1.0, 1.0), horizon=(1.0, 1.0, 1.0), ground=(1.0, 1.0, 1.0))
    return attrs.evolve(scene, meshes=meshes, background=sky)


def only_emission(scene: Scene) -> Scene | None:
    """Return the scene without any light but what its textures emit; None where none does."""
    if all(texture.emission is None for texture in scene.textures):
        return None
    meshes = [attrs.evolve(mesh, light=np.zeros_like(mesh.light)) for mesh in scene.meshes]
    return attrs.evolve(scene, meshes=meshes, background=Background())


def _albedo(mesh: Mesh) -> NDArray[Any]:
    luminance = (mesh.light @ _LUMINANCE)[:, None]
    guess = np.where(luminance > 0, UNKNOWN_ALBEDO * mesh.light / np.where(luminance > 0, luminance, 1), UNKNOWN_ALBEDO)
    return np.asarray(np.maximum(guess if mesh.albedo is None else mesh.albedo, LEAST_ALBEDO))


def fewer_triangles(meshes: Sequence[Mesh], share: float) -> Triangles:
    """Return `share` of all triangles, for each mesh as indices into its own vertices.

    Collapses go by errors of position, light, texture and normal; borders and seams stay closed.
    Small things go as a whole where that changes less than the next collapse. Meshes that meet in a
    vertex still meet there, unless they move apart. Two calls return the same.
    Errors: MachineError without meshoptimizer.
    Source: Garland and Heckbert 1997, Surface Simplification Using Quadric Error Metrics; Hoppe
    1999, New Quadric Metric for Simplifying Meshes with Appearance Attributes.
    """
    sizes, count = [len(mesh.positions) for mesh in meshes], sum(len(mesh.triangles) for mesh in meshes)
    if share == 1 or not count:
        return [mesh.triangles for mesh in meshes]
    starts, owner = np.cumsum([0, *sizes]), np.repeat(np.arange(len(meshes)), sizes)
    position, normal, uv, light = (
        np.concatenate([getattr(m, name) for m in meshes]) for name in ("positions", "normals", "uv", "light")
    )
    corners = np.concatenate([m.triangles + s for m, s in zip(meshes, starts, strict=False)])
    # Vertices count as one surface where their positions are equal, so what moves by itself is put
    # a little aside.
    moves_with = [mesh.body if mesh.deformation is None else -1 - k for k, mesh in enumerate(meshes)]
    _, part = np.unique(moves_with, return_inverse=True)
    aside = ASIDE * np.ptp(position, axis=0).max() * part[owner]
    scale = np.array([_metres_per_uv(mesh) for mesh in meshes])[owner]
    looks = [WEIGHT_OF_LIGHT * light, WEIGHT_OF_TEXTURE * scale[:, None] * uv, WEIGHT_OF_NORMAL * normal]
    table = np.concatenate([position + aside[:, None], *looks, owner[:, None]], axis=1, dtype=np.float32)
    _, first, which = np.unique(table, axis=0, return_index=True, return_inverse=True)
    indices = which.reshape(-1)[corners].astype(np.uint32).ravel()
    kept, simplifier = np.empty_like(indices), _simplifier()
    found = simplifier.simplify_with_attributes(
        kept,
        indices,
        np.ascontiguousarray(table[first, :3]),
        np.ascontiguousarray(table[first, 3:-1]),
        np.ones(table.shape[1] - 4),
        target_index_count=3 * round(share * count),
        target_error=1e6,  # none
        options=simplifier.SIMPLIFY_PRUNE,
    )
    corners = first[kept[:found].reshape(-1, 3)]
    return [(corners[owner[corners[:, 0]] == k] - starts[k]).astype(np.uint32) for k in range(len(meshes))]


@cache
def _simplifier() -> Any:
    """Return meshoptimizer's simplifier; 0.2.30 does not declare its parameters to ctypes."""
    module = import_extra("meshoptimizer.simplifier", "meshoptimizer", "reduce")
    array, number = ctypes.c_void_p, ctypes.c_size_t
    arrays = [array, array, number, array, number, number, array, number, array, number, array]
    module.lib.meshopt_simplifyWithAttributes.argtypes = [*arrays, number, ctypes.c_float, ctypes.c_uint, array]
    module.lib.meshopt_simplifyWithAttributes.restype = number
    return module


def _metres_per_uv(mesh: Mesh) -> float:
    """Return the mean size of a texture on the mesh; 0 without one."""
    if mesh.texture < 0:
        return 0.0
    p, uv = mesh.positions[mesh.triangles].astype(np.float64), mesh.uv[mesh.triangles].astype(np.float64)
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
    (a, b), (c, d) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    painted = np.abs(a * d - b * c).sum()
    return float(np.sqrt(area / painted)) if painted > 0 else 0.0


@attrs.frozen(eq=False)
class _Subset:
    """A deformation of some of its vertices."""

    whole: Deformation
    kept: NDArray[np.integer]

    def positions(self, time_ns: int) -> NDArray[np.float64]:
        return np.asarray(self.whole.positions(time_ns)[self.kept])

    def velocities(self, time_ns: int) -> NDArray[np.float64]:
        return np.asarray(self.whole.velocities(time_ns)[self.kept])


def with_triangles(mesh: Mesh, triangles: NDArray[np.uint32], *, matt: bool = False) -> Mesh:
    """Return the mesh with these triangles and their vertices only; matt: in plain material."""
    kept, which = np.unique(triangles, return_inverse=True)
    return attrs.evolve(
        mesh,
        positions=mesh.positions[kept],
        normals=mesh.normals[kept],
        uv=mesh.uv[kept],
        light=mesh.light[kept],
        triangles=which.reshape(-1, 3),
        albedo=None if mesh.albedo is None else mesh.albedo[kept],
        light_uv=None if mesh.light_uv is None else mesh.light_uv[kept],
        deformation=None if mesh.deformation is None else _Subset(mesh.deformation, kept),
        material=Material() if matt else mesh.material,
    )
