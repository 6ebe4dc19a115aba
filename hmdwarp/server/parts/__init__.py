"""What a scene may have besides plain surfaces, one file each: drawn into the picture, or sent as a layer of its own."""

from ...registry import Registry
from ._base import DrawContext, Drawing, Part

parts: Registry[type[Part]] = Registry("part", __name__)

__all__ = ["Drawing", "DrawContext", "Part", "parts"]
