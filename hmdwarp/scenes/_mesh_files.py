"""OBJ and PLY files as parts of a scene; trimesh reads PLY, and materials of OBJ."""

from __future__ import annotations

import io
import logging
import struct
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ..base import InputError, SceneError, import_extra, linear_from_srgb
from ..base.named_files import BESIDE, SCENE, content_of, keep_inside, opened, text_in
from ._draft import MOST_TRIANGLES, Draft, Look, Notes, normals_of, read_beside, rgba_of
from ._mesh import Material, Texture

Array = NDArray[np.float64]
GREY = 0.5
_LONGEST_LINE = 10_000  # of a PLY's header
# Diffuse colour that trimesh assumes where a file names none; its own exporter writes it as Kd 0.4.
_TRIMESH_DEFAULT = (102, 102, 102)


def drafts_of(path: Path, units: Array, notes: Notes, textures: list[Texture]) -> list[Draft]:
    """Return the parts with triangles; pictures go to `textures`. units: 4x4 to metres, +y up."""
    return [_draft(part, f"{path.stem}-{i}", units, textures, notes) for i, part in enumerate(_mesh_parts(path, notes))]


def _mesh_parts(path: Path, notes: Notes) -> list[Any]:
    """Return every mesh of the file with triangles (trimesh.Trimesh), checked."""
    parts = [part for part in _parts_of(path, notes) if len(part.faces)]
    for part in parts:
        # trimesh passes on what a damaged file says, vertices of two numbers for instance.
        for name, array in (("vertices", part.vertices), ("faces", part.faces)):
            if np.ndim(array) != 2 or np.shape(array)[1] != 3:
                what = f"{path}: {name} of shape {np.shape(array)}"
                raise SceneError(f"{what}; expected three numbers each; export the file again")
        bad, most = ~np.isfinite(part.vertices).all(axis=1), int(part.faces.max())
        if bad.any():
            at = int(np.argmax(bad))
            raise SceneError(f"{path}: position {at} is not a finite number; export the file again without it")
        if most >= len(part.vertices) or int(part.faces.min()) < 0:
            raise SceneError(f"{path}: a triangle uses vertex {most} of {len(part.vertices)}; the file is damaged")
    return parts


@contextmanager
def _warnings_to(say: Callable[[str], None]) -> Iterator[None]:
    """Pass on what trimesh warns of in the block, by either way, instead of printing it."""
    logger, handler = logging.getLogger("trimesh"), logging.Handler(logging.WARNING)
    handler.emit = lambda record: say(record.getMessage())  # type: ignore[method-assign]
    (propagates, level), logger.propagate = (logger.propagate, logger.level), False
    logger.setLevel(logging.WARNING)
    logger.addHandler(handler)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        for warning in caught:
            if not issubclass(warning.category, RuntimeWarning):  # of numbers such as 0 / 0
                say(str(warning.message))
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = propagates


def _parts_of(path: Path, notes: Notes) -> list[Any]:
    trimesh = import_extra("trimesh", "trimesh", "scenes")
    kind, warned = path.suffix.lower().removeprefix("."), list[str]()
    beside = _Beside(path.parent)
    try:
        with _warnings_to(warned.append), np.errstate(all="ignore"), opened(path, SCENE) as file:
            if kind == "obj":
                found = _parts_of_obj(path, file.read().decode("utf-8", "replace"), beside, notes)
            else:
                loaded = trimesh.load(file, file_type=kind, resolver=beside, process=False, maintain_order=True)
                found = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
    except (MemoryError, SceneError):
        raise
    except Exception as error:  # trimesh's parsers let any exception through
        raise (beside.refused or [unreadable(path, error)])[0] from error
    if beside.refused:
        raise beside.refused[0]
    if kind == "ply":
        for name in _pictures_of_ply(path):
            with suppress(OSError):
                beside.get(name)
        for part in found:
            _cut_polygons_of_ply(part, notes)
    for name, how in beside.missing.items():
        what = "material file" if name.lower().endswith(".mtl") else "texture"
        notes.add(f"a file that it names {how}, drawn grey", f"{what} '{name}'")
    for line in warned:
        if not beside.missing or "image" not in line:
            notes.add("trimesh, which reads it, says", " ".join(line.split())[:160])
    meshes = [part for part in found if isinstance(part, trimesh.Trimesh)]
    if len(meshes) < len(found):
        notes.add("points and lines are left out")
    return meshes


_ROWS = {"v": 3, "vt": 2, "vn": 3}  # of an OBJ file, each with its numbers
_Faces = dict[str, dict[tuple[int, int], list[str]]]  # lines by material, number of corners and their form


