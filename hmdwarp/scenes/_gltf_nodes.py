"""The nodes of a GLB: who hangs from whom, and how animations move them. In float64, a pure function of the scene's clock.

Source: Khronos 2021, glTF 2.0 Specification, 3.5.3 (transforms), 3.11 and appendix C (animations and their interpolation).
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ._gltf_file import GltfFile

Array = NDArray[np.float64]
_WIDTH = {"translation": 3, "rotation": 4, "scale": 3}
_REST = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}


@attrs.frozen(eq=False)
class Curve:
    """Values over time. times_s: (k,) increasing. values: (k, n); for CUBICSPLINE (k, 3, n): tangent in, value, tangent out."""

    path: str
    kind: str
    times_s: Array
    values: Array

    def at(self, seconds: float) -> tuple[Array, Array]:
        """Value and its change in 1/s; held before the first key and after the last. Rotations as unit quaternions."""
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
            return self._on_spline(key, share, length)
        start, end = self._value(key), self._value(key + 1)
        if self.path != "rotation":
            return start + share * (end - start), (end - start) / length
        return _slerp(start, end, share, length)

    def _value(self, key: int) -> Array:
        return self.values[key] if self.kind != "CUBICSPLINE" else self.values[key, 1]

    def _on_spline(self, key: int, t: float, length: float) -> tuple[Array, Array]:
        start, out = self.values[key, 1], self.values[key, 2] * length
        into, end = self.values[key + 1, 0] * length, self.values[key + 1, 1]
        value = (
            (2 * t**3 - 3 * t**2 + 1) * start
            + (t**3 - 2 * t**2 + t) * out
            + (3 * t**2 - 2 * t**3) * end
            + (t**3 - t**2) * into
        )
        rate = (6 * t**2 - 6 * t) * (start - end) + (3 * t**2 - 4 * t + 1) * out + (3 * t**2 - 2 * t) * into
        if self.path != "rotation":
            return value, rate / length
        size = max(float(np.linalg.norm(value)), 1e-12)
        unit = value / size
        return unit, (rate - unit * (unit @ rate)) / (size * length)


def _slerp(start: Array, end: Array, share: float, length: float) -> tuple[Array, Array]:
    first = Rotation.from_quat(start)
    turn = (Rotation.from_quat(end) * first.inv()).as_rotvec()  # the shorter way round
    now = (Rotation.from_rotvec(share * turn) * first).as_quat()
    return now, 0.5 * _product(np.append(turn / length, 0.0), now)


def _product(p: Array, q: Array) -> Array:
    """Quaternions xyzw."""
    return np.append(p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3]), p[3] * q[3] - p[:3] @ q[:3])


class Nodes:
    """Where every node is at an instant: 4x4 world_from_node and its change in 1/s. All animations play together, over and over."""

    def __init__(self, file: GltfFile, notes: list[str]) -> None:
        self._file, self._told = file, file.listed("nodes")
        self.parents = self._parents_of()
        self._rest = [self._rest_of(index) for index in range(len(self._told))]
        self.curves: dict[int, dict[str, Curve]] = {}
        for index, animation in enumerate(file.listed("animations")):
            self._read_animation(animation, animation.get("name") or f"number {index}", notes)
        ends = [curve.times_s[-1] for curves in self.curves.values() for curve in curves.values()]
        self.period_s = float(max(ends, default=0.0))

    def moves(self, node: int) -> bool:
        """Whether it, or one it hangs from, is animated."""
        return any(one in self.curves for one in self.line(node))

    def line(self, node: int) -> list[int]:
        """The node and all that it hangs from, the topmost first."""
        found = [node]
        while self.parents[found[0]] >= 0:
            found.insert(0, self.parents[found[0]])
        return found

    def at(self, node: int, time_ns: int) -> tuple[Array, Array]:
        """world_from_node, and its change."""
        seconds = np.mod(time_ns * 1e-9, self.period_s) if self.period_s > 0 else 0.0
        placed, moving = np.eye(4), np.zeros((4, 4))
        for one in self.line(node):
            local, change = self._local(one, seconds)
            placed, moving = placed @ local, moving @ local + placed @ change
        return placed, moving

    def _local(self, node: int, seconds: float) -> tuple[Array, Array]:
        rest, curves = self._rest[node], self.curves.get(node)
        if curves is None:
            return rest if isinstance(rest, np.ndarray) else _matrix(rest), np.zeros((4, 4))
        parts = {path: (np.array(rest[path]), np.zeros(_WIDTH[path])) for path in _WIDTH} | {
            p: c.at(seconds) for p, c in curves.items()
        }
        (place, speed), (turn, turning), (scale, growing) = (parts[path] for path in _WIDTH)
        rotation = Rotation.from_quat(turn).as_matrix()
        x, y, z = 2 * _product(turning, turn * (-1, -1, -1, 1))[:3]
        spin = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation
        change = np.zeros((4, 4))
        change[:3, :3], change[:3, 3] = spin * scale + rotation * growing, speed
        return _matrix({"translation": place, "rotation": turn, "scale": scale}), change

    def _rest_of(self, index: int) -> dict | Array:
        told = self._told[index]
        if "matrix" in told:
            matrix = np.array(told["matrix"], np.float64)
            if matrix.shape != (16,) or not np.isfinite(matrix).all():
                raise self._file.wrong(f"node {index} has no matrix of 16 finite numbers; export it again")
            return matrix.reshape(4, 4).T
        found = {}
        for path, width in _WIDTH.items():
            value = np.array(told.get(path, _REST[path]), np.float64)
            if value.shape != (width,) or not np.isfinite(value).all() or (path == "rotation" and not value.any()):
                raise self._file.wrong(
                    f"node {index}: {path} {told.get(path)!r} is not {width} finite numbers; export it again"
                )
            found[path] = value
        return found

    def _parents_of(self) -> list[int]:
        parents = [-1] * len(self._told)
        for index, told in enumerate(self._told):
            for child in told.get("children", []):
                self._file.one("nodes", child, f"node {index}")
                if parents[child] >= 0 or child == index:
                    raise self._file.wrong(f"node {child} hangs from two nodes; wanted a tree")
                parents[child] = index
        for index in range(len(parents)):
            above, steps = parents[index], 0
            while above >= 0:
                above, steps = parents[above], steps + 1
                if steps > len(parents):
                    raise self._file.wrong(f"node {index} hangs from itself in the end; wanted a tree")
        return parents

    def _read_animation(self, animation: dict, name: str, notes: list[str]) -> None:
        samplers = animation.get("samplers", [])
        for channel in animation.get("channels", []):
            target = channel.get("target", {})
            path, told = target.get("path"), f"animation '{name}'"
            if "node" not in target:
                continue
            node = target["node"]
            name_of = self._file.one("nodes", node, told).get("name", node)
            if path not in _WIDTH:
                notes.append(f"{self._file.path}: {told} moves {path} of node '{name_of}': not played")
                continue
            if isinstance(self._rest[node], np.ndarray):
                raise self._file.wrong(
                    f"{told} moves node {node}, which has a matrix: wanted translation, rotation, scale"
                )
            index = channel.get("sampler")
            if not isinstance(index, int) or not 0 <= index < len(samplers):
                raise self._file.wrong(f"{told} wants sampler {index!r} of {len(samplers)}; export it again")
            if path in self.curves.get(node, {}):
                notes.append(
                    f"{self._file.path}: {told} moves {path} of node '{name_of}' as one before it does; left out"
                )
                continue
            self.curves.setdefault(node, {})[path] = self._curve(
                samplers[index], path, f"{told}, {path} of node '{name_of}'"
            )

    def _curve(self, sampler: dict, path: str, told: str) -> Curve:
        kind, wrong = sampler.get("interpolation", "LINEAR"), self._file.wrong
        if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
            raise wrong(f"{told}: interpolation '{kind}'; wanted LINEAR, STEP or CUBICSPLINE")
        times = self._file.numbers(sampler.get("input"), told, 1)[:, 0].astype(np.float64)
        values = self._file.numbers(sampler.get("output"), told, _WIDTH[path])
        if values.dtype.kind != "f":
            raise wrong(f"{told}: its values are whole numbers; wanted floats, or whole numbers that are normalised")
        values = values.astype(np.float64)
        each = 3 if kind == "CUBICSPLINE" else 1
        if not len(times) or len(values) != each * len(times):
            raise wrong(f"{told}: {len(times)} key times and {len(values)} values; wanted {each} for each")
        if not np.isfinite(times).all() or not np.isfinite(values).all():
            raise wrong(f"{told}: a key is not made of finite numbers")
        rendered = np.diff(times) <= 0
        if rendered.any() or times[0] < 0:
            key = int(np.argmax(rendered)) + 1 if rendered.any() else 0
            raise wrong(f"{told}: key {key} is at {times[key]:g} s; key times must be 0 or more and increase")
        values = values.reshape(len(times), 3, -1) if each == 3 else values
        if path == "rotation":
            values = self._unit(values, each, told)
        return Curve(path, kind, times, values)

    def _unit(self, values: Array, each: int, told: str) -> Array:
        turns = values[:, 1] if each == 3 else values
        size = np.linalg.norm(turns, axis=1, keepdims=True)
        if (size < 1e-6).any():
            raise self._file.wrong(f"{told}: key {int(np.argmin(size))} is no rotation (a quaternion of length 0)")
        return values if each == 3 else values / size


def _matrix(parts: dict) -> Array:
    out = np.eye(4)
    out[:3, :3] = Rotation.from_quat(parts["rotation"]).as_matrix() * np.asarray(parts["scale"])
    out[:3, 3] = parts["translation"]
    return out
