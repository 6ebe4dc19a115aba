"""Float64 twin of splatted photons: the light of each place, by looking at every photon.

The GPU goes from photon to pixel, through a picture of depth and normals; this goes from a pixel's
ray, met with the surfaces themselves, to all photons.
"""

from __future__ import annotations

import attrs
import numpy as np
from scipy.ndimage import map_coordinates

from hmdwarp.cloudlight.photons import unpacked
from hmdwarp.geometry import View
from hmdwarp.scenes import ATLAS, Scene


@attrs.frozen
class Seen:
    """What each pixel sees, bottom row first; nan where nothing is lit."""

    places: np.ndarray  # (h, w, 3) from the scene's origin
    normals: np.ndarray  # (h, w, 3)
    texels: np.ndarray  # (h, w, 2) in the light atlas
    albedo: np.ndarray  # (h, w, 3)


def seen(scene: Scene, view: View, size: tuple[int, int]) -> Seen:
    """Rays met with the rectangles that the meshes of a lit room are."""
    angles = view.fov.left, view.fov.right, view.fov.down, view.fov.up
    left, right, down, up = np.tan(angles)
    x = left + (np.arange(size[0]) + 0.5) / size[0] * (right - left)
    y = down + (np.arange(size[1]) + 0.5) / size[1] * (up - down)
    ways = np.stack([*np.meshgrid(x, y), np.full(size[::-1], -1.0)], axis=2) @ view.pose.rotation.as_matrix().T
    eye, nearest = view.pose.position_m - scene.origin_m, np.full(size[::-1], np.inf)
    out = Seen(*(np.full((*size[::-1], width), np.nan) for width in (3, 3, 2, 3)))
    for mesh in scene.meshes:
        corner, right_one, up_one = mesh.positions[[0, 1, 3]].astype(float)
        sides = np.stack([right_one - corner, up_one - corner])
        facing = np.cross(*sides)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = ((corner - eye) @ facing) / (ways @ facing)
            share = (eye + far[..., None] * ways - corner) @ np.linalg.pinv(sides)
        found = ((share >= 0) & (share <= 1)).all(axis=2) & (far > 0) & (far < nearest) & (ways @ facing < 0)
        nearest[found] = far[found]
        out.places[found] = (corner + share @ sides)[found]
        out.normals[found] = facing / np.linalg.norm(facing)
        texels = mesh.light_uv[[0, 1, 3]].astype(float)
        out.texels[found] = (texels[0] + share @ (texels[1:] - texels[0]))[found]
        out.albedo[found] = mesh.albedo[0]
    return out


@attrs.frozen
class Received:
    """Photons as the wire has them."""

    places: np.ndarray
    normals: np.ndarray
    powers: np.ndarray


def received(contents: list[np.ndarray]) -> Received:
    """The newest of each bundle of some updates."""
    newest: dict[int, tuple[int, np.ndarray]] = {}
    cube = None
    for content in contents:
        _, cube, bundles = unpacked(content)
        for (bundle, number), words in bundles:
            if number > newest.get(bundle, (-1,))[0]:
                newest[bundle] = number, words
    x, z, power = np.concatenate([np.zeros((0, 3), np.uint32), *(words for _, words in newest.values())]).T.astype(int)
    places = cube.low + np.stack([x % 65536, x // 65536, z % 65536], axis=1) / 65535 * cube.edge
    flat = np.stack([(z >> 16) % 256, z >> 24], axis=1) / 127 - 1
    up = 1 - np.abs(flat).sum(axis=1)
    folded = (1 - np.abs(flat[:, ::-1])) * np.where(flat >= 0, 1, -1)
    normals = np.column_stack([np.where(up[:, None] < 0, folded, flat), up])
    powers = (
        np.stack([power % 512, (power >> 9) % 512, (power >> 18) % 512], axis=1) * 2.0 ** ((power >> 27) - 24)[:, None]
    )
    return Received(places, normals / np.linalg.norm(normals, axis=1, keepdims=True), powers)


def photons(there: Seen, got: Received, factors: np.ndarray, radius: float) -> np.ndarray:
    """(h, w, 3) the light of each pixel, nan where nothing is lit."""
    light = np.full(there.places.shape, np.nan)
    finer = factors.shape[0] / ATLAS[1]
    for at in np.argwhere(np.isfinite(there.places[..., 0])):
        place, normal, texel = (kind[tuple(at)] for kind in (there.places, there.normals, there.texels))
        off = got.places - place
        near = (np.linalg.norm(off, axis=1) < radius) & (got.normals @ normal > 0.8)
        near &= np.abs((off * got.normals).sum(axis=1)) < 0.25 * radius
        share = 2 / (np.pi * radius**2) * (1 - (off[near] ** 2).sum(axis=1) / radius**2)
        row, column = texel[1] * finer - 0.5, texel[0] * finer - 0.5
        factor = map_coordinates(factors[..., 0].astype(float), [[row], [column]], order=1, mode="nearest")[0]
        light[tuple(at)] = factor * (share @ got.powers[near])
    return light
