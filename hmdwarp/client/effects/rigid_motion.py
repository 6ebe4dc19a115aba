"""Things that move as a whole: each pixel goes where its body goes until it is shown."""

from __future__ import annotations

from ...frames import Needs
from ...scenes.effects import SceneEffect
from . import effects
from ._base import Effect
from ._motion import MotionPass

effects.register(
    Effect(
        flag=SceneEffect.RIGID_MOTION,
        summary="each pixel of a moving body goes where the body goes until it is shown; the hole it leaves is a hole",
        made_by=MotionPass,
        needs=Needs(ids=True),
        without="moving things hang where they were when the frame was drawn",
        source="object poses on the frame, as appSpaceDeltaPose of XR_FB_space_warp; McMillan and Bishop 1995 for the map of each body",
    )
)
