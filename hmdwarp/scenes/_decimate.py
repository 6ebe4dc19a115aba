"""Quadric decimation of many meshes at once; every remaining vertex is one of the originals.

All faces of all meshes are one soup with error quadrics. Vertices collapse onto neighbours; the
cheapest collapses that do not touch each other are made at the same time.
Source: Garland and Heckbert 1997, Surface Simplification Using Quadric Error Metrics (quadrics,
planes that hold borders); 1998, Simplifying Surfaces with Color and Texture Using Quadric Error
Metrics (position, light and uv in one quadric, section 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ._mesh import Mesh

METRES_PER_LIGHT = 0.15  # position error that weighs as much as an error of 1 in light
METRES_PER_METRE_OF_TEXTURE = 0.2
BORDER_WEIGHT = 10.0  # of the plane that holds a border, times the edge's length squared
DIMENSIONS = 8

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]


@attrs.define(eq=False)
class Soup:
    """All faces of a scene, by positions and by wedges.

    A wedge is what the faces on one side of a crease or seam share at a position: one vertex of one
    mesh.
    """

    faces: Indices  # (m, 3) indices into positions, and into wedges
    wedges: Indices
    positions: Array  # (p, 3) metres
    places: Array  # (w, 8) metres: the position of a wedge, its light and uv
    quadrics: Array  # (w, 9, 9) cost of taking a wedge elsewhere
    borders: Array  # (p, 4, 4) cost of leaving a border or a seam

    def edges(self) -> Indices:
        """Return every side, (3 m, 5): from, to, the corner across, wedge from, wedge to."""
        f, w = self.faces, self.wedges
        sides = [(f[:, k], f[:, (k + 1) % 3], f[:, (k + 2) % 3], w[:, k], w[:, (k + 1) % 3]) for k in range(3)]
        return np.concatenate([np.stack(side, axis=1) for side in sides])


def soup_of(meshes: Sequence[Mesh]) -> tuple[Soup, Indices]:
    """Return the soup of all meshes, and the vertex of each wedge, counted through all meshes."""
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.positions) for mesh in meshes])
    moves = np.array([_moves_with(meshes, k) for k in range(len(meshes))])[owner]
    position, light, uv, normal = (
        np.concatenate([getattr(m, name) for m in meshes]) for name in ("positions", "light", "uv", "normals")
    )
    starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])[:-1]
    faces = np.concatenate([m.triangles.astype(np.int64) + s for m, s in zip(meshes, starts, strict=True)])
    first, wedge = _distinct_rows(owner, position, uv, light, normal)
    seat, at = _distinct_rows(moves, position)
    faces = faces[(at[faces] != at[np.roll(faces, 1, axis=1)]).all(axis=1)]  # without area
    scale = np.array([_metres_per_uv(mesh) for mesh in meshes])[owner]
    painted = METRES_PER_METRE_OF_TEXTURE * scale[:, None] * uv
    places = np.concatenate([position, METRES_PER_LIGHT * light, painted], axis=1, dtype=np.float64)
    quadrics = np.zeros((len(first), DIMENSIONS + 1, DIMENSIONS + 1))
    borders = np.zeros((len(seat), 4, 4))
    soup = Soup(at[faces], wedge[faces], position[seat].astype(np.float64), places[first], quadrics, borders)
    _add_faces(soup)
    _add_borders(soup)
    return soup, first


def double_areas(corners: Array) -> Array:
    """Return twice the areas of (m, 3, 3) triangles."""
    return np.asarray(np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1))


def _moves_with(meshes: Sequence[Mesh], index: int) -> int:
    """Return a number that meshes have in common only if they always move together."""
    mesh = meshes[index]
    return mesh.body if mesh.deformation is None else -1 - index


def _distinct_rows(*columns: NDArray[Any]) -> tuple[Indices, Indices]:
    """Return the first index of each distinct row, and for each row which distinct one it is."""
    table = np.concatenate([np.asarray(c, np.float32).reshape(len(c), -1) for c in columns], axis=1)
    table = table + np.float32(0)  # -0 is 0
    rows = np.ascontiguousarray(table).view(np.dtype((np.void, table.shape[1] * 4))).ravel()
    _, first, which = np.unique(rows, return_index=True, return_inverse=True)
    return first, which.reshape(-1)


def _metres_per_uv(mesh: Mesh) -> float:
    """Return the mean size of a texture on the mesh; 0 without one."""
    if mesh.texture < 0:
        return 0.0
    corners, uv = mesh.positions[mesh.triangles].astype(np.float64), mesh.uv[mesh.triangles].astype(np.float64)
    area = double_areas(corners).sum()
    (a, b), (c, d) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    painted = np.abs(a * d - b * c).sum()
    return float(np.sqrt(area / painted)) if painted > 0 else 0.0


def _add_faces(soup: Soup) -> None:
    """Add each face's quadric, by area, to its wedges (Garland and Heckbert 1998, equation 3)."""
    p, q, r = (soup.places[soup.wedges[:, k]] for k in range(3))
    across = _unit(q - p)
    up = r - p
    up = _unit(up - np.einsum("ij,ij->i", up, across)[:, None] * across)
    normal = np.eye(DIMENSIONS) - across[:, :, None] * across[:, None, :] - up[:, :, None] * up[:, None, :]
    linear = -np.einsum("ijk,ik->ij", normal, p)
    quadric = np.empty((len(p), DIMENSIONS + 1, DIMENSIONS + 1))
    quadric[:, :-1, :-1], quadric[:, -1, :-1], quadric[:, :-1, -1] = normal, linear, linear
    quadric[:, -1, -1] = -np.einsum("ij,ij->i", linear, p)
    quadric *= double_areas(soup.positions[soup.faces])[:, None, None] / 2
    for k in range(3):
        np.add.at(soup.quadrics, soup.wedges[:, k], quadric)


