"""All faces of many meshes as one soup with error quadrics, ready to be decimated.

Source: Garland and Heckbert 1997, Surface Simplification Using Quadric Error Metrics (quadrics,
planes that hold borders); 1998, Simplifying Surfaces with Color and Texture Using Quadric Error
Metrics (position, light and uv in one quadric, section 3).
"""

from __future__ import annotations

from collections.abc import Sequence

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

    # (m, 3) indices into positions, and into wedges.
    faces: Indices
    wedges: Indices
    # (p, 3) metres.
    positions: Array
    # (w, 8) metres: the position of a wedge, its light and uv.
    places: Array
    # (w, 9, 9) cost of taking a wedge elsewhere.
    quadrics: Array
    # (p, 4, 4) cost of leaving a border or a seam.
    borders: Array

    def edges(self) -> Indices:
        """Return every side of every face, (3 m, 5).

        Columns: from, to, the corner across, wedge from, wedge to.
        """
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
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def _moves_with(meshes: Sequence[Mesh], index: int) -> int:
    """Return a number that meshes have in common only if they always move together."""
    mesh = meshes[index]
    return mesh.body if mesh.deformation is None else -1 - index


def _distinct_rows(*columns: NDArray) -> tuple[Indices, Indices]:
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
    """Add the quadric of every face, by its area, to its three wedges.

    Source: Garland and Heckbert 1998, equation 3.
    """
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
    """Add planes through borders and seams, upright on their faces, to both ends.

    Flat and even surfaces would shrink without them.
    """
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
    """Return which sides do not continue smoothly into exactly one other face.

    These are borders, creases, and seams of texture or light.
    """
    count = len(soup.positions)
    low, high = np.minimum(edges[:, 0], edges[:, 1]), np.maximum(edges[:, 0], edges[:, 1])
    _, edge, sides = np.unique(low * count + high, return_inverse=True, return_counts=True)
    wedges = np.sort(edges[:, 3:], axis=1)
    _, smooth, same = np.unique(wedges[:, 0] * len(soup.places) + wedges[:, 1], return_inverse=True, return_counts=True)
    return (sides[edge.reshape(-1)] != 2) | (same[smooth.reshape(-1)] != 2)


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)
