"""Recordings of Meta's Immersive Web Emulation Runtime: JSON of schema and frames."""

from ..assumptions import By
from . import TraceFormat, formats


class Iwer(TraceFormat):
    """Source: ActionRecorder of meta-quest/immersive-web-emulation-runtime; WebXR for the axes."""

    name = "iwer"
    kind = "iwer"
    summary = "frames of an IWER ActionRecorder: JSON with schema and frames; ms, OpenXR axes"
    order = "quaternion xyzw"
    facts = {
        "unit": "ms",
        "axes_by": By.FORMAT,
        "scale_by": By.FORMAT,
        "order_by": By.FORMAT,
        "direction_by": By.FORMAT,
    }


formats.register(Iwer())
