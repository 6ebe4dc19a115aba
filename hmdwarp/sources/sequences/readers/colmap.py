"""COLMAP: a sparse model, its images, and depth for each, from its own stereo or elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....errors import InputError, TraceError
from ....options.named_files import PICTURE_FILE, content_of, named_in
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ....poses.reading.colmap import ColmapCamera, ColmapImage, read_cameras, read_images
from ..camera import Camera, refuse_distortion
from ..options import SequenceOptions
from ..picture_files import read_depth
from ..recorded import DEPTH_SCALE, INTRINSICS, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import DEPTHS, OPTICAL, Pair, SequenceReader, at_rate, facts_of, folder_named, pose_of
from ._dataset import axes_of, clock_of, left_out

_MODELS = ("sparse/0", "sparse", ".", "colmap/sparse/0")
_DEPTHS = ("depth", "depths", "depth_maps", "stereo/depth_maps")
_OWN = (".geometric.bin", ".photometric.bin")  # depth of COLMAP's stereo, in the model's unit
_CENTRE = 0.5  # of the first pixel
_KINDS = {
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
}
_KINDS |= {"OPENCV": "fx fy cx cy k1 k2 p1 p2", "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"}


@readers.register
class ColmapReader(SequenceReader):
    """Models of COLMAP with depth; poses are camera from world and inverted, in the model's unit.

    Source: COLMAP documentation, output format (cameras, images, dense depth maps); its camera
    models.
    """

    name = "colmap"
    summary = "COLMAP: images/, sparse/0/images.txt and cameras.txt (or .bin), and depth/ or stereo/depth_maps/"
    assumes = (
        Assumption(INTRINSICS, "cameras.txt or cameras.bin, for each image", By.FILE, "--intrinsics"),
        Assumption(
            DEPTH_SCALE, "1 unit of the model in its own depth maps, else to be stated", By.FORMAT, "--depth-scale"
        ),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(OPTICAL)),
        Assumption(POSE, "camera from world, inverted; qw qx qy qz tx ty tz", By.FORMAT),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        return 70 if _model(path) is not None and _depths(path) is not None else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        found = _model(path)
        if found is None:
            raise InputError(f"{path}: no images.txt or images.bin in {', '.join(_MODELS)}; expected {self.summary}")
        try:
            images, cameras = read_images(found), read_cameras(found.with_name(f"cameras{found.suffix}"))
        except TraceError as error:
            raise InputError(str(error)) from error
        pictures, depths = folder_named(path, "images", "image", "color", "rgb"), _depths(path) or path / _DEPTHS[0]
        chosen = list(_with_depth(images, pictures, depths))
        own = {key: _camera(cameras, key, found) for key in {image.camera_id for _, image, _ in chosen}}
        of_stereo = bool(chosen) and chosen[0][2].name.endswith(_OWN)
        facts = facts_of(path, options, None, 1.0 if of_stereo else None, own=next(iter(own.values()), None))
        axes = facts.axes()
        pairs = [
            Pair(
                pictures / image.name,
                depth,
                at_rate(options, at),
                pose_of(axes, image.position, image.rotation),
                own[image.camera_id] if options.intrinsics is None else None,
            )
            for at, image, depth in chosen
        ]
        unit = Assumption("length", "1 m per unit of the model, whose own is any", By.NOBODY)
        more = (axes_of(axes), unit, clock_of(options))
        notes = left_out(len(images) - len(pairs), "no picture or no depth")
        return self.sequence_of(path, pairs, facts, notes=notes, more=more, depth_of=_depth)


def _model(path: Path) -> Path | None:
    """Return the file of a model's images."""
    files = (path / place / f"images{ending}" for place in _MODELS for ending in (".txt", ".bin"))
    return next((file for file in files if file.exists()), None)


def _depths(path: Path) -> Path | None:
    return next((path / name for name in _DEPTHS if (path / name).is_dir()), None)


def _with_depth(images: list[ColmapImage], pictures: Path, depths: Path) -> Iterator[tuple[int, ColmapImage, Path]]:
    """Yield number, image and depth of the images that have both files."""
    for at, image in enumerate(images):
        names = [depths / f"{image.name}{ending}" for ending in _OWN]
        names += [named_in(depths, image.name).with_suffix(ending) for ending in DEPTHS]
        depth = next((file for file in names if file.exists()), None)
        if depth is not None and named_in(pictures, image.name).exists():
            yield at, image, depth


def _camera(cameras: dict[int, ColmapCamera], key: int, model: Path) -> Camera:
    """Return a camera without distortion. Errors: InputError, which names the distortion."""
    if key not in cameras:
        raise InputError(f"{model}: its images name camera {key}; expected it in cameras{model.suffix}")
    camera = cameras[key]
    refuse_distortion(camera.where, {"camera_model": camera.model})
    names = _KINDS.get(camera.model, "").split()
    if len(names) != len(camera.parameters):
        raise InputError(
            f"{camera.where}: {len(camera.parameters)} parameters of {camera.model}; expected {len(names)}"
        )
    facts: dict[str, Any] = dict(zip(names, camera.parameters, strict=True))
    refuse_distortion(camera.where, facts)
    fx, fy = (facts["f"], facts["f"]) if "f" in facts else (facts["fx"], facts["fy"])
    return Camera(fx, fy, facts["cx"], facts["cy"], camera.size, _CENTRE)


def _depth(path: Path) -> NDArray[Any]:
    """Return depth; that of COLMAP's stereo is 'width&height&channels&' and then floats by rows."""
    if not path.name.endswith(_OWN):
        return read_depth(path)
    try:
        wide, high, channels, *rest = content_of(path, PICTURE_FILE).split(b"&", 3)
        shape = (int(high), int(wide))
        values = np.frombuffer(rest[0], "<f4").reshape(shape)
    except (ValueError, IndexError):
        raise InputError(f"{path}: not a depth map of COLMAP; expected width&height&1& and as many floats") from None
    if channels != b"1":
        raise InputError(f"{path}: {channels.decode('ascii', 'replace')} channels; expected 1, of depth")
    return values
