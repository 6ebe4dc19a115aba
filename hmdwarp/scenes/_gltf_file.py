"""glTF files: their JSON, numbers and extensions, every reference checked before it is followed.

trimesh leaves out animations, skins, see-through and mirroring materials and head-locked nodes, and
the models of the library must arrive bit by bit.
Source: Khronos 2021, glTF 2.0 Specification, 3.6 (binary data) and 4 (GLB); the registry of
extensions, https://github.com/KhronosGroup/glTF/tree/main/extensions.
"""

from __future__ import annotations

import base64
import binascii
import io
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, SceneError
from ..base.documents import DocumentError, parse_json
from ..base.named_files import GLTF, SCENE, content_of
from ._draft import Notes, read_beside, rgba_of

_MAGIC, _JSON, _BINARY = 0x46546C67, 0x4E4F534A, 0x004E4942
_LONGEST_NAME = 1000  # characters of a path
_HEADERS = 20  # bytes of the header of a GLB, and of that of its first chunk
_NUMBERS: dict[Any, str] = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@attrs.frozen(eq=False)
class GltfFile:
    """A glTF 2.0 file in memory, with the bytes it refers to."""

    path: Path
    header: dict[str, Any]  # the JSON
    buffers: tuple[bytes, ...]  # the bytes of each buffer
    lists: dict[str, list[dict[str, Any]]] = attrs.field(factory=dict, init=False)  # by kind, once they are checked

    @classmethod
    def read(cls, path: Path) -> GltfFile:
        """Read a .glb, or a .gltf and its files. Errors: SceneError if not glTF 2.0, or cut off."""
        data = content_of(path, GLTF if path.suffix.lower() == ".gltf" else SCENE)
        if data[:4] == struct.pack("<I", _MAGIC) or path.suffix.lower() == ".glb":
            return cls.parse(path, data)
        return cls._with_buffers(path, _header_of(path, data), None)

    @classmethod
    def parse(cls, path: Path, data: bytes) -> GltfFile:
        """Split the bytes of a GLB into its chunks; errors, as those of `read`, name `path`."""
        magic, version, _, length, kind = struct.unpack("<5I", data[:_HEADERS].ljust(_HEADERS, b"\0"))
        start, binary = _HEADERS + length, b""
        if (magic, version, kind) != (_MAGIC, 2, _JSON) or start > len(data):
            found = f"{len(data)} bytes that begin with {data[:_HEADERS]!r}"
            raise SceneError(f"{path}: no GLB 2.0 file: {found}; expected b'glTF', 2 and whole JSON; export it again")
        header = _header_of(path, data[_HEADERS:start])
        if start + 8 <= len(data):
            length, kind = struct.unpack_from("<2I", data, start)
            binary = data[start + 8 : start + 8 + length] if kind == _BINARY else b""
        return cls._with_buffers(path, header, binary)

    @classmethod
    def _with_buffers(cls, path: Path, header: dict[str, Any], binary: bytes | None) -> GltfFile:
        """Return the file with all its buffers; the first may be that of a GLB, `binary`."""
        bare = cls(path, header, ())
        found, left = [], SCENE.most_bytes
        for index, buffer in enumerate(bare.items("buffers")):
            own = binary or b"" if index == 0 else b""
            found.append(bare.bytes_at(buffer["uri"], f"buffer {index}") if "uri" in buffer else own)
            left -= len(found[-1])
            if left < 0:
                raise bare.error(f"buffers of more than {SCENE.most_bytes} bytes; expected fewer: simplify the scene")
        return cls(path, header, tuple(found or [binary or b""]))

    def bytes_at(self, uri: object, user: str) -> bytes:
        """Return the bytes of a data URI or of a file next to this one. Errors: as read_beside."""
        if not isinstance(uri, str):
            raise self.damaged(f"{user}: {uri!r} in place of a file's name")
        if uri.startswith("data:"):
            head, _, data = uri.partition(",")
            try:
                return base64.b64decode(unquote(data), validate=True) if ";base64" in head else unquote_to_bytes(data)
            except (binascii.Error, ValueError) as error:
                raise self.damaged(f"{user}: its data cannot be decoded ({error})") from error
        if len(uri) > _LONGEST_NAME:
            raise self.damaged(f"{user}: a name of {len(uri)} characters in place of a file's")
        try:
            return read_beside(self.path.parent, uri)
        except InputError as error:
            raise InputError(f"{self.path}: {user}: {error}") from error
        except (OSError, ValueError) as error:
            raise self.error(f"{user} lies in '{uri}', which cannot be read: {error}") from error

    def error(self, what: str) -> SceneError:
        return SceneError(f"{self.path}: {what}")

    def damaged(self, what: str) -> SceneError:
        return self.error(f"{what}; export it again")

    def items(self, kind: str) -> list[dict[str, Any]]:
        """Return all items of a kind, such as "nodes"; none if the file lacks the list."""
        if kind in self.lists:
            return self.lists[kind]
        found = self.header.get(kind, [])
        if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
            raise self.damaged(f"its '{kind}' are not a list of objects")
        return self.lists.setdefault(kind, found)

    def item(self, kind: str, index: object, user: str) -> dict[str, Any]:
        """Return item `index` of a kind. Errors: SceneError, naming the `user` of the index."""
        found = self.items(kind)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise self.damaged(f"{user} uses number {index!r} of {len(found)} {kind}")
        return found[index]

    def count(self, table: dict[str, Any], name: str) -> int:
        """Return how many elements an accessor says that it has, 0 where that is no number."""
        index, found = table.get(name), self.items("accessors")
        count = found[index].get("count") if isinstance(index, int) and 0 <= index < len(found) else 0
        return count if isinstance(count, int) else 0

    def numbers(self, index: object, user: str, columns: int | None = None) -> NDArray[Any]:
        """Return the (n, columns) numbers of an accessor as they are stored.

        Normalised integers come as float64 of -1..1 or 0..1. Errors: SceneError.
        """
        accessor = self.item("accessors", index, user)
        kind, count = accessor.get("componentType"), accessor.get("count")
        width = _COLUMNS.get(accessor.get("type", ""))
        if not (isinstance(kind, int) and kind in _NUMBERS and width and isinstance(count, int) and count >= 0):
            found = f"component {kind}, {accessor.get('type')}"
            raise self.error(f"{user}: accessor {index} is of an unsupported kind ({found})")
        name = f"{user}: accessor {index}"
        rows = self._rows(accessor, kind, (count, width), name)
        if "sparse" in accessor:
            rows = self._replaced(rows, accessor, name)
        if columns is not None and rows.shape[1] != columns:
            raise self.error(f"{user}: accessor {index} has {rows.shape[1]} numbers per element, expected {columns}")
        if accessor.get("normalized") and rows.dtype.kind in "iu":
            return np.maximum(rows / np.iinfo(rows.dtype).max, -1.0)
        return rows

    def _rows(self, place: dict[str, Any], kind: int, shape: tuple[int, int], user: str) -> NDArray[Any]:
        """Return an array of a component type; place: what has its buffer view and offset."""
        number, (count, width) = np.dtype(_NUMBERS[kind]), shape
        if "bufferView" not in place:
            if count > (most := sum(map(len, self.buffers))):
                raise self.error(f"{user} has {count} elements without data; expected at most {most}, the file's bytes")
            return np.zeros(shape)
        view = self.item("bufferViews", place["bufferView"], user)
        binary = self._buffer_of(view, user)
        size, offset = number.itemsize * width, place.get("byteOffset", 0)
        start, stride = view.get("byteOffset", 0), view.get("byteStride", size)
        if not all(isinstance(value, int) and value >= 0 for value in (start, stride, offset)) or stride < size:
            raise self.error(f"{user}: a buffer view with offset {start}, stride {stride} for elements of {size} bytes")
        start += offset
        if count and start + stride * (count - 1) + size > len(binary):
            raise self.error(f"{user} reaches beyond the file's {len(binary)} bytes; it is cut off or damaged")
        rows: NDArray[Any] = np.ndarray(shape, number, binary, start, (stride, number.itemsize))
        return rows.copy()

    def _replaced(self, rows: NDArray[Any], accessor: dict[str, Any], user: str) -> NDArray[Any]:
        try:
            sparse, count = accessor["sparse"], int(accessor["sparse"]["count"])
            which = self._rows(sparse["indices"], sparse["indices"]["componentType"], (count, 1), user)[:, 0]
            values = self._rows(sparse["values"], accessor["componentType"], (count, rows.shape[1]), user)
            out = rows.astype(values.dtype)
            out[which] = values
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise self.damaged(f"{user}: its sparse values do not fit ({type(error).__name__}: {error})") from error
        return out

    def _buffer_of(self, view: dict[str, Any], user: str) -> bytes:
        index = view.get("buffer", 0)
        if not isinstance(index, int) or not 0 <= index < len(self.buffers):
            raise self.damaged(f"{user} lies in buffer {index!r} of {len(self.buffers)}")
        return self.buffers[index]

    def view(self, view: dict[str, Any]) -> bytes:
        start, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        return self._buffer_of(view, "a buffer view")[start : start + length]

    def image(self, index: object, user: str) -> NDArray[np.uint8]:
        from PIL import Image

        found = self.item("images", index, user)
        if "uri" in found:
            data = self.bytes_at(found["uri"], f"{user}: image {index}")
        else:
            data = self.view(self.item("bufferViews", found.get("bufferView"), f"{user} (image {index})"))
        try:
            return rgba_of(Image.open(io.BytesIO(data)))
        except (OSError, ValueError, SyntaxError, TypeError, Image.DecompressionBombError) as error:
            what = f"{user}: image {index}, {len(data)} bytes that begin with {data[:8]!r}, cannot be decoded"
            raise self.damaged(f"{what}; expected PNG, JPEG or WebP") from error


