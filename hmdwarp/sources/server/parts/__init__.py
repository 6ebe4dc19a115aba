"""Content of frames besides plain surfaces, one file each: in the picture, or as layers."""

from ....registry import Registry
from ._base import DrawContext, Drawing, Part

parts: Registry[type[Part]] = Registry("part", __name__)

__all__ = ["Drawing", "DrawContext", "Part", "parts"]
