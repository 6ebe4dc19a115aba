"""Mitsuba's scenes (.xml, of versions 0.5 to 3), as parts of a scene: shapes with matt colours."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..options.named_files import BESIDE, content_of, keep_inside, text_in
from ._draft import MOST_TRIANGLES, Draft, Look, normals_of
from ._mesh import Material, Texture
from ._mesh_files import GREY, mesh_parts
from ._notes import Notes, read_beside, rgba_of

Array = NDArray[np.float64]
Part = tuple[Array, Array, NDArray[np.uint32]]  # positions (n, 3), uv (n, 2), triangles (m, 3)
_SQUARE = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float64)
_TWO = np.array([(0, 1, 2), (0, 2, 3)], np.uint32)
_COLOURS = ("reflectance", "diffusereflectance", "specularreflectance")
_GLASS = ("dielectric", "thindielectric", "roughdielectric")
# Of a serialized mesh: what follows its positions, and their type.
_NORMALS, _UV, _DOUBLE = 1, 2, 0x2000
_LIGHT = 1.0


def mitsuba_drafts(path: Path, units: Array, notes: Notes, textures: list[Texture]) -> list[Draft]:
    """Return the shapes of a scene; pictures go to `textures`. units: 4x4 to metres, +y up.

    Lights shine in their own colour and light nothing; metal is matt; glass is left out.
    """
    root = ElementTree.fromstring(text_in(path, BESIDE))
    named = {one.get("id", ""): one for one in root.iter() if one.tag in ("bsdf", "texture")}
    looks, drafts = _Looks(path.parent, named, textures, notes), []
    for number, shape in enumerate(root.iter("shape")):
        look = looks.of(shape)
        if look is None:
            continue
        world = units @ _matrix(path, shape)
        for positions, uv, triangles in _parts(path, shape, notes):
            placed = positions @ world[:3, :3].T + world[:3, 3]
            name, colour = f"{path.stem}-{number}", np.tile(look.colour, (len(placed), 1))
            drafts.append(Draft(name, placed, look, triangles, normals_of(placed, triangles), uv, colour))
    return drafts


def _value(element: ElementTree.Element, name: str) -> str:
    """Return the value of a named child, "" for none; version 3 writes names with underscores."""
    return next((one.get("value", "") for one in element if _name(one) == name), "")


def _name(element: ElementTree.Element) -> str:
    return element.get("name", "").replace("_", "").lower()


def _matrix(path: Path, shape: ElementTree.Element) -> Array:
    """Return the 4x4 that takes a shape to the world. Errors: SceneError for other transforms."""
    placed = np.eye(4)
    for step in (one for each in shape.iter("transform") if _name(each) == "toworld" for one in each):
        numbers = step.get("value", "").replace(",", " ").split()
        if step.tag != "matrix" or len(numbers) != 16:
            raise SceneError(f"{path}: a shape is placed by <{step.tag}>; expected <matrix> of 16 numbers")
        placed = np.array(numbers, np.float64).reshape(4, 4) @ placed
    return placed


def _parts(path: Path, shape: ElementTree.Element, notes: Notes) -> Iterator[Part]:
    kind, name = shape.get("type", ""), _value(shape, "filename")
    if kind == "rectangle":
        yield _SQUARE, (_SQUARE[:, :2] + 1) / 2, _TWO
    elif kind in ("obj", "ply"):
        for part in mesh_parts(keep_inside(path.parent / name, path.parent), notes):
            uv = getattr(part.visual, "uv", None)
            uv = np.zeros((len(part.vertices), 2)) if uv is None else np.asarray(uv, np.float64)
            yield np.asarray(part.vertices, np.float64), uv, np.asarray(part.faces).astype(np.uint32)
    elif kind == "serialized":
        try:
            yield serialized(content_of(path.parent / name, BESIDE, path.parent), int(_value(shape, "shapeindex") or 0))
        except (ValueError, IndexError, struct.error, zlib.error) as error:
            raise SceneError(f"{path.parent / name}: not a readable mesh ({error}); export it again") from error
    else:
        notes.add("shapes that are no mesh are left out", kind)


def serialized(data: bytes, index: int) -> Part:
    """Return a mesh of Mitsuba's own file of meshes.

    Errors: ValueError, IndexError, struct.error or zlib.error for what is none.

    Source: Mitsuba 0.6 documentation, 8.1.7 (shape `serialized`).
    """
    (version,), (count,) = struct.unpack_from("<H", data, 2), struct.unpack_from("<I", data, len(data) - 4)
    wide = "Q" if version >= 4 else "I"
    begins = struct.unpack_from(f"<{count}{wide}", data, len(data) - 4 - count * struct.calcsize(wide))[index]
    stream = _Inflated(data[begins + 4 :])
    (flags,) = struct.unpack("<I", stream.read(4))
    while version >= 4 and stream.read(1) not in (b"\0", b""):  # its name
        pass
    vertices, triangles = struct.unpack("<QQ", stream.read(16))
    if max(vertices, triangles) > MOST_TRIANGLES:
        raise ValueError(f"{vertices} vertices and {triangles} triangles; at most {MOST_TRIANGLES} are read")

    def numbers(rows: int, columns: int, kind: str) -> NDArray[Any]:
        size = rows * columns * np.dtype(kind).itemsize
        return np.frombuffer(stream.read(size), kind).reshape(rows, columns)

    real = "<f8" if flags & _DOUBLE else "<f4"
    positions = numbers(vertices, 3, real).astype(np.float64)
    if flags & _NORMALS:
        numbers(vertices, 3, real)
    uv = numbers(vertices, 2, real).astype(np.float64) if flags & _UV else np.zeros((vertices, 2))
    faces = numbers(triangles, 3, "<u4").astype(np.uint32)
    return positions, np.column_stack([uv[:, 0], 1 - uv[:, 1]]), faces


class _Inflated:
    """Packed bytes, of which no more is unpacked than is read: a few may unpack to gigabytes."""

    def __init__(self, packed: bytes) -> None:
        self._unpacker, self._packed = zlib.decompressobj(), packed

    def read(self, size: int) -> bytes:
        found = self._unpacker.decompress(self._packed, size) if size else b""
        self._packed = self._unpacker.unconsumed_tail
        return found


class _Looks:
    """What surfaces look like, each once."""

    def __init__(
        self, folder: Path, named: dict[str, ElementTree.Element], textures: list[Texture], notes: Notes
    ) -> None:
        self._folder, self._named, self._textures, self._notes = folder, named, textures, notes
        self._pictures: dict[str, int] = {}

    def of(self, shape: ElementTree.Element) -> Look | None:
        """Return the look of a shape; None for one that is left out."""
        if shape.find("emitter") is not None:
            return Look(np.full(3, _LIGHT), -1, Material(), double_sided=True, unlit=True)
        surface = self._surface(shape)
        if surface is not None and surface.get("type") in _GLASS:
            self._notes.add("glass is left out", surface.get("type", ""))
            return None
        colour, picture = (np.full(3, GREY), -1) if surface is None else self._colour(surface)
        return Look(colour, picture, Material(), double_sided=True)

    def _surface(self, element: ElementTree.Element) -> ElementTree.Element | None:
        """Return the innermost surface: of a shape, or within `twosided` and its like."""
        for one in element:
            found = self._named.get(one.get("id", "")) if one.tag == "ref" else one
            if found is not None and found.tag == "bsdf":
                inner = self._surface(found)
                return found if inner is None else inner
        return None

    def _colour(self, surface: ElementTree.Element) -> tuple[Array, int]:
        """Return linear colour (3,) and the index of its picture, -1 for none."""
        for one in sorted(surface, key=_name):
            if _name(one) not in _COLOURS:
                continue
            found = self._named.get(one.get("id", ""), one) if one.tag == "ref" else one
            if found.tag == "texture":
                return np.ones(3), self._picture(_value(found, "filename"))
            numbers = found.get("value", "").replace(",", " ").split()
            if found.tag in ("rgb", "spectrum", "float") and len(numbers) in (1, 3):
                return np.broadcast_to(np.array(numbers, np.float64), 3), -1
        return np.full(3, GREY), -1

    def _picture(self, name: str) -> int:
        if name not in self._pictures:
            from PIL import Image

            try:
                with Image.open(io.BytesIO(read_beside(self._folder, name))) as image:
                    self._textures.append(Texture(name, rgba_of(image)[..., :3]))
                self._pictures[name] = len(self._textures) - 1
            except (OSError, ValueError):
                self._notes.add("a file that it names is missing or cannot be read, drawn white", f"texture '{name}'")
                self._pictures[name] = -1
        return self._pictures[name]
