"""Quadric decimation of many meshes at once: vertices collapse onto neighbours, so that every one that stays is one of the originals.

Source: Garland and Heckbert 1997, Surface Simplification Using Quadric Error Metrics (quadrics, planes that hold borders); 1998,
Simplifying Surfaces with Color and Texture Using Quadric Error Metrics (position, light and uv in one quadric, section 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from . import _collapses

if TYPE_CHECKING:
    from ._model import Mesh

METRES_PER_LIGHT = 0.15  # how far a vertex may lie off for its light to be off by 1
METRES_PER_METRE_OF_TEXTURE = 0.2
BORDER_WEIGHT = 10.0  # of the plane that holds a border, times the edge's length squared
DIMENSIONS = 8

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@attrs.define(eq=False)
class Soup:
    """All faces of a scene, by positions and by wedges.

    A wedge is what the faces on one side of a crease or seam share at a position: one vertex of one mesh. faces, wedges: (m, 3).
    positions: (p, 3) metres. places: (w, 8) metres, where a wedge lies with its light and uv. quadrics: (w, 9, 9), what it costs to
    take it elsewhere; borders: (p, 4, 4), what it costs to leave a border or a seam.
    """

    faces: Indices
    wedges: Indices
    positions: Array
    places: Array
    quadrics: Array
    borders: Array


def decimated(meshes: Sequence[Mesh], share: float) -> list[NDArray[np.uint32]]:
    """The triangles of each mesh, indices into its own vertices, after as many collapses as leave `share` of all of them.

    Small things go as a whole when that changes less than the next collapse. What can neither go nor be collapsed without a crack or a
    fold stays, so that it may be more. Meshes that meet in a vertex still meet there. The same to the last bit every time.
    """
    if not sum(len(mesh.triangles) for mesh in meshes):
        return [mesh.triangles for mesh in meshes]
    soup, original = _soup(meshes)
    wanted = round(share * sum(len(mesh.triangles) for mesh in meshes))
    dearest = 0.0
    while dearest is not None and len(soup.faces) > wanted:
        dearest = _collapses.one_round(soup, len(soup.faces) - wanted)
        if dearest is not None and len(soup.faces) > wanted:
            drop_small(soup, dearest, len(soup.faces) - wanted)
    starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    corners = original[soup.wedges]
    owner = np.searchsorted(starts, corners[:, 0], side="right") - 1
    return [(corners[owner == k] - starts[k]).astype(np.uint32) for k in range(len(meshes))]


def drop_small(soup: Soup, limit: float, most: int) -> None:
    """Leave out what hangs together with nothing else and whose area times its extent squared (metres^4, as the cost of a collapse) is
    below `limit`, the least first, at most `most` faces.

    Without that, boxes that cannot have fewer than their 12 triangles stay and the walls go: 16 instead of 24 dB at a share of 0.1 of the
    furnished room.
    """
    piece = _pieces(soup)
    corners, count = soup.positions[soup.faces], int(piece.max(initial=-1)) + 1
    area = np.bincount(piece, _double_areas(corners) / 2, minlength=count)
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
    """(m,) which of the pieces that hang together each face belongs to, 0 and up."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    start, end = soup.faces[:, :2].ravel(), soup.faces[:, 1:].ravel()
    count = len(soup.positions)
    _, label = connected_components(
        sparse.coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count)), directed=False
    )
    return np.unique(label[soup.faces[:, 0]], return_inverse=True)[1].reshape(-1)


