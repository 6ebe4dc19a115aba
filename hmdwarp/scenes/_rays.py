"""Rays against triangles in NumPy, for the few that choose a viewer's place."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_EDGE = 1e-5  # of a triangle, so that no ray slips between two
_TOUCHING_M = 1e-4  # behind a ray's start, which may lie on a surface
_AT_ONCE = 8192  # triangles; with 26 rays its arrays stay in the cache


@attrs.define(eq=False, frozen=True, slots=False)
class Triangles:
    """Triangles by corner, each (n, 3)."""

    a: Array
    b: Array
    c: Array

    @classmethod
    def of(cls, parts: list[tuple[Array, NDArray]]) -> Triangles:
        """Return the triangles of several (vertices, faces)."""
        corners = [vertices[faces] for vertices, faces in parts]
        every = np.concatenate(corners) if corners else np.empty((0, 3, 3))
        return cls(every[:, 0], every[:, 1], every[:, 2])

    def __len__(self) -> int:
        return len(self.a)

    @cached_property
    def crosses(self) -> Array:
        """(n, 3) normals, of twice the area's length."""
        return np.cross(self.b - self.a, self.c - self.a)

    def chosen(self, which: NDArray | slice) -> Triangles:
        """Return some of them."""
        return Triangles(self.a[which], self.b[which], self.c[which])

    def near(self, low: Array, high: Array) -> Triangles:
        """Return those whose bounding boxes reach into a box."""
        least, most = self._boxes
        return self.chosen(np.flatnonzero(((least <= high) & (most >= low)).all(axis=1)))

    @cached_property
    def _boxes(self) -> tuple[Array, Array]:
        corners = self.a, self.b, self.c
        return np.minimum.reduce(corners), np.maximum.reduce(corners)

    def first_hits(self, origin: Array, directions: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Return (r,) distances along (r, 3) unit vectors, inf for none; and whether from behind.

        Source: Moeller and Trumbore 1997, Fast, Minimum Storage Ray-Triangle Intersection.
        """
        distance, behind = np.full(len(directions), np.inf), np.zeros(len(directions), bool)
        for start in range(0, len(self), _AT_ONCE):
            nearer, back = self.chosen(slice(start, start + _AT_ONCE))._hits(origin, directions)
            behind = np.where(nearer < distance, back, behind)
            distance = np.minimum(nearer, distance)
        return distance, behind

    def _hits(self, origin: Array, directions: Array) -> tuple[Array, NDArray[np.bool_]]:
        # Differences in float64, then float32: twice as quick, and metres keep their micrometres.
        first, second, to_origin, normal, rays = (
            array.astype(np.float32)
            for array in (self.b - self.a, self.c - self.a, origin - self.a, self.crosses, directions)
        )
        facing = rays @ normal.T
        with np.errstate(all="ignore"):
            scale = -1 / facing
            u = (rays @ np.cross(second, to_origin).T) * scale
            v = (rays @ np.cross(to_origin, first).T) * scale
            t = np.einsum("ij,ij->i", to_origin, normal)[None, :] * scale
            hit = (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE) & (t > -_TOUCHING_M) & (facing != 0)
        t = np.where(hit, t, np.float32(np.inf))
        nearest = np.argmin(t, axis=1)
        rows = np.arange(len(directions))
        return t[rows, nearest], hit[rows, nearest] & (facing[rows, nearest] > 0)

    def heights_at(self, x: float, z: float) -> tuple[Array, Array]:
        """Return the ascending heights at which a vertical line meets them, and ny of each."""
        low, high = np.array([x, -np.inf, z]), np.array([x, np.inf, z])
        few = self.near(low, high)
        cross = few.crosses
        with np.errstate(all="ignore"):
            up = cross[:, 1]
            y = few.a[:, 1] - ((x - few.a[:, 0]) * cross[:, 0] + (z - few.a[:, 2]) * cross[:, 2]) / up
            steep = up / np.linalg.norm(cross, axis=1)
        inside = np.ones(len(few), bool)
        for start, end in ((few.a, few.b), (few.b, few.c), (few.c, few.a)):
            side = (end[:, 0] - start[:, 0]) * (z - start[:, 2]) - (end[:, 2] - start[:, 2]) * (x - start[:, 0])
            inside &= side * np.sign(up) <= 1e-12
        good = inside & np.isfinite(y) & (np.abs(steep) > 1e-6)
        order = np.argsort(y[good], kind="stable")
        return y[good][order], steep[good][order]
