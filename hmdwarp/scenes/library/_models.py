"""Models of the library's scenes: geometry with baked light in GLB files next to their modules.

README.md in this folder says what the files hold and how to edit them. Rooms of boxes and walls,
for scenes whose light moves, have places in the light atlas instead.
"""

from __future__ import annotations

import lzma
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from .._gltf_file import GltfFile
from .._mesh import Material, Mesh, Texture
from .._scene import ATLAS, Background
from ..shapes import Quad, Triple, checker
from ..textures import textures_named

SKY = Background((0.13, 0.30, 0.66), (0.68, 0.78, 0.90), (0.30, 0.34, 0.22))


def deck_textures(*more: str) -> list[Texture]:
    """Paint the textures of the deck, then those of these names."""
    country = ("foliage", "grass", "roof", "facade", "map", "posters")
    return textures_named("planks", "wood", "bricks", "plaster", "fabric", "speckle", *country, *more)


_FIELDS = {
    "positions": "POSITION",
    "normals": "NORMAL",
    "uv": "TEXCOORD_0",  # v up as in Mesh, not down as in glTF: 1 - v would round
    "light": "COLOR_0",
    "albedo": "_ALBEDO",
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
            texture=index[gltf["name"]],
            double_sided=gltf.get("doubleSided", False),
            material=Material(**settings),
            body=node.get("extras", {}).get("body", 0),
            **arrays,
        )

    def doubles(self, name: str, columns: int) -> NDArray[np.float64]:
        """Return the (n, columns) numbers of the buffer view of that name."""
        (view,) = (view for view in self._file.items("bufferViews") if view.get("name") == name)
        return np.frombuffer(self._file.view(view), "<f8").reshape(-1, columns)

    def mask(self, name: str) -> NDArray[np.bool_]:
        """Return the (h, w) black and white image of that name."""
        names = [image.get("name") for image in self._file.items("images")]
        return self._file.image(names.index(name), name)[..., 0] > 127


BORDER = 1  # texels around each chart, so that light never blends with another's


def textures() -> tuple[Texture, ...]:
    """Return plaster and planks, as far as a checkerboard is either."""
    return (
        Texture("plaster", checker(16, 16, (205, 200, 192), (225, 220, 212), 3)),
        Texture("tiles", checker(16, 16, (120, 112, 104), (216, 206, 190), 4)),
    )


def wall(centre: Triple, right: Triple, up: Triple, albedo: Triple, texture: int = 0) -> Quad:
    """Return a wall with half edges right and up, its texture 2 m wide."""
    sides = (float(np.linalg.norm(right)), float(np.linalg.norm(up)))
    return Quad(centre, right, up, texture, albedo, sides)


def box(low: Triple, high: Triple, albedo: Triple, texture: int = 0) -> list[Quad]:
    """Return the sides of a box and its top; it stands on the floor."""
    middle, half = (np.array(low) + high) / 2, (np.array(high) - low) / 2
    x, y, z = np.diag(half)
    outwards = ((x, -z, y), (-x, z, y), (z, x, y), (-z, -x, y), (y, x, -z))  # side, right, up
    return [wall(tuple(middle + side), tuple(right), tuple(up), albedo, texture) for side, right, up in outwards]


def in_atlas(quads: Iterable[Quad], texel_m: float) -> list[Mesh]:
    """Return the quads as meshes placed in the light atlas, tallest first; texel_m: about wide."""
    quads = list(quads)
    counts = [
        [max(1, round(2 * float(np.linalg.norm(half)) / texel_m)) for half in (quad.right, quad.up)] for quad in quads
    ]
    meshes: dict[int, Mesh] = {}
    column = row = tallest = 0
    for index in sorted(range(len(quads)), key=lambda i: -counts[i][1]):
        wide, high = counts[index]
        if column + wide + 2 * BORDER > ATLAS[0]:
            column, row, tallest = 0, row + tallest, 0
        low = np.array([column, row]) + BORDER
        corners = low + np.array([(0, 0), (wide, 0), (wide, high), (0, high)])
        meshes[index] = attrs.evolve(quads[index].mesh(f"surface-{index}"), light_uv=corners)
        column, tallest = column + wide + 2 * BORDER, max(tallest, high + 2 * BORDER)
    return [meshes[index] for index in range(len(quads))]
