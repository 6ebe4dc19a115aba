"""COLMAP's images.txt: camera from world, in the order of the images' names."""

from __future__ import annotations

from ..assumptions import By, Layout
from ..options import TraceOptions
from ..reading.file_head import Head
from . import TraceFormat, formats


@formats.register
class Colmap(TraceFormat):
    """Images of a model, which have no time and, unless it was aligned, no metres and no up.

    Source: COLMAP documentation, output format (images.txt).
    """

    name = kind = "colmap"
    summary = "images.txt of COLMAP: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME; needs --trace-rate"
    order = "quaternion wxyz"
    order_by = By.FORMAT
    facts = {"axes": "opencv", "axes_by": By.FORMAT, "inverse": True, "direction_by": By.FORMAT, "order_by": By.FORMAT}

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        return Layout(time=None, orientation=(1, 2, 3, 0), position=(4, 5, 6), columns_by=By.FORMAT, **self.facts)
