"""The resolution that a server chooses where it, its link or its client cannot keep up."""

from __future__ import annotations

import math

import attrs

# Of the full resolution, along each axis: 1, 0.64, 0.42 and 0.25 of its pixels.
SCALES = (1.0, 0.8, 0.65, 0.5)
# After so long without a wait it is tried higher; longer after each attempt that failed.
_PATIENCE_NS, _MOST_PATIENCE_NS = 1_000_000_000, 16_000_000_000
# The slowest stage may take this share of a period at the higher resolution.
_ROOM = 0.8


@attrs.define
class Overload:
    """Lower the resolution as soon as a frame has to wait for the one before, and raise it later.

    Down: one step when a frame waits for longer than a period (or half the longest queue, if that
    is less), so before frames are dropped, or when the server is still busy at an instant. What
    already waits gets the time to leave before the next step, unless the wait grows on.

    Up: one step after a second without a wait, if the slowest stage is expected to have room for
    more pixels. After each step up that had to be taken back the patience doubles, to 16 s at most.

    period_ns: of the server. queue_ns: the longest wait at the bottleneck.
    """

    period_ns: int
    queue_ns: int
    changes: int = attrs.field(default=0, init=False)
    _level: int = attrs.field(default=0, init=False)
    # No step down before this instant, unless frames wait for longer than this.
    _settled_ns: int | None = attrs.field(default=None, init=False)
    _waited_ns: int = attrs.field(default=0, init=False)
    # Since when nothing has waited, and when it was last raised.
    _clear_ns: int | None = attrs.field(default=None, init=False)
    _raised_ns: int | None = attrs.field(default=None, init=False)
    _patience_ns: int = attrs.field(default=_PATIENCE_NS, init=False)

    @property
    def scale(self) -> float:
        """The share of the full width and height that the next frame has."""
        return SCALES[self._level]

    def busy(self, now_ns: int, free_ns: int) -> None:
        """Note that the server could not draw at this instant, and when it can again."""
        self._lower(now_ns, free_ns - now_ns)

    def sent(self, now_ns: int, waits_ns: int, slowest_ns: int) -> None:
        """Note how long a frame of the present scale waits, and the time of its slowest stage."""
        if waits_ns > min(self.period_ns, self.queue_ns // 2):
            self._lower(now_ns, waits_ns)
        elif waits_ns:
            self._clear_ns = None
        elif self._clear_ns is None:
            self._clear_ns = now_ns
        elif now_ns - self._clear_ns >= self._patience_ns and self._has_room(slowest_ns):
            self._raised_ns = self._clear_ns = now_ns
            self._go(self._level - 1)

    def _lower(self, now_ns: int, waits_ns: int) -> None:
        self._clear_ns = None
        is_settling = self._settled_ns is not None and now_ns < self._settled_ns
        if self._level + 1 == len(SCALES) or (is_settling and waits_ns <= self._waited_ns):
            return
        if self._raised_ns is not None and now_ns - self._raised_ns < self._patience_ns:
            self._patience_ns = min(2 * self._patience_ns, _MOST_PATIENCE_NS)
        self._raised_ns = None
        self._settled_ns, self._waited_ns = now_ns + waits_ns + self.period_ns, waits_ns
        self._go(self._level + 1)

    def _has_room(self, slowest_ns: int) -> bool:
        if not self._level:
            return False
        grown = SCALES[self._level - 1] / self.scale
        return slowest_ns * grown * grown <= _ROOM * self.period_ns

    def _go(self, level: int) -> None:
        self._level, self.changes = level, self.changes + 1


def scaled_size(size: tuple[int, int], scale: float) -> tuple[int, int]:
    """Return (w, h) at a scale, at least one pixel each."""
    return max(1, math.floor(size[0] * scale + 0.5)), max(1, math.floor(size[1] * scale + 0.5))
