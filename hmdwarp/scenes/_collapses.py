"""Edge collapses: which vertices may collapse onto which neighbours, and at what cost.

The cheapest collapses that do not touch each other are made at the same time.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ._soup import Array, Indices, Mask, Soup

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
    # In metres^4, as the quadrics.
    cost: Array
    # (n,) where each row's wedges begin in the next two.
    first: Indices
    # (k,) wedges of all rows in sequence.
    wedge_from: Indices
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
    """Collapse some vertices, so that at most about `too_many` faces go.

    Returns the highest cost of a collapse; None if nothing more can be collapsed.
    """
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
    return np.maximum(np.einsum("ij,ij->i", np.einsum("ijk,ik->ij", quadrics, at), at), 0)


@attrs.frozen(eq=False)
class _Rings:
    """Faces around the u of each move."""

    # The move that a face belongs to.
    row: Indices
    face: Indices
    # The corner of the face at u.
    corner: Indices


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
