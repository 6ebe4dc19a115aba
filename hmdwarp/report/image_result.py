"""A warped picture as a file, by the ending of its name."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import srgb8_from_linear
from ..errors import InputError, listed
from ..geometry import View
from ..resources import import_extra
from .files import atomic, write_bytes
from .pictures import jpeg_bytes, png_bytes


@attrs.frozen(eq=False)
class ImageResult:
    """A warped picture, row 0 at the top."""

    # (h, w, 3) linear light.
    colour: NDArray[np.float32]
    # (h, w), 0 for a hole.
    coverage: NDArray[np.float32]
    # (h, w) metres along -z, inf infinitely far, NaN unknown; None where it was not requested.
    depth_m: NDArray[np.floating] | None
    time_ms: Mapping[str, float]
    # The view that it shows.
    view: View

    @property
    def srgb(self) -> NDArray[np.uint8]:
        """The colour in bytes, black in holes."""
        return srgb8_from_linear(np.where(self.coverage[..., None] > 0, self.colour, 0))


def _npz(path: Path, image: ImageResult) -> None:
    """Write a file that is a frame for the next warp."""
    pose, fov = image.view.pose, image.view.fov
    facts: dict[str, Any] = {"fov": (fov.left, fov.right, fov.down, fov.up), "position_m": pose.position_m}
    facts |= {"orientation_xyzw": pose.orientation_xyzw, "time_ms": json.dumps(image.time_ms)}
    facts |= {} if image.depth_m is None else {"depth_m": image.depth_m}
    with atomic(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, colour=image.colour, coverage=image.coverage, **facts)


def _png(path: Path, image: ImageResult) -> None:
    alpha = np.where(image.coverage > 0, np.uint8(255), np.uint8(0))  # what a repair guessed is opaque too
    write_bytes(path, png_bytes(np.concatenate([srgb8_from_linear(image.colour), alpha[..., None]], axis=2)))


def _jpeg(path: Path, image: ImageResult) -> None:
    write_bytes(path, jpeg_bytes(image.srgb))


def _exr(path: Path, image: ImageResult) -> None:
    from ..sources.sequences.exr import write_exr

    assert image.depth_m is not None  # TAKES_DEPTH
    with atomic(path) as temporary:
        write_exr(temporary, image.colour, image.coverage, image.depth_m)


_WRITERS: dict[str, Callable[[Path, ImageResult], None]] = {
    ".npz": _npz,
    ".png": _png,
    ".jpg": _jpeg,
    ".jpeg": _jpeg,
    ".exr": _exr,
}
_TAKE_DEPTH = (".npz", ".exr")


def has_depth(path: Path) -> bool:
    """Return whether a file of that name holds depth.

    Errors: InputError for an ending that is not written; MachineError for EXR without its package.
    """
    ending = path.suffix.lower()
    if ending not in _WRITERS:
        raise InputError(f"{path}: expected a name that ends in {listed(tuple(_WRITERS), 'or')}")
    if ending == ".exr":
        import_extra("OpenEXR", "OpenEXR", "exr")
    return ending in _TAKE_DEPTH


def write_image_result(path: Path, image: ImageResult) -> None:
    """Write a warped picture by the ending of the path.

    .npz: linear light, coverage, depth_m and the view, as a frame has them, and time_ms as JSON
    text. .png: sRGB, holes transparent. .jpg: sRGB, holes black. .exr: linear light, coverage in A,
    depth in Z. Errors: as has_depth; else as write_bytes.
    """
    has_depth(path)
    _WRITERS[path.suffix.lower()](path, image)
