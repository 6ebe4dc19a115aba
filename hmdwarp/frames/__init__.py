"""Frames: what the server drew, with the exact views it was drawn for."""

from .frame import EyeImage, Frame, Layer, Needs, Reflection, Transparent

__all__ = ["EyeImage", "Frame", "Layer", "Needs", "Reflection", "Transparent"]
