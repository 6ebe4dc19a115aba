"""Somebody's GLB, OBJ or PLY as a scene: node transforms applied, textures and colours kept, a plain light baked in."""

from __future__ import annotations

import logging
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..errors import SceneError
from ..geometry import Pose
from ._content import Material
from ._gltf_file import GltfFile
from ._gltf_scene import rich_parts
from ._model import Background, Mesh, Scene, Texture

if TYPE_CHECKING:
    import trimesh

SKY = Background((0.30, 0.42, 0.62), (0.72, 0.77, 0.82), (0.32, 0.31, 0.30))
GREY = 0.5
_UNCHOSEN = (102, 102, 102)  # trimesh's diffuse colour where a file names none; its own exporter writes it as Kd 0.4
_KEY_LIGHT = np.array([0.35, 0.80, 0.48]) / np.linalg.norm([0.35, 0.80, 0.48])
_STANDING_M = 1.6


def scene_from_file(path: Path) -> Scene:
    """The file's triangles as a Scene; what was survivable (a missing picture, degenerate parts) is said in its notes.

    The file's units are taken as metres and +y as up, as glTF has it. The viewer stands at `viewpoint` (see viewpoint_of).
    Far from the origin the float64 offset is kept apart (origin_m), so that no digits are lost on the GPU.
    Errors: SceneError, one line, for a file that is missing, empty, corrupt, without triangles, or with positions that are not finite.
    """
    if _is_rich(path):
        return _rich_scene(path)
    notes: list[str] = []
    parts = [part for part in _parts_of(path, notes) if len(part.faces)]
    if not parts:
        raise SceneError(f"{path}: no triangles in it; wanted a mesh (a point cloud or an empty scene cannot be drawn)")
    for part in parts:
        _check_shape(path, part)
        _check_finite(path, part)
    low, high = (np.array([getattr(part.vertices, end)(axis=0) for part in parts]) for end in ("min", "max"))
    low, high = low.min(axis=0), high.max(axis=0)
    origin = np.round((low + high) / 2)  # whole metres, so that a scene drawn at the origin keeps its own numbers
    textures: list[Texture] = []
    meshes = [_mesh(part, f"{path.stem}-{i}", origin, textures, notes) for i, part in enumerate(parts)]
    viewpoint, bounds = viewpoint_of(low, high)
    summary = f"{path.name}: {sum(len(m.triangles) for m in meshes)} triangles"
    return Scene(
        path.stem,
        summary,
        meshes,
        textures,
        SKY,
        origin_m=origin,
        viewpoint=viewpoint,
        walk_bounds_m=bounds,
        notes=dict.fromkeys(notes),
    )


def _rich_scene(path: Path) -> Scene:
    """A GLB with animations, skins, mirrors or what one sees through, see _gltf_scene."""
    import trimesh

    def is_closed(positions: NDArray, triangles: NDArray) -> bool:
        return _is_closed(trimesh.Trimesh(positions, triangles, process=False))

    try:
        with np.errstate(all="ignore"):
            parts = rich_parts(path, _normals, is_closed)
            if not parts.drafts:
                raise SceneError(
                    f"{path}: no triangles in it; wanted a mesh (a point cloud or an empty scene cannot be drawn)"
                )
            standing = [draft.positions for draft in parts.drafts if not draft.look.material.head_locked]
            low, high = (
                np.array([getattr(one, end)(axis=0) for one in standing or [np.zeros((1, 3))]])
                for end in ("min", "max")
            )
            low, high = low.min(axis=0), high.max(axis=0)
            origin = np.round((low + high) / 2)
            meshes = [draft.mesh(origin, _light_on) for draft in parts.drafts]
            viewpoint, bounds = viewpoint_of(low, high)
            summary = f"{path.name}: {sum(len(m.triangles) for m in meshes)} triangles"
            told = {"bodies": parts.bodies, "origin_m": origin, "notes": dict.fromkeys(parts.notes)}
            return Scene(
                path.stem, summary, meshes, parts.textures, SKY, viewpoint=viewpoint, walk_bounds_m=bounds, **told
            )
    except (SceneError, MemoryError):
        raise
    except Exception as error:  # a damaged file may have anything where something else is wanted
        reason = " ".join(str(error).split())[:120]
        raise SceneError(
            f"{path}: not a readable GLB file ({type(error).__name__}: {reason}); export it again"
        ) from error


def _is_rich(path: Path) -> bool:
    try:
        return path.suffix.lower() == ".glb" and path.is_file() and GltfFile.read(path).is_rich()
    except (SceneError, OSError, AttributeError, TypeError):
        return False  # whatever is wrong with it is said by those who read it


