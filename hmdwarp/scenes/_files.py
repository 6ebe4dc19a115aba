"""A user's GLB, OBJ or PLY as a scene: transforms applied, colours kept, a plain light baked in."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..errors import SceneError
from ..geometry import Pose
from ._content import Body, Material
from ._gltf_file import GltfFile
from ._gltf_scene import RichFile
from ._mesh import Mesh, Texture
from ._scene import Background, Scene

if TYPE_CHECKING:
    import trimesh

Array = NDArray[np.float64]
SKY = Background((0.30, 0.42, 0.62), (0.72, 0.77, 0.82), (0.32, 0.31, 0.30))
GREY = 0.5
# Diffuse colour that trimesh assumes where a file names none; its own exporter writes it as Kd 0.4.
_TRIMESH_DEFAULT = (102, 102, 102)
_KEY_LIGHT = np.array([0.35, 0.80, 0.48]) / np.linalg.norm([0.35, 0.80, 0.48])
_STANDING_M = 1.6


def scene_from_file(path: Path) -> Scene:
    """Return the file's triangles as a Scene; its notes say what had to be left out or replaced.

    Units are metres and +y is up, as in glTF. viewpoint_of chooses where the viewer stands. The
    origin is kept apart in float64 (origin_m), so that far from it no digits are lost on the GPU.
    Errors: SceneError, one line, for a file that is missing, empty, corrupt, without triangles, or
    with positions that are not finite.
    """
    if _is_rich(path):
        return _rich_scene(path)
    notes: list[str] = []
    parts = [part for part in _parts_of(path, notes) if len(part.faces)]
    _check_any(path, parts)
    for part in parts:
        _check_shape(path, part)
        _check_finite(path, part)
    textures: list[Texture] = []

    def meshes_in(origin: Array) -> list[Mesh]:
        return [_mesh(part, f"{path.stem}-{i}", origin, textures, notes) for i, part in enumerate(parts)]

    return _assembled(path, [part.vertices for part in parts], meshes_in, textures, notes)


def _rich_scene(path: Path) -> Scene:
    """Return a GLB with animations, skins, mirrors or see-through surfaces as a Scene."""
    import trimesh

    def is_closed(positions: NDArray, triangles: NDArray) -> bool:
        return _is_closed(trimesh.Trimesh(positions, triangles, process=False))

    try:
        with np.errstate(all="ignore"):
            file = RichFile(path, _normals, is_closed)
            _check_any(path, file.drafts)
            standing = [draft.positions for draft in file.drafts if not draft.look.material.head_locked]

            def meshes_in(origin: Array) -> list[Mesh]:
                return [draft.mesh(origin, _light_on) for draft in file.drafts]

            return _assembled(
                path, standing or [np.zeros((1, 3))], meshes_in, file.textures, file.notes, bodies=file.bodies
            )
    except (SceneError, MemoryError):
        raise
    except Exception as error:  # a damaged file may hold any value where another is due
        raise _unreadable(path, error) from error


def _assembled(
    path: Path,
    clouds: Sequence[Array],
    meshes_in: Callable[[Array], list[Mesh]],
    textures: list[Texture],
    notes: list[str],
    bodies: Sequence[Body] = (),
) -> Scene:
    """Return the scene around these (n, 3) points; meshes_in makes its meshes for an origin."""
    low = np.array([points.min(axis=0) for points in clouds]).min(axis=0)
    high = np.array([points.max(axis=0) for points in clouds]).max(axis=0)
    origin = np.round((low + high) / 2)  # whole metres, so that a scene near the origin keeps its own numbers
    meshes = meshes_in(origin)
    viewpoint, bounds = viewpoint_of(low, high)
    return Scene(
        path.stem,
        f"{path.name}: {sum(len(mesh.triangles) for mesh in meshes)} triangles",
        meshes,
        textures,
        SKY,
        bodies,
        origin_m=origin,
        viewpoint=viewpoint,
        walk_bounds_m=bounds,
        notes=dict.fromkeys(notes),
    )


def _check_any(path: Path, found: Sequence[object]) -> None:
    if not found:
        raise SceneError(
            f"{path}: no triangles in it; expected a mesh (a point cloud or an empty scene cannot be drawn)"
        )


def _unreadable(path: Path, error: Exception) -> SceneError:
    reason = " ".join(str(error).split())[:120] or type(error).__name__
    kind = path.suffix.removeprefix(".").upper()
    return SceneError(f"{path}: not a readable {kind} file ({type(error).__name__}: {reason}); export it again")


def _is_rich(path: Path) -> bool:
    try:
        return path.suffix.lower() == ".glb" and path.is_file() and GltfFile.read(path).is_rich()
    except (SceneError, OSError, AttributeError, TypeError):
        return False  # trimesh's reader reports what is wrong with it


def viewpoint_of(low: Array, high: Array) -> tuple[Pose, Array]:
    """Return a viewer's pose in a box (3,) low to high, and the (2, 3) box to walk in.

    The viewer looks along -z. In a box of a room's size (3 m or more across both ways and 2 m high)
    the viewer stands in its middle, 1.6 m above the floor. Anything else is an object, seen from
    the +z side at the height of its middle, at a distance where it fills about 50 degrees.
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
    """Return every mesh of the file in world coordinates."""
    import trimesh

    if not path.is_file():
        raise SceneError(f"{path}: no such scene file; expected a .glb, .obj or .ply file, or the name of a scene")
    if path.stat().st_size == 0:
        raise SceneError(f"{path}: the file is empty; expected a .glb, .obj or .ply file")
    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("glb", "obj", "ply"):
        raise SceneError(f"{path}: cannot read '{path.suffix}' scenes; expected .glb, .obj or .ply")
    quiet, before = logging.getLogger("trimesh"), logging.getLogger("trimesh").level
    quiet.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            loaded = trimesh.load(path, file_type=kind, process=False, maintain_order=True)
            found = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    except MemoryError:
        raise
    except Exception as error:  # trimesh's parsers let any exception through
        raise _unreadable(path, error) from error
    finally:
        quiet.setLevel(before)
    notes += {"obj": _missing_pictures, "ply": _missing_ply_pictures}.get(kind, lambda _: [])(path)
    return [part for part in found if isinstance(part, trimesh.Trimesh)]


