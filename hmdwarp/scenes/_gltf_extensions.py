"""Extensions of glTF: which are read, which are noted, how to be rid of those that a file needs.

Source: the registry of extensions, https://github.com/KhronosGroup/glTF/tree/main/extensions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import SceneError
from ..resources import install_line
from ._gltf_file import GltfFile
from ._notes import Notes

DRACO, INSTANCING, LIGHTS, KTX2 = (
    "KHR_draco_mesh_compression",
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_texture_basisu",
)
READ = {
    DRACO,
    INSTANCING,
    "EXT_texture_webp",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
}
# What a file may need and still be drawn, with a note of its own.
NOTED = {LIGHTS}
_COPY = "gltf-transform copy"
_TOOLS = {
    DRACO: _COPY,
    "EXT_meshopt_compression": _COPY,
    "KHR_meshopt_compression": _COPY,
    KTX2: "gltf-transform ktxdecompress",
    "KHR_materials_pbrSpecularGlossiness": "gltf-transform metalrough",
}
# They describe the file, not the picture.
_SILENT = {"KHR_xmp", "KHR_xmp_json_ld"}


def check_extensions(file: GltfFile, notes: Notes) -> None:
    """Note the extensions that are left out. Errors: SceneError for what the file needs in vain."""
    required, used = (_names(file, kind) for kind in ("extensionsRequired", "extensionsUsed"))
    missing = [name for name in required if name not in READ | NOTED]
    if DRACO in required and not _has_draco():
        missing.insert(0, DRACO)
    if missing:
        raise file.error("; ".join(_refusal(file, name) for name in missing))
    lights = ((file.header.get("extensions") or {}).get(LIGHTS) or {}).get("lights", [])
    if lights:
        notes.add(f"{len(lights)} lights ({LIGHTS}) are left out: a plain light from above is used")
    left = [name for name in used if name not in READ | NOTED | _SILENT and name not in _SPOKEN_OF_ELSEWHERE]
    if left:
        notes.add(f"extensions are left out, and the file does not need them: {', '.join(left)}")


# Images that are in no other format are noted one by one.
_SPOKEN_OF_ELSEWHERE = {KTX2}


def _names(file: GltfFile, kind: str) -> list[str]:
    found = file.header.get(kind, [])
    if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
        raise file.error(f"its '{kind}' are not a list of names; export it again")
    return list(dict.fromkeys(found))


def _refusal(file: GltfFile, name: str) -> str:
    own = file.path
    if name == DRACO:
        install = f"install its decoder ({install_line('draco')}), or remove it with "
        return f"needs {name}: {install}'{_COPY} {own.name} {own.stem}-plain.glb'"
    if name in _TOOLS:
        return f"needs {name}, which is not read: '{_TOOLS[name]} {own.name} {own.stem}-plain.glb' removes it"
    return f"needs {name}, which is not read: export it without"


def _has_draco() -> bool:
    try:
        import DracoPy  # noqa: F401
    except ImportError:
        return False
    return True


def unpack_draco(file: GltfFile, primitive: dict[str, Any], user: str, notes: Notes) -> None:
    """Decode a primitive that Draco packed; its accessors then give the decoded numbers.

    Source: Khronos 2019, KHR_draco_mesh_compression.
    """
    packed = (primitive.get("extensions") or {}).get(DRACO)
    if packed is None:
        return
    if not _has_draco():  # not required, so there is a plain copy beside it
        notes.add(f"{DRACO} is not unpacked ({install_line('draco')}); the plain copy in the file is used")
        return
    import DracoPy

    view = file.item("bufferViews", packed.get("bufferView"), user)
    try:
        mesh = DracoPy.decode(file.view(view))
        data = {one["unique_id"]: np.asarray(one["data"]) for one in mesh.attributes}
        for name, number in packed["attributes"].items():
            rows = data[number]
            file.unpacked[primitive["attributes"][name]] = rows.reshape(len(rows), -1)
        if "indices" in primitive:
            file.unpacked[primitive["indices"]] = np.asarray(mesh.faces, np.uint32).reshape(-1, 1)
    except SceneError:
        raise
    except Exception as error:  # a damaged stream: DracoPy raises what it likes
        raise file.error(
            f"{user}: its Draco data cannot be decoded ({type(error).__name__}); export it again"
        ) from error


def instances_of(file: GltfFile, node: dict[str, Any], user: str) -> np.ndarray | None:
    """Return (n, 4, 4) node_from_instance of a node that is drawn several times; None for others.

    Source: Khronos 2021, EXT_mesh_gpu_instancing.
    """
    from scipy.spatial.transform import Rotation

    found = (node.get("extensions") or {}).get(INSTANCING)
    if found is None:
        return None
    attributes = found.get("attributes") or {}
    widths = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}
    parts = {
        name: file.numbers(attributes[name], user, width).astype(np.float64)
        for name, width in widths.items()
        if name in attributes
    }
    counts = {len(rows) for rows in parts.values()}
    if len(counts) != 1 or not all(np.isfinite(rows).all() for rows in parts.values()):
        raise file.error(f"{user}: instances without one finite place, turn and size each; export it again")
    (count,) = counts
    matrices = np.tile(np.eye(4), (count, 1, 1))
    if "ROTATION" in parts and count:
        if (np.linalg.norm(parts["ROTATION"], axis=1) < 1e-6).any():
            raise file.error(f"{user}: an instance's rotation has length 0; export it again")
        matrices[:, :3, :3] = Rotation.from_quat(parts["ROTATION"]).as_matrix()
    if "SCALE" in parts:
        matrices[:, :3, :3] *= parts["SCALE"][:, None, :]
    if "TRANSLATION" in parts:
        matrices[:, :3, 3] = parts["TRANSLATION"]
    return matrices
