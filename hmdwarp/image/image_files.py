"""A warped picture as a file, by the ending of its name."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..colour import srgb8_from_linear
from ..errors import InputError, listed
from ..geometry import View
from ..report import atomic, jpeg_bytes, png_bytes, write_bytes
from ..resources import import_extra
from ..sources.sequences.picture_files import write_exr
from .warper import WarpedImage


def _npz(path: Path, image: WarpedImage, shown: View) -> None:
    """Write a file that is a frame for the next warp."""
    pose, fov = shown.pose, shown.fov
    facts: dict[str, Any] = {"fov": (fov.left, fov.right, fov.down, fov.up), "position_m": pose.position_m}
    facts |= {"orientation_xyzw": pose.orientation_xyzw, "time_ms": json.dumps(image.time_ms)}
    facts |= {"encoding": image.encoding, **({} if image.depth_m is None else {"depth_m": image.depth_m})}
    with atomic(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, colour=image.colour, coverage=image.coverage, **facts)


def _png(path: Path, image: WarpedImage, _: View) -> None:
    alpha = np.where(image.coverage > 0, np.uint8(255), np.uint8(0))  # what a repair guessed is opaque too
    write_bytes(path, png_bytes(np.concatenate([srgb8_from_linear(image.colour), alpha[..., None]], axis=2)))


def _jpeg(path: Path, image: WarpedImage, _: View) -> None:
    black = np.where(image.coverage[..., None] > 0, image.colour, 0)
    write_bytes(path, jpeg_bytes(srgb8_from_linear(black)))


def _exr(path: Path, image: WarpedImage, _: View) -> None:
    assert image.depth_m is not None  # TAKES_DEPTH
    with atomic(path) as temporary:
        write_exr(temporary, image.colour, image.coverage, image.depth_m)


_WRITERS: dict[str, Callable[[Path, WarpedImage, View], None]] = {
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


def write_image(path: Path, image: WarpedImage, shown: View) -> None:
    """Write a warped picture in linear light by the ending of the path. shown: its view.

    .npz: linear light, coverage, depth_m and the view, as a frame has them, and time_ms as JSON
    text. .png: sRGB, holes transparent. .jpg: sRGB, holes black. .exr: linear light, coverage in A,
    depth in Z. Errors: as has_depth; else as write_bytes.
    """
    has_depth(path)
    _WRITERS[path.suffix.lower()](path, image, shown)
