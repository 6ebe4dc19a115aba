"""The scenes of the library: a table each, NAME.toml, and for most a model, NAME.glb.xz.

README.md in this folder says what they hold and how to edit them.
"""

from __future__ import annotations

import lzma
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...base import Registry
from ...geometry import Pose
from .._draft import Notes
from .._gltf_file import GltfFile
from .._mesh import Ball, Body, Material, Mesh, Quad, Texture, checker
from .._scene import Background, Lamp, Panel, Scene
from ..input_events import InputLog
from ..motions import Bouncing, Hinged, Pendulum, Spinning, Still, Switched, Thrown, Track, Waving

Arrays = Mapping[str, dict[str, NDArray[np.float64]]]  # of what moves, by its name and theirs
_FOLDER = Path(__file__).parent
_FIELDS = {
    "positions": "POSITION",
    "normals": "NORMAL",
    "uv": "TEXCOORD_0",  # v up as in Mesh, not down as in glTF: 1 - v would round
    "light": "COLOR_0",
    "albedo": "_ALBEDO",
    "light_uv": "_LIGHT_UV",
}


def textures_named(*names: str) -> list[Texture]:
    """Return the library's textures of these names; each is read when its image is first used."""
    kinds = tomllib.loads((_FOLDER / "textures" / "textures.toml").read_text("utf-8"))
    painted = {name: partial(checker, **board) for name, board in kinds["checkers"].items()}
    sources = [(name, painted.get(name) or partial(_image, name)) for name in names]
    linear, clamped = kinds["linear"], kinds["clamped"]
    return [Texture(name, source, name not in linear, name not in clamped) for name, source in sources]


def _image(name: str) -> NDArray[np.uint8]:
    from PIL import Image

    with Image.open(_FOLDER / "textures" / f"{name}.webp") as found:
        return np.asarray(found)


def _mesh(file: GltfFile, node: dict[str, Any], textures: Sequence[Texture]) -> Mesh:
    """Return the mesh of a node; its material finds textures by name."""
    index, name = {texture.name: i for i, texture in enumerate(textures)}, node["name"]
    (primitive,) = file.item("meshes", node.get("mesh"), name)["primitives"]
    gltf = file.item("materials", primitive.get("material"), name)
    settings = dict(gltf.get("extras", {}))
    if "normal_map" in settings:
        settings["normal_map"] = index[settings["normal_map"]]
    attributes = primitive["attributes"]
    arrays: dict[str, Any] = {
        field: file.numbers(attributes[key], name) for field, key in _FIELDS.items() if key in attributes
    }
    if "skin" in node:
        from .._gltf_nodes import Nodes, skinned  # it brings SciPy, and most scenes do without

        notes, rest = Notes(file.path), arrays["positions"].astype(np.float64)
        arrays["deformation"] = skinned(file, Nodes(file, notes), node["skin"], primitive, rest, notes)
    arrays["triangles"] = file.numbers(primitive["indices"], name, 1).reshape(-1, 3)
    texture = index[gltf["name"]] if "name" in gltf else -1
    body, double_sided = node.get("extras", {}).get("body", 0), gltf.get("doubleSided", False)
    return Mesh(name, texture=texture, double_sided=double_sided, material=Material(**settings), body=body, **arrays)


def _arrays(file: GltfFile) -> Arrays:
    """Return the numbers of buffer views called NAME-FIELD; extras of a view say its columns."""
    found: dict[str, dict[str, NDArray[np.float64]]] = {}
    for view in (view for view in file.items("bufferViews") if "name" in view):
        name, _, field = view["name"].rpartition("-")
        numbers = np.frombuffer(file.view(view), "<f8")
        found.setdefault(name, {})[field] = numbers.reshape(-1, *view.get("extras", {}).values())
    return found


def _track(keys: ArrayLike) -> Track:
    """Return the track through rows of seconds, metres and rotation vector."""
    from scipy.spatial.transform import Rotation

    rows = np.array(keys)
    return Track(rows[:, 0], rows[:, 1:4], Rotation.from_rotvec(rows[:, 4:]))


