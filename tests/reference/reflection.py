"""What mirrors add to a picture, by rays through the world.

And where a ball's image stands, by two neighbouring rays.
"""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import Mirror, View
from reference._rays import world_directions
from reference.mirrors import fresnel
from reference.picture import HALF_SMALLEST, HALF_UNIT, ReferencePicture, sample_covered
from reference.raycast import Hits, cast_quads, cast_spheres, nearest

Array = NDArray[np.float64]
APRON_M = 0.4  # as in shaders/lib/mirrors.glsl
FAR_M = 1e9  # stands for infinitely far
# A look's place is some 30 float32 operations on pixels up to a few thousand, more where the ray
# grazes the mirror.
PLACE_ERROR_PX = 4e-3


@attrs.frozen(eq=False)
class MirrorPictures:
    """Bottom row first.

    picture, surface, seen (h, w, 4), seen_inverse_depth (h, w), all of `view`; surface and seen as
    in frame.Reflection.
    """

    picture: Array
    surface: Array
    seen: Array
    seen_inverse_depth: Array
    view: View


def with_reflection(pictures: MirrorPictures, mirrors: Sequence[Mirror], *, glossy: bool = True) -> ReferencePicture:
    """The picture with what its mirrors show.

    glossy: whether disturbed normals turn the mirrored rays.

    A ray is mirrored at the disturbed normal, goes on in the real world for as long as the
    undisturbed one does, and what it meets is seen where its mirror image stands. Source: Schlick
    1994 for how much of it is seen.
    """
    view, size = pictures.view, pictures.picture.shape[1::-1]
    rays = world_directions(view, size).reshape(-1, 3)
    met = _meet(mirrors, view.pose.position_m, rays)
    surface, own = pictures.surface.reshape(-1, 4), pictures.seen.reshape(-1, 4)
    met_any = met.shape >= 0
    which = np.maximum(met.shape, 0)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        place = view.pose.position_m + rays / np.where(met_any, met.inverse_depth, 1)[:, None]
    normals = _normals(mirrors, which, place)
    image, tolerance, undecided = own.copy(), HALF_UNIT * np.abs(own[:, :3]).max(axis=1), np.zeros(len(rays), bool)
    if glossy:
        flat = np.array([not mirror.is_curved for mirror in mirrors])[which]
        depth = pictures.seen_inverse_depth.ravel()
        disturbed = flat & met_any & (surface[:, 1:3] != 0).any(axis=1) & (depth >= 0)
        tilted = _tilted(mirrors, which, normals, surface[:, 1:3])
        looked = _look(pictures, place, unit, normals, tilted, depth, met.inverse_depth, rays)
        found = disturbed & (looked.colour[..., 3].ravel() > 0)
        image[found] = looked.colour.reshape(-1, 4)[found]
        tolerance = np.where(found, looked.tolerance.ravel(), tolerance)
        undecided = disturbed & looked.undecided.ravel()
        normals = np.where((flat & met_any)[:, None], tilted, normals)
    straight = np.array([mirror.reflectivity for mirror in mirrors])[which]
    share = np.clip(surface[:, 0] / straight, 0, 1) * fresnel(straight, -np.einsum("ij,ij->i", unit, normals))
    share = np.where(met_any & (image[:, 3] > 0) & (surface[:, 0] > 0), share, 0)[:, None]
    base = pictures.picture.reshape(-1, 4)
    out = base.copy()
    out[:, :3] = base[:, :3] * (1 - share) + image[:, :3] * share
    brightest = np.abs(np.concatenate([base[:, :3], image[:, :3]], axis=1)).max(axis=1)
    tolerance = (
        share[:, 0] * tolerance + (HALF_UNIT + 1e-5) * brightest + HALF_SMALLEST
    )  # 1e-5: Schlick's fifth power in float32
    shape = size[::-1]
    return ReferencePicture(out.reshape(*shape, 4), tolerance.reshape(shape), undecided.reshape(shape))


def _meet(mirrors: Sequence[Mirror], eye: Array, rays: Array) -> Hits:
    """The nearest mirror that a ray meets from before; where there is none, the nearest apron."""

    def all_of(apron_m: float) -> Hits:
        found = []
        for mirror in mirrors:
            if mirror.is_curved:
                found.append(cast_spheres([(*mirror.centre_m, mirror.radius_m)], eye, rays))
                continue
            edges = [half * (1 + apron_m / np.linalg.norm(half)) for half in (mirror.right_m, mirror.up_m)]
            hits = cast_quads([(mirror.centre_m, *edges)], eye, rays)
            before = rays @ mirror.normal < 0
            found.append(
                attrs.evolve(
                    hits, inverse_depth=np.where(before, hits.inverse_depth, 0), shape=np.where(before, hits.shape, -1)
                )
            )
        return _first(found)

    exact, around = all_of(0.0), all_of(APRON_M)
    none = exact.shape < 0
    return attrs.evolve(
        exact,
        inverse_depth=np.where(none, around.inverse_depth, exact.inverse_depth),
        shape=np.where(none, around.shape, exact.shape),
    )


