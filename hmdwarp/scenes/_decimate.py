"""Quadric decimation of many meshes at once; every remaining vertex is one of the originals.

Vertices collapse onto neighbours. Source: Garland and Heckbert 1997 and 1998, see _soup.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ._collapses import collapse_round
from ._mesh import Mesh
from ._soup import Indices, Soup, double_areas, soup_of


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
