"""What moves in a GLB as the scene wants it: rigid bodies, vertices driven by a node that is not rigid, skins over joints."""

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

Array = NDArray[np.float64]
# A chain of nodes is rigid if lengths change by less than that along the way: float32 rotations are off by 1e-7 each.
RIGID = 1e-5
MOST_OFF = 0.01  # by which weights may miss a sum of 1: half a byte's step for each of four is 0.008


@attrs.define(eq=False, frozen=True, slots=False)
class NodeMotion:
    """A node whose size and shape stay as they are at time 0; the body's origin is the node's, and so are its axes, without scale."""

    nodes: Nodes
    node: int

    @cached_property
    def _without_turn(self) -> Array:
        """3x3: takes the turn out of world_from_node at time 0 and leaves size and shape: the polar part of it, inverted."""
        left, sizes, right = np.linalg.svd(self.nodes.at(self.node, 0)[0][:3, :3])
        flip = np.diag(
            [1.0, 1.0, np.sign(np.linalg.det(left @ right))]
        )  # a mirrored node keeps its mirroring in its shape
        return np.linalg.inv(right.T @ flip @ np.diag(sizes) @ right)

    def state(self, time_ns: int) -> RigidState:
        """Where it is then, and how it moves."""
        placed, moving = self.nodes.at(self.node, time_ns)
        rotation = Rotation.from_matrix(placed[:3, :3] @ self._without_turn)
        across = moving[:3, :3] @ np.linalg.inv(placed[:3, :3])
        spin = 0.5 * np.array([across[2, 1] - across[1, 2], across[0, 2] - across[2, 0], across[1, 0] - across[0, 1]])
        return RigidState(Pose(placed[:3, 3], rotation.as_quat()), moving[:3, 3], spin)


def is_rigid(nodes: Nodes, node: int) -> bool:
    """Whether it can be a body: at all key times, and between them, it is a turned and moved copy of itself."""
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
    """Vertices that nodes take along: by linear blend skinning over several, or all by one that grows or shears.

    rest: (n, 3) as the file has them. joints: nodes. inverse: (j, 4, 4) joint_from_rest. which, weights: (n, k). origin: of the scene.
    """

    nodes: Nodes
    rest: Array
    joints: Sequence[int]
    inverse: Array
    which: NDArray[np.int64]
    weights: Array
    origin: Array

    def _blended(self, time_ns: int, which: int) -> Array:
        pairs = zip(self.joints, self.inverse, strict=True)
        matrices = np.array([self.nodes.at(joint, time_ns)[which] @ inverse for joint, inverse in pairs])
        blended = np.einsum("nk,nkij->nij", self.weights, matrices[self.which][..., :3, :])
        return np.einsum("nij,nj->ni", blended[:, :, :3], self.rest) + blended[:, :, 3]

    def positions(self, time_ns: int) -> Array:
        """(n, 3) metres relative to the scene's origin."""
        return self._blended(time_ns, 0) - self.origin

    def velocities(self, time_ns: int) -> Array:
        """(n, 3) m/s in world axes."""
        return self._blended(time_ns, 1)

    def seen_from(self, origin: Array) -> Driven:
        """The same in a scene with that origin."""
        return attrs.evolve(self, origin=np.array(origin, np.float64))


def driven_by_node(nodes: Nodes, node: int, rest: Array) -> Driven:
    """All vertices by one node."""
    count = len(rest)
    return Driven(
        nodes, rest, [node], np.eye(4)[None], np.zeros((count, 1), np.int64), np.ones((count, 1)), np.zeros(3)
    )


def skinned(file: GltfFile, nodes: Nodes, skin: int, primitive: dict, rest: Array) -> Driven:
    """A primitive with joints and weights under a skin. Errors: SceneError, naming the skin, for one that does not fit."""
    told = file.one("skins", skin, "a node")
    name = f"skin '{told.get('name') or skin}'"
    joints = told.get("joints", [])
    for joint in joints:
        file.one("nodes", joint, name)
    attributes = primitive.get("attributes", {})
    if "JOINTS_0" not in attributes or "WEIGHTS_0" not in attributes:
        raise file.wrong(f"{name}: a mesh without joints and weights (JOINTS_0, WEIGHTS_0); export it again")
    sets = [k for k in range(4) if f"JOINTS_{k}" in attributes]
    which = np.concatenate([file.numbers(attributes[f"JOINTS_{k}"], name, 4) for k in sets], axis=1).astype(np.int64)
    weights = np.concatenate([file.numbers(attributes.get(f"WEIGHTS_{k}"), name, 4) for k in sets], axis=1).astype(
        np.float64
    )
    if len(which) != len(rest) or len(weights) != len(rest):
        raise file.wrong(
            f"{name}: {len(rest)} positions, {len(which)} joints, {len(weights)} weights; wanted as many of each"
        )
    _check_weights(file, name, weights)
    used = weights > 0
    if (which[used] >= len(joints)).any():
        raise file.wrong(f"{name}: a vertex wants joint {int(which[used].max())}, there are {len(joints)}")
    which[~used] = 0
    inverse = np.tile(np.eye(4), (len(joints), 1, 1))
    if "inverseBindMatrices" in told:
        found = file.numbers(told["inverseBindMatrices"], name, 16).astype(np.float64)
        if len(found) < len(joints) or not np.isfinite(found).all():
            raise file.wrong(
                f"{name}: {len(found)} inverse bind matrices for {len(joints)} joints, or not finite; export it again"
            )
        inverse = found[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return Driven(nodes, rest, joints, inverse, which, weights / weights.sum(axis=1, keepdims=True), np.zeros(3))


def _check_weights(file: GltfFile, name: str, weights: Array) -> None:
    bad = ~(
        np.isfinite(weights).all(axis=1) & (weights >= 0).all(axis=1) & (np.abs(weights.sum(axis=1) - 1) <= MOST_OFF)
    )
    if bad.any():
        vertex = int(np.argmax(bad))
        told = ", ".join(f"{value:.4g}" for value in weights[vertex])
        raise file.wrong(f"{name}: weights {told} of vertex {vertex}; wanted 0 or more each, with sum 1")
