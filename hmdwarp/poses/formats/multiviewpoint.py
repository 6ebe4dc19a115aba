"""Multi-viewpoint 360-degree video, MMSys'18: rotation only, w first, z up.

Its Euler twin is refused.
"""

from __future__ import annotations

from ...errors import TraceError
from ..assumptions import By, Layout
from ..options import TraceOptions
from ..reading.file_head import Head
from . import TraceFormat, formats, has

# The head pitches about the file's y and hardly ever rolls about its x (measured: angular speed
# about x is half that about y in the head's own axes), so x is forward and y left, as in the viewer
# of Corbillon et al. 2017, whose convention the set names.
AXES = "ros"


@formats.register
class MultiViewpoint(TraceFormat):
    """The quaternion files of the set.

    Source: Corbillon et al. 2018, Dynamic adaptive streaming for multi-viewpoint omnidirectional
    videos (MMSys).
    """

    name = "multiviewpoint"
    summary = "timestamp viewpoint w x y z; seconds, rotation only, z up, x forward"
    header = ("timestamp", "viewpoint")
    facts = {"unit": "s", "axes": AXES, "axes_by": By.FORMAT}

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if has(head, "yaw", "pitch", "roll") and not has(head, "w"):
            raise TraceError(
                f"{head.path} gives Euler angles only, under a header that is mislabelled (its 'yaw' is the pitch): "
                "read the twin of this file that holds quaternions"
            )
        return super().layout(head, options)