def _read_obj(path: Path, text: str, beside: Any, notes: Notes) -> tuple[dict[str, list[str]], _Faces, Any]:
    """Return rows of numbers, faces, and facts of materials. Errors: SceneError naming the line."""
    from trimesh.exchange.obj import parse_mtl

    rows: dict[str, list[str]] = {key: [] for key in _ROWS}
    faces: _Faces = {}
    materials: dict[str, Any] = {}
    name, lines = "", text.replace("\\\r\n", " ").replace("\\\n", " ").splitlines()
    for number, line in enumerate(lines, 1):
        key, *words = line.partition("#")[0].split() or [""]
        try:
            if key in rows:
                rows[key].append(" ".join(words[:6]))
            elif key == "f":
                if "-" in line:  # counted back from the last of those before it
                    counts = [len(own) + 1 for own in rows.values()]
                    pairs = [list(zip(word.split("/"), counts, strict=False)) for word in words]
                    words = ["/".join(str(n + int(at)) if at[:1] == "-" else at for at, n in one) for one in pairs]
                form = words[0].count("/") + ("//" in words[0])
                faces.setdefault(name, {}).setdefault((len(words), form), []).append(" ".join(words))
            elif key == "usemtl":
                name = " ".join(words)
            elif key == "mtllib":
                for file in [" ".join(words)] if line.lower().count(".mtl") < 2 else words:
                    with suppress(OSError):
                        materials |= parse_mtl(beside.get(file), resolver=beside)  # type: ignore[no-untyped-call]
            elif key in ("l", "p", "curv", "surf"):
                notes.add("points, lines and curved surfaces are left out")
        except (ValueError, IndexError):
            what = f"{path}, line {number}: '{line.strip()[:60]}'"
            raise SceneError(f"{what}; expected numbers; export it again") from None
    return rows, faces, materials


def _parts_of_obj(path: Path, text: str, beside: Any, notes: Notes) -> list[Any]:
    from trimesh import Trimesh
    from trimesh.visual import ColorVisuals, TextureVisuals
    from trimesh.visual.material import SimpleMaterial

    rows, faces, materials = _read_obj(path, text, beside, notes)
    known = []  # (n, 6) numbers of each, 0 where a row has fewer
    for key, least in _ROWS.items():
        counts = np.array([row.count(" ") + 1 for row in rows[key]], int)
        found = np.fromstring(" ".join(rows[key]), sep=" ")
        if len(found) != counts.sum() or (counts < least - (key == "vt")).any():
            raise SceneError(f"{path}: a line of {key} is not {least} numbers; export the file again")
        at = np.cumsum(counts)[:, None] - counts[:, None] + np.arange(6)
        known.append(np.where(np.arange(6) < counts[:, None], np.append(found, np.zeros(6))[at], 0))
    coloured = all(row.count(" ") == 5 for row in rows["v"])
    parts = []
    for name, groups in faces.items():
        corners = [_corners(path, *form, lines, known) for form, lines in groups.items() if form[0] > 2]
        if not corners:
            continue
        triangles, material = np.concatenate(corners), materials.get(name)
        if name and material is None and not beside.missing:
            notes.add("a material that its files lack, drawn grey", f"'{name}'")
        if "image" in (material or {}) and not all(form in (1, 2) for _, form in groups):
            notes.add("faces without texture coordinates do not have the picture of their material", f"'{name}'")
        _, key = np.unique(triangles[..., 1] * (len(known[2]) + 1) + triangles[..., 2], return_inverse=True)
        key = triangles[..., 0].ravel() * triangles.size + key.ravel()
        _, first, at = np.unique(key, return_index=True, return_inverse=True)
        used = triangles.reshape(-1, 3)[first]
        part = Trimesh(known[0][used[:, 0], :3], at.reshape(-1, 3), process=False)
        if material is not None or (used[:, 1] >= 0).any():
            uv = np.vstack([known[1], np.zeros(6)])[used[:, 1], :2] if (used[:, 1] >= 0).any() else None
            kind = SimpleMaterial(**material) if material else None  # type: ignore[no-untyped-call]
            part.visual = TextureVisuals(uv=uv, material=kind)  # type: ignore[no-untyped-call]
        if coloured and "image" not in (material or {}):
            part.visual = ColorVisuals(vertex_colors=known[0][used[:, 0], 3:])
        parts.append(part)
    return parts


