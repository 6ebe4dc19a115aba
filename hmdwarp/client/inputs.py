"""The inputs of the passes of one eye at one refresh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from ..frames import EyeImage
from ..geometry import View

if TYPE_CHECKING:
    import moderngl


@attrs.frozen(eq=False)
class PassInputs:
    """One eye's rendered picture and the view to show it in."""

    rendered: EyeImage
    # The view when the first row lights up.
    shown: View
    eye: int = 0
    # Other rendered pictures of the scene with their own views: the other eye's, then those that
    # the server chose for this one, then this eye's older ones, newest first.
    others: tuple[EyeImage, ...] = ()
    # The view when the last row lights up, None for a display that lights up at once.
    shown_last: View | None = None
    # r32f of the shown size: the client's own depth in the shown view, -1 where nothing is.
    client_inverse_depth: moderngl.Texture | None = None
    # When the first row is seen.
    shown_ns: int = 0
    # The rendered picture as it arrived, None where no pass has changed `rendered` since.
    drawn: EyeImage | None = None

    @property
    def age_ns(self) -> int:
        """The time from drawing to showing."""
        return self.shown_ns - self.rendered.drawn_ns

    @property
    def as_drawn(self) -> EyeImage:
        """The rendered picture as it arrived, before any motion was applied."""
        return self.rendered if self.drawn is None else self.drawn

    @property
    def middle(self) -> View:
        """The view at the middle of the scan-out, for passes that show all rows at once."""
        if self.shown_last is None:
            return self.shown
        return attrs.evolve(self.shown, pose=self.shown.pose.towards(self.shown_last.pose, 0.5))

    def at_once(self) -> PassInputs:
        """Return the inputs for passes that cannot follow the scan-out: all rows at its middle."""
        return self if self.shown_last is None else attrs.evolve(self, shown=self.middle, shown_last=None)
