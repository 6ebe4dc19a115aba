"""The inputs of the passes of one eye at one refresh."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property

import attrs
import moderngl

from ..frames import EyeImage, Frame, Others, Surface
from ..geometry import View
from ..gpu import Canvas


@attrs.frozen(eq=False)
class PassInputs:
    """One eye's rendered picture and the view to show it in."""

    rendered: EyeImage
    shown: View  # The view when the first row lights up.
    eye: int = 0
    # Other rendered pictures of the scene with their own views: the other eye's, then those that
    # the server chose for this one, then this eye's older ones, newest first.
    others: tuple[EyeImage, ...] = ()
    recent: tuple[EyeImage, ...] = ()  # This eye's frames straight before the rendered one, newest first.
    # The view when the last row lights up, None for a display that lights up at once.
    shown_last: View | None = None
    # r32f of the shown size: the client's own depth in the shown view, -1 where nothing is.
    client_inverse_depth: moderngl.Texture | None = None
    shown_ns: int = 0  # When the first row is seen.
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
    def images(self) -> tuple[EyeImage, ...]:
        """Every rendered picture, the newest first."""
        return (self.rendered, *self.others, *self.recent)

    def having(self, images: Iterable[EyeImage]) -> PassInputs:
        """Return the inputs with these in place of `images`."""
        rendered, *further = images
        count = len(self.others)
        return attrs.evolve(self, rendered=rendered, others=tuple(further[:count]), recent=tuple(further[count:]))

    @cached_property
    def middle(self) -> View:
        """The view at the middle of the scan-out, for passes that show all rows at once."""
        if self.shown_last is None:
            return self.shown
        return attrs.evolve(self.shown, pose=self.shown.pose.towards(self.shown_last.pose, 0.5))

    def at_once(self) -> PassInputs:
        """Return the inputs for passes that cannot follow the scan-out: all rows at its middle."""
        return self if self.shown_last is None else attrs.evolve(self, shown=self.middle, shown_last=None)


def as_image(image: EyeImage, surface: Surface) -> EyeImage:
    """Return a surface of a layer as an image of its own."""
    return EyeImage(image.view, surface.colour, surface.inverse_depth, drawn_ns=image.drawn_ns)


@attrs.frozen(eq=False)
class ShownPicture:
    """The shown picture."""

    colour: Canvas  # rgba16f, linear, coverage in alpha.
    # r32f of the same size, 1/m in the shown view, -1 where unknown (a hole, or a filled pixel
    # without depth); None where no pass of the plan reads it.
    inverse_depth: moderngl.Texture | None = None

    @property
    def depth(self) -> moderngl.Texture:
        """The inverse depth, for passes that read or write it: their plan makes it."""
        assert self.inverse_depth is not None
        return self.inverse_depth


class History:
    """Keep the older frames that `others` asks for: some at least its spacing apart, and the last.

    All others go to `discard` at once.
    """

    def __init__(self, others: Others, discard: Callable[[Frame], None]) -> None:
        self._others, self._discard = others, discard
        # Those apart, and those straight before the shown one, each newest first.
        self.frames: tuple[Frame, ...] = ()
        self.recent: tuple[Frame, ...] = ()

    def offer(self, frame: Frame) -> None:
        """Take a frame that a newer one has replaced."""
        before, asked = (frame, *self.frames, *self.recent), self._others
        if not self.frames or frame.drawn_ns - self.frames[0].drawn_ns >= asked.spacing_ns:
            self.frames = (frame, *self.frames)[: asked.past]
        self.recent = (frame, *self.recent)[: asked.recent]
        kept = {*self.frames, *self.recent}
        for dropped in dict.fromkeys(before):
            if dropped not in kept:
                self._discard(dropped)

    def close(self) -> None:
        """Pass all kept frames to `discard`."""
        kept, self.frames, self.recent = dict.fromkeys((*self.recent, *self.frames)), (), ()
        for frame in kept:
            self._discard(frame)
