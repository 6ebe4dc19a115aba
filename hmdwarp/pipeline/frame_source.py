"""Where the frames of a loop come from: the server, or what stands between it and the loop."""

from __future__ import annotations

from typing import Protocol

import attrs

from ..client.client_scene import ClientScene
from ..frames import Frame
from ..geometry import Eyes, Guard, GuardBand
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link import scaled_size
from ..poses import PoseSample
from ..sources.server import Renderer
from .channel import Channel, ChannelSetup, Settled
from .requested import PoseRequest


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