def _header_of(path: Path, text: bytes) -> dict[str, Any]:
    if len(text) > GLTF.most_bytes:
        raise SceneError(f"{path}: its JSON has {len(text)} bytes; expected at most {GLTF.most_bytes}; export it again")
    try:
        header = parse_json(text)
    except DocumentError as error:
        raise SceneError(f"{path}: its JSON cannot be read: {error}; export it again") from error
    asset = header.get("asset") if isinstance(header, dict) else None
    version = asset.get("version", "2.0") if isinstance(asset, dict) else "2.0"
    if not isinstance(header, dict) or not str(version).startswith("2"):
        raise SceneError(f"{path}: glTF {version}, expected 2.0; export it again")
    return header


POINTER, LIGHTS, VISIBILITY = "KHR_animation_pointer", "KHR_lights_punctual", "KHR_node_visibility"
KTX2 = "KHR_texture_basisu"
_READ = {POINTER, LIGHTS, VISIBILITY, "EXT_texture_webp", "KHR_mesh_quantization", "KHR_texture_transform"}
_READ |= {f"KHR_materials_{name}" for name in ("emissive_strength", "transmission", "unlit")}
# They describe the file, not the picture; images that are in no other format are noted one by one.
_SILENT = {"KHR_xmp", "KHR_xmp_json_ld", KTX2}
_TOOLS = {KTX2: "ktxdecompress", "KHR_materials_pbrSpecularGlossiness": "metalrough"}  # commands of glTF Transform
_TOOLS |= dict.fromkeys(("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"), "copy")


def check_extensions(file: GltfFile, notes: Notes) -> None:
    """Note the extensions that are left out. Errors: SceneError for what the file needs in vain."""
    lists = {kind: file.header.get(kind, []) for kind in ("extensionsRequired", "extensionsUsed")}
    for kind, found in lists.items():
        if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
            raise file.damaged(f"its '{kind}' are not a list of names")
    own = f"{file.path.name} {file.path.stem}-plain.glb"
    how = {name: f"'gltf-transform {tool} {own}' removes it" for name, tool in _TOOLS.items()}
    required, used = map(dict.fromkeys, lists.values())
    missing = [name for name in required if name not in _READ]
    if missing:
        said = (f"needs {name}, which is not read: {how.get(name, 'export it without')}" for name in missing)
        raise file.error("; ".join(said))
    left = [f"{name} ({how[name]})" if name in how else name for name in used if name not in _READ | _SILENT]
    if left:
        notes.add(f"extensions are left out, and the file does not need them: {', '.join(left)}")