def _corners(path: Path, count: int, form: int, lines: list[str], known: list[Array]) -> NDArray[np.int64]:
    """Return (t, 3, 3) positions, texture coordinates and normals, from 0, -1 for none."""
    columns = ((0,), (0, 1), (0, 1, 2), (0, 2))[min(form, 3)]
    numbers = np.fromstring(" ".join(lines).replace("/", " "), np.int64, sep=" ")
    if len(numbers) != len(lines) * count * len(columns):
        raise SceneError(f"{path}: corners of one face differ, as in 'f {lines[0][:60]}'; export the file again")
    found = np.full((len(lines), count, 3), -1)
    found[..., columns] = numbers.reshape(len(lines), count, -1) - 1
    for column, kind in zip(columns, _ROWS, strict=False):
        own = found[..., column]
        if own.min() < 0 or own.max() >= len(known[column]):
            wrong = own.min() + 1 if own.min() < 0 else own.max() + 1
            raise SceneError(f"{path}: a face names {kind} {wrong} of {len(known[column])}; the file is damaged")
    return _triangulated(found, known[0][found[..., 0], :3])


_MOST_CORNERS = 2000  # of a polygon that is not convex: cutting it takes their square


def _triangulated(corners: NDArray[Any], polygons: Array) -> NDArray[Any]:
    """Return triangles (t, 3, ..) of the corners (m, n, ..) of polygons at (m, n, 3).

    Convex ones are cut as fans, others by their ears. Errors: SceneError for one too large.
    """
    count = corners.shape[1]
    if count == 3:
        return corners
    ways = polygons - np.roll(polygons, 1, axis=1)
    turns = np.cross(ways, np.roll(ways, -1, axis=1))
    apart = polygons - polygons[:, :1]
    normal = np.cross(apart, np.roll(apart, -1, axis=1)).sum(axis=1)
    hollow = (np.einsum("mni,mi->mn", turns, normal) < -1e-9 * (normal**2).sum(axis=1)[:, None]).any(axis=1)
    plain = corners[~hollow]
    cut = [plain[:, [0, at, at + 1]] for at in range(1, count - 1)]
    for at in np.flatnonzero(hollow):
        if count > _MOST_CORNERS:
            raise SceneError(f"a polygon of {count} corners is not convex; expected {_MOST_CORNERS} or fewer")
        axis = int(np.abs(normal[at]).argmax())  # seen along it, it turns to the left
        flat = polygons[at][:, [(axis + 1) % 3, (axis + 2) % 3]] * (1, np.sign(normal[at, axis]))
        cut.append(corners[at][_ears(flat)])
    return np.concatenate(cut)


def _ears(points: Array) -> NDArray[np.int64]:
    """Return (n - 2, 3) triangles of a polygon that turns to the left. Source: Meisters 1975."""

    def doubled(a: Array, b: Array, c: Array) -> Any:
        return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])

    left, found = list(range(len(points))), []
    while len(left) > 3:
        rest, area = points[left], np.empty(len(left))
        for at in range(len(left)):
            a, b, c = rest[at - 1], rest[at], rest[(at + 1) % len(left)]
            area[at] = doubled(a, b, c)
            inside = np.minimum(np.minimum(doubled(a, b, rest), doubled(b, c, rest)), doubled(c, a, rest)) >= 0
            inside &= ~((rest == a) | (rest == b) | (rest == c)).all(axis=1)
            if area[at] > 0 and not inside.any():
                break
        else:  # it crosses itself, or has no area
            at = int(np.abs(area).argmin())
        found.append((left[at - 1], left[at], left[(at + 1) % len(left)]))
        del left[at]
    return np.array([*found, left])


def _cut_polygons_of_ply(part: Any, notes: Notes) -> None:
    """Cut polygons that are not convex by their ears: trimesh has cut them as fans."""
    raw = getattr(part, "metadata", {}).get("_ply_raw", {})
    data: Any = raw.get("face", {}).get("data")
    names: Any = data.keys() if isinstance(data, dict) else getattr(data, "dtype", np.dtype(int)).names
    name = next((one for one in names or () if one.startswith("vertex_ind")), None)
    if name is None or not len(part.faces):
        return
    polygons = data[name] if isinstance(data, dict) else data[name]["f1"]
    sizes = np.array([len(one) for one in polygons])
    if (sizes == 3).all():
        return
    vertices, cut = np.column_stack([raw["vertex"]["data"][axis] for axis in "xyz"]).astype(float), []
    for size in np.unique(sizes[sizes > 2]):
        same = np.stack([polygons[at] for at in np.flatnonzero(sizes == size)]).astype(np.int64)
        cut.append(_triangulated(same, vertices[same]))
    if len(part.vertices) == len(vertices) and part.visual.kind != "face":
        part.faces = np.concatenate(cut)
    else:
        notes.add("polygons with pictures or colours of their own are cut as fans: notches may be filled")


