"""A warped picture as a file, by the ending of its name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..base import InputError, import_extra, listed, srgb8_from_linear
from ..geometry import View
from ..report import atomic, jpeg_bytes, png_bytes, write_bytes
from ..sources.sequences.picture_files import write_exr
from .warper import WarpedImage

_ENDINGS, _TAKE_DEPTH = (".npz", ".png", ".jpg", ".jpeg", ".exr"), (".npz", ".exr")


def has_depth(path: Path) -> bool:
    """Return whether a file of that name holds depth. Errors: InputError; MachineError for EXR."""
    ending = path.suffix.lower()
    if ending not in _ENDINGS:
        raise InputError(f"{path}: expected a name that ends in {listed(_ENDINGS, 'or')}")
    if ending == ".exr":
        import_extra("OpenEXR", "OpenEXR", "exr")
    return ending in _TAKE_DEPTH


def write_image(path: Path, image: WarpedImage, shown: View) -> None:
    """Write a warped picture in linear light by the ending of the path. shown: its view.

    .npz: a frame, with time_ms as JSON text. .png: sRGB, holes transparent. .jpg: sRGB, holes
    black. .exr: linear light, coverage in A, depth in Z. Errors: as has_depth, write_bytes.
    """
    if has_depth(path):
        with atomic(path) as temporary:
            if path.suffix.lower() == ".exr":
                assert image.depth_m is not None  # as has_depth says
                write_exr(temporary, image.colour, image.coverage, image.depth_m)
                return
            pose, fov = shown.pose, shown.fov  # it is a frame for the next warp
            facts: dict[str, Any] = {"fov": (fov.left, fov.right, fov.down, fov.up), "position_m": pose.position_m}
            facts |= {"orientation_xyzw": pose.orientation_xyzw, "time_ms": json.dumps(image.time_ms)}
            facts |= {"encoding": image.encoding, **({} if image.depth_m is None else {"depth_m": image.depth_m})}
            with temporary.open("wb") as file:
                np.savez_compressed(file, colour=image.colour, coverage=image.coverage, **facts)
        return
    seen = image.coverage[..., None] > 0  # what a repair guessed is opaque too
    if path.suffix.lower() != ".png":
        write_bytes(path, jpeg_bytes(srgb8_from_linear(np.where(seen, image.colour, 0))))
        return
    alpha = np.where(seen, np.uint8(255), np.uint8(0))
    write_bytes(path, png_bytes(np.concatenate([srgb8_from_linear(image.colour), alpha], axis=2)))