def _missing_pictures(path: Path) -> list[str]:
    """Return a note for each material library or picture that an OBJ names and that is missing."""
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
    """Return the same for pictures named in a PLY's header, as MeshLab and others write them."""
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
    # trimesh passes on what a damaged file says, vertices of two numbers for instance.
    for name, array in (("vertices", part.vertices), ("faces", part.faces)):
        if np.ndim(array) != 2 or np.shape(array)[1] != 3:
            raise SceneError(
                f"{path}: {name} of shape {np.shape(array)}; expected three numbers each; export the file again"
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


def _mesh(part: Any, name: str, origin: Array, textures: list[Texture], notes: list[str]) -> Mesh:
    vertices, faces = np.asarray(part.vertices, np.float64), np.asarray(part.faces)
    normals = _normals(vertices, faces)
    colour, uv, texture = _surface(part, len(vertices), textures, notes, name)
    gltf_material = getattr(part.visual, "material", None)
    double_sided = bool(getattr(gltf_material, "doubleSided", False)) or not _is_closed(part)
    lit = _light_on(normals, double_sided)
    return Mesh(
        name,
        vertices - origin,
        normals,
        uv,
        colour * lit[:, None],
        faces,
        texture,
        double_sided,
        _dissolve(gltf_material),
        albedo=colour,
    )


def _dissolve(material: Any) -> Material:
    """Return a see-through material where an OBJ's `d` (dissolve) is below 1, else a plain one."""
    value = (getattr(material, "kwargs", None) or {}).get("d")
    try:
        share = float(value[0] if isinstance(value, list) and value else value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return Material()
    return Material(see_through=True, opacity=share) if 0 <= share < 1 else Material()


def _light_on(normals: Array, double_sided: bool) -> Array:
    """Return (n,) a plain light on unit normals; a single sheet is lit from both sides."""
    if double_sided:
        return 0.45 + 0.25 * normals[:, 1] + 0.5 * np.abs(normals @ _KEY_LIGHT)
    return 0.42 + 0.18 * normals[:, 1] + 0.55 * np.maximum(normals @ _KEY_LIGHT, 0)


def _is_closed(part: Any) -> bool:
    """Return whether it may be culled from behind; an open surface may be seen from both sides."""
    return bool(part.is_watertight and part.is_winding_consistent and part.volume > 0)


def _normals(vertices: Array, faces: NDArray) -> Array:
    """Return area-weighted unit vertex normals; +y where a vertex has no triangle of any area."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(total, faces[:, corner], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0, total / np.where(length > 0, length, 1), (0.0, 1.0, 0.0))


def _surface(part: Any, count: int, textures: list[Texture], notes: list[str], name: str) -> tuple[Array, Array, int]:
    """Return linear colour (n, 3), uv (n, 2) and texture index of a part.

    Its picture comes first, else its vertex colours, else its material's colour, else grey.
    """
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
        chosen = base if tuple(getattr(material, "diffuse", ())[:3]) != _TRIMESH_DEFAULT else None
        return np.tile(np.ones(3) if chosen is None else chosen, (count, 1)), uv, len(textures) - 1
    colours = getattr(visual, "vertex_colors", None) if visual.kind in ("vertex", "face") else None
    if colours is None:
        colours = (getattr(visual, "vertex_attributes", None) or {}).get("color")
    if colours is not None and np.shape(colours)[0] == count:
        return np.asarray(linear_from_srgb(np.asarray(colours)[:, :3] / 255.0), np.float64), uv, -1
    return np.tile(np.full(3, GREY) if base is None else base, (count, 1)), uv, -1


def _picture_of(material: Any) -> NDArray[np.uint8] | None:
    """Return the base colour picture of a PBR or simple material as (h, w, 3) bytes."""
    picture = getattr(material, "baseColorTexture", None)
    if picture is None:
        picture = getattr(material, "image", None)
    if picture is None:
        return None
    try:
        return np.asarray(picture.convert("RGB"), dtype=np.uint8)
    except (OSError, ValueError, SyntaxError):  # Pillow decodes late: a cut-off picture shows only here
        return None


def _base_colour(material: Any) -> Array | None:
    """Return the linear base colour.

    trimesh keeps glTF's linear factors as bytes; an OBJ's Kd is sRGB.
    """
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:
        factor = np.asarray(factor)
        return (factor[:3] / 255.0 if factor.dtype.kind in "ui" else factor[:3]).astype(np.float64)
    diffuse = getattr(material, "diffuse", None)
    return (
        None
        if diffuse is None
        else np.asarray(linear_from_srgb(np.asarray(diffuse, np.float64)[:3] / 255.0), np.float64)
    )