def _add_borders(soup: Soup) -> None:
    """Add upright planes through borders and seams to both ends: flat surfaces would shrink."""
    edges = soup.edges()
    held = edges[_is_seam(soup, edges)]
    a, b, c = (soup.positions[held[:, k]] for k in range(3))
    along = b - a
    outward = _unit(np.cross(along, np.cross(along, c - a)))
    plane = np.concatenate([outward, -np.einsum("ij,ij->i", outward, a)[:, None]], axis=1)
    weight = BORDER_WEIGHT * np.einsum("ij,ij->i", along, along)
    quadric = weight[:, None, None] * plane[:, :, None] * plane[:, None, :]
    for k in range(2):
        np.add.at(soup.borders, held[:, k], quadric)


def _is_seam(soup: Soup, edges: Indices) -> Mask:
    """Return which sides lack one smooth next face: borders, creases, seams of texture or light."""
    count = len(soup.positions)
    low, high = np.minimum(edges[:, 0], edges[:, 1]), np.maximum(edges[:, 0], edges[:, 1])
    _, edge, sides = np.unique(low * count + high, return_inverse=True, return_counts=True)
    wedges = np.sort(edges[:, 3:], axis=1)
    _, smooth, same = np.unique(wedges[:, 0] * len(soup.places) + wedges[:, 1], return_inverse=True, return_counts=True)
    return np.asarray((sides[edge.reshape(-1)] != 2) | (same[smooth.reshape(-1)] != 2))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30))


# Share of the possible collapses that may go in a round, or dear ones would go while cheap ones
# wait for neighbours. The next share is tried if fewer vertices than ENOUGH of all faces would go:
# most of the cheap ones may be folds.
CHEAPEST = (0.3, 0.6, 1.0)
ENOUGH = 0.015
LEAST_COSINE = 0.35  # between a face before and after: none turns by more than 70 degrees at a time
LEAST_COMPACTNESS = 0.02  # twice the area over the longest edge squared, unless it was less before


