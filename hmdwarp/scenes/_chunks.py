"""Meshes in compact chunks, small enough to cull or to send one by one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._mesh import Mesh

CHUNK_TRIANGLES = 1024


def chunks_of(mesh: Mesh) -> list[NDArray[np.uint32]]:
    """Return the mesh's triangles in compact pieces of at most CHUNK_TRIANGLES."""
    triangles = mesh.triangles
    if len(triangles) <= CHUNK_TRIANGLES:
        return [triangles] if len(triangles) else []
    order = np.argsort(morton(mesh.positions[triangles].mean(axis=1)), kind="stable")
    return np.array_split(triangles[order], -(-len(triangles) // CHUNK_TRIANGLES))


def morton(points: NDArray) -> NDArray[np.uint64]:
    """Return the Z-order of points, 10 bits per axis: close in order is close in space."""
    low, high = points.min(axis=0), points.max(axis=0)
    cell = ((points - low) / max(float((high - low).max()), 1e-30) * 1023).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cell[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return code
