"""OBJ and PLY files, which trimesh reads, as parts of a scene."""

from __future__ import annotations

import io
import logging
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..errors import InputError, SceneError
from ..options.named_files import SCENE, opened
from ..resources import import_extra
from ._draft import Draft, Look, normals_of
from ._mesh import Material, Texture
from ._notes import Notes, read_beside, rgba_of

Array = NDArray[np.float64]
GREY = 0.5
_LONGEST_LINE = 10_000  # of a PLY's header
# Diffuse colour that trimesh assumes where a file names none; its own exporter writes it as Kd 0.4.
_TRIMESH_DEFAULT = (102, 102, 102)


def drafts_of(path: Path, units: Array, notes: Notes, textures: list[Texture]) -> list[Draft]:
    """Return the parts with triangles; pictures go to `textures`. units: 4x4 to metres, +y up."""
    return [_draft(part, f"{path.stem}-{i}", units, textures, notes) for i, part in enumerate(mesh_parts(path, notes))]


def mesh_parts(path: Path, notes: Notes) -> list[Any]:
    """Return every mesh of the file with triangles (trimesh.Trimesh), checked."""
    parts = [part for part in _parts_of(path, notes) if len(part.faces)]
    for part in parts:
        _check_shape(path, part)
        _check_finite(path, part)
    return parts


def _trimesh() -> Any:
    return import_extra("trimesh", "trimesh", "scenes")


def is_closed(positions: Array, triangles: NDArray[Any]) -> bool:
    """Return whether it may be culled from behind; an open surface may be seen from both sides."""
    part = _trimesh().Trimesh(positions, triangles, process=False)
    return bool(part.is_watertight and part.is_winding_consistent and part.volume > 0)


class _LogHandler(logging.Handler):
    """Notes what trimesh logs."""

    def __init__(self, say: Callable[[str], None]) -> None:
        super().__init__(logging.WARNING)
        self._say = say

    def emit(self, record: logging.LogRecord) -> None:
        self._say(record.getMessage())


@contextmanager
def _warnings_to(say: Callable[[str], None]) -> Iterator[None]:
    """Pass on what trimesh warns of in the block, by either way, instead of printing it."""
    logger, handler = logging.getLogger("trimesh"), _LogHandler(say)
    propagates, level = logger.propagate, logger.level
    logger.propagate = False
    logger.setLevel(logging.WARNING)
    logger.addHandler(handler)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        for warning in caught:
            if not issubclass(warning.category, RuntimeWarning):  # of numbers such as 0 / 0, see _check_finite
                say(str(warning.message))
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = propagates


def _parts_of(path: Path, notes: Notes) -> list[Any]:
    """Return every mesh of the file (trimesh.Trimesh)."""
    trimesh = _trimesh()
    kind, warned = path.suffix.lower().removeprefix("."), list[str]()
    beside = _beside(path.parent)
    try:
        with _warnings_to(warned.append), np.errstate(all="ignore"), opened(path, SCENE) as file:
            loaded = trimesh.load(file, file_type=kind, resolver=beside, process=False, maintain_order=True)
            found = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    except (MemoryError, SceneError):
        raise
    except Exception as error:  # trimesh's parsers let any exception through
        raise unreadable(path, error) from error
    if beside.refused:
        raise beside.refused[0]
    if kind == "ply":
        beside.look_for(_pictures_of_ply(path))
    missing = beside.missing
    for name, how in missing.items():
        what = "material file" if name.lower().endswith(".mtl") else "texture"
        notes.add(f"a file that it names {how}, drawn grey", f"{what} '{name}'")
    for line in warned:
        if not missing or "image" not in line:
            notes.add("trimesh, which reads it, says", " ".join(line.split())[:160])
    clouds = [part for part in found if not isinstance(part, trimesh.Trimesh)]
    if clouds:
        notes.add("points and lines are left out")
    return [part for part in found if isinstance(part, trimesh.Trimesh)]


