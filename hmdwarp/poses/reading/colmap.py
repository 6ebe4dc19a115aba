"""Sparse models of COLMAP, as text or binary: cameras, and images with the world's pose in each."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError
from ...options.named_files import LIST, content_of
from .header import Made, rows_text

MARK = b"Image list with two lines of data per image"  # in the comment above the images
COLUMNS = ("qw", "qx", "qy", "qz", "tx", "ty", "tz")
# Name and number of parameters of each camera model, by its number in binary files.
_MODELS = [
    *(("SIMPLE_PINHOLE", 3), ("PINHOLE", 4), ("SIMPLE_RADIAL", 4), ("RADIAL", 5), ("OPENCV", 8)),
    *(("OPENCV_FISHEYE", 8), ("FULL_OPENCV", 12), ("FOV", 5), ("SIMPLE_RADIAL_FISHEYE", 4)),
    *(("RADIAL_FISHEYE", 5), ("THIN_PRISM_FISHEYE", 12)),
]
_POSE, _CAMERA, _COUNT = "<i7di", "<iiQQ", "<Q"
_POINT_BYTES = 24


@attrs.frozen(eq=False)
class ColmapImage:
    """An image and the pose of its camera."""

    where: str
    name: str
    camera_id: int
    pose: tuple[float, ...]  # as the file has it, camera from world: qw qx qy qz tx ty tz
    rotation: NDArray[np.float64]  # (3, 3) world from camera

    @property
    def position(self) -> NDArray[np.float64]:
        """(3,) of the camera in the world."""
        return np.asarray(-self.rotation @ np.array(self.pose[4:]))


@attrs.frozen
class ColmapCamera:
    """A camera of a model."""

    where: str
    model: str
    size: tuple[int, int]  # (w, h)
    parameters: tuple[float, ...]


def read_images(path: Path) -> list[ColmapImage]:
    """Return the images of images.txt or images.bin, by name. Errors: TraceError."""
    rows = _images_in_binary(path) if path.suffix == ".bin" else _images_in_text(path, _bytes(path))
    return sorted(rows, key=lambda image: image.name)


def table_of_colmap(path: Path, raw: bytes) -> Made:
    """Return the poses of images.txt in the order of the names. Errors: TraceError."""
    images = sorted(_images_in_text(path, raw), key=lambda image: image.name)
    return Made("colmap", rows_text(map(repr, image.pose) for image in images), COLUMNS)


def read_cameras(path: Path) -> dict[int, ColmapCamera]:
    """Return the cameras of cameras.txt or cameras.bin by their numbers. Errors: TraceError."""
    return dict(_cameras_in_binary(path) if path.suffix == ".bin" else _cameras_in_text(path))


def _images_in_text(path: Path, raw: bytes) -> Iterator[ColmapImage]:
    """Yield the images of the text form: a line of its pose, and one of points, perhaps empty."""
    lines = enumerate(_lines(path, raw), 1)
    for number, line in lines:
        if not line.strip() or line.startswith("#"):
            continue
        where, words = f"{path}, line {number}", line.split(maxsplit=9)
        try:
            numbers = [float(word) for word in words[:9]]
            name = words[9].strip()
        except (ValueError, IndexError):
            wanted = "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points"
            raise TraceError(f"{where}: '{line.strip()[:60]}'; expected {wanted}") from None
        yield _image(where, name, int(numbers[8]), numbers[1:8])
        next(lines, None)


def _images_in_binary(path: Path) -> Iterator[ColmapImage]:
    raw = _bytes(path)
    stream = io.BytesIO(raw)
    for number in range(*_unpacked(path, stream, _COUNT)):
        _, *pose, camera_id = _unpacked(path, stream, _POSE)
        name = stream.read(max(0, raw.find(b"\0", stream.tell()) - stream.tell()))
        stream.read(1)
        yield _image(f"{path}, image {number}", name.decode("utf-8", "replace"), camera_id, pose)
        points = _POINT_BYTES * _unpacked(path, stream, _COUNT)[0]
        stream.seek(min(points, len(raw)), io.SEEK_CUR)  # of 2^64 no file has the bytes
        if stream.tell() > len(raw):
            raise _cut(path)


def _image(where: str, name: str, camera_id: int, pose: list[float]) -> ColmapImage:
    from scipy.spatial.transform import Rotation

    w, x, y, z, *moved = pose
    length = float(np.linalg.norm((w, x, y, z)))
    if not abs(length - 1) <= 1e-2 or not np.isfinite(moved).all():
        raise TraceError(f"{where}: a quaternion of length {length:.4g}; expected 1 within 0.01, w x y z")
    return ColmapImage(where, name, camera_id, tuple(pose), Rotation.from_quat((x, y, z, w)).as_matrix().T)


def _cameras_in_text(path: Path) -> Iterator[tuple[int, ColmapCamera]]:
    for number, line in enumerate(_lines(path, _bytes(path)), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        where = f"{path}, line {number}"
        try:
            key, wide, high = int(words[0]), int(words[2]), int(words[3])
            yield key, ColmapCamera(where, words[1], (wide, high), tuple(float(word) for word in words[4:]))
        except (ValueError, IndexError):
            raise TraceError(f"{where}: '{line.strip()[:60]}'; expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS") from None


def _cameras_in_binary(path: Path) -> Iterator[tuple[int, ColmapCamera]]:
    stream = io.BytesIO(_bytes(path))
    for number in range(*_unpacked(path, stream, _COUNT)):
        key, model, wide, high = _unpacked(path, stream, _CAMERA)
        if not 0 <= model < len(_MODELS):
            raise TraceError(f"{path}, camera {number}: model {model}; expected 0 to {len(_MODELS) - 1}")
        name, count = _MODELS[model]
        yield key, ColmapCamera(f"{path}, camera {number}", name, (wide, high), _unpacked(path, stream, f"<{count}d"))


def _unpacked(path: Path, stream: io.BytesIO, form: str) -> tuple[Any, ...]:
    data = stream.read(struct.calcsize(form))
    if len(data) < struct.calcsize(form):
        raise _cut(path)
    return struct.unpack(form, data)


def _cut(path: Path) -> TraceError:
    return TraceError(f"{path}: it ends in the middle; expected a whole binary model of COLMAP")


def _bytes(path: Path) -> bytes:
    return content_of(path, attrs.evolve(LIST, error=TraceError))


def _lines(path: Path, raw: bytes) -> list[str]:
    try:
        return raw.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise TraceError(f"{path}: not a text file ({error})") from None
