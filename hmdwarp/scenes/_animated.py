"""The animated nodes of a GLB: what moves as a whole, and how. Skins and morphs are told, not moved.

Source: Khronos glTF 2.0 specification, 3.11 (animations) and 4.4 (the GLB container).
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from ..errors import InputError, SceneError
from ..geometry import Pose
from ._content import Body
from .motions import Track

_FLOAT, _JSON, _BINARY = 5126, 0x4E4F534A, 0x004E4942
_WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


@attrs.frozen(eq=False)
class AnimatedNodes:
    """bodies: what moves. of_node: by the name of a node with a mesh, the number of its body (from 1) and world_from_body at rest."""

    bodies: tuple[Body, ...] = ()
    of_node: Mapping[str, tuple[int, Pose]] = attrs.field(factory=dict)


def animated_nodes(path: Path, notes: list[str]) -> AnimatedNodes:
    """Of a GLB that is otherwise readable; what is not shown moving is said in `notes`.

    Positions and rotations run evenly from key to key and begin anew after the last. Errors: SceneError for keys that are broken.
    """
    header, binary = _chunks(path)
    nodes = header.get("nodes", [])
    if any("skin" in node for node in nodes):
        notes.append(f"{path}: its skins are not moved; drawn at rest")
    channels = _channels(path, header, binary, notes)
    if not channels:
        return AnimatedNodes()
    parents = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}
    bodies, numbers = [], {}
    for index, keys in sorted(channels.items()):
        name = nodes[index].get("name", str(index))
        try:
            bodies.append(Body(name, _track(nodes, parents, index, keys)))
        except (SceneError, InputError, ValueError) as error:
            raise SceneError(f"{path}: animation of node '{name}': {error}") from error
        numbers[index] = len(bodies), _rest(nodes, parents, index)
    return AnimatedNodes(tuple(bodies), _meshes_below(path, nodes, parents, numbers, notes))


def _chunks(path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON of a GLB and its binary part; nothing of what is no GLB, which trimesh has told by then."""
    data, at, found = path.read_bytes(), 12, {}
    while at + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, at)
        found.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    try:
        header = json.loads(found.get(_JSON, b"{}"))
    except ValueError:
        header = {}
    return (header if isinstance(header, dict) else {}), found.get(_BINARY, b"")


Keys = dict[str, tuple[NDArray, NDArray]]  # "translation", "rotation": times in s, values


def _channels(path: Path, header: dict[str, Any], binary: bytes, notes: list[str]) -> dict[int, Keys]:
    """Of the first animation, by node."""
    animations = header.get("animations", [])
    if len(animations) > 1:
        notes.append(f"{path}: {len(animations)} animations; only the first is shown")
    found: dict[int, Keys] = {}
    for channel in animations[0].get("channels", []) if animations else []:
        try:
            target, sampler = channel["target"], animations[0]["samplers"][channel["sampler"]]
            if target["path"] not in ("translation", "rotation"):
                notes.append(f"{path}: its animated {target['path']} is not shown")
                continue
            times, values = (_accessor(header, binary, sampler[end]) for end in ("input", "output"))
            header["nodes"][target["node"]]
        except (KeyError, IndexError, TypeError, ValueError, struct.error) as error:
            raise SceneError(f"{path}: its animation cannot be read ({type(error).__name__}: {error}); export it again") from error
        if sampler.get("interpolation", "LINEAR") == "CUBICSPLINE":
            values = values[1::3]  # without the tangents
        if len(times) != len(values):
            raise SceneError(f"{path}: an animation has {len(times)} key times and {len(values)} keys: wanted as many")
        found.setdefault(target["node"], {})[target["path"]] = times[:, 0], values
    return found


def _accessor(header: dict[str, Any], binary: bytes, index: int) -> NDArray[np.float64]:
    """(n, k) numbers. Errors: ValueError for what is not float32, KeyError and the like for what is not there."""
    accessor = header["accessors"][index]
    if accessor["componentType"] != _FLOAT:
        raise ValueError(f"keys of component type {accessor['componentType']}, wanted {_FLOAT} (float)")
    view, width = header["bufferViews"][accessor["bufferView"]], _WIDTH[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    stride = view.get("byteStride", 4 * width)
    rows = [np.frombuffer(binary, "<f4", width, start + row * stride) for row in range(accessor["count"])]
    return np.array(rows, np.float64).reshape(-1, width)


def _local(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    out = np.eye(4)
    turn = Rotation.from_quat(node.get("rotation", (0, 0, 0, 1))).as_matrix()
    out[:3, :3] = turn * np.array(node.get("scale", (1, 1, 1)), np.float64)
    out[:3, 3] = node.get("translation", (0, 0, 0))
    return out


def _world(nodes: list, parents: dict[int, int], index: int | None) -> NDArray[np.float64]:
    """4x4 world_from_node at rest; the world's own for None."""
    out = np.eye(4)
    while index is not None:
        out, index = _local(nodes[index]) @ out, parents.get(index)
    return out


def _turn_of(matrix: NDArray) -> Rotation:
    """Without its scale."""
    return Rotation.from_matrix(matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0))


def _rest(nodes: list, parents: dict[int, int], index: int) -> Pose:
    world = _world(nodes, parents, index)
    return Pose(world[:3, 3], _turn_of(world).as_quat())


def _track(nodes: list, parents: dict[int, int], index: int, keys: Keys) -> Track:
    """world_from_node over time; what has no keys of its own stays as it rests."""
    for times, values in keys.values():
        Track(times, values[:, -3:], smooth=False)  # says which key is broken
    above, own = _world(nodes, parents, parents.get(index)), _local(nodes[index])
    times = np.unique(np.concatenate([times for times, _ in keys.values()]))
    places = np.tile(own[:3, 3], (len(times), 1))
    if "translation" in keys:
        known, values = keys["translation"]
        places = np.stack([np.interp(times, known, values[:, axis]) for axis in range(3)], axis=1)
    turns = Rotation.from_quat(np.tile(_turn_of(own).as_quat(), (len(times), 1)))
    if "rotation" in keys:
        known, values = keys["rotation"]
        turns = Slerp(known, Rotation.from_quat(values))(np.clip(times, known[0], known[-1]))
    return Track(times, places @ above[:3, :3].T + above[:3, 3], _turn_of(above) * turns, smooth=False)


def _meshes_below(
    path: Path, nodes: list, parents: dict[int, int], numbers: dict[int, tuple[int, Pose]], notes: list[str]
) -> dict[str, tuple[int, Pose]]:
    """By name, each node with a mesh that is animated or hangs from one that is; from the nearest, if from several."""
    found = {}
    for index, node in enumerate(nodes):
        above, moving = index, []
        while above is not None:
            moving += [above] if above in numbers else []
            above = parents.get(above)
        if "mesh" in node and moving:
            found[node.get("name", str(index))] = numbers[moving[0]]
            if len(moving) > 1:
                notes.append(f"{path}: node '{node.get('name', index)}' hangs from several animated ones; moved by the nearest alone")
    return found
