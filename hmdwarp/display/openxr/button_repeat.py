"""Turn the state of buttons and sticks into requests: one a press, repeated while held."""

from __future__ import annotations

from collections.abc import Mapping

PUSHED, LET_GO = 0.6, 0.4  # of a stick's travel: hysteresis, so that a trembling hand does not repeat
FIRST_NS, NEXT_NS = 450_000_000, 120_000_000  # delay until a held direction repeats, and its interval: as on keyboards
DIRECTIONS = {"left": ("across", -1), "right": ("across", 1), "up": ("along", 1), "down": ("along", -1)}
PAD = "pad_"  # prefix of an axis that counts only while the pad is pressed


class ButtonRepeat:
    """Buttons and sticks of one user. One that is down at the start counts after its release."""

    def __init__(self) -> None:
        # When each held button repeats; None for never.
        self._down: dict[str, int | None] = {}
        self._synced = False  # whether step() was called since the last pause

    def forget(self) -> None:
        """Forget held buttons: a press during a pause was not meant for this program."""
        self._down.clear()
        self._synced = False

    def step(self, buttons: Mapping[str, bool], axes: Mapping[str, float], now_ns: int) -> list[str]:
        """Return the names of the requests: "left", "right", "up", "down", "confirm", "menu"."""
        requests = []
        for name in ("left", "right", "up", "down", "confirm", "menu"):
            if not self._held(name, buttons, axes):
                self._down.pop(name, None)
            elif name not in self._down:
                self._down[name] = now_ns + FIRST_NS if self._synced and name in DIRECTIONS else None
                requests += [name] if self._synced else []
            elif self._repeats(name, now_ns):
                requests.append(name)
        self._synced = True
        return requests

    def _repeats(self, name: str, now_ns: int) -> bool:
        due = self._down[name]
        if due is None or now_ns < due:
            return False
        self._down[name] = now_ns + NEXT_NS  # not due + NEXT_NS: one step after a stall, not many at once
        return True

    def _held(self, name: str, buttons: Mapping[str, bool], axes: Mapping[str, float]) -> bool:
        if buttons.get(name, False):
            return True
        if name not in DIRECTIONS:
            return False
        axis, sign = DIRECTIONS[name]
        pushed = sign * axes.get(axis, 0.0)
        if buttons.get("pad", False):
            pushed = max(pushed, sign * axes.get(PAD + axis, 0.0))
        least = LET_GO if name in self._down else PUSHED
        across_it = max(abs(axes.get(other, 0.0)) for other in ("across", "along") if other != axis)
        return pushed >= least and (name in self._down or pushed >= across_it)
