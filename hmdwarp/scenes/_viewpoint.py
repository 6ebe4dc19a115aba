"""Where a viewer stands in a file's scene: never inside an object, a wall or the floor.

And what its size says of the file's unit.
"""

from __future__ import annotations

import itertools
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ._draft import Notes

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
    def of(cls, parts: list[tuple[Array, NDArray[Any]]]) -> Triangles:
        corners = [vertices[faces] for vertices, faces in parts]
        every = np.concatenate(corners) if corners else np.empty((0, 3, 3))
        return cls(every[:, 0], every[:, 1], every[:, 2])

    def __len__(self) -> int:
        return len(self.a)

    @cached_property
    def crosses(self) -> Array:
        """(n, 3) normals, of twice the area's length."""
        return np.cross(self.b - self.a, self.c - self.a)

    def chosen(self, which: NDArray[Any] | slice) -> Triangles:
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
        arrays = (self.b - self.a, self.c - self.a, origin - self.a, self.crosses, directions)
        first, second, to_origin, normal, rays = (array.astype(np.float32) for array in arrays)
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


EYE_HEIGHT_M, HEADROOM_M = 1.6, 1.9
_LEAST_HEADROOM_M = 1.0
# Free around the eyes and around the middle of the body.
_ARM_M, _BODY_M = 0.4, 0.3
# A floor is flatter than 45 degrees, in the lower half of the scene, and below this share of it.
_FLAT, _LOW, _FLOOR_SHARE = 0.7, 0.5, 0.25
_LEVEL_M = 0.5
_GRID, _TRIED = 15, 60
# Shares seen from behind: of all directions inside a thing, and of what is seen in a free place,
# where single sheets may turn their backs.
_MOST_BEHIND, _FEW_BEHIND = 0.4, 0.25
_ANGLE_DEG = 25.0  # half of what an object fills
_AROUND = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])
_AROUND /= np.linalg.norm(_AROUND, axis=1, keepdims=True)
_RING = np.array([(np.sin(a), 0.0, -np.cos(a)) for a in np.arange(16) * np.pi / 8])
_AHEAD = np.array([(x, y, -1.0) for x in (-0.5, -0.25, 0.0, 0.25, 0.5) for y in (-0.35, 0.0, 0.2)])
_AHEAD /= np.linalg.norm(_AHEAD, axis=1, keepdims=True)


@attrs.frozen(eq=False)
class Place:
    """A viewer's place in the file's world, metres, +y up."""

    eye: Array  # (3,) between the eyes
    yaw_deg: float  # to the left of -z
    reach: Array  # (2, 3) how far the head may go from there, along its own axes


def free_place(triangles: Triangles, low: Array, high: Array) -> Place:
    """Return a place in a scene from corner `low` to `high`.

    In a scene of a room's size (3 m or more across, 2 m high) with a floor, the viewer stands on it
    near its middle. Anything else is an object, seen from +z at the height of its middle, where it
    fills about 50 degrees.
    """
    size = high - low
    if size[0] >= 3 and size[2] >= 3 and size[1] >= 2:
        for eye in itertools.islice(_places(triangles, low, high), _TRIED):
            if _is_free(triangles, eye):
                return place_at(triangles, eye[:3], _open_side(triangles, eye[:3], float(size.max())), size)
    distance = max(float(max(size[0], size[1])) / (2 * np.tan(np.radians(_ANGLE_DEG))), 0.05)
    eye = np.array([*((low + high) / 2)[:2], high[2] + distance])
    return Place(eye, 0.0, np.array([[-distance / 2] * 3, [distance / 2] * 3]))


def place_at(triangles: Triangles, eye: Array, yaw_deg: float, size: Array) -> Place:
    """Return a place and what is free around it, up to a quarter of the scene's size."""
    turn = _turn(yaw_deg)
    most = np.maximum(0.25 * size, 0.3)[[0, 2]].max()
    limits = np.array([[most, 0.8, most], [most, 0.6, most]])
    free = triangles.first_hits(eye, np.concatenate([-turn.T, turn.T]))[0].reshape(2, 3)
    return Place(eye, yaw_deg, np.minimum(limits, 0.8 * free) * ((-1.0,), (1.0,)))


def is_inside(triangles: Triangles, eye: Array) -> bool:
    """Return whether surfaces are seen from behind in most directions."""
    return bool(triangles.first_hits(eye, _AROUND)[1].mean() > _MOST_BEHIND)


def _turn(yaw_deg: float) -> Array:
    sine, cosine = np.sin(np.radians(yaw_deg)), np.cos(np.radians(yaw_deg))
    return np.array([(cosine, 0, sine), (0, 1, 0), (-sine, 0, cosine)])


