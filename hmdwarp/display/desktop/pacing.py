"""When the next picture will be seen, on a screen that may change."""

from __future__ import annotations

from collections import deque
from statistics import median

_REMEMBERED = 16  # refreshes; a change of scene or size is forgotten after a quarter of a second
UNSYNCED = 8  # consecutive pictures faster than the screen, after which vsync counts as off
_TOO_FAST = 0.7  # of a period


class Pacer:
    """Estimate display times from when pictures were begun and when their swaps returned.

    All times in ns on one clock. waits: whether the driver should wait for the screen (vsync).
    Where it does not (software drivers, a user's setting), `paced` turns true and the caller waits
    until `due` instead; otherwise a window would make pictures that are never visible.
    """

    def __init__(self, rate_hz: float, waits: bool) -> None:
        self._expected_ns = 0
        self._intervals: deque[int] = deque(maxlen=_REMEMBERED)
        self._works: deque[int] = deque(maxlen=_REMEMBERED)
        self.set(rate_hz, waits)

    def set(self, rate_hz: float, waits: bool) -> None:
        """Use another screen or setting."""
        self.rate_hz = rate_hz
        self.period_ns = round(1e9 / self.rate_hz)
        self.waits = waits
        self.paced = False
        self._too_fast = 0
        self.pause()

    def pause(self) -> None:
        """Note a deliberate pause: no refresh was missed, and earlier durations are void."""
        self._last_ns: int | None = None
        self._missed = 0
        self._intervals.clear()
        self._works.clear()

    def swapped(self, begun_ns: int, back_ns: int) -> None:
        """Note the swap of a picture begun at `begun_ns`; the swap returned at `back_ns`."""
        self._works.append(back_ns - begun_ns)
        if self._last_ns is not None:
            interval = back_ns - self._last_ns
            self._intervals.append(interval)
            self._missed += max(0, round(interval / self.period_ns) - 1)
            if self.waits and not self.paced:
                self._too_fast = self._too_fast + 1 if interval < _TOO_FAST * self.period_ns else 0
                self.paced = self._too_fast >= UNSYNCED
        self._last_ns = back_ns

    def due(self, now_ns: int) -> int:
        """Return when to begin the next picture: now, unless we pace in place of the driver."""
        if not self.paced or self._last_ns is None:
            return now_ns
        work = int(median(self._works))
        return max(now_ns, self._last_ns + self.period_ns - work)

    def expect(self, now_ns: int) -> int:
        """Return when a picture begun now will be seen; call once for each.

        Pictures keep their order.

        With a driver that waits: at the swap that follows the last one by as many whole periods as
        a picture takes. Otherwise: when it is done, plus half a period, the screen's mean time to
        the middle of the picture.
        """
        work = int(median(self._works)) if self._works else 0
        guess = now_ns + work + self.period_ns // 2
        if self.waits and not self.paced and self._last_ns is not None and self._intervals:
            periods = max(1, round(median(self._intervals) / self.period_ns))
            at = self._last_ns + periods * self.period_ns
            late = max(0, now_ns - at)
            guess = at + -(-late // self.period_ns) * self.period_ns
        self._expected_ns = max(guess, self._expected_ns + 1)
        return self._expected_ns

    def missed(self) -> int:
        missed, self._missed = self._missed, 0
        return missed
