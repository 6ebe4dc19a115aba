"""Warp one RGB-D frame of the caller's own in one call, without scene or headset."""

from .usable import usable_fills, usable_warps
from .warper import WarpedImage, WarpedTextures, Warper

__all__ = ["WarpedImage", "WarpedTextures", "Warper", "usable_fills", "usable_warps"]
