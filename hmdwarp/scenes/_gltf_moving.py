"""Moving content of a glTF file: rigid bodies, vertices driven by a non-rigid node, skins."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..geometry import Pose, RigidState
from ._gltf_file import GltfFile
from ._gltf_nodes import Nodes
from ._notes import Notes

Array = NDArray[np.float64]
# A chain of nodes is rigid if lengths change by less than this share: float32 rotations are off by
# 1e-7 each.
RIGID = 1e-5
# Weights may miss a sum of 1 by this much without a note: half a byte's step for each of four is
# 0.008.
MOST_OFF = 0.01


@attrs.define(eq=False, frozen=True, slots=False)
class NodeMotion:
    """Motion of a rigid node; the body has the node's origin and axes, without its scale."""

    nodes: Nodes
    node: int

    @cached_property
    def _without_turn(self) -> Array:
        """3x3 inverse of the node's size and shape at time 0: the polar part of world_from_node."""
        left, sizes, right = np.linalg.svd(self.nodes.at(self.node, 0)[0][:3, :3])
        # A mirrored node keeps its mirroring in its shape.
        flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        return np.linalg.inv(right.T @ flip @ np.diag(sizes) @ right)

    def state(self, time_ns: int) -> RigidState:
        """Return the pose and its derivatives at `time_ns`."""
        placed, moving = self.nodes.at(self.node, time_ns)
        rotation = Rotation.from_matrix(placed[:3, :3] @ self._without_turn)
        across = moving[:3, :3] @ np.linalg.inv(placed[:3, :3])
        spin = 0.5 * np.array([across[2, 1] - across[1, 2], across[0, 2] - across[2, 0], across[1, 0] - across[0, 1]])
        return RigidState(Pose(placed[:3, 3], rotation.as_quat()), moving[:3, 3], spin)


def is_rigid(nodes: Nodes, node: int) -> bool:
    """Return whether the node keeps its size and shape at all key times and midway between them."""
    start = nodes.at(node, 0)[0][:3, :3]
    if abs(np.linalg.det(start)) < 1e-12:
        return False
    keys = np.unique(
        np.concatenate([c.times_s for one in nodes.line(node) for c in nodes.curves.get(one, {}).values()])
    )
    for seconds in np.union1d(keys, (keys[1:] + keys[:-1]) / 2):
        turn = nodes.at(node, round(seconds * 1e9))[0][:3, :3] @ np.linalg.inv(start)
        if np.abs(turn.T @ turn - np.eye(3)).max() > RIGID or np.linalg.det(turn) < 0:
            return False
    return True


@attrs.frozen(eq=False)
class Driven:
    """Vertices driven by nodes: a skin (linear blend skinning), or all by one non-rigid node."""

    nodes: Nodes
    # (n, 3) as in the file.
    rest: Array
    # Indices of the driving nodes.
    joints: Sequence[int]
    # (j, 4, 4) joint_from_rest.
    inverse: Array
    # (n, k) indices into joints, and their weights.
    which: NDArray[np.int64]
    weights: Array
    # Origin of the scene.
    origin: Array

    def _blended(self, time_ns: int, derivative: int) -> Array:
        pairs = zip(self.joints, self.inverse, strict=True)
        matrices = np.array([self.nodes.at(joint, time_ns)[derivative] @ inverse for joint, inverse in pairs])
        blended = np.einsum("nk,nkij->nij", self.weights, matrices[self.which][..., :3, :])
        return np.einsum("nij,nj->ni", blended[:, :, :3], self.rest) + blended[:, :, 3]

    def positions(self, time_ns: int) -> Array:
        """Return (n, 3) metres relative to the scene's origin."""
        return self._blended(time_ns, 0) - self.origin

    def velocities(self, time_ns: int) -> Array:
        """Return (n, 3) m/s in world axes."""
        return self._blended(time_ns, 1)

    def seen_from(self, origin: Array) -> Driven:
        """Return the same in a scene with that origin."""
        return attrs.evolve(self, origin=np.array(origin, np.float64))


def driven_by_node(nodes: Nodes, node: int, rest: Array) -> Driven:
    """Return a deformation in which one node drives all vertices."""
    count = len(rest)
    return Driven(
        nodes, rest, [node], np.eye(4)[None], np.zeros((count, 1), np.int64), np.ones((count, 1)), np.zeros(3)
    )


def skinned(file: GltfFile, nodes: Nodes, skin: int, primitive: dict, rest: Array, notes: Notes) -> Driven:
    """Return a primitive under a skin; its weights are scaled to sum 1, with a note if need be.

    Errors: SceneError, naming the skin, if joints or weights do not fit.
    """
    found = file.item("skins", skin, "a node")
    name = f"skin '{found.get('name') or skin}'"
    joints = found.get("joints", [])
    for joint in joints:
        file.item("nodes", joint, name)
    attributes = primitive.get("attributes", {})
    if "JOINTS_0" not in attributes or "WEIGHTS_0" not in attributes:
        raise file.error(f"{name}: a mesh without joints and weights (JOINTS_0, WEIGHTS_0); export it again")
    sets = [k for k in range(4) if f"JOINTS_{k}" in attributes]

    def columns(kind: str) -> NDArray:
        return np.concatenate([file.numbers(attributes.get(f"{kind}_{k}"), name, 4) for k in sets], axis=1)

    which, weights = columns("JOINTS").astype(np.int64), columns("WEIGHTS").astype(np.float64)
    if len(which) != len(rest) or len(weights) != len(rest):
        raise file.error(
            f"{name}: {len(rest)} positions, {len(which)} joints, {len(weights)} weights; expected as many of each"
        )
    weights = _with_sum_1(file, name, weights, notes)
    used = weights > 0
    if (which[used] >= len(joints)).any():
        raise file.error(f"{name}: a vertex uses joint {int(which[used].max())}, there are {len(joints)}")
    which[~used] = 0
    inverse = _inverse_bind_matrices(file, found, name, len(joints))
    return Driven(nodes, rest, joints, inverse, which, weights, np.zeros(3))


def _inverse_bind_matrices(file: GltfFile, skin: dict, name: str, count: int) -> Array:
    """Return (count, 4, 4) joint_from_rest; the identity where the skin lacks them."""
    if "inverseBindMatrices" not in skin:
        return np.tile(np.eye(4), (count, 1, 1))
    found = file.numbers(skin["inverseBindMatrices"], name, 16).astype(np.float64)
    if len(found) < count or not np.isfinite(found).all():
        raise file.error(
            f"{name}: {len(found)} inverse bind matrices for {count} joints, or not finite; export it again"
        )
    return found[:count].reshape(-1, 4, 4).transpose(0, 2, 1)


def _with_sum_1(file: GltfFile, name: str, weights: Array, notes: Notes) -> Array:
    """Return (n, k) weights with sum 1; a vertex without any goes with its first joint."""
    bad = ~(np.isfinite(weights).all(axis=1) & (weights >= 0).all(axis=1))
    if bad.any():
        vertex = int(np.argmax(bad))
        found = ", ".join(f"{value:.4g}" for value in weights[vertex])
        raise file.error(f"{name}: weights {found} of vertex {vertex}; expected 0 or more each; export it again")
    total = weights.sum(axis=1)
    off = np.abs(total - 1)
    if (off > MOST_OFF).any():
        notes.add(
            "skin weights do not have sum 1; they were scaled to it", f"{name}, a sum of {total[np.argmax(off)]:.4g}"
        )
    without = total == 0
    weights = np.where(without[:, None], np.eye(1, weights.shape[1]), weights)
    return weights / np.where(without, 1.0, total)[:, None]
