"""Motion that frames carry: of rigid bodies, and the velocity of each pixel."""

from ...frames import Needs
from ...scenes import REACH_M, REACH_S
from ..effect_passes import MotionPass
from . import Effect, effects

effects.register(
    Effect(
        name="rigid_motion",
        order=20,
        summary="each pixel of a moving body goes where the body goes until it is shown; the hole it leaves is a hole",
        applies=lambda _, mesh: mesh.body > 0,
        made_by=MotionPass,
        needs=Needs(ids=True),
        without="moving things hang where they were when the frame was drawn",
        source="object poses on the frame, as appSpaceDeltaPose of XR_FB_space_warp; McMillan and Bishop 1995 for "
        "the map of each body",
    )
)

effects.register(
    Effect(
        name="soft_motion",
        order=21,
        summary=f"each pixel of what deforms goes on with its velocity, for {REACH_S:g} s and {REACH_M:g} m at most",
        applies=lambda _, mesh: mesh.deformation is not None,
        made_by=MotionPass,
        needs=Needs(velocity=True),
        without="what deforms stands still as it was when the frame was drawn",
        source="motion vectors on the frame, as XR_EXT_frame_synthesis and XR_FB_space_warp have them",
    )
)
