"""What a foreign file becomes: meshes without a place yet, and notes on what is left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import SceneError
from ..base.named_files import BESIDE, content_of
from ..geometry import Pose
from ._mesh import Body, Material, Mesh, Texture
from ._scene import Panel


class Notes:
    """Gathers what was left out or replaced; the same thing twice is one line with a count."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._examples: dict[str, list[str]] = {}

    def add(self, what: str, example: str = "") -> None:
        """Note a fact. example: where it was met, which one line of many names."""
        found = self._examples.setdefault(what, [])
        if example not in found:
            found.append(example)

    def lines(self) -> list[str]:
        """Return one line for each fact, in the order in which they were first met."""
        lines = []
        for what, (first, *more) in self._examples.items():
            several = f"{len(more) + 1} of them, such as " if more else ""
            lines.append(f"{self._path.name}: {what}" + (f": {several}{first}" if first else ""))
        return lines


_NETWORK = ("http:", "https:", "ftp:")


def rgba_of(image: Any) -> NDArray[np.uint8]:
    """Return (h, w, 4) bytes of a PIL image; 16 bits of grey are scaled, not clipped."""
    from PIL import Image

    if image.mode.startswith("I"):
        image = Image.fromarray(np.rint(np.clip(np.asarray(image), 0, 65535) / 257).astype(np.uint8))
    return np.array(image.convert("RGBA"))


def read_beside(folder: Path, uri: str) -> bytes:
    """Return the bytes of the file that a URI names next to a scene file.

    Backslashes, another case than the disk, and queries are followed. Errors: OSError with the
    reason in plain words; InputError, as content_of.
    """
    if uri.lower().startswith(_NETWORK):
        raise OSError("it is on the network; download it, and name the copy")
    names = [uri, unquote(uri), unquote(uri.partition("?")[0].partition("#")[0])]
    names += [name.replace("\\", "/") for name in names]
    names = [name.removeprefix("file://") for name in dict.fromkeys(names) if "\0" not in name]
    whole = next((folder / name for name in names if _is_file(folder / name)), None)
    found = [whole] if whole is not None else _in_any_case(folder, names)
    if len(found) > 1:
        raise OSError(f"{len(found)} files have that name in upper and lower case; rename the others")
    if found:
        return content_of(found[0], BESIDE, folder)
    if any((folder / name).is_dir() for name in names):
        raise OSError("it is a folder; name a file")
    raise FileNotFoundError("there is no such file; put it beside the scene file")


def _is_file(path: Path) -> bool:  # or anything else but a folder, which content_of looks at
    return path.exists() and not path.is_dir()


def _in_any_case(folder: Path, names: list[str]) -> list[Path]:
    """Return the files under the first of the names that fits but for case."""
    for name in names:
        places = [Path("/") if name.startswith("/") else folder]
        for part in PurePosixPath(name).parts:
            places = [path for place in places for path in _called(place, part)]
        if found := list(filter(_is_file, places)):
            return found
    return []


def _called(place: Path, part: str) -> list[Path]:
    if part in ("..", "/"):
        return [place / part]
    try:
        return [path for path in place.iterdir() if path.name.casefold() == part.casefold()]
    except OSError:
        return []


_LOOSE = 1e-3  # share of its size by which a panel may be no rectangle
MOST_TRIANGLES = 50_000_000  # of instances together; 50 million take about 10 GB here

Array = NDArray[np.float64]
_KEY_LIGHT = np.array([0.35, 0.80, 0.48]) / np.linalg.norm([0.35, 0.80, 0.48])


@attrs.frozen(eq=False)
class Look:
    """Appearance of a part of a file."""

    colour: Array  # (3,) linear
    texture: int  # index of its texture, -1 for none
    material: Material
    double_sided: bool
    texcoords: str = ""  # name of the attribute with its texture coordinates
    # (3, 3), which takes the file's texture coordinates (u, v, 1) to those of the picture.
    uv_transform: Array = attrs.field(factory=lambda: np.eye(3))
    unlit: bool = False  # no light falls on it: it shines in its own colour
    emission: Array = attrs.field(factory=lambda: np.zeros(3))  # (3,) linear, where no picture has it
    has_alpha: bool = False  # whether alpha counts


