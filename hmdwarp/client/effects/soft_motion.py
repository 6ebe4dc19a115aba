"""Deforming motion: each pixel continues with its velocity, for a short time and distance."""

from ...frames import Needs
from ...scenes import REACH_M, REACH_S
from ..effect_passes import MotionPass
from . import effects
from ._base import Effect

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
