"""The layers that a frame can carry, one file each."""

from __future__ import annotations

from ...registry import Registry
from ._base import (
    BRIGHT_VIDEO,
    DEPTH,
    OWN,
    PACKED,
    PIXEL_BYTES,
    RENDERED,
    SHOWN,
    VECTORS,
    VIDEO,
    Delivered,
    EyeSizes,
    Layer,
    Surface,
    readable,
)

# What passes read of an eye's own picture.
PICTURE = (readable("colour"), readable("inverse_depth"))
layers: Registry[type[Layer]] = Registry("layer", __name__)


def readable_names() -> tuple[str, ...]:
    """Return what passes may read of a frame, one name for each layer; imports no layer."""
    return tuple(readable(name) for name in layers.names())


__all__ = [
    "BRIGHT_VIDEO",
    "DEPTH",
    "OWN",
    "PACKED",
    "PICTURE",
    "PIXEL_BYTES",
    "RENDERED",
    "SHOWN",
    "VECTORS",
    "VIDEO",
    "Delivered",
    "EyeSizes",
    "Layer",
    "Surface",
    "layers",
    "readable",
    "readable_names",
]