@attrs.frozen(eq=False)
class Draft:
    """A mesh in the axes of the file's world, in metres with +y up."""

    name: str
    positions: Array  # (n, 3) at time 0 in the file's world; in head axes if head-locked
    look: Look
    triangles: NDArray[np.uint32]
    normals: Array  # (n, 3), in the same axes
    uv: Array  # (n, 2), origin bottom left
    colour: Array  # (n, 3) linear
    body: int = 0  # number of the body, 0 for none
    driven: Any = None  # a Driven of _gltf_nodes
    panel: bool = False  # it is sent as a panel, hidden by what is nearer if that is asked for
    occluded: bool = False

    @property
    def is_surface(self) -> bool:
        return not (self.panel or self.look.material.see_through or self.look.material.head_locked)

    def as_panel(self, world_from_file: Pose, textures: Sequence[Texture]) -> Panel:
        """Return it as a panel, seen from where its picture is not mirrored. Errors: SceneError."""
        from scipy.spatial.transform import Rotation

        name = f"panel '{self.name}'"
        if self.look.texture < 0:
            raise SceneError(f"{name} has no picture: expected a base colour texture")
        low, high = self.uv.min(axis=0), self.uv.max(axis=0)
        if np.abs([low, high - 1]).max() > _LOOSE:
            shown = f"{low.round(3).tolist()} to {high.round(3).tolist()}"
            raise SceneError(f"{name} shows {shown} of its picture: expected texture coordinates from 0 to 1")
        at = np.column_stack([self.uv - 0.5, np.ones(len(self.uv))])
        right, up, middle = found = np.linalg.lstsq(at, self.positions, rcond=None)[0]
        lengths = np.linalg.norm(found[:2], axis=1)
        a, b, c = (self.positions[self.triangles[:, i]] for i in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        off = np.abs(at @ found - self.positions).max() / max(lengths.max(), 1e-30)
        if max(off, abs(right @ up) / max(lengths.prod(), 1e-30), abs(area / lengths.prod() - 1)) > _LOOSE:
            raise SceneError(f"{name} is no rectangle with its whole picture on it: expected two triangles, unbent")
        axes = np.column_stack([right / lengths[0], up / lengths[1], np.cross(right, up) / lengths.prod()])
        locked, picture = self.look.material.head_locked, textures[self.look.texture]
        pose = Pose(middle, Rotation.from_matrix(axes).as_quat())
        pose = pose if locked else world_from_file @ pose
        return Panel(picture, pose, (lengths[0], lengths[1]), head_locked=locked, occluded=self.occluded)

    def mesh(self, world_from_file: Pose, origin: Array, bodies: Sequence[Body]) -> Mesh:
        """Return it in a scene with that origin, or in its body's frame. bodies: in the world."""
        look, locked = self.look, self.look.material.head_locked
        positions = self.positions if locked else world_from_file.transform(self.positions)
        normals = self.normals if locked else world_from_file.rotation.apply(self.normals)
        if self.body and not locked:
            inverse = bodies[self.body - 1].motion.state(0).pose.inverse()
            positions, normals = inverse.transform(positions), inverse.rotation.apply(normals)
        elif not locked:
            positions = positions - origin
        # No lamp of the world shines on what is fixed to the head. Else the light stays where it is
        # in the file, wherever the viewer stands.
        up, facing, lit = self.normals[:, 1], self.normals @ _KEY_LIGHT, np.ones(len(normals))
        if not (locked or look.unlit):  # a plain light; a single sheet is lit from both sides
            both, one = 0.45 + 0.25 * up + 0.5 * np.abs(facing), 0.42 + 0.18 * up + 0.55 * np.maximum(facing, 0)
            lit = both if look.double_sided else one
        light, driven = self.colour * lit[:, None] + look.emission, self.driven
        albedo = self.colour + look.emission if self.is_surface else self.colour
        how: dict[str, Any] = {"texture": look.texture, "double_sided": look.double_sided, "material": look.material}
        how |= {"body": self.body, "deformation": driven and attrs.evolve(driven, origin=origin), "albedo": albedo}
        return Mesh(self.name, positions, normals, self.uv, light, self.triangles, **how)


def normals_of(vertices: Array, faces: NDArray[Any]) -> Array:
    """Return area-weighted unit vertex normals; +y where a vertex has no triangle of any area."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    total = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(total, faces[:, corner], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0, total / np.where(length > 0, length, 1), (0.0, 1.0, 0.0))
