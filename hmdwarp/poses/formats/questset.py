"""QuestSet: Quest 2 games, head beside hands and buttons, w first, time in the last column."""

from __future__ import annotations

from ..options import TraceOptions
from ..reading.file_head import Head
from ..reading.rows import BY_FORMAT, Layout
from . import formats
from ._base import TraceFormat, has, named_layout


class QuestSet(TraceFormat):
    """Head tracks of the set.

    Source: Baldoni et al. 2024, Questset: A VR dataset for network and quality of experience
    studies.
    """

    name = "questset"
    summary = "TouchButtons,..,HeadPosX,..,HeadOrientationW,..,time; seconds, w first, OpenXR axes"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        return 90 if has(head, "HeadPosX", "HeadOrientationW", "LeftTouchPosX", "time") else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        return named_layout(head, options, unit="s", axes_by=BY_FORMAT)


formats.register(QuestSet())
