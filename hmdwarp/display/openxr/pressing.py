"""From the state of buttons and sticks to requests.

At a press, and repeated while a direction is held.
"""

from __future__ import annotations

from collections.abc import Mapping

PUSHED, LET_GO = 0.6, 0.4  # of a stick's way: a hand that trembles at the one does not reach the other
FIRST_NS, NEXT_NS = 450_000_000, 120_000_000  # until a held direction goes on, and between its steps: as keyboards do
DIRECTIONS = {"left": ("across", -1), "right": ("across", 1), "up": ("along", 1), "down": ("along", -1)}
PAD = "pad_"  # before the name of an axis that counts only while the pad is pressed


class Pressing:
    """State of one pair of hands. A button that is down at first counts once it was released."""

    def __init__(self) -> None:
        self._down: dict[
            str, int | None
        ] = {}  # since then it is held and goes on at that instant; None: not before it was let go
        self._heard = False

    def forget(self) -> None:
        """Forget what is held: after a pause, it was not pressed for us."""
        self._down.clear()
        self._heard = False

    def step(self, buttons: Mapping[str, bool], axes: Mapping[str, float], now_ns: int) -> list[str]:
        """Return the names of the requests: "left", "right", "up", "down", "confirm", "menu"."""
        asked = []
        for name in ("left", "right", "up", "down", "confirm", "menu"):
            if not self._held(name, buttons, axes):
                self._down.pop(name, None)
            elif name not in self._down:
                self._down[name] = now_ns + FIRST_NS if self._heard and name in DIRECTIONS else None
                asked += [name] if self._heard else []
            elif self._goes_on(name, now_ns):
                asked.append(name)
        self._heard = True
        return asked

    def _goes_on(self, name: str, now_ns: int) -> bool:
        due = self._down[name]
        if due is None or now_ns < due:
            return False
        self._down[name] = now_ns + NEXT_NS  # not due + NEXT_NS: after a stall one step, not many at once
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
