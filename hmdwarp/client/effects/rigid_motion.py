"""Rigid motion: each pixel follows its body until it is shown."""

from ...frames import Needs
from ..effect_passes import MotionPass
from . import effects
from ._base import Effect

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