# What moves or reacts by its `kind` in a table, where the other keys are the parameters.
_MOVES: dict[str, Callable[..., Any]] = {"still": Still, "spinning": Spinning, "pendulum": Pendulum}
_MOVES |= {"thrown": Thrown, "track": _track, "waving": Waving}
_REACTS: dict[str, Callable[..., Any]] = {"bouncing": Bouncing, "hinged": Hinged, "switched": Switched}
_POSES = ("at", "start", "pose", "viewpoint")  # keys of a place, or of a place and a quaternion


def _stored_scene(name: str, table: dict[str, Any]) -> Scene:
    textures, meshes = textures_named(*table["textures"]), list[Mesh]()
    arrays: Arrays = {}
    if (path := _FOLDER / f"{name}.glb.xz").is_file():
        file = GltfFile.parse(path, lzma.decompress(path.read_bytes()))
        meshes, arrays = [_mesh(file, node, textures) for node in file.items("nodes") if "mesh" in node], _arrays(file)
    meshes += [Ball(**ball).mesh(called) for called, ball in table.get("balls", {}).items()]
    meshes += [Quad(**quad).mesh(called) for called, quad in table.get("quads", {}).items()]
    soft = {name: _made(name, said, arrays) for name, said in table.get("deformations", {}).items()}
    meshes = [attrs.evolve(one, deformation=soft[one.name]) if one.name in soft else one for one in meshes]
    colours, panels = table.get("background", [(0.0, 0.0, 0.0)]), table.get("panels", ())
    return Scene(
        name,
        table["summary"],
        meshes,
        textures,
        Background(*map(tuple, colours * (3 if len(colours) == 1 else 1))),
        panels=[Panel(**_values(said | {"pictures": textures_named(*said["pictures"])})) for said in panels],
        **_values({key: table[key] for key in ("viewpoint", "walk_bounds_m") if key in table}),
        **moving(table, InputLog(), arrays),
    )


def moving(table: dict[str, Any], inputs: InputLog, arrays: Arrays) -> dict[str, Any]:
    bodies = {name: _made(name, said, arrays, inputs) for name, said in table.get("bodies", {}).items()}
    lamps = []
    for name, said in table.get("lamps", {}).items():
        made = {}
        for key in [key for key in ("motion", "brightness") if key in said]:
            part = said[key]
            made[key] = bodies[part] if isinstance(part, str) else _made(name, part, arrays, inputs)
        lamps.append(Lamp(**said | made | {"colour": tuple(said["colour"])}))
    return {"bodies": [Body(name, motion) for name, motion in bodies.items()], "lamps": lamps}


def _made(name: str, said: dict[str, Any], arrays: Arrays, *inputs: InputLog) -> Any:
    """Return what moves or reacts by that name: a motion, a deformation or a brightness."""
    values = _values(said) | arrays.get(name, {})
    kind = values.pop("kind")
    return _MOVES[kind](**values) if kind in _MOVES else _REACTS[kind](name, *inputs, **values)


def _values(said: dict[str, Any]) -> dict[str, Any]:
    return {key: Pose(value[:3], value[3:] or (0, 0, 0, 1)) if key in _POSES else value for key, value in said.items()}


@attrs.frozen(eq=False)
class SceneSource:
    """A registered scene before it is built; listing scenes builds nothing."""

    name: str
    summary: str
    build: Callable[[], Scene]  # makes the scene, the same arrays every time
    effects: tuple[str, ...] = ()  # names of the effects that the built scene's content calls for
    # The fields of the built scene, by name, that follow from inputs; None where none do.
    reacts: Callable[[InputLog], dict[str, Any]] | None = None


def _of_table(name: str, table: dict[str, Any]) -> SceneSource:
    reacts = partial(moving, table, arrays={}) if table.get("reacts") else None
    effects = tuple(table.get("effects", ()))
    return SceneSource(name, table["summary"], partial(_stored_scene, name, table), effects, reacts)


scenes: Registry[SceneSource] = Registry("scene", __name__, group="scenes", of_table=_of_table, columns="effects")
