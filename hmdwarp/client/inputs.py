"""What the passes of one eye are given at one refresh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from ..frames.frame import EyeImage
from ..geometry import View

if TYPE_CHECKING:
    import moderngl


@attrs.frozen(eq=False)
class PassInputs:
    """One eye's late picture and the view to show it in.

    shown: the view when the first row lights up; shown_last: when the last one does, None for a display that lights up at once.
    others: further late pictures of the same scene with their own views: the other eye's, then this eye's older ones, newest
    first. shown_ns: when it is seen (the first row). client_inverse_depth: r32f of the shown size, the client's own depth in the shown
    view, -1 where it has none. drawn: the late picture as it came, None where no pass has changed `late` since.
    """

    rendered: EyeImage
    shown: View
    eye: int = 0
    others: tuple[EyeImage, ...] = ()
    shown_last: View | None = None
    client_inverse_depth: moderngl.Texture | None = None
    shown_ns: int = 0
    drawn: EyeImage | None = None

    @property
    def age_ns(self) -> int:
        """How long before it is seen the late picture was drawn."""
        return self.shown_ns - self.rendered.drawn_ns

    @property
    def as_drawn(self) -> EyeImage:
        """The late picture as it came: nothing in it has been moved to where it is by now."""
        return self.rendered if self.drawn is None else self.drawn

    @property
    def middle(self) -> View:
        """The view half way through the scan-out: the best one for whatever shows all rows as at one instant."""
        if self.shown_last is None:
            return self.shown
        return attrs.evolve(self.shown, pose=self.shown.pose.towards(self.shown_last.pose, 0.5))

    def at_once(self) -> PassInputs:
        """The same for what cannot follow the scan-out: all rows as in its middle."""
        return self if self.shown_last is None else attrs.evolve(self, shown=self.middle, shown_last=None)
