"""GLB files: their JSON and numbers, every reference checked before it is followed.

For what trimesh leaves out: animations, skins, see-through and mirroring materials, head-locked
nodes; and for the models of the library, whose numbers must arrive bit by bit.
Source: Khronos 2021, glTF 2.0 Specification, 3.6 (binary data) and 4 (GLB).
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
_NUMBERS: dict[Any, Any] = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@attrs.frozen(eq=False)
class GltfFile:
    """A GLB 2.0 file in memory."""

    path: Path
    # The JSON chunk.
    header: dict[str, Any]
    # The binary chunk, empty if the file has none.
    binary: bytes

    @classmethod
    def read(cls, path: Path) -> GltfFile:
        """Read the file at `path`. Errors: SceneError if it is not GLB 2.0 or is cut off."""
        return cls.parse(path, path.read_bytes())

    @classmethod
    def parse(cls, path: Path, data: bytes) -> GltfFile:
        """Split the bytes of a GLB into its chunks; errors, as those of `read`, name `path`."""
        try:
            magic, version, _ = struct.unpack_from("<3I", data)
            length, kind = struct.unpack_from("<2I", data, 12)
            header = json.loads(data[20 : 20 + length])
        except (struct.error, ValueError, RecursionError) as error:
            raise SceneError(f"{path}: not a readable GLB file ({type(error).__name__}); export it again") from error
        if magic != _MAGIC or version != 2 or kind != _JSON or not isinstance(header, dict):
            raise SceneError(f"{path}: not a GLB 2.0 file; export it again")
        start, binary = 20 + length, b""
        if start + 8 <= len(data):
            length, kind = struct.unpack_from("<2I", data, start)
            binary = data[start + 8 : start + 8 + length] if kind == _BINARY else b""
        return cls(path, header, binary)

    def error(self, what: str) -> SceneError:
        """Return an error that names the file."""
        return SceneError(f"{self.path}: {what}")

    def items(self, kind: str) -> list[dict[str, Any]]:
        """Return all items of a kind, such as "nodes"; none if the file lacks the list."""
        found = self.header.get(kind, [])
        if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
            raise self.error(f"its '{kind}' are not a list of objects; export it again")
        return found

    def item(self, kind: str, index: object, user: str) -> dict[str, Any]:
        """Return item `index` of a kind. Errors: SceneError, naming the `user` of the index."""
        found = self.items(kind)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise self.error(f"{user} uses number {index!r} of {len(found)} {kind}; export it again")
        return found[index]

    def numbers(self, index: object, user: str, columns: int | None = None) -> NDArray:
        """Return the (n, columns) numbers of an accessor as they are stored.

        Normalised integers come as float64 of -1..1 or 0..1.
        Errors: SceneError for an unknown accessor, one of another width, or one that reaches beyond
        the file.
        """
        accessor = self.item("accessors", index, user)
        kind, width, count = (
            accessor.get("componentType"),
            _COLUMNS.get(accessor.get("type", "")),
            accessor.get("count"),
        )
        if kind not in _NUMBERS or width is None or not isinstance(count, int) or count < 0 or "sparse" in accessor:
            raise self.error(
                f"{user}: accessor {index} is of an unsupported kind (component {kind}, {accessor.get('type')})"
            )
        if columns is not None and width != columns:
            raise self.error(f"{user}: accessor {index} has {width} numbers per element, expected {columns}")
        number = np.dtype(_NUMBERS[kind]).newbyteorder("<")
        if "bufferView" not in accessor:
            return np.zeros((count, width))
        view = self.item("bufferViews", accessor["bufferView"], user)
        start, stride = self._place(view, accessor, number.itemsize * width, user)
        if count and start + stride * (count - 1) + number.itemsize * width > len(self.binary):
            raise self.error(
                f"{user}: accessor {index} reaches beyond the file's {len(self.binary)} bytes; it is cut off or damaged"
            )
        rows: NDArray = np.ndarray((count, width), number, self.binary, start, (stride, number.itemsize))
        if accessor.get("normalized") and number.kind in "iu":
            return np.maximum(rows / np.iinfo(_NUMBERS[kind]).max, -1.0)
        return rows.copy()

    def _place(self, view: dict, accessor: dict, size: int, user: str) -> tuple[int, int]:
        """Return offset and stride of an accessor's elements of `size` bytes."""
        if view.get("buffer", 0) != 0 or "uri" in (self.items("buffers") or [{}])[0]:
            raise self.error(f"{user} lies in another file; export it as one GLB")
        start, stride = view.get("byteOffset", 0), view.get("byteStride", size)
        offset = accessor.get("byteOffset", 0)
        if not all(isinstance(value, int) and value >= 0 for value in (start, stride, offset)) or stride < size:
            raise self.error(f"{user}: a buffer view with offset {start}, stride {stride} for elements of {size} bytes")
        return start + offset, stride

    def view(self, view: dict) -> bytes:
        """Return the bytes of a buffer view."""
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        return self.binary[start : start + length]

    def image(self, index: object, user: str) -> NDArray[np.uint8]:
        """Return (h, w, 4) bytes of an image. Errors: SceneError if it cannot be decoded."""
        from PIL import Image

        found = self.item("images", index, user)
        view = self.item("bufferViews", found.get("bufferView"), f"{user} (image {index})")
        try:
            return np.array(Image.open(io.BytesIO(self.view(view))).convert("RGBA"))
        except (OSError, ValueError, SyntaxError, TypeError) as error:
            raise self.error(
                f"{user}: image {index} cannot be decoded ({type(error).__name__}); export it again"
            ) from error

    def is_rich(self) -> bool:
        """Return whether it holds more than plain surfaces that stand still."""
        if self.header.get("animations") or self.header.get("skins"):
            return True
        if any((node.get("extras") or {}).get("head_locked") for node in self.items("nodes")):
            return True
        return any(_is_special(material) for material in self.items("materials"))


def _is_special(material: dict) -> bool:
    extensions, extras = (material.get(name) or {} for name in ("extensions", "extras"))
    see_through = material.get("alphaMode") in ("MASK", "BLEND") or "KHR_materials_transmission" in extensions
    return see_through or "reflectivity" in extras or is_mirror(material)


def is_mirror(material: dict) -> bool:
    """Return whether it is polished metal: metallic of at least 0.95, roughness of at most 0.05.

    Both must be numbers that hold for the whole surface.
    """
    surface = material.get("pbrMetallicRoughness") or {}
    if "metallicRoughnessTexture" in surface:
        return False
    metallic, rough = surface.get("metallicFactor", 1.0), surface.get("roughnessFactor", 1.0)
    return isinstance(metallic, int | float) and isinstance(rough, int | float) and metallic >= 0.95 and rough <= 0.05