def viewpoint_of(low: NDArray, high: NDArray) -> tuple[Pose, NDArray]:
    """Where a viewer stands in a box (3,) low to high of somebody's scene, looking along -z, and the (2, 3) box to walk in.

    Something of a room's size (3 m or more across both ways and 2 m high) is stood in: at its middle, 1.6 m above its floor.
    Anything else is an object: it is looked at from outside, from the +z side at the height of its middle, far enough away
    that it fills about 50 degrees.
    """
    middle, size = (low + high) / 2, high - low
    if size[0] >= 3 and size[2] >= 3 and size[1] >= 2:
        eye = np.array([middle[0], low[1] + min(_STANDING_M, 0.6 * size[1]), middle[2]])
        reach = np.array([0.25 * size[0], 0.3, 0.25 * size[2]])
    else:
        distance = max(float(max(size[0], size[1])) / (2 * np.tan(np.radians(25))), 0.05)
        eye = np.array([middle[0], middle[1], high[2] + distance])
        reach = np.full(3, distance / 2)
    return Pose(eye), np.array([eye - reach, eye + reach])


def _parts_of(path: Path, notes: list[str]) -> list[trimesh.Trimesh]:
    """Every mesh of the file in world coordinates."""
    import trimesh

    if not path.is_file():
        raise SceneError(f"{path}: no such scene file; wanted a .glb, .obj or .ply file, or the name of a scene")
    if path.stat().st_size == 0:
        raise SceneError(f"{path}: the file is empty; wanted a .glb, .obj or .ply file")
    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("glb", "obj", "ply"):
        raise SceneError(f"{path}: cannot read '{path.suffix}' scenes; wanted .glb, .obj or .ply")
    quiet, before = logging.getLogger("trimesh"), logging.getLogger("trimesh").level
    quiet.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            loaded = trimesh.load(path, file_type=kind, process=False, maintain_order=True)
            found = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    except MemoryError:
        raise
    except Exception as error:  # trimesh's readers raise whatever their parsing trips over
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise SceneError(
            f"{path}: not a readable {kind.upper()} file ({type(error).__name__}: {reason}); export it again"
        ) from error
    finally:
        quiet.setLevel(before)
    notes += {"obj": _missing_pictures, "ply": _missing_ply_pictures}.get(kind, lambda _: [])(path)
    return [part for part in found if isinstance(part, trimesh.Trimesh)]


def _missing_pictures(path: Path) -> list[str]:
    """One note per material library or picture that an OBJ names and that is not there; its surfaces are drawn grey or plain."""
    notes = []
    for library in _named_in(path, "mtllib"):
        if not (path.parent / library).is_file():
            notes.append(f"{path}: its material file '{library}' is missing; drawn grey")
            continue
        for picture in _named_in(path.parent / library, "map_Kd"):
            if not (path.parent / picture).is_file():
                notes.append(f"{path}: texture '{picture}' is missing; drawn grey")
    return notes


def _missing_ply_pictures(path: Path) -> list[str]:
    """The same for the pictures that a PLY names in its header, as MeshLab and others write them."""
    names = []
    with path.open("rb") as file:
        for line in file:
            words = line.decode("utf-8", "replace").split(maxsplit=2)
            if words[:1] == ["end_header"]:
                break
            if words[:2] == ["comment", "TextureFile"] and len(words) == 3:
                names.append(words[2].strip())
    return [f"{path}: texture '{name}' is missing; drawn grey" for name in names if not (path.parent / name).is_file()]


def _named_in(path: Path, keyword: str) -> list[str]:
    with path.open(encoding="utf-8", errors="replace") as file:
        lines = (line.split(maxsplit=1) for line in file if line.lstrip().startswith(keyword))
        return list(dict.fromkeys(words[1].strip() for words in lines if len(words) == 2 and words[0] == keyword))


def _check_shape(path: Path, part: Any) -> None:
    """trimesh hands on what a damaged file says, vertices of two numbers for instance."""
    for name, array in (("vertices", part.vertices), ("faces", part.faces)):
        if np.ndim(array) != 2 or np.shape(array)[1] != 3:
            raise SceneError(
                f"{path}: {name} of shape {np.shape(array)}; wanted three numbers each; export the file again"
            )


def _check_finite(path: Path, part: Any) -> None:
    bad = ~np.isfinite(part.vertices).all(axis=1)
    if bad.any():
        raise SceneError(
            f"{path}: position {int(np.argmax(bad))} is not a finite number; export the file again without it"
        )
    if int(part.faces.max()) >= len(part.vertices) or int(part.faces.min()) < 0:
        raise SceneError(
            f"{path}: a triangle uses vertex {int(part.faces.max())} of {len(part.vertices)}; the file is damaged"
        )


