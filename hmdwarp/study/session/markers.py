"""Markers of a session as a stream of the Lab Streaming Layer (LSL), in the display's time.

LSL joins what several devices record (EEG, eye trackers, force plates) by stamps on one clock.
Source: Kothe et al. 2025, The lab streaming layer for synchronized multimodal recording, Imaging
Neuroscience 3.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from typing import Any

import attrs

from ...base import MachineError, import_extra

EXTRA = "lsl"
_TYPE = "Markers"  # of the stream, by which recorders know it
READINGS = 8  # of both clocks for each conversion; the closest counts
# For what is on its way when a session ends: the library drops it where the stream closes at once.
_LEAVING_S = 0.5


def load_lsl() -> Any:
    """Import pylsl. Errors: MachineError that says how to install it, or the library under it."""
    try:
        return import_extra("pylsl", "pylsl", EXTRA)
    except RuntimeError as error:  # its wheel holds the library for common systems only
        raise MachineError(
            "pylsl is installed and finds no liblsl: conda install -c conda-forge liblsl, or name the file in PYLSL_LIB"
        ) from error


@attrs.frozen
class _ClockReading:
    """Both clocks at one instant."""

    display_ns: int
    lsl_s: float
    error_s: float  # they were read at most this far apart

    @classmethod
    def of(cls, now_ns: Callable[[], int], local_clock: Callable[[], float]) -> _ClockReading:
        """Read LSL's clock between two readings of the display's, and keep the closest of some."""
        readings = []
        for _ in range(READINGS):
            before_ns, lsl_s, after_ns = now_ns(), local_clock(), now_ns()
            readings.append(cls((before_ns + after_ns) // 2, lsl_s, (after_ns - before_ns) / 2e9))
        return min(readings, key=lambda one: one.error_s)

    def lsl_time(self, at_ns: int) -> float:
        return self.lsl_s + (at_ns - self.display_ns) * 1e-9


class MarkerStream:
    """Stream of markers, each a JSON object with its `event`; one text channel, no fixed rate.

    A marker's stamp is the instant it happened, converted to LSL's clock; the clocks are compared
    anew for each, as they may drift. Sending takes some 20 us and never waits for a receiver.
    name: of the stream and its source, by which recorders find it again after a crash. about: facts
    for its description. is_simulated: whether the display's clock advances by refreshes alone: then
    it is compared once, and stamps are right beside each other only.
    """

    def __init__(
        self, name: str, about: Mapping[str, str], now_ns: Callable[[], int], *, is_simulated: bool = False
    ) -> None:
        self._lsl = load_lsl()
        self._now_ns = now_ns
        self.name = name
        self.error_s = 0.0  # of the conversion, the largest so far
        reading = self._read()
        self._fixed = reading if is_simulated else None
        info = self._lsl.StreamInfo(name, _TYPE, 1, self._lsl.IRREGULAR_RATE, self._lsl.cf_string, name)
        clock = "simulated" if is_simulated else "display"
        for key, value in {**about, "clock": clock, "clock_error_s": f"{self.error_s:.1e}"}.items():
            info.desc().append_child_value(key, value)
        self._outlet = self._lsl.StreamOutlet(info)

    @property
    def are_received(self) -> bool:
        """Whether any program receives them now; what was sent before is lost to it."""
        return bool(self._outlet.have_consumers())

    def describe(self) -> str:
        stream = f"markers go to LSL as stream '{self.name}'"
        if self._fixed is not None:
            return f"{stream}; the clock of this display is simulated: stamps do not fit those of other streams"
        return f"{stream}; the display's time is converted to LSL's within {self.error_s * 1e6:.1f} us"

    def send(self, event: str, at_ns: int, **data: object) -> None:
        reading = self._fixed or self._read()
        self._outlet.push_sample([json.dumps({"event": event, **data})], reading.lsl_time(at_ns))

    def close(self) -> None:
        """End the stream, once what is on its way has left."""
        if self.are_received:
            time.sleep(_LEAVING_S)
        del self._outlet

    def _read(self) -> _ClockReading:
        reading = _ClockReading.of(self._now_ns, self._lsl.local_clock)
        self.error_s = max(self.error_s, reading.error_s)
        return reading
