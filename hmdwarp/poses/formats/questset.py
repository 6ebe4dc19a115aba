"""QuestSet: Quest 2 games, head with hands and buttons, w first, time in the last column."""

from ..assumptions import By
from . import TraceFormat, formats


class QuestSet(TraceFormat):
    """Head tracks of the set.

    Source: Baldoni et al. 2024, Questset: A VR dataset for network and quality of experience
    studies.
    """

    name = "questset"
    summary = "TouchButtons,..,HeadPosX,..,HeadOrientationW,..,time; seconds, w first, OpenXR axes"
    header = ("HeadPosX", "HeadOrientationW", "LeftTouchPosX", "time")
    facts = {"unit": "s", "axes_by": By.FORMAT}


formats.register(QuestSet())
