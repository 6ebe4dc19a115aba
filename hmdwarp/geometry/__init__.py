"""Float64 geometry without a GPU: poses, views, the warp map between two views, depth conventions.

This package knows nothing of the rest of the program. Conventions: docs/conventions.md.
"""

from .depth import DepthLayer, inverse_depth_from_clip, inverse_depth_from_metres
from .mirror import Mirror
from .pose import Pose
from .rigid import RigidState
from .view import Eyes, Fov, View, guarded_eyes
from .warp_map import WarpMap

__all__ = [
    "DepthLayer",
    "Eyes",
    "Fov",
    "Mirror",
    "Pose",
    "RigidState",
    "View",
    "WarpMap",
    "guarded_eyes",
    "inverse_depth_from_clip",
    "inverse_depth_from_metres",
]
