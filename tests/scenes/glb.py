"""GLB files put together by hand, with known content."""

from __future__ import annotations

import base64
import io
import json
import struct

import numpy as np
from PIL import Image

from hmdwarp.scenes import Scene, SceneOptions, load_scene

# A viewer at (0, 1.6, 0) of the file, so that its numbers stay as they are.
IN_PLACE = SceneOptions(viewpoint="0,1.6,0")
SQUARE = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float32)
FACES = np.array([0, 1, 2, 0, 2, 3], np.uint16)


class Glb:
    """A GLB put together by hand: one square on one node, and what the test adds."""

    def __init__(self, positions: np.ndarray = SQUARE) -> None:
        self.binary = b""
        self.header: dict = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "bufferViews": [], "accessors": [],
        }  # fmt: skip
        uv = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], np.float32)
        attributes = {"POSITION": self.numbers(positions), "TEXCOORD_0": self.numbers(uv)}
        self.primitive = {"attributes": attributes, "indices": self.numbers(FACES)}
        self.header |= {
            "meshes": [{"primitives": [self.primitive]}],
            "nodes": [{"name": "thing", "mesh": 0, "translation": [0, 1, -3]}],
        }

    @classmethod
    def of(cls, path) -> Glb:
        """A file's, to be changed."""
        data, made = path.read_bytes(), cls()
        length = int.from_bytes(data[12:16], "little")
        made.header, made.binary = json.loads(data[20 : 20 + length]), data[28 + length :]
        return made

    def view(self, data: bytes) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.header["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.header["bufferViews"]) - 1

    def numbers(self, array) -> int:
        array = np.asarray(array)
        array = array.astype(np.float32) if array.dtype == np.float64 else array
        kind = {np.float32: 5126, np.uint16: 5123, np.uint8: 5121}[array.dtype.type]
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[array.shape[1] if array.ndim > 1 else 1]
        view = self.view(array.tobytes())
        self.header["accessors"].append({"bufferView": view, "componentType": kind, "count": len(array), "type": shape})
        return len(self.header["accessors"]) - 1

    def material(self, **said) -> Glb:
        self.header["materials"] = [said]
        self.primitive["material"] = 0
        return self

    def texture(self, image: np.ndarray) -> dict:
        stream = io.BytesIO()
        Image.fromarray(image).save(stream, "PNG")
        self.header.setdefault("images", []).append(
            {"bufferView": self.view(stream.getvalue()), "mimeType": "image/png"}
        )
        self.header.setdefault("textures", []).append({"source": len(self.header["images"]) - 1})
        return {"index": len(self.header["textures"]) - 1}

    def animate(self, path: str, times, values, kind: str = "LINEAR", node: int = 0, pointer: str = "") -> Glb:
        animation = self.header.setdefault("animations", [{"name": "walk", "samplers": [], "channels": []}])[0]
        ends = {
            "input": self.numbers(np.array(times, np.float32)),
            # Bytes stay bytes: truths.
            "output": self.numbers(values if isinstance(values, np.ndarray) else np.array(values, np.float32)),
        }
        animation["samplers"].append(ends | {"interpolation": kind})
        target = {"node": node, "path": path}
        if pointer:
            target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": target})
        return self

    def skin(self, weights=((1, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0.5, 0.5, 0, 0)), joints=(0, 1, 0, 0)) -> Glb:
        """Two joints: one that stands at the origin, and one that hangs from it, 1 m up at rest."""
        self.header["nodes"] += [{"name": "foot", "children": [2]}, {"name": "head", "translation": [0, 1, 0]}]
        self.header["scenes"][0]["nodes"].append(1)
        self.header["nodes"][0]["skin"] = 0
        inverse = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
        inverse[1, 3, :3] = (0, -1, 0)  # columns first, as the format has it
        self.header["skins"] = [
            {"name": "figure", "joints": [1, 2], "inverseBindMatrices": self.numbers(inverse.reshape(2, 16))}
        ]
        attributes = self.primitive["attributes"]
        attributes["JOINTS_0"] = self.numbers(np.tile(np.array(joints, np.uint8), (4, 1)))
        attributes["WEIGHTS_0"] = self.numbers(np.array(weights, np.float32))
        return self

    def data(self) -> bytes:
        self.header["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.header).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + b"\0" * (-len(self.binary) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body

    def load(self, folder, name: str = "thing.glb", options: SceneOptions = IN_PLACE) -> Scene:
        (folder / name).write_bytes(self.data())
        return load_scene(folder / name, options)

    def write_gltf(self, path, *, inside: bool) -> None:
        """As JSON, with the buffer and the images as data URIs, or in files beside it."""
        header = json.loads(json.dumps(self.header))

        def uri(name: str, data: bytes) -> str:
            if inside:
                return "data:application/octet-stream;base64," + base64.b64encode(data).decode()
            (path.parent / name).write_bytes(data)
            return name.replace(" ", "%20")

        for number, image in enumerate(header.get("images", [])):
            view = self.header["bufferViews"][image.pop("bufferView")]
            data = self.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
            image["uri"] = uri(f"picture {number}.png", data)
        header["buffers"] = [{"byteLength": len(self.binary), "uri": uri("all numbers.bin", self.binary)}]
        path.write_text(json.dumps(header), encoding="utf-8")
