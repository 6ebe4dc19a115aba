"""When the next picture will be seen, told from when the last ones were."""

from __future__ import annotations

from collections import deque
from statistics import median

UNKNOWN_HZ = 60.0
REMEMBERED = 16  # refreshes; a change of scene or size is forgotten after a quarter of a second
DISOBEYED = 8  # pictures in a row that came faster than the screen before a driver is said not to wait for it
TOO_FAST = 0.7  # of a period


def known_rate(rate_hz: float) -> float:
    """What a screen says of its rate; 0 or less, where it does not say, is taken for 60."""
    return rate_hz if rate_hz > 0 else UNKNOWN_HZ


class Pacer:
    """Told when each picture was begun and when its swap had come back. All times in ns on one clock.

    waits: whether the driver is asked to wait for the screen (vsync). Where it is asked and does not (software drivers, a setting of the
    user's), `paced` turns true and whoever begins pictures waits until `due` instead: else a window would make pictures nobody sees.
    """

    def __init__(self, rate_hz: float, waits: bool) -> None:
        self._expected_ns = 0
        self._intervals: deque[int] = deque(maxlen=REMEMBERED)
        self._works: deque[int] = deque(maxlen=REMEMBERED)
        self.set(rate_hz, waits)

    def set(self, rate_hz: float, waits: bool) -> None:
        """Another screen, or other wishes. rate_hz: as known_rate takes it."""
        self.rate_hz = known_rate(rate_hz)
        self.period_ns = round(1e9 / self.rate_hz)
        self.waits = waits
        self.paced = False
        self._too_fast = 0
        self.pause()

    def pause(self) -> None:
        """Nothing was shown for a while, on purpose: no refresh was missed, and how long pictures took before says nothing."""
        self._last_ns: int | None = None
        self._missed = 0
        self._intervals.clear()
        self._works.clear()

    def swapped(self, begun_ns: int, back_ns: int) -> None:
        """A picture begun then is on its way to the screen: its swap, and what was drawn for it, was done at `back_ns`."""
        self._works.append(back_ns - begun_ns)
        if self._last_ns is not None:
            interval = back_ns - self._last_ns
            self._intervals.append(interval)
            self._missed += max(0, round(interval / self.period_ns) - 1)
            self._notice(interval)
        self._last_ns = back_ns

    def _notice(self, interval_ns: int) -> None:
        if self.waits and not self.paced:
            self._too_fast = self._too_fast + 1 if interval_ns < TOO_FAST * self.period_ns else 0
            self.paced = self._too_fast >= DISOBEYED

    def due(self, now_ns: int) -> int:
        """When to begin the next picture: now, unless the driver does not wait and we must."""
        if not self.paced or self._last_ns is None:
            return now_ns
        work = int(median(self._works))
        return max(now_ns, self._last_ns + self.period_ns - work)

    def expect(self, now_ns: int) -> int:
        """When a picture begun now will be seen; asked once for each. Later than the one before in any case: pictures keep their order.

        With a driver that waits: at the swap as many whole periods after the last one as pictures take. Else: when it is done, and half a
        period more, which is how long the screen takes to reach the middle of the picture on average.
        """
        self._expected_ns = max(self._guess(now_ns), self._expected_ns + 1)
        return self._expected_ns

    def _guess(self, now_ns: int) -> int:
        if self.waits and not self.paced and self._last_ns is not None and self._intervals:
            periods = max(1, round(median(self._intervals) / self.period_ns))
            at = self._last_ns + periods * self.period_ns
            late = max(0, now_ns - at)
            return at + -(-late // self.period_ns) * self.period_ns
        work = int(median(self._works)) if self._works else 0
        return now_ns + work + self.period_ns // 2

    def missed(self) -> int:
        """Refreshes that went by without a new picture since the last time this was asked."""
        missed, self._missed = self._missed, 0
        return missed