@attrs.frozen(eq=False)
class _Moves:
    """Possible collapses of a vertex u onto v, one per row, with the wedges that move."""

    u: Indices
    v: Indices
    cost: Array  # in metres^4, as the quadrics
    first: Indices  # (n,) where each row's wedges begin in the next two
    wedge_from: Indices  # (k,) wedges of all rows in sequence
    wedge_to: Indices

    def only(self, chosen: Mask | Indices) -> _Moves:
        """Return those rows."""
        row = np.repeat(np.arange(len(self.u)), np.diff([*self.first, len(self.wedge_from)]))
        kept = np.isin(row, np.flatnonzero(chosen) if chosen.dtype == bool else chosen)
        counts = np.diff([*self.first, len(self.wedge_from)])[chosen]
        first = np.cumsum(counts) - counts
        return _Moves(
            self.u[chosen], self.v[chosen], self.cost[chosen], first, self.wedge_from[kept], self.wedge_to[kept]
        )


def collapse_round(soup: Soup, too_many: int) -> float | None:
    """Collapse vertices `too_many` faces at most; return the dearest cost, None for no more."""
    moves = _allowed(soup)
    if not len(moves.u):
        return None
    best = np.full(len(soup.positions), np.inf)
    np.minimum.at(best, moves.u, moves.cost)
    for share in CHEAPEST:
        cheap = moves.only(moves.cost <= np.quantile(best[np.isfinite(best)], share))
        chosen = _apart(soup, cheap, _shape_kept(soup, cheap))
        if len(chosen) >= ENOUGH * len(soup.faces) or (len(chosen) and share == CHEAPEST[-1]):
            most = max(1, too_many // 2)  # two faces go with most vertices
            taken = cheap.only(np.sort(chosen[:most]))
            _collapse(soup, taken)
            return float(taken.cost.max())
    return None


def _allowed(soup: Soup) -> _Moves:
    """Return moves along edges that open no crack and keep the surface one sheet."""
    from scipy import sparse

    count, wedges = len(soup.positions), len(soup.places)
    edges = soup.edges()
    ways = np.concatenate([edges[:, [0, 1, 3, 4]], edges[:, [1, 0, 4, 3]]])
    edge_of_way = ways[:, 0] * count + ways[:, 1]
    order = np.lexsort((ways[:, 3], ways[:, 2], edge_of_way))
    ways, edge_of_way = ways[order], edge_of_way[order]
    new_edge = np.concatenate([[True], edge_of_way[1:] != edge_of_way[:-1]])
    new_wedge = new_edge | np.concatenate([[True], ways[1:, 2] != ways[:-1, 2]])
    torn = ~new_wedge & np.concatenate([[False], ways[1:, 3] != ways[:-1, 3]])  # one wedge to two: a seam begins here
    start = np.flatnonzero(new_edge)
    u, v, sides = ways[start, 0], ways[start, 1], np.diff([*start, len(ways)])
    border, tangled = np.zeros(count, bool), np.zeros(count, bool)
    border[u[sides == 1]], tangled[u[sides > 2]] = True, True
    around = sparse.csr_array((np.ones(len(u), np.int32), (u, v)), shape=(count, count))
    shared = np.asarray((around @ around)[u, v]).reshape(-1)
    reached = np.add.reduceat(new_wedge.astype(np.int64), start)
    allowed = (sides <= 2) & ~tangled[u] & (~border[u] | (sides == 1)) & (shared == sides)
    allowed &= (reached == _wedges_at(soup, count, wedges)[u]) & ~np.logical_or.reduceat(torn, start)
    kept = new_wedge & np.repeat(allowed, sides)
    first = np.cumsum(reached[allowed]) - reached[allowed]
    return _costed(soup, u[allowed], v[allowed], first, ways[kept, 2], ways[kept, 3])


def _wedges_at(soup: Soup, count: int, wedges: int) -> Indices:
    """Return the number of wedges of each position."""
    pairs = np.unique(soup.faces.ravel() * wedges + soup.wedges.ravel())
    return np.bincount(pairs // wedges, minlength=count)


def _costed(soup: Soup, u: Indices, v: Indices, first: Indices, wedge_from: Indices, wedge_to: Indices) -> _Moves:
    if not len(u):
        return _Moves(u, v, np.zeros(0), first, wedge_from, wedge_to)
    cost = np.add.reduceat(_quadric_at(soup.quadrics[wedge_from], soup.places[wedge_to]), first)
    return _Moves(u, v, cost + _quadric_at(soup.borders[u], soup.positions[v]), first, wedge_from, wedge_to)


def _quadric_at(quadrics: Array, places: Array) -> Array:
    at = np.concatenate([places, np.ones((len(places), 1))], axis=1)
    return np.asarray(np.maximum(np.einsum("ij,ij->i", np.einsum("ijk,ik->ij", quadrics, at), at), 0))


@attrs.frozen(eq=False)
class _Rings:
    """Faces around the u of each move."""

    row: Indices  # the move that a face belongs to
    face: Indices
    corner: Indices  # the corner of the face at u


def _rings(soup: Soup, u: Indices) -> _Rings:
    corners = soup.faces.ravel()
    order = np.argsort(corners, kind="stable")
    begin, end = np.searchsorted(corners[order], u), np.searchsorted(corners[order], u, side="right")
    row = np.repeat(np.arange(len(u)), end - begin)
    slot = order[np.arange(len(row)) - np.repeat(np.cumsum(end - begin) - (end - begin), end - begin) + begin[row]]
    return _Rings(row, slot // 3, slot % 3)


def _shape_kept(soup: Soup, moves: _Moves) -> Mask:
    """Return which moves neither turn a face over nor make a sliver of it."""
    ring = _rings(soup, moves.u)
    faces = soup.faces[ring.face]
    staying = (faces != moves.v[ring.row][:, None]).all(axis=1)
    row, face, corner = ring.row[staying], ring.face[staying], ring.corner[staying]
    before = soup.positions[soup.faces[face]]
    after = before.copy()
    after[np.arange(len(row)), corner] = soup.positions[moves.v[row]]
    (old, old_shape), (new, new_shape) = _normals(before), _normals(after)
    bad = np.einsum("ij,ij->i", old, new) < LEAST_COSINE
    bad |= new_shape < np.minimum(LEAST_COMPACTNESS, old_shape)
    kept = np.ones(len(moves.u), bool)
    kept[row[bad]] = False
    return kept


def _normals(corners: Array) -> tuple[Array, Array]:
    """Return unit normals (m, 3) and compactness (m,) of (m, 3, 3) corners."""
    a, b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1], corners[:, 0] - corners[:, 2]
    across = np.cross(a, b)
    double_area = np.linalg.norm(across, axis=1)
    longest = np.max([np.einsum("ij,ij->i", side, side) for side in (a, b, c)], axis=0)
    return across / np.maximum(double_area, 1e-300)[:, None], double_area / np.maximum(longest, 1e-300)


def _apart(soup: Soup, moves: _Moves, possible: Mask) -> Indices:
    """Return the best possible move of each neighbourhood, cheapest first: no two share a face."""
    able = np.flatnonzero(possible)
    order = able[np.lexsort((moves.v[able], moves.u[able], moves.cost[able]))]
    _, best_of_vertex = np.unique(moves.u[order], return_index=True)
    best = order[best_of_vertex]
    order = best[np.lexsort((_mixed(moves.u[best]), _cost_class(moves.cost[best])))]
    ring = _rings(soup, moves.u[order])
    rank = np.full(len(soup.positions), len(order))
    rank[moves.u[order]] = np.arange(len(order))
    alone = np.ones(len(order), bool)
    alone[ring.row[rank[soup.faces[ring.face]].min(axis=1) < ring.row]] = False
    return order[alone]


def _cost_class(cost: Array) -> Indices:
    """Return a class in which costs within a factor of two are equal.

    Strictly cheapest first, rows of vertices wait for each other: 246 rounds instead of 60.
    """
    return np.frexp(np.maximum(cost, 1e-30))[1].astype(np.int64)


def _mixed(numbers: Indices) -> NDArray[np.uint64]:
    """Return a fixed pseudorandom number for each.

    Source: Steele et al. 2014, Fast Splittable Pseudorandom Number Generators (mix64).
    """
    mixed = numbers.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    return mixed ^ (mixed >> np.uint64(27))


def _collapse(soup: Soup, moves: _Moves) -> None:
    to, wedge_to = np.arange(len(soup.positions)), np.arange(len(soup.places))
    to[moves.u], wedge_to[moves.wedge_from] = moves.v, moves.wedge_to
    np.add.at(soup.quadrics, moves.wedge_to, soup.quadrics[moves.wedge_from])
    np.add.at(soup.borders, moves.v, soup.borders[moves.u])
    faces, wedges = to[soup.faces], wedge_to[soup.wedges]
    whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    soup.faces, soup.wedges = faces[whole], wedges[whole]


def decimated(meshes: Sequence[Mesh], share: float) -> list[NDArray[np.uint32]]:
    """Return the triangles of each mesh, as indices into its own vertices, after decimation.

    share: of all triangles; more stay where nothing can collapse without a crack or a fold. Small
    things go as a whole when that changes less than the next collapse. Meshes that meet in a vertex
    still meet there. The result is the same to the last bit every time.
    """
    if not sum(len(mesh.triangles) for mesh in meshes):
        return [mesh.triangles for mesh in meshes]
    soup, original = soup_of(meshes)
    target = round(share * sum(len(mesh.triangles) for mesh in meshes))
    dearest: float | None = 0.0
    while dearest is not None and len(soup.faces) > target:
        dearest = collapse_round(soup, len(soup.faces) - target)
        if dearest is not None and len(soup.faces) > target:
            drop_small(soup, dearest, len(soup.faces) - target)
    starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    corners = original[soup.wedges]
    owner = np.searchsorted(starts, corners[:, 0], side="right") - 1
    return [(corners[owner == k] - starts[k]).astype(np.uint32) for k in range(len(meshes))]


def drop_small(soup: Soup, limit: float, most: int) -> None:
    """Remove connected pieces whose area times their extent squared is below `limit`.

    That product is in metres^4, as the cost of a collapse. The least goes first, at most `most`
    faces. Otherwise boxes that cannot have fewer than their 12 triangles stay and the walls go: 16
    instead of 24 dB at a share of 0.1 of the furnished room.
    """
    piece = _pieces(soup)
    corners, count = soup.positions[soup.faces], int(piece.max(initial=-1)) + 1
    area = np.bincount(piece, double_areas(corners) / 2, minlength=count)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, piece, corners.min(axis=1))
    np.maximum.at(high, piece, corners.max(axis=1))
    cost = area * ((high - low) ** 2).sum(axis=1)
    order = np.argsort(cost, kind="stable")
    faces = np.bincount(piece, minlength=count)[order]
    gone = order[(cost[order] < limit) & (np.cumsum(faces) <= most)]
    staying = ~np.isin(piece, gone)
    soup.faces, soup.wedges = soup.faces[staying], soup.wedges[staying]


def _pieces(soup: Soup) -> Indices:
    """Return (m,) the number of the connected piece that each face belongs to."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    start, end = soup.faces[:, :2].ravel(), soup.faces[:, 1:].ravel()
    count = len(soup.positions)
    _, label = connected_components(
        sparse.coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count)), directed=False
    )
    return np.unique(label[soup.faces[:, 0]], return_inverse=True)[1].reshape(-1)
