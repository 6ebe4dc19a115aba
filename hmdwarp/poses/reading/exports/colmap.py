"""COLMAP's images.txt as a table: a line of a pose and a line of points for each image."""

from __future__ import annotations

from pathlib import Path

from ..colmap import MARK, images_in_text
from ..made import Made, rows_text

COLUMNS = ("qw", "qx", "qy", "qz", "tx", "ty", "tz")


def fits(path: Path, start: bytes) -> bool:
    """Return whether a file lists the images of a model."""
    return MARK.encode() in start[:200]


def made(path: Path, text: str) -> Made:
    """Return the poses in the order of the images' names. Errors: TraceError naming the line."""
    images = sorted(images_in_text(path, text.encode()), key=lambda image: image.name)
    return Made("colmap", rows_text(map(repr, image.pose) for image in images), COLUMNS)