def _first(found: list[Hits]) -> Hits:
    """As raycast.nearest, but numbered by the list: a mirror that no ray meets counts too."""
    numbered = [attrs.evolve(hits, shape=np.where(hits.shape >= 0, i, -1)) for i, hits in enumerate(found)]
    best = nearest(*numbered)
    depths = np.array([hits.inverse_depth for hits in numbered])
    return attrs.evolve(best, shape=np.where(depths.max(axis=0) > 0, depths.argmax(axis=0), -1))


def _normals(mirrors: Sequence[Mirror], which: NDArray, place: Array) -> Array:
    out = np.zeros_like(place)
    for i, mirror in enumerate(mirrors):
        here = which == i
        out[here] = (place[here] - mirror.centre_m) / mirror.radius_m if mirror.is_curved else mirror.normal
    return out


def _tilted(mirrors: Sequence[Mirror], which: NDArray, normals: Array, tilt: Array) -> Array:
    out = normals * np.sqrt(np.maximum(1 - (tilt**2).sum(axis=1), 0))[:, None]
    for i, mirror in enumerate(mirrors):
        if not mirror.is_curved:
            axes = np.stack([half / np.linalg.norm(half) for half in (mirror.right_m, mirror.up_m)])
            out[which == i] += tilt[which == i] @ axes
    return out


def _look(
    pictures: MirrorPictures,
    place: Array,
    unit: Array,
    normals: Array,
    tilted: Array,
    depth: Array,
    met: Array,
    rays: Array,
) -> ReferencePicture:
    """What the disturbed rays meet, looked up where its mirror image is seen."""
    length = np.linalg.norm(rays, axis=1)
    with np.errstate(divide="ignore"):
        whole = np.minimum(1 / np.maximum(depth, 0), FAR_M)
        before = 1 / np.where(met > 0, met, np.inf)
    beyond = np.maximum(whole - before, 0) * length
    turned = _mirrored(unit, tilted)
    into = np.minimum(np.einsum("ij,ij->i", turned, normals), 0)
    turned = turned - 2 * into[:, None] * normals
    image = place + _mirrored(turned, normals) * beyond[:, None]
    in_eye = pictures.view.pose.inverse().transform(image)
    size = pictures.picture.shape[1::-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        tangents = np.stack([in_eye[:, 0], in_eye[:, 1], -in_eye[:, 2]], axis=1) / -in_eye[:, 2:]
    pixels = (tangents @ pictures.view.fov.pixel_from_tangent(size).T)[:, :2].reshape(*size[::-1], 2)
    # Beside the picture the shader's sampler continues its border, which the twin's counts as
    # nothing.
    near_border = ((pixels < 1) | (pixels > np.array(size) - 1)).any(axis=-1) | ~np.isfinite(pixels).all(axis=-1)
    found = sample_covered(pictures.seen, pixels, np.full(size[::-1], PLACE_ERROR_PX))
    return attrs.evolve(found, undecided=found.undecided | near_border)


def _mirrored(rays: Array, normals: Array) -> Array:
    return rays - 2 * np.einsum("ij,ij->i", rays, normals)[:, None] * normals


def image_by_two_rays(away_m: float, radius_m: float, incidence_rad: float, step: float = 1e-5) -> float:
    """How far behind a ball's surface the image of a point stands, seen at two places of the ball
    `step` radians apart.

    In the plane of the two rays: from a point `away_m` from the surface along the mirrored ray,
    light goes to either place and is thrown back there; where the two lines of sight meet behind
    the surface is the image.
    """

    def normal_at(angle: float) -> Array:
        return np.array([np.sin(angle), np.cos(angle)])

    def turned(vector: Array, angle: float) -> Array:
        c, s = np.cos(angle), np.sin(angle)
        return np.array([c * vector[0] + s * vector[1], -s * vector[0] + c * vector[1]])  # clockwise, as normal_at

    first = radius_m * normal_at(0.0)
    mirrored, incoming = (
        turned(normal_at(0.0), incidence_rad),
        turned(normal_at(0.0), -incidence_rad),
    )  # both away from the surface
    point = first + away_m * mirrored
    second = radius_m * normal_at(step)
    towards_point = (point - second) / np.linalg.norm(point - second)
    normal = normal_at(step)
    towards_eye = 2 * (towards_point @ normal) * normal - towards_point
    # first - a * incoming = second - b * towards_eye
    along = np.linalg.solve(np.stack([incoming, -towards_eye], axis=1), first - second)
    return float(along[0])
