"""The few older frames that some warps read."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..frames import Frame


class History:
    """Keep up to `keep` older frames, at least `spacing_ns` apart.

    All others go to `discard` at once.
    """

    def __init__(self, keep: int, spacing_ns: int, discard: Callable[[Frame], None]) -> None:
        self._keep, self._spacing_ns, self._discard = keep, spacing_ns, discard
        self._held: deque[Frame] = deque()

    @property
    def frames(self) -> tuple[Frame, ...]:
        """The frames kept, newest first."""
        return tuple(self._held)

    def offer(self, frame: Frame) -> None:
        """Take a frame that a newer one has replaced."""
        if self._keep == 0 or (self._held and frame.drawn_ns - self._held[0].drawn_ns < self._spacing_ns):
            self._discard(frame)
            return
        self._held.appendleft(frame)
        if len(self._held) > self._keep:
            self._discard(self._held.pop())

    def close(self) -> None:
        """Pass all kept frames to `discard`."""
        while self._held:
            self._discard(self._held.pop())