def unreadable(path: Path, error: Exception) -> SceneError:
    """Return the error for a file on whose contents a reader fell over."""
    reason = " ".join(str(error).split())[:120] or type(error).__name__
    kind = path.suffix.removeprefix(".").upper()
    return SceneError(f"{path}: not a readable {kind} file ({reason}); export it again")


def _beside(folder: Path) -> Any:
    """Return what gives trimesh the files that one in `folder` names, and notes what it lacks."""
    from trimesh.resolvers import Resolver

    class Beside(Resolver):
        def __init__(self) -> None:
            self.file_name = "mesh"  # of what has no name of its own
            self.missing = dict[str, str]()  # names with what is wrong
            self.refused = list[InputError]()  # trimesh goes on after any error

        def get(self, key: str) -> bytes:
            try:
                data = read_beside(folder, key)
                if not key.lower().endswith(".mtl") and not _is_picture(data):
                    self.missing[key] = "cannot be read"
                return data
            except InputError as error:
                self.refused.append(error)
                raise
            except OSError:
                self.missing[key] = "is missing"
                raise

        def look_for(self, names: list[str]) -> None:
            for name in names:
                with suppress(OSError):
                    self.get(name)

        def keys(self) -> list[str]:
            return []

        def namespaced(self, namespace: str) -> Any:
            return self

        def write(self, name: str, data: Any) -> None:
            raise OSError("it is only read")

    return Beside()


def _is_picture(data: bytes) -> bool:
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data)):
            return True
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return False


def _pictures_of_ply(path: Path) -> list[str]:
    """Return the pictures named in a PLY's header, as MeshLab and others write them."""
    names = []
    with opened(path, SCENE) as file:
        while line := file.readline(_LONGEST_LINE):
            words = line.decode("utf-8", "replace").split(maxsplit=2)
            if words[:1] == ["end_header"]:
                break
            if words[:2] == ["comment", "TextureFile"] and len(words) == 3:
                names.append(words[2].strip())
    return names


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


def _draft(part: Any, name: str, units: Array, textures: list[Texture], notes: Notes) -> Draft:
    vertices = np.asarray(part.vertices, np.float64) @ units[:3, :3].T + units[:3, 3]
    faces = np.asarray(part.faces).astype(np.uint32)
    colour, uv, texture = _surface(part, len(vertices), textures, notes, name)
    material = getattr(part.visual, "material", None)
    double_sided = bool(getattr(material, "doubleSided", False)) or not is_closed(vertices, faces)
    look = Look(np.ones(3), texture, _dissolve(material), double_sided)
    return Draft(name, vertices, look, faces, normals_of(vertices, faces), uv, colour)


def _dissolve(material: Any) -> Material:
    """Return a see-through material where an OBJ's `d` (dissolve) is below 1, else a plain one."""
    value = (getattr(material, "kwargs", None) or {}).get("d")
    try:
        share = float(value[0] if isinstance(value, list) and value else value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return Material()
    return Material(see_through=True, opacity=share) if 0 <= share < 1 else Material()


def _surface(part: Any, count: int, textures: list[Texture], notes: Notes, name: str) -> tuple[Array, Array, int]:
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
            notes.add("texture coordinates that are not finite numbers were set to 0", name)
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
    """Return the picture of a material as (h, w, 3) bytes."""
    picture = getattr(material, "image", None)
    try:
        return None if picture is None else rgba_of(picture)[..., :3]
    except (OSError, ValueError, SyntaxError):  # Pillow decodes late: a cut-off picture shows only here
        return None


def _base_colour(material: Any) -> Array | None:
    """Return the linear base colour; an OBJ's Kd is sRGB."""
    diffuse = getattr(material, "diffuse", None)
    if diffuse is None:
        return None
    return np.asarray(linear_from_srgb(np.asarray(diffuse, np.float64)[:3] / 255.0), np.float64)
