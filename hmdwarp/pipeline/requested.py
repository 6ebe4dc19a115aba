"""A request to a loop: whose head, and pictures of which format."""

from __future__ import annotations

from collections.abc import Callable

import attrs

from ..frames import Needs
from ..frames.layers import PICTURE
from ..geometry import Guard
from ..poses import PoseSample, PoseSource


@attrs.define(eq=False)
class PoseRequest:
    """Head poses for the server and the display, and the format of the pictures to draw."""

    source: PoseSource
    # Predicts the head at an instant for so long after it; None for no prediction.
    predicted: Callable[[int, int], PoseSample] | None
    # (w, h) of one eye.
    size: tuple[int, int]
    # What is rendered beyond the shown view.
    guard: Guard
    # Layers that frames carry.
    needs: Needs
    # Time from the first row of the display to its last.
    scanout_ns: int = 0
    # From drawing a frame to showing it, as far as that is known beforehand; set anew where the
    # latency changes during a run.
    age_ns: int = 0
    # What is read of the eyes' pictures, by readable name; none are drawn where it is empty.
    pictures: frozenset[str] = frozenset(PICTURE)

    def for_server(self, now_ns: int, later_ns: int = 0) -> PoseSample:
        """Return the pose for a frame drawn now: the current or the predicted one.

        later_ns: how much later than a frame of this request it is seen.
        """
        return self.source.head_at(now_ns) if self.predicted is None else self.predicted(now_ns, self.age_ns + later_ns)

    def for_display(self, shown_ns: int) -> PoseSample:
        """Return the head pose at the instant when the picture is seen."""
        return self.source.head_at(shown_ns)
