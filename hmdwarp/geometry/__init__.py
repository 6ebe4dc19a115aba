"""Float64 geometry without a GPU: poses, views, the warp map between two views, depth conventions.

This package does not depend on the rest of the program. Conventions: docs/conventions.md.
"""

from .cube import cube_size, face_views, wide_fov, wide_size, wide_view
from .depth import DepthLayer, inverse_depth_from_clip, inverse_depth_from_metres, metres_from_inverse_depth
from .guard_band import GuardBand
from .mirror import Mirror
from .pose import Pose, RigidState
from .view import Eyes, Fov, Guard, View, guarded_eyes
from .warp_map import WarpMap

__all__ = [
    "DepthLayer",
    "Eyes",
    "Fov",
    "Guard",
    "GuardBand",
    "Mirror",
    "Pose",
    "RigidState",
    "View",
    "WarpMap",
    "cube_size",
    "face_views",
    "guarded_eyes",
    "inverse_depth_from_clip",
    "inverse_depth_from_metres",
    "metres_from_inverse_depth",
    "wide_fov",
    "wide_size",
    "wide_view",
]
