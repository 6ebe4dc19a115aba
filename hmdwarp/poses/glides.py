"""Heads that move in one way only, there and back: along a line, or about the upright axis.

A way out and a way back take equal times and follow each other without a pause. Each begins and
ends at rest: the speed grows along a minimum-jerk profile for `EASE_S`, stays, and falls the same
way. So the head never goes farther than the amplitude, nor faster than the speed.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Array = NDArray[np.float64]

_LEAST = 1e-3  # of speed and amplitude
EASE_S = 0.2  # 0.5 m/s is reached at 4.7 m/s2 at most, as a person sets off
# `room`, the largest shipped scene, can be walked in to 1.6 m from where a head begins.
_MOST = {"m": (5.0, 1.5), "degrees": (720.0, 360.0)}


@attrs.frozen
class Glide:
    """A motion there and back.

    Errors of `with_`: InputError for a speed or amplitude out of range.
    """

    speed: float  # at most, in `unit` per second
    amplitude: float  # distance of the turning point from the start, in `unit`
    direction: tuple[float, float, float] | None  # of the way out, as a unit vector; None turns to the left

    @property
    def unit(self) -> str:
        """Return what the amplitude counts: m or degrees."""
        return "degrees" if self.direction is None else "m"

    def with_(self, speed: float | None, amplitude: float | None) -> Glide:
        """Return it with another speed or amplitude; None keeps its own."""
        most_speed, most_amplitude = _MOST[self.unit]
        for name, value, most, per in (
            ("speed", speed, most_speed, " per second"),
            ("amplitude", amplitude, most_amplitude, ""),
        ):
            if value is not None and not _LEAST <= value <= most:
                raise InputError(f"{name} {value:g} {self.unit}{per}: expected {_LEAST:g} to {most:g}")
        changes: dict[str, Any] = {"speed": speed, "amplitude": amplitude}
        return attrs.evolve(self, **{name: value for name, value in changes.items() if value is not None})

    @property
    def ease_s(self) -> float:
        """Return how long it takes to reach the speed: EASE_S, less for a short way."""
        return min(EASE_S, self.amplitude / self.speed)

    @property
    def steady_s(self) -> tuple[float, float]:
        """Return the seconds between which the first way out has its full speed."""
        return self.ease_s, self.amplitude / self.speed

    def way(self, t: Array) -> Array:
        """Return the distance from the start at the seconds t: 0 to the amplitude and back."""
        leg_s = self.amplitude / self.speed + self.ease_s
        phase = np.mod(t, 2 * leg_s)
        out_s = np.minimum(phase, 2 * leg_s - phase)
        return self.speed * (self._eased(out_s) - self._eased(out_s - self.amplitude / self.speed))

    def _eased(self, t: Array) -> Array:
        """Return the integral of a minimum-jerk step from 0 to 1 that begins at 0."""
        s = np.clip(t / self.ease_s, 0.0, 1.0)
        return self.ease_s * (s**4 * (2.5 + s * (s - 3.0))) + np.maximum(t - self.ease_s, 0.0)

    def place(self, t: Array) -> Array:
        """Return (n, 3) metres from the start; zeros for a head that turns."""
        return np.outer(self.way(t), self.direction or (0.0, 0.0, 0.0))

    def yaw(self, t: Array) -> Array:
        """Return (n,) degrees to the left; zeros for a head that does not turn."""
        return self.way(t) if self.direction is None else np.zeros_like(t)


FORWARD = Glide(0.5, 0.8, (0.0, 0.0, -1.0))
BACKWARD = Glide(0.5, 0.8, (0.0, 0.0, 1.0))
SIDEWAYS = Glide(0.5, 0.8, (1.0, 0.0, 0.0))
ROTATE = Glide(60.0, 180.0, None)
