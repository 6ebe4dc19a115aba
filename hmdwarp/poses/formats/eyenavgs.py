"""EyeNavGS: Quest Pro in 3D Gaussian splatting scenes, a row per eye.

The two sites order and name their columns differently.
"""

from __future__ import annotations

from ..defects import Defect
from ..options import TraceOptions
from ..reading.file_head import Head
from ..reading.rows import BY_FORMAT, Layout
from . import formats
from ._base import TraceFormat, has, named_layout

_EYES = Defect(
    "eye-position",
    "positions are of the left eye, not of the head, and in units of the scene, not in metres",
    "kept as they are; --scale gives metres per unit",
)


class EyeNavGS(TraceFormat):
    """Both sites' layouts.

    Source: Ding et al. 2025, EyeNavGS (arXiv:2506.02380).
    """

    name = "eyenavgs"
    summary = "ViewIndex,FOV1-4,Position..,Quaternion..,Gaze..,Timestamp or timestep; ms, a row per eye"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        return 90 if has(head, "ViewIndex", "FOV1", "PositionX", "QuaternionX", "GazePosX") else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        return named_layout(head, options, unit="ms", axes_by=BY_FORMAT, caveats=(_EYES,))


formats.register(EyeNavGS())
