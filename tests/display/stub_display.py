"""The least that a display does: a pattern for new ones, and the contract in code."""

from __future__ import annotations

from collections.abc import Sequence

from hmdwarp.display import Command, DisplayOptions, Label, Picture, Status, Tick
from hmdwarp.geometry import Pose
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.poses import Origin, PoseSample


class StubDisplay:
    """A display.Display that shows nothing and counts its ticks as time."""

    name = "stub"
    distorts = takes_depth = takes_panels = ""
    rate_hz = 50.0

    def __init__(self, options: DisplayOptions) -> None:
        self.eyes = self.headset = load_headset(options.headset)
        self.size = options.size or self.headset.eye_size_px
        self.gpu, self.source, self._at_ns = Gpu(), StubHead(self), 0
        self.about = {"display": "stub"}

    def now_ns(self) -> int:
        """As Display.now_ns."""
        return self._at_ns

    def wait(self) -> Tick | None:
        """As Display.wait."""
        period_ns = round(1e9 / self.rate_hz)
        self._at_ns += period_ns
        return Tick(self._at_ns + period_ns, period_ns)

    def show(self, refresh: Picture | None, label: Label = "") -> int:
        """As Display.show."""
        return self._at_ns

    def set_view(self, view: str) -> None:
        """As Display.look: it has one view."""

    def restart(self) -> None:
        """As Display.restart."""

    def commands(self) -> Sequence[Command]:
        """As Display.commands: it has no user."""
        return ()

    def show_status(self, status: Status) -> None:
        """As Display.tell: it shows no status."""

    def reopen(self) -> bool:
        """As Display.reopen: it is never lost."""
        return False

    def close(self) -> None:
        """As Display.close."""
        self.gpu.close()


class StubHead:
    """A head that stands still."""

    def __init__(self, display: StubDisplay) -> None:
        self._display = display

    def start(self) -> None:
        """As PoseSource.start."""

    def head_at(self, time_ns: int) -> PoseSample:
        """As PoseSource.head_at."""
        return PoseSample(time_ns, Pose((0.0, 1.6, 0.0)), Origin.HELD, self._display.now_ns())

    def close(self) -> None:
        """As PoseSource.close."""
