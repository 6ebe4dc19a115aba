"""Rays against shapes in float64.

What the server should have drawn, found without matrices or rasterising.

Directions come from `_rays.world_directions`: of length 1 along the view axis, so that 1/t is
inverse depth. Source for triangles: Moeller and Trumbore 1997, Fast, Minimum Storage Ray/Triangle
Intersection.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@attrs.frozen(eq=False)
class Hits:
    """What each ray met first.

    `inverse_depth` in 1/m along the eye's -z (0: nothing), `shape` index (-1: nothing), surface
    `uv`.

    cosine: |cosine| between ray and surface, 1 where nothing was met; small near silhouettes of
    round things.
    """

    inverse_depth: Array
    shape: NDArray[np.int64]
    uv: Array
    cosine: Array


def _empty(count: int) -> Hits:
    return Hits(np.zeros(count), np.full(count, -1), np.zeros((count, 2)), np.ones(count))


def nearest(*found: Hits) -> Hits:
    """The first of several hits of the same rays; shapes are numbered on."""
    out, offset = _empty(len(found[0].inverse_depth)), 0
    for hits in found:
        nearer = hits.inverse_depth > out.inverse_depth
        shape = np.where(hits.shape >= 0, hits.shape + offset, -1)
        out = Hits(
            np.where(nearer, hits.inverse_depth, out.inverse_depth),
            np.where(nearer, shape, out.shape),
            np.where(nearer[:, None], hits.uv, out.uv),
            np.where(nearer, hits.cosine, out.cosine),
        )
        offset += int(hits.shape.max(initial=-1)) + 1
    return out


def cast_quads(quads: ArrayLike, eye: Array, rays: Array) -> Hits:
    """Rays (n, 3) from `eye` against quads given as (centre, right, up) half edges, shape (k, 3,
    3). uv runs -1..1 on the quad."""
    out = _empty(len(rays))
    for index, (centre, right, up) in enumerate(np.asarray(quads, np.float64)):
        normal = np.cross(right, up)
        slope = rays @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = slope / ((centre - eye) @ normal)
            at = rays / inverse[:, None] - (centre - eye)
        to_right, to_up = np.cross(up, normal), np.cross(normal, right)  # each at right angles to the other edge
        uv = np.stack([at @ to_right / (right @ to_right), at @ to_up / (up @ to_up)], axis=-1)
        hit = (inverse > out.inverse_depth) & (np.abs(uv) <= 1).all(axis=1)
        out.inverse_depth[hit], out.shape[hit], out.uv[hit] = inverse[hit], index, uv[hit]
        out.cosine[hit] = np.abs(slope[hit]) / (np.linalg.norm(rays[hit], axis=1) * np.linalg.norm(normal))
    return out


def cast_spheres(spheres: ArrayLike, eye: Array, rays: Array) -> Hits:
    """Rays (n, 3) from `eye`, outside all spheres, against spheres (k, 4): centre and radius. uv is
    not set."""
    out = _empty(len(rays))
    squared = np.einsum("ij,ij->i", rays, rays)
    for index, (*centre, radius) in enumerate(np.asarray(spheres, np.float64)):
        to_centre = np.array(centre) - eye
        along = rays @ to_centre
        under_root = along**2 - squared * (to_centre @ to_centre - radius**2)
        with np.errstate(invalid="ignore", divide="ignore"):
            root = np.sqrt(under_root)
            inverse = squared / (along - root)
        hit = (under_root > 0) & (inverse > out.inverse_depth)
        out.inverse_depth[hit], out.shape[hit] = inverse[hit], index
        out.cosine[hit] = root[hit] / (np.sqrt(squared[hit]) * radius)
    return out


def cast_triangles(corners: ArrayLike, eye: Array, rays: Array) -> Hits:
    """Rays (n, 3) from `eye` against triangles (m, 3, 3), both sides. uv are the barycentric
    weights of corners 1 and 2."""
    corners = np.asarray(corners, np.float64)
    start, edge_1, edge_2 = corners[:, 0] - eye, corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    out = _empty(len(rays))
    normal, across = np.cross(edge_1, edge_2), np.cross(-start, edge_1)
    distance = np.einsum("ij,ij->i", across, edge_2)
    for index, ray in enumerate(rays):
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = -(normal @ ray)
            u = np.einsum("ij,ij->i", np.cross(ray, edge_2), -start) / slope
            v = (across @ ray) / slope
            inverse = slope / distance
        inverse[~((u >= 0) & (v >= 0) & (u + v <= 1) & (inverse > 0))] = 0
        best = int(np.argmax(inverse))
        if inverse[best] > 0:
            out.inverse_depth[index], out.shape[index], out.uv[index] = inverse[best], best, (u[best], v[best])
            out.cosine[index] = abs(slope[best]) / (np.linalg.norm(ray) * np.linalg.norm(normal[best]))
    return out


def away_from_edges(shape: Array) -> Array:
    """Pixels (h, w) whose 3 x 3 neighbours all meet the same shape; none at the border."""
    same, inner = np.zeros(shape.shape, bool), shape[1:-1, 1:-1]
    around = np.lib.stride_tricks.sliding_window_view(shape, (3, 3))
    same[1:-1, 1:-1] = (around == inner[..., None, None]).all(axis=(2, 3))
    return same
