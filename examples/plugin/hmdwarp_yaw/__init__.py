"""A warp that follows turns to left and right alone, as a display on a turntable would."""

from hmdwarp import Pose, View, WarpMap
from hmdwarp.client.warps import warps


@warps.register
class YawOnly(warps.get("rotation")):
    """Turns the rendered picture about the vertical axis of the head, ignores pitch and roll."""

    name = "yaw_only"
    summary = "turns the picture to left and right with the head, ignores pitch, roll and how the eye moved"
    exact_when = "the head only turns to left and right, or everything is far away and it does"
    gets_wrong = "pitch, roll, and near things under translation"
    source = "examples/plugin"

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the map for the part of the turn that is about the vertical axis (its twist)."""
        _, y, _, w = (rendered.pose.inverse() @ shown.pose).orientation_xyzw
        yaw = Pose(orientation_xyzw=(0, y, 0, w if y or w else 1))
        return super().map_between(View(rendered.pose @ yaw, shown.fov), rendered)