def unreadable(path: Path, error: Exception) -> SceneError:
    reason = " ".join(str(error).split())[:120] or type(error).__name__
    kind = path.suffix.removeprefix(".").upper()
    return SceneError(f"{path}: not a readable {kind} file ({reason}); export it again")


class _Beside:
    """Gives trimesh the files that one in `folder` names, and notes what it lacks."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.missing = dict[str, str]()  # names with what is wrong
        self.refused = list[InputError]()  # trimesh goes on after any error

    def get(self, key: str) -> bytes:
        from PIL import Image

        try:
            data = read_beside(self.folder, key)
        except InputError as error:
            self.refused.append(error)
            raise
        except OSError:
            self.missing[key] = "is missing"
            raise
        try:
            if not key.lower().endswith(".mtl"):
                Image.open(io.BytesIO(data)).close()
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
            self.missing[key] = "cannot be read"
        return data


def _pictures_of_ply(path: Path) -> Iterator[str]:
    """Yield the pictures named in a PLY's header, as MeshLab and others write them."""
    with opened(path, SCENE) as file:
        while (line := file.readline(_LONGEST_LINE)) and line.split(maxsplit=1)[:1] != [b"end_header"]:
            words = line.decode("utf-8", "replace").split(maxsplit=2)
            if words[:2] == ["comment", "TextureFile"] and len(words) == 3:
                yield words[2].strip()


def _draft(part: Any, name: str, units: Array, textures: list[Texture], notes: Notes) -> Draft:
    """Return a part in its picture, else its vertex colours, its material's colour, or grey."""
    vertices = np.asarray(part.vertices, np.float64) @ units[:3, :3].T + units[:3, 3]
    faces, visual, uv = np.asarray(part.faces).astype(np.uint32), part.visual, np.zeros((len(vertices), 2))
    material, found_uv = getattr(visual, "material", None), getattr(visual, "uv", None)
    if found_uv is not None and np.shape(found_uv) == uv.shape:
        uv = np.asarray(found_uv, np.float64)
        if not np.isfinite(uv).all():
            notes.add("texture coordinates that are not finite numbers were set to 0", name)
            uv = np.where(np.isfinite(uv), uv, 0)
    # An OBJ's Kd is sRGB.
    diffuse, colour, texture = getattr(material, "diffuse", None), np.full(3, GREY), -1
    if diffuse is not None:
        colour = linear_from_srgb(np.asarray(diffuse, np.float64)[:3] / 255.0)
    colours = getattr(visual, "vertex_colors", None) if visual.kind in ("vertex", "face") else None
    if colours is None:
        colours = (getattr(visual, "vertex_attributes", None) or {}).get("color")
    image, picture = getattr(material, "image", None), None
    with suppress(OSError, ValueError, SyntaxError):  # Pillow decodes late: a cut-off picture shows only here
        picture = None if image is None else rgba_of(image)[..., :3]
    if picture is not None and found_uv is not None:
        textures.append(Texture(name, picture))
        texture = len(textures) - 1
        if diffuse is None or tuple(np.asarray(diffuse)[:3]) == _TRIMESH_DEFAULT:
            colour = np.ones(3)
    elif colours is not None and len(colours) == len(vertices):
        colour = linear_from_srgb(np.asarray(colours)[:, :3] / 255.0)
    try:  # an OBJ's `d` (dissolve), if it has one
        share = float(next(iter((getattr(material, "kwargs", None) or {}).get("d", ()))))
    except (ValueError, StopIteration):
        share = 1.0
    see_through = Material(see_through=True, opacity=share) if 0 <= share < 1 else Material()
    # What is closed may be culled from behind; an open surface may be seen from both sides.
    closed = bool(part.is_watertight and part.is_winding_consistent and part.volume > 0)
    look = Look(np.ones(3), texture, see_through, not closed)
    colour = np.broadcast_to(np.asarray(colour, np.float64), vertices.shape)
    return Draft(name, vertices, look, faces, normals_of(vertices, faces), uv, colour)


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
        for part in _mesh_parts(keep_inside(path.parent / name, path.parent), notes):
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
    """Return a mesh of Mitsuba's own file of meshes. Errors: those of its unpacking.

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
    def __init__(self, folder: Path, named: dict[str, Any], textures: list[Texture], notes: Notes) -> None:
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
