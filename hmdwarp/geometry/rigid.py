"""Pose and motion of a rigid body at one instant."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .pose import Pose, frozen3


@attrs.frozen(eq=False)
class RigidState:
    """world_from_body at one instant, and its motion in world axes."""

    pose: Pose
    # of the body's origin
    velocity_m_s: NDArray[np.float64] = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen3)
    # about that origin, right-handed around its direction
    angular_velocity_rad_s: NDArray[np.float64] = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen3)
    # of the origin; gravity for thrown bodies
    acceleration_m_s2: NDArray[np.float64] = attrs.field(default=(0.0, 0.0, 0.0), converter=frozen3)

    def after(self, age_ns: int) -> Pose:
        """Return world_from_body `age_ns` later, at constant acceleration and angular velocity."""
        from scipy.spatial.transform import Rotation

        seconds = age_ns * 1e-9
        position = self.pose.position_m + seconds * (self.velocity_m_s + 0.5 * seconds * self.acceleration_m_s2)
        turned = Rotation.from_rotvec(self.angular_velocity_rad_s * seconds) * self.pose.rotation
        return Pose(position, turned.as_quat())
