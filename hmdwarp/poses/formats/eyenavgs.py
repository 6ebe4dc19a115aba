"""EyeNavGS: Quest Pro in 3D Gaussian splatting scenes, a row per eye.

The two sites order and name their columns differently.
"""

from ..assumptions import By, Defect
from . import TraceFormat, formats

_EYES = Defect(
    "eye-position",
    "positions are of the left eye, not of the head, and in units of the scene, not in metres",
    "kept as they are; --scale gives metres per unit",
)


class EyeNavGS(TraceFormat):
    """Both sites' layouts. Source: Ding et al. 2025, EyeNavGS (arXiv:2506.02380)."""

    name = "eyenavgs"
    summary = "ViewIndex,FOV1-4,Position..,Quaternion..,Gaze..,Timestamp or timestep; ms, a row per eye"
    header = ("ViewIndex", "FOV1", "PositionX", "QuaternionX", "GazePosX")
    facts = {"unit": "ms", "axes_by": By.FORMAT, "caveats": (_EYES,)}


formats.register(EyeNavGS())