def _mesh(part: Any, name: str, origin: NDArray, textures: list[Texture], notes: list[str]) -> Mesh:
    vertices, faces = np.asarray(part.vertices, np.float64), np.asarray(part.faces)
    normals = _normals(vertices, faces)
    colour, uv, texture = _surface(part, len(vertices), textures, notes, name)
    double_sided = bool(getattr(getattr(part.visual, "material", None), "doubleSided", False)) or not _is_closed(part)
    lit = _light_on(normals, double_sided)
    material = _see_through(getattr(part.visual, "material", None))
    return Mesh(
        name,
        vertices - origin,
        normals,
        uv,
        colour * lit[:, None],
        faces,
        texture,
        double_sided,
        material,
        albedo=colour,
    )


def _see_through(material: Any) -> Material:
    """What an OBJ's `d` (dissolve) says; nothing for other files' materials."""
    said = (getattr(material, "kwargs", None) or {}).get("d")
    said = said[0] if isinstance(said, list) and said else said
    try:
        share = float(said)
    except (TypeError, ValueError):
        return Material()
    return Material(see_through=True, opacity=share) if 0 <= share < 1 else Material()


def _light_on(normals: NDArray, double_sided: bool) -> NDArray:
    """A plain light on (n, 3) unit normals; on a single sheet from both sides."""
    if double_sided:
        return 0.45 + 0.25 * normals[:, 1] + 0.5 * np.abs(normals @ _KEY_LIGHT)
    return 0.42 + 0.18 * normals[:, 1] + 0.55 * np.maximum(normals @ _KEY_LIGHT, 0)


def _is_closed(part: Any) -> bool:
    """Closed surfaces may be culled from behind; anything else may be a single sheet, seen from both sides."""
    return bool(part.is_watertight and part.is_winding_consistent and part.volume > 0)


def _normals(vertices: NDArray, faces: NDArray) -> NDArray:
    """Area-weighted vertex normals, unit; +y where a vertex has no triangle of any area."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(total, faces[:, corner], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0, total / np.where(length > 0, length, 1), (0.0, 1.0, 0.0))


def _surface(
    part: Any, count: int, textures: list[Texture], notes: list[str], name: str
) -> tuple[NDArray, NDArray, int]:
    """Linear colour (n, 3), uv (n, 2) and texture index of a part: its picture, else its vertex colours, else its material, else grey."""
    visual, uv = part.visual, np.zeros((count, 2))
    material = getattr(visual, "material", None)
    picture = _picture_of(material)
    found_uv = getattr(visual, "uv", None)
    if found_uv is not None and np.shape(found_uv) == (count, 2):
        uv = np.asarray(found_uv, np.float64)
        if not np.isfinite(uv).all():
            notes.append(f"{name}: texture coordinates that are not finite numbers were set to 0")
            uv = np.where(np.isfinite(uv), uv, 0)
    base = _base_colour(material)
    if picture is not None and found_uv is not None:
        textures.append(Texture(name, picture))
        chosen = base is not None and tuple(getattr(material, "diffuse", ())[:3]) != _UNCHOSEN
        return np.tile(base if chosen else (1.0, 1.0, 1.0), (count, 1)), uv, len(textures) - 1
    colours = getattr(visual, "vertex_colors", None) if visual.kind in ("vertex", "face") else None
    if colours is None:
        colours = (getattr(visual, "vertex_attributes", None) or {}).get("color")
    if colours is not None and np.shape(colours)[0] == count:
        return linear_from_srgb(np.asarray(colours)[:, :3] / 255.0), uv, -1
    return np.tile(base if base is not None else (GREY, GREY, GREY), (count, 1)), uv, -1


def _picture_of(material: Any) -> NDArray[np.uint8] | None:
    """The base colour picture of a PBR or simple material as (h, w, 3) bytes."""
    picture = getattr(material, "baseColorTexture", None)
    if picture is None:
        picture = getattr(material, "image", None)
    if picture is None:
        return None
    try:
        return np.asarray(picture.convert("RGB"), dtype=np.uint8)
    except (OSError, ValueError, SyntaxError):  # Pillow decodes late: a cut-off picture shows only here
        return None


def _base_colour(material: Any) -> NDArray[np.float64] | None:
    """Linear base colour: glTF factors are linear already (trimesh keeps them as bytes), an OBJ's Kd is sRGB by custom."""
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:
        factor = np.asarray(factor)
        return (factor[:3] / 255.0 if factor.dtype.kind in "ui" else factor[:3]).astype(np.float64)
    diffuse = getattr(material, "diffuse", None)
    return None if diffuse is None else linear_from_srgb(np.asarray(diffuse, np.float64)[:3] / 255.0)