def _double_areas(corners: Array) -> Array:
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def _soup(meshes: Sequence[Mesh]) -> tuple[Soup, Indices]:
    """Everything before the first collapse, and which vertex (counted through all meshes) each wedge is."""
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.positions) for mesh in meshes])
    moves = np.array([_moves_with(meshes, k) for k in range(len(meshes))])[owner]
    position, light, uv, normal = (
        np.concatenate([getattr(m, name) for m in meshes]) for name in ("positions", "light", "uv", "normals")
    )
    faces = np.concatenate([m.triangles.astype(np.int64) + s for m, s in zip(meshes, _starts(meshes), strict=True)])
    first, wedge = _same_rows(owner, position, uv, light, normal)
    seat, at = _same_rows(moves, position)
    whole = (at[faces] != at[np.roll(faces, 1, axis=1)]).all(axis=1)
    faces = faces[whole]
    scale = np.array([_metres_per_uv(mesh) for mesh in meshes])[owner]
    painted = METRES_PER_METRE_OF_TEXTURE * scale[:, None] * uv
    places = np.concatenate([position, METRES_PER_LIGHT * light, painted], axis=1, dtype=np.float64)
    quadrics = np.zeros((len(first), DIMENSIONS + 1, DIMENSIONS + 1))
    borders = np.zeros((len(seat), 4, 4))
    soup = Soup(at[faces], wedge[faces], position[seat].astype(np.float64), places[first], quadrics, borders)
    _add_faces(soup)
    _add_borders(soup)
    return soup, first


def _starts(meshes: Sequence[Mesh]) -> Indices:
    return np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])[:-1]


def _moves_with(meshes: Sequence[Mesh], index: int) -> int:
    """A number that only meshes have in common that always move together."""
    mesh = meshes[index]
    return mesh.body if mesh.deformation is None else -1 - index


def _same_rows(*columns: NDArray) -> tuple[Indices, Indices]:
    """(index of the first of each distinct row, which distinct row each row is)."""
    table = np.concatenate([np.float32(c).reshape(len(c), -1) for c in columns], axis=1) + np.float32(0)  # -0 is 0
    rows = np.ascontiguousarray(table).view(np.dtype((np.void, table.shape[1] * 4))).ravel()
    _, first, which = np.unique(rows, return_index=True, return_inverse=True)
    return first, which.reshape(-1)


def _metres_per_uv(mesh: Mesh) -> float:
    """How large the texture lies on the mesh, in the mean; 0 where there is none."""
    if mesh.texture < 0:
        return 0.0
    corners, uv = mesh.positions[mesh.triangles].astype(np.float64), mesh.uv[mesh.triangles].astype(np.float64)
    area = _double_areas(corners).sum()
    (a, b), (c, d) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    painted = np.abs(a * d - b * c).sum()
    return float(np.sqrt(area / painted)) if painted > 0 else 0.0


def _add_faces(soup: Soup) -> None:
    """The quadric of every face, by its area, to its three wedges. Source: Garland and Heckbert 1998, equation 3."""
    p, q, r = (soup.places[soup.wedges[:, k]] for k in range(3))
    across = _unit(q - p)
    up = r - p
    up = _unit(up - np.einsum("ij,ij->i", up, across)[:, None] * across)
    normal = np.eye(DIMENSIONS) - across[:, :, None] * across[:, None, :] - up[:, :, None] * up[:, None, :]
    linear = -np.einsum("ijk,ik->ij", normal, p)
    quadric = np.empty((len(p), DIMENSIONS + 1, DIMENSIONS + 1))
    quadric[:, :-1, :-1], quadric[:, -1, :-1], quadric[:, :-1, -1] = normal, linear, linear
    quadric[:, -1, -1] = -np.einsum("ij,ij->i", linear, p)
    quadric *= _double_areas(soup.positions[soup.faces])[:, None, None] / 2
    for k in range(3):
        np.add.at(soup.quadrics, soup.wedges[:, k], quadric)


def _add_borders(soup: Soup) -> None:
    """Planes through borders and seams, upright on their faces, to both ends: what is flat and even would shrink without them."""
    edges = _collapses.edges_of(soup)
    held = edges[_collapses.is_seam(soup, edges)]
    a, b, c = (soup.positions[held[:, k]] for k in range(3))
    along = b - a
    outward = _unit(np.cross(along, np.cross(along, c - a)))
    plane = np.concatenate([outward, -np.einsum("ij,ij->i", outward, a)[:, None]], axis=1)
    weight = BORDER_WEIGHT * np.einsum("ij,ij->i", along, along)
    quadric = weight[:, None, None] * plane[:, :, None] * plane[:, None, :]
    for k in range(2):
        np.add.at(soup.borders, held[:, k], quadric)


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)
