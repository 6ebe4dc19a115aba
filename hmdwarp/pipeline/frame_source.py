"""Where the frames of a loop come from: the server, or what stands between it and the loop.

A request says whose head they are for, and in which format.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import attrs

from ..client.client_scene import ClientScene
from ..frames import Frame, Needs
from ..frames.layers import PICTURE
from ..geometry import Eyes, Guard, GuardBand
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link import scaled_size
from ..poses import PoseSample, PoseSource
from ..sources.server import Renderer
from .channel import Channel, ChannelSetup, Settled


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


@attrs.frozen(eq=False)
class Target:
    """Where the pictures of a run go."""

    # Belongs to the caller.
    gpu: Gpu
    eyes: Eyes
    # Refresh rate of the display.
    rate_hz: float
    # Delay of the link alone, without the wait for the next refresh.
    link_latency_ns: int
    # Headset whose lens the plans correct, or None.
    lens_of: Headset | None = None


class FrameSource(Protocol):
    """Frames for the heads that a loop asks for."""

    def draw(self, head: PoseSample, now_ns: int, scale: float) -> Frame | None:
        """Return a frame made now for that head, None while there is nothing to make one from.

        scale: the share of the full width and height that it should have.
        """

    def has_more(self, now_ns: int) -> bool:
        """Return whether there is something to send even if nothing has moved."""

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        """Take note of whether a frame arrived, which the sender hears at that instant."""

    def recycle(self, frame: Frame) -> None:
        """Take back a frame that is no longer needed."""

    def channel(self, setup: ChannelSetup) -> Channel:
        """Return the channel that the frames come through."""


@attrs.frozen(eq=False)
class ServerFrames:
    """Frames as the server draws them.

    requested: their format. eyes: the views that belong to a head pose.
    """

    server: Renderer
    requested: PoseRequest
    eyes: Eyes

    def draw(self, head: PoseSample, now_ns: int, scale: float) -> Frame:
        """Draw all eyes for that head."""
        asked, timer = self.requested, self.server.gpu.timer
        with timer.stage("render"):
            views, (size, guard) = self.eyes.views(head.pose), self._resolution(scale)
            frame = self.server.draw_frame(
                views,
                now_ns,
                size,
                guard,
                asked.needs,
                shown_size=asked.size,
                age_ns=asked.age_ns,
                pictures=bool(asked.pictures),
            )
        return attrs.evolve(frame, head=frame.head or head, drawing=timer.lap())

    def has_more(self, now_ns: int) -> bool:
        """Return whether the server has something to send even if nothing has moved."""
        return self.server.has_more(now_ns)

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        """Tell the server whether a frame arrived."""
        self.server.heard(frame, arrived, heard_ns)

    def recycle(self, frame: Frame) -> None:
        """Return the frame to the server's pools."""
        self.server.recycle(frame)

    def channel(self, setup: ChannelSetup) -> Channel:
        """Return a channel over the link."""
        return Channel(setup, self.recycle)

    def _resolution(self, scale: float) -> tuple[tuple[int, int], Guard]:
        """Return the size to draw in, without the guard band, and the guard band."""
        asked = self.requested
        if scale == 1:
            return asked.size, asked.guard
        return scaled_size(asked.size, scale), GuardBand.of(asked.guard).factors(asked.size)


def settling(frames: FrameSource, geometry: ClientScene) -> Settled:
    """Return what is done with a frame whose fate is known: both ends take note of it."""

    def settled(frame: Frame, arrived: bool, heard_ns: int) -> None:
        if arrived:
            geometry.receive(frame)
        frames.heard(frame, arrived, heard_ns)

    return settled
