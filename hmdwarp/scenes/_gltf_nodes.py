"""Nodes of a glTF file over time: hierarchy, animations, rigid bodies and skins, in float64.

All are pure functions of the scene's clock.
Source: Magnenat-Thalmann et al. 1988, Joint-Dependent Local Deformations (linear blend skinning);
Khronos 2021, glTF 2.0 Specification, 3.5.3 (transforms), 3.11 and appendix C (animations
and their interpolation).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ..geometry import Pose, RigidState
from ._draft import Notes
from ._gltf_file import POINTER, VISIBILITY, GltfFile
from .options import NONE, numbered

Array = NDArray[np.float64]
_WIDTH = {"translation": 3, "rotation": 4, "scale": 3}
_TIMES = 16  # of which the places of all nodes are kept
_REST = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}


@attrs.frozen(eq=False)
class _Curve:
    """Animated values of one property of a node."""

    path: str  # "translation", "rotation" or "scale"
    kind: str  # Interpolation: "LINEAR", "STEP" or "CUBICSPLINE"
    times_s: Array  # (k,) increasing
    values: Array  # (k, n); for CUBICSPLINE (k, 3, n): tangent in, value, tangent out

    def at(self, seconds: float) -> tuple[Array, Array]:
        """Return the value (rotations: unit) and its change in 1/s; held beyond both ends."""
        times = self.times_s
        if not times[0] <= seconds < times[-1]:
            key = 0 if seconds < times[0] else -1
            return self._value(key), np.zeros(self.values.shape[-1])
        key = int(np.searchsorted(times, seconds, side="right")) - 1
        length = times[key + 1] - times[key]
        share = (seconds - times[key]) / length
        if self.kind == "STEP":
            return self._value(key), np.zeros(self.values.shape[-1])
        if self.kind == "CUBICSPLINE":
            t, start, out = share, self.values[key, 1], self.values[key, 2] * length
            into, end = self.values[key + 1, 0] * length, self.values[key + 1, 1]
            value = (2 * t**3 - 3 * t**2 + 1) * start + (t**3 - 2 * t**2 + t) * out
            value = value + (3 * t**2 - 2 * t**3) * end + (t**3 - t**2) * into
            rate = (6 * t**2 - 6 * t) * (start - end) + (3 * t**2 - 4 * t + 1) * out + (3 * t**2 - 2 * t) * into
            if self.path != "rotation":
                return value, rate / length
            size = max(float(np.linalg.norm(value)), 1e-12)
            unit = value / size
            return unit, (rate - unit * (unit @ rate)) / (size * length)
        start, end = self._value(key), self._value(key + 1)
        if self.path != "rotation":
            return start + share * (end - start), (end - start) / length
        first = Rotation.from_quat(start)
        turn = (Rotation.from_quat(end) * first.inv()).as_rotvec()  # the shorter way round
        now = (Rotation.from_rotvec(share * turn) * first).as_quat()
        return now, 0.5 * _product(np.append(turn / length, 0.0), now)

    def _value(self, key: int) -> Array:
        return np.asarray(self.values[key] if self.kind != "CUBICSPLINE" else self.values[key, 1])


def _product(p: Array, q: Array) -> Array:
    """Multiply quaternions xyzw: ten times as fast as by np.cross."""
    (a, b, c, d), (x, y, z, w) = p.tolist(), q.tolist()
    first = d * x + w * a + (b * z - c * y), d * y + w * b + (c * x - a * z)
    return np.array([*first, d * z + w * c + (a * y - b * x), d * w - (a * x + b * y + c * z)])


class Nodes:
    """Transforms of all nodes over time; the animations that play repeat."""

    def __init__(self, file: GltfFile, notes: Notes, animation: str | None = None) -> None:
        self._file, self._nodes, self.error = file, file.items("nodes"), file.error
        # 4x4, world_from_file: what it takes to metres with +y up, and to where the viewer stands.
        self.root = np.eye(4)
        self.parents = self._parents_of()
        self._rest = [self._rest_of(index) for index in range(len(self._nodes))]
        self._matrices: dict[int, Array] = {}  # of nodes at rest, see _local
        # By the root and the time, what `at` found for each node: the last few times.
        self._found: dict[tuple[int, float], tuple[Array, dict[int, tuple[Array, Array]]]] = {}
        self.placed, self._keys = 0, sum(map(len, file.buffers))  # times that nodes were placed; keys that may come
        self.curves: dict[int, dict[str, _Curve]] = {}
        animations = file.items("animations")
        names = [str(one.get("name") or f"number {index}") for index, one in enumerate(animations)]
        for index in self._playing(animations, names, animation, notes):
            self._read_animation(animations[index], f"animation '{names[index]}'", notes)
        said = (((node.get("extensions") or {}).get(VISIBILITY) or {}) for node in self._nodes)
        hidden = [one.get("visible", True) is False for one in said]
        # Of each node, whether it or an ancestor is animated; is hidden (KHR_node_visibility).
        self.moving = self.inherited([node in self.curves for node in range(len(hidden))])
        self.hidden = self.inherited(hidden)
        ends = [curve.times_s[-1] for curves in self.curves.values() for curve in curves.values()]
        self.period_s = float(max(ends, default=0.0))

    @staticmethod
    def _playing(animations: list[dict[str, Any]], names: list[str], wanted: str | None, notes: Notes) -> list[int]:
        """Return which to play: that wanted, or the first and each that moves other things."""
        if wanted is not None and wanted not in names and wanted == NONE:
            return []
        if wanted is not None:
            return [numbered(names, wanted, "animations", "--animation", NONE)]
        moved: set[tuple[object, ...]] = set()
        playing, left = [], []
        for index, animation in enumerate(animations):
            targets = [channel.get("target", {}) for channel in animation.get("channels", [])]
            things = {(target["node"], target.get("path")) for target in targets if "node" in target}
            if moved & things:
                left.append(names[index])
                continue
            moved |= things
            playing.append(index)
        if left:
            most, more = left[:8], f" and {len(left) - 8} more" if len(left) > 8 else ""
            played = ", ".join(f"'{names[index]}'" for index in playing)
            notes.add(f"plays animation {played}; --animation plays another: {', '.join(map(repr, most))}{more}")
        return playing

    def inherited(self, own: Sequence[bool]) -> list[bool]:
        """Return of each node whether something is so of it or of an ancestor, by whether of it."""
        found = list(own)
        for node in self._order:
            found[node] |= self.parents[node] >= 0 and found[self.parents[node]]
        return found

    def at(self, node: int, time_ns: int) -> tuple[Array, Array]:
        """Return 4x4 world_from_node and its change in 1/s, at whole ns of the period."""
        seconds = round(time_ns * 1e-9 % self.period_s, 9) if self.period_s > 0 else 0.0
        key = id(self.root), seconds
        kept = self._found.get(key)
        if kept is None:  # each node is placed once a time, however many hang below it
            if len(self._found) >= _TIMES:
                del self._found[next(iter(self._found))]
            kept = self._found[key] = self.root, {-1: (self.root, np.zeros((4, 4)))}
        found, way = kept[1], []
        while node not in found:
            way.append(node)
            node = self.parents[node]
        for below in reversed(way):
            (placed, moving), (local, change) = found[self.parents[below]], self._local(below, seconds)
            found[below] = placed @ local, moving @ local + placed @ change
            node = below
        self.placed += len(way)
        return found[node]

    def _local(self, node: int, seconds: float) -> tuple[Array, Array]:
        rest, curves = self._rest[node], self.curves.get(node, {})
        if isinstance(rest, np.ndarray):
            return rest, np.zeros((4, 4))
        if not curves:
            if node not in self._matrices:
                matrix = self._matrices[node] = np.eye(4)
                matrix[:3, :3] = Rotation.from_quat(rest["rotation"]).as_matrix() * rest["scale"]
                matrix[:3, 3] = rest["translation"]
            return self._matrices[node], np.zeros((4, 4))
        parts = {path: (rest[path], np.zeros(_WIDTH[path])) for path in _WIDTH} | {
            path: curve.at(seconds) for path, curve in curves.items()
        }
        (place, speed), (turn, turning), (scale, growing) = (parts[path] for path in _WIDTH)
        placed, change, rotation = np.eye(4), np.zeros((4, 4)), Rotation.from_quat(turn).as_matrix()
        x, y, z = 2 * _product(turning, turn * (-1, -1, -1, 1))[:3]
        spin = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
        placed[:3, :3], placed[:3, 3] = rotation * scale, place
        change[:3, :3], change[:3, 3] = spin * scale + rotation * growing, speed
        return placed, change

    def _rest_of(self, index: int) -> dict[str, Array] | Array:
        node = self._nodes[index]
        if "matrix" in node:
            matrix = np.array(node["matrix"], np.float64)
            if matrix.shape != (16,) or not np.isfinite(matrix).all():
                raise self._file.damaged(f"node {index}: its matrix is not 16 finite numbers")
            return matrix.reshape(4, 4).T
        found = {}
        for path, width in _WIDTH.items():
            value = np.array(node.get(path, _REST[path]), np.float64)
            if value.shape != (width,) or not np.isfinite(value).all() or (path == "rotation" and not value.any()):
                raise self._file.damaged(f"node {index}: {path} {node.get(path)!r} is not {width} finite numbers")
            found[path] = value
        return found

    def _parents_of(self) -> list[int]:
        parents = [-1] * len(self._nodes)
        for index, node in enumerate(self._nodes):
            for child in node.get("children", []):
                self._file.item("nodes", child, f"node {index}")
                if parents[child] >= 0 or child == index:
                    raise self._file.error(f"node {child} has two parents; expected a tree")
                parents[child] = index
        below: dict[int, list[int]] = {}
        for index, parent in enumerate(parents):
            below.setdefault(parent, []).append(index)
        self._order = list(below.get(-1, []))  # parents first
        for index in self._order:
            self._order += below.get(index, [])
        if len(self._order) < len(parents):
            index = min(set(range(len(parents))) - set(self._order))
            raise self._file.error(f"node {index} is its own ancestor, or below one that is; expected a tree")
        return parents

    def _read_animation(self, animation: dict[str, Any], name: str, notes: Notes) -> None:
        samplers, file = animation.get("samplers", []), self._file
        for channel in animation.get("channels", []):
            target = channel.get("target", {})
            path, index = target.get("path"), channel.get("sampler")
            if path == "pointer":
                what = "an animation's pointers are not followed: what they point at stays as the file has it"
                said = (target.get("extensions") or {}).get(POINTER)
                notes.add(what, f"{name}, {said.get('pointer') if isinstance(said, dict) else said}")
            if path == "pointer" or "node" not in target:
                continue
            node = target["node"]
            target_name = f"{path} of node '{file.item('nodes', node, name).get('name', node)}'"
            if path not in _WIDTH:
                what = "what an animation changes beside place, turn and size is not played"
                notes.add(what, f"{name}, {target_name}")
                continue
            if isinstance(self._rest[node], np.ndarray):
                raise file.error(f"{name} moves node {node}, which has a matrix: expected translation, rotation, scale")
            if not isinstance(index, int) or not 0 <= index < len(samplers):
                raise file.damaged(f"{name} uses sampler {index!r} of {len(samplers)}")
            if path in self.curves.get(node, {}):
                notes.add("an animation moves something twice; the first is played", f"{name}, {target_name}")
                continue
            self.curves.setdefault(node, {})[path] = self._curve(samplers[index], path, f"{name}, {target_name}")

    def _curve(self, sampler: dict[str, Any], path: str, name: str) -> _Curve:
        kind, error = sampler.get("interpolation", "LINEAR"), self._file.error
        if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
            raise error(f"{name}: interpolation '{kind}'; expected LINEAR, STEP or CUBICSPLINE")
        self._keys -= self._file.count(sampler, "input")
        if self._keys < 0:
            raise error(f"{name}: more keys in all than the file has bytes; export it with fewer")
        times = self._file.numbers(sampler.get("input"), name, 1)[:, 0].astype(np.float64)
        values = self._file.numbers(sampler.get("output"), name, _WIDTH[path])
        if values.dtype.kind != "f":
            raise error(f"{name}: its values are integers; expected floats or normalised integers")
        values = values.astype(np.float64)
        each = 3 if kind == "CUBICSPLINE" else 1
        if not len(times) or len(values) != each * len(times):
            raise error(f"{name}: {len(times)} key times and {len(values)} values; expected {each} for each")
        if not np.isfinite(times).all() or not np.isfinite(values).all():
            raise error(f"{name}: a key is not made of finite numbers")
        backwards = np.diff(times) <= 0
        if backwards.any() or times[0] < 0:
            key = int(np.argmax(backwards)) + 1 if backwards.any() else 0
            raise error(f"{name}: key {key} is at {times[key]:g} s; key times must be 0 or more and increase")
        values = values.reshape(len(times), 3, -1) if each == 3 else values
        if path == "rotation":
            size = np.linalg.norm(values[:, 1] if each == 3 else values, axis=1, keepdims=True)
            if (size < 1e-6).any():
                raise error(f"{name}: key {int(np.argmin(size))} is no rotation (a quaternion of length 0)")
            values = values if each == 3 else values / size
        return _Curve(path, kind, times, values)


MOST_PLACED = 1_000_000  # of nodes at instants, to know which chains are rigid: two or three minutes
RIGID = 1e-5  # change of lengths along a chain of nodes: float32 rotations are off by 1e-7 each
MOST_OFF = 0.01  # of weights from a sum of 1: half a byte's step for each of four is 0.008


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
    times, above = list[Array](), node
    while above >= 0:
        times += [curve.times_s for curve in nodes.curves.get(above, {}).values()]
        above = nodes.parents[above]
    keys = np.unique(np.concatenate(times))
    for seconds in np.union1d(keys, (keys[1:] + keys[:-1]) / 2):
        if nodes.placed > MOST_PLACED:
            what = f"node {node}: its chains of nodes move at too many instants: {MOST_PLACED:,} places were looked at"
            raise nodes.error(f"{what}; export fewer keys, or a chain that is less deep")
        turn = nodes.at(node, round(seconds * 1e9))[0][:3, :3] @ np.linalg.inv(start)
        if np.abs(turn.T @ turn - np.eye(3)).max() > RIGID or np.linalg.det(turn) < 0:
            return False
    return True


@attrs.frozen(eq=False)
class Driven:
    """Vertices driven by nodes: a skin (linear blend skinning), or all by one non-rigid node."""

    nodes: Nodes
    rest: Array  # (n, 3) as in the file
    joints: Sequence[int]  # indices of the driving nodes
    inverse: Array  # (j, 4, 4) joint_from_rest
    which: NDArray[np.int64]  # (n, k) indices into joints, and their weights
    weights: Array
    origin: Array = attrs.field(factory=lambda: np.zeros(3))  # of the scene

    def _blended(self, time_ns: int, derivative: int) -> Array:
        pairs = zip(self.joints, self.inverse, strict=True)
        matrices = np.array([self.nodes.at(joint, time_ns)[derivative] @ inverse for joint, inverse in pairs])
        blended = np.einsum("nk,nkij->nij", self.weights, matrices[self.which][..., :3, :])
        return np.asarray(np.einsum("nij,nj->ni", blended[:, :, :3], self.rest) + blended[:, :, 3])

    def positions(self, time_ns: int) -> Array:
        return self._blended(time_ns, 0) - self.origin

    def velocities(self, time_ns: int) -> Array:
        return self._blended(time_ns, 1)


def skinned(file: GltfFile, nodes: Nodes, skin: int, primitive: dict[str, Any], rest: Array, notes: Notes) -> Driven:
    """Return a primitive under a skin, whose weights are scaled to sum 1. Errors: SceneError."""
    found = file.item("skins", skin, "a node")
    name = f"skin '{found.get('name') or skin}'"
    joints = found.get("joints", [])
    for joint in joints:
        file.item("nodes", joint, name)
    attributes = primitive.get("attributes", {})
    if "JOINTS_0" not in attributes or "WEIGHTS_0" not in attributes:
        raise file.damaged(f"{name}: a mesh without joints and weights (JOINTS_0, WEIGHTS_0)")
    sets = [k for k in range(4) if f"JOINTS_{k}" in attributes]

    def columns(kind: str) -> NDArray[Any]:
        return np.concatenate([file.numbers(attributes.get(f"{kind}_{k}"), name, 4) for k in sets], axis=1)

    which, weights = columns("JOINTS").astype(np.int64), columns("WEIGHTS").astype(np.float64)
    if len(which) != len(rest) or len(weights) != len(rest):
        counts = f"{len(rest)} positions, {len(which)} joints, {len(weights)} weights"
        raise file.error(f"{name}: {counts}; expected as many of each")
    weights = _with_sum_1(file, name, weights, notes)
    used = weights > 0
    if (which[used] >= len(joints)).any():
        raise file.error(f"{name}: a vertex uses joint {int(which[used].max())}, there are {len(joints)}")
    which[~used], columns_used = 0, used.any(axis=0)
    which, weights = which[:, columns_used], weights[:, columns_used]
    if "inverseBindMatrices" not in found:
        return Driven(nodes, rest, joints, np.tile(np.eye(4), (len(joints), 1, 1)), which, weights)
    inverse = file.numbers(found["inverseBindMatrices"], name, 16).astype(np.float64)
    if len(inverse) < len(joints) or not np.isfinite(inverse).all():
        raise file.damaged(f"{name}: {len(inverse)} inverse bind matrices for {len(joints)} joints, or not finite")
    joint_from_rest = inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return Driven(nodes, rest, joints, joint_from_rest, which, weights)


def _with_sum_1(file: GltfFile, name: str, weights: Array, notes: Notes) -> Array:
    """Return (n, k) weights with sum 1; a vertex without any goes with its first joint."""
    bad = ~(np.isfinite(weights).all(axis=1) & (weights >= 0).all(axis=1))
    if bad.any():
        vertex = int(np.argmax(bad))
        found = ", ".join(f"{value:.4g}" for value in weights[vertex])
        raise file.damaged(f"{name}: weights {found} of vertex {vertex}; expected 0 or more each")
    total = weights.sum(axis=1)
    off = np.abs(total - 1)
    if (off > MOST_OFF).any():
        found = f"{name}, a sum of {total[np.argmax(off)]:.4g}"
        notes.add("skin weights do not have sum 1; they were scaled to it", found)
    without = total == 0
    weights = np.where(without[:, None], np.eye(1, weights.shape[1]), weights)
    return weights / np.where(without, 1.0, total)[:, None]