def _places(triangles: Triangles, low: Array, high: Array) -> list[Array]:
    """Return (x, y, z, floor) of eyes above a floor: the file's origin, then from the middle."""
    shares = (np.arange(_GRID) + 0.5) / _GRID
    size, middle = high - low, (low + high) / 2
    found = []
    for x in low[0] + shares * size[0]:
        slab = triangles.near(np.array([x, *low[1:]]), np.array([x, *high[1:]]))
        for z in low[2] + shares * size[2]:
            found += [(x, z, *floor) for floor in _floor_at(slab, x, z, low, high)]
    if len(found) < _FLOOR_SHARE * _GRID**2:
        return []
    ground = float(np.median([floor for _, _, floor, _ in found]))
    if (low < 0)[[0, 2]].all() and (high > 0)[[0, 2]].all():
        found += [(0.0, 0.0, *floor) for floor in _floor_at(triangles, 0.0, 0.0, low, high)]

    def worth(one: tuple[float, float, float, float]) -> tuple[bool, bool, float]:
        x, z, floor, headroom = one
        apart = np.hypot(x - middle[0], z - middle[2]) if (x, z) != (0.0, 0.0) else -1.0
        return headroom < HEADROOM_M, abs(floor - ground) > _LEVEL_M, float(apart)

    ordered = sorted(found, key=worth)
    heights = [EYE_HEIGHT_M if room >= HEADROOM_M else 0.6 * room for *_, room in ordered]
    return [np.array([x, floor + up, z, floor]) for (x, z, floor, _), up in zip(ordered, heights, strict=True)]


def _floor_at(triangles: Triangles, x: float, z: float, low: Array, high: Array) -> list[tuple[float, float]]:
    """Return the lowest floor there to stand on, and the headroom above it; else nothing."""
    heights, up = triangles.heights_at(x, z)
    for height, flat in zip(heights, up, strict=True):
        above = np.flatnonzero(heights > height + 0.01)
        headroom = float(heights[above[0]] - height) if len(above) else np.inf
        # What is seen from behind overhead is the top of a solid thing, or a roof of one sheet.
        least = HEADROOM_M if len(above) and up[above[0]] > 0 else _LEAST_HEADROOM_M
        if flat >= _FLAT and headroom >= least and height <= low[1] + _LOW * (high - low)[1]:
            return [(float(height), headroom)]
    return []


def _is_free(triangles: Triangles, place: Array) -> bool:
    eye = place[:3]
    body = np.array([eye[0], (eye[1] + place[3]) / 2, eye[2]])
    for middle, least in ((eye, _ARM_M), (body, _BODY_M)):
        if (triangles.near(middle - 0.5, middle + 0.5).first_hits(middle, _RING)[0] < least).any():
            return False
    distance, behind = triangles.first_hits(eye, _AROUND)
    return bool(float(behind.sum()) <= _FEW_BEHIND * np.isfinite(distance).sum())


def _open_side(triangles: Triangles, eye: Array, size: float) -> float:
    """Return a yaw at which something is seen, not too near; 0 if it is so there."""
    seen = {}
    for yaw in (0.0, 90.0, 180.0, -90.0):
        distance, _ = triangles.first_hits(eye, _AHEAD @ _turn(yaw).T)
        seen[yaw] = float(((distance >= 1) & (distance <= size)).mean())
        if seen[yaw] >= 0.5:
            return yaw
    return max(seen, key=lambda yaw: seen[yaw])


# Larger than a hall, which is rarely meant in metres; and smaller than a head moves, which goes
# past it or through it.
_LARGE_M, _SMALL_M = 50.0, 0.2
# What a file in these units may hold: from a thing in the hand to a hall.
_UNITS = (("a centimetre", 0.01), ("a millimetre", 0.001))
_LIKELY_M = 0.05, 50.0
_LARGEST_SCALE = 1e6  # the most that --scene-scale takes


def add_hints(size: float, scale: float, notes: Notes) -> None:
    """Note a size that is rarely meant in metres. scale: as the option has it."""
    if scale == 1 and size > _LARGE_M:
        fits = [unit for unit in _UNITS if _LIKELY_M[0] <= unit[1] * size <= _LIKELY_M[1]] or _UNITS[-1:]
        units = (f"{name}, --scene-scale {metres:g} makes it {_metres(metres * size)}" for name, metres in fits)
        notes.add(f"{_metres(size)} across; if its unit is {' or '.join(units)}")
    if scale == 1 and size < _SMALL_M:
        larger = min(10 ** round(-np.log10(size)), _LARGEST_SCALE)
        remedy = f"--scene-scale {larger:g} makes it {_metres(larger * size)}"
        notes.add(f"{_metres(size)} across, and a head moves farther; {remedy}")


def _metres(metres: float) -> str:
    """Return a length in metres to three digits, in powers of ten only where zeros abound."""
    return f"{float(f'{metres:.3g}'):.15g} m" if 1e-4 <= metres < 1e7 else f"{metres:.3g} m"
