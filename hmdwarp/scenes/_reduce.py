"""A scene with fewer triangles, for a client that draws for itself; made once, then found again in the user's cache folder."""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ._content import Deformation, Material
from ._decimate import decimated
from ._model import Mesh, Scene

VERSION = 2  # of what decimated() makes of the same meshes: counted up with every change of its results
UNKNOWN_ALBEDO = 0.5
LEAST_TRIANGLES = 2000  # a client draws so many in no time, and a fifth of ten would leave things out
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB

Triangles = list[NDArray[np.uint32]]


def reduced(scene: Scene, share: float, folder: Path | None = None) -> Scene:
    """What of the scene hides what is behind it, with about `share` of its triangles: matt, its light as baked.

    No scene is brought below LEAST_TRIANGLES. Mirrors stay as plain surfaces; what is see-through or fixed to the head is left out. Bodies
    and deformations move as before.
    folder: where results are kept, the user's cache folder if None. One that cannot be read or written costs the time to reduce again,
    about 3 s for 75,000 triangles, and is no error. Errors: SceneError for a share that is not above 0 and at most 1.
    """
    if not 0 < share <= 1:
        raise SceneError(f"share {share:g} of a scene's triangles: wanted more than 0 and at most 1")
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
    share = max(share, min(1.0, LEAST_TRIANGLES / max(1, sum(len(mesh.triangles) for mesh in surfaces))))
    triangles = (
        [mesh.triangles for mesh in surfaces] if share == 1 else _remembered(surfaces, share, folder or cache_folder())
    )
    meshes = [_with_triangles(mesh, kept) for mesh, kept in zip(surfaces, triangles, strict=True) if len(kept)]
    return attrs.evolve(scene, meshes=meshes)


def unlit(scene: Scene) -> Scene:
    """The same as if every surface were in light of 1: its texture times its material's colour.

    Where a mesh does not know its albedo, it is its baked colour at a luminance of 0.5: the hue is the material's and the light's together.
    """
    return attrs.evolve(scene, meshes=[attrs.evolve(mesh, light=_albedo(mesh)) for mesh in scene.meshes])


def _albedo(mesh: Mesh) -> NDArray:
    if mesh.albedo is not None:
        return mesh.albedo
    luminance = (mesh.light @ _LUMINANCE)[:, None]
    return np.where(luminance > 0, UNKNOWN_ALBEDO * mesh.light / np.where(luminance > 0, luminance, 1), UNKNOWN_ALBEDO)


def cache_folder() -> Path:
    """Where this user's programs keep what they can make again."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = "~/Library/Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(os.path.expanduser(base)) / "hmdwarp" / "models"  # noqa: PTH111 (a user without a home folder is no error here)


def _remembered(meshes: Sequence[Mesh], share: float, folder: Path) -> Triangles:
    """decimated(), read from the cache if it is there and fits the meshes."""
    path = folder / f"{_key(meshes, share)}.npz"
    found = _read(path, meshes)
    if found is None:
        found = decimated(meshes, share)
        with suppress(OSError):
            _write(path, found)
    return found


def _key(meshes: Sequence[Mesh], share: float) -> str:
    """Of everything that decides about the result."""
    digest = hashlib.sha256(f"{VERSION} {share!r} {len(meshes)}".encode())
    for index, mesh in enumerate(meshes):
        arrays = (mesh.positions, mesh.normals, mesh.uv, mesh.light, mesh.triangles)
        moves = mesh.body if mesh.deformation is None else -1 - index
        digest.update(f"{[array.shape for array in arrays]} {moves} {mesh.texture < 0}".encode())
        for array in arrays:
            digest.update(array.tobytes())
    return digest.hexdigest()[:40]


def _read(path: Path, meshes: Sequence[Mesh]) -> Triangles | None:
    """None for a file that is not there, or is not what _write() makes for these meshes."""
    try:
        with (
            path.open("rb") as file,
            np.load(file, allow_pickle=False) as stored,
        ):  # given a path it forgets to close what is no archive
            triangles, counts = stored["triangles"], stored["counts"]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None
    fits = (
        triangles.dtype == np.uint32
        and triangles.shape[1:] == (3,)
        and counts.shape == (len(meshes),)
        and counts.dtype == np.int64
    )
    if not fits or (counts < 0).any() or counts.sum() != len(triangles):
        return None
    parts = np.split(triangles, np.cumsum(counts)[:-1]) if len(counts) else []
    known = all(not len(part) or part.max() < len(mesh.positions) for part, mesh in zip(parts, meshes, strict=True))
    return parts if known else None


def _write(path: Path, triangles: Triangles) -> None:
    """Under its name only when it is whole: another run may read at the same time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.stem, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            counts = np.array([len(part) for part in triangles], np.int64)
            np.savez_compressed(
                file, triangles=np.concatenate([np.zeros((0, 3), np.uint32), *triangles]), counts=counts
            )
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


@attrs.frozen(eq=False)
class _Some:
    """The vertices that are left of a deformation."""

    whole: Deformation
    kept: NDArray[np.int64]

    def positions(self, time_ns: int) -> NDArray:
        return self.whole.positions(time_ns)[self.kept]

    def velocities(self, time_ns: int) -> NDArray:
        return self.whole.velocities(time_ns)[self.kept]


def _with_triangles(mesh: Mesh, triangles: NDArray[np.uint32]) -> Mesh:
    """The mesh with these of its vertices' triangles, and without the vertices they do not use."""
    kept, which = np.unique(triangles, return_inverse=True)
    albedo = None if mesh.albedo is None else mesh.albedo[kept]
    deformation = None if mesh.deformation is None else _Some(mesh.deformation, kept)
    fields = {name: getattr(mesh, name)[kept] for name in ("positions", "normals", "uv", "light")}
    triangles = which.reshape(-1, 3)
    return attrs.evolve(
        mesh, **fields, triangles=triangles, albedo=albedo, deformation=deformation, material=Material()
    )
