"""Models of the library's scenes: geometry with baked light in GLB files next to their modules.

README.md in this folder says what the files hold and how to edit them.
"""

from __future__ import annotations

import lzma
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose
from .._gltf_file import GltfFile
from .._mesh import Material, Mesh, Texture
from .._scene import Background, Scene
from ..shapes import checker

SKY = Background((0.13, 0.30, 0.66), (0.68, 0.78, 0.90), (0.30, 0.34, 0.22))


_CLAMPED = {"flag", "hud", "label-1", "label-2", "page-1", "page-2", "paintings", "sun-floor"}
_LINEAR = {"floor-normals"}


def textures_named(*names: str) -> list[Texture]:
    """Return the library's textures of these names; each is read when its image is first used."""
    return [
        Texture(name, partial(_image, name), srgb=name not in _LINEAR, repeat=name not in _CLAMPED) for name in names
    ]


def _image(name: str) -> NDArray[np.uint8]:
    from PIL import Image

    with Image.open(Path(__file__).with_name("textures") / f"{name}.webp") as found:
        return np.asarray(found)


def deck_textures(*more: str) -> list[Texture]:
    """Return the textures of the deck, then those of these names."""
    country = ("foliage", "grass", "roof", "facade", "map", "posters")
    return textures_named("planks", "wood", "bricks", "plaster", "fabric", "speckle", *country, *more)


_FIELDS = {
    "positions": "POSITION",
    "normals": "NORMAL",
    "uv": "TEXCOORD_0",  # v up as in Mesh, not down as in glTF: 1 - v would round
    "light": "COLOR_0",
    "albedo": "_ALBEDO",
    "light_uv": "_LIGHT_UV",
}


class StoredModel:
    """The model of one scene."""

    def __init__(self, scene: str) -> None:
        path = Path(__file__).with_name(f"{scene}.glb.xz")
        self._file = GltfFile.parse(path, lzma.decompress(path.read_bytes()))

    def meshes(self, textures: Sequence[Texture]) -> list[Mesh]:
        """Return its meshes; materials find their textures by name among `textures`."""
        index = {texture.name: i for i, texture in enumerate(textures)}
        return [self._mesh(node, index) for node in self._file.items("nodes")]

    def _mesh(self, node: dict[str, Any], index: dict[str, int]) -> Mesh:
        file, name = self._file, node["name"]
        (primitive,) = file.item("meshes", node.get("mesh"), name)["primitives"]
        gltf = file.item("materials", primitive.get("material"), name)
        settings = dict(gltf.get("extras", {}))
        if "normal_map" in settings:
            settings["normal_map"] = index[settings["normal_map"]]
        attributes = primitive["attributes"]
        arrays: dict[str, Any] = {
            field: file.numbers(attributes[key], name) for field, key in _FIELDS.items() if key in attributes
        }
        return Mesh(
            name,
            triangles=file.numbers(primitive["indices"], name, 1).reshape(-1, 3),
            texture=index[gltf["name"]] if "name" in gltf else -1,
            double_sided=gltf.get("doubleSided", False),
            material=Material(**settings),
            body=node.get("extras", {}).get("body", 0),
            **arrays,
        )

    def doubles(self, name: str, columns: int) -> NDArray[np.float64]:
        """Return the (n, columns) numbers of the buffer view of that name."""
        (view,) = (view for view in self._file.items("bufferViews") if view.get("name") == name)
        return np.frombuffer(self._file.view(view), "<f8").reshape(-1, columns)


def stored_scene(name: str, table: Mapping[str, Any]) -> Scene:
    """Return the scene of a table that has a model and nothing that moves."""
    held = textures_named(*table["textures"])
    where: dict[str, Any] = {"viewpoint": Pose(table["viewpoint_m"])} if "viewpoint_m" in table else {}
    colours = [*map(tuple, table["background"])] * (3 if len(table["background"]) == 1 else 1)
    return Scene(
        name,
        table["summary"],
        StoredModel(name).meshes(held),
        held,
        Background(*colours),
        walk_bounds_m=table["walk_bounds_m"],
        **where,
    )


def textures() -> tuple[Texture, ...]:
    """Return plaster and planks, as far as a checkerboard is either."""
    return (
        Texture("plaster", checker(16, 16, (205, 200, 192), (225, 220, 212), 3)),
        Texture("tiles", checker(16, 16, (120, 112, 104), (216, 206, 190), 4)),
    )
