"""A GLB file: its JSON and its numbers, every reference checked before it is followed.

Source: Khronos 2021, glTF 2.0 Specification, 3.6 (binary data) and 4 (GLB). For what trimesh leaves out: animations, skins, see-through
and mirroring materials, what is fixed to the head.
"""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError

_MAGIC, _JSON, _BINARY = 0x46546C67, 0x4E4F534A, 0x004E4942
_NUMBERS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@attrs.frozen(eq=False)
class GltfFile:
    """told: the JSON. binary: what it points into."""

    path: Path
    told: dict[str, Any]
    binary: bytes

    @classmethod
    def read(cls, path: Path) -> GltfFile:
        """Errors: SceneError for a file that is no GLB 2.0, or ends too early."""
        data = path.read_bytes()
        try:
            magic, version, _ = struct.unpack_from("<3I", data)
            length, kind = struct.unpack_from("<2I", data, 12)
            told = json.loads(data[20 : 20 + length])
        except (struct.error, ValueError, RecursionError) as error:
            raise SceneError(f"{path}: not a readable GLB file ({type(error).__name__}); export it again") from error
        if magic != _MAGIC or version != 2 or kind != _JSON or not isinstance(told, dict):
            raise SceneError(f"{path}: not a GLB 2.0 file; export it again")
        start, binary = 20 + length, b""
        if start + 8 <= len(data):
            length, kind = struct.unpack_from("<2I", data, start)
            binary = data[start + 8 : start + 8 + length] if kind == _BINARY else b""
        return cls(path, told, binary)

    def wrong(self, what: str) -> SceneError:
        """The error that says so, naming the file."""
        return SceneError(f"{self.path}: {what}")

    def listed(self, kind: str) -> list[dict]:
        """All of one kind; none if the file has none."""
        found = self.told.get(kind, [])
        if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
            raise self.wrong(f"its '{kind}' are no list of objects; export it again")
        return found

    def one(self, kind: str, index: object, wanted_by: str) -> dict:
        """Number `index` of a kind. Errors: SceneError if there is none of that number."""
        found = self.listed(kind)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise self.wrong(f"{wanted_by} wants number {index!r} of {len(found)} {kind}; export it again")
        return found[index]

    def numbers(self, index: object, wanted_by: str, columns: int | None = None) -> NDArray:
        """(n, columns) numbers of an accessor as they are stored; normalised integers as float64 of -1..1 or 0..1.

        Errors: SceneError for one that is not there, of another width, or that reaches beyond the file.
        """
        accessor = self.one("accessors", index, wanted_by)
        kind, width, count = accessor.get("componentType"), _COLUMNS.get(accessor.get("type")), accessor.get("count")
        if kind not in _NUMBERS or width is None or not isinstance(count, int) or count < 0 or "sparse" in accessor:
            raise self.wrong(
                f"{wanted_by}: accessor {index} is of a kind that is not read (component {kind}, {accessor.get('type')})"
            )
        if columns is not None and width != columns:
            raise self.wrong(f"{wanted_by}: accessor {index} has {width} numbers an element, wanted {columns}")
        number = np.dtype(_NUMBERS[kind]).newbyteorder("<")
        if "bufferView" not in accessor:
            return np.zeros((count, width))
        view = self.one("bufferViews", accessor["bufferView"], wanted_by)
        start, stride = self._place(view, accessor, number.itemsize * width, wanted_by)
        if count and start + stride * (count - 1) + number.itemsize * width > len(self.binary):
            raise self.wrong(
                f"{wanted_by}: accessor {index} reaches beyond the file's {len(self.binary)} bytes; it is cut off or damaged"
            )
        rows = np.ndarray((count, width), number, self.binary, start, (stride, number.itemsize))
        if accessor.get("normalized") and number.kind in "iu":
            return np.maximum(rows / np.iinfo(number).max, -1.0)
        return rows.copy()

    def _place(self, view: dict, accessor: dict, size: int, wanted_by: str) -> tuple[int, int]:
        if view.get("buffer", 0) != 0 or "uri" in (self.listed("buffers") or [{}])[0]:
            raise self.wrong(f"{wanted_by} lies in another file; export it as one GLB")
        start, stride = view.get("byteOffset", 0), view.get("byteStride", size)
        offset = accessor.get("byteOffset", 0)
        if not all(isinstance(value, int) and value >= 0 for value in (start, stride, offset)) or stride < size:
            raise self.wrong(
                f"{wanted_by}: a buffer view with offset {start}, stride {stride} for elements of {size} bytes"
            )
        return start + offset, stride

    def image(self, index: object, wanted_by: str) -> NDArray[np.uint8]:
        """(h, w, 4) bytes of an image. Errors: SceneError for one that cannot be read."""
        from PIL import Image

        told = self.one("images", index, wanted_by)
        view = self.one("bufferViews", told.get("bufferView"), f"{wanted_by} (image {index})")
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        try:
            return np.array(Image.open(io.BytesIO(self.binary[start : start + length])).convert("RGBA"))
        except (OSError, ValueError, SyntaxError, TypeError) as error:
            raise self.wrong(
                f"{wanted_by}: image {index} cannot be read ({type(error).__name__}); export it again"
            ) from error

    def is_rich(self) -> bool:
        """Whether there is more to it than plain surfaces that stand still."""
        if self.told.get("animations") or self.told.get("skins"):
            return True
        if any((node.get("extras") or {}).get("head_locked") for node in self.listed("nodes")):
            return True
        return any(_is_special(material) for material in self.listed("materials"))


def _is_special(material: dict) -> bool:
    extensions, extras = (material.get(name) or {} for name in ("extensions", "extras"))
    see_through = material.get("alphaMode") in ("MASK", "BLEND") or "KHR_materials_transmission" in extensions
    return see_through or "reflectivity" in extras or is_mirror(material)


def is_mirror(material: dict) -> bool:
    """A polished metal: metallic 0.95 or more and roughness 0.05 at most, both of them numbers for all of it."""
    told = material.get("pbrMetallicRoughness") or {}
    if "metallicRoughnessTexture" in told:
        return False
    metallic, rough = told.get("metallicFactor", 1.0), told.get("roughnessFactor", 1.0)
    return isinstance(metallic, int | float) and isinstance(rough, int | float) and metallic >= 0.95 and rough <= 0.05
