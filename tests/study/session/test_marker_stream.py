"""Markers in the Lab Streaming Layer, as a real inlet in another process receives them."""

from __future__ import annotations

import time

import pytest

from hmdwarp.study.session.markers import MarkerStream

from .lsl import lsl_on_this_machine, receiving, with_lsl  # noqa: F401

AHEAD_NS = 10**15  # of the display's clock; a double of so many seconds still tells 0.2 us apart
ROUNDING_S = 1e-8  # a double of the seconds that a machine is up: below 2^-53 of a year


@with_lsl
@pytest.mark.usefixtures("lsl_on_this_machine")
def test_stamps_are_the_instants_of_the_display_on_lsl_s_clock():
    """On Linux LSL's clock is CLOCK_MONOTONIC, so the stamps are known to the nanosecond.

    A clock of its own, another zero: each stamp is off by no more than the stream says.
    """

    def now_ns() -> int:
        return time.monotonic_ns() + AHEAD_NS

    with receiving("clocks", "end") as receiver:
        stream = MarkerStream("clocks", {"study": "none"}, now_ns)
        told, said = receiver.connected(), stream.describe()
        first_error_s = stream.error_s
        instants_ns = [now_ns() + ahead_ns for ahead_ns in (0, 30_000_000, -2_000_000_000)]
        while not stream.are_received:
            time.sleep(0.01)
        for number, at_ns in enumerate(instants_ns):
            stream.send("shown", at_ns, number=number)
        stream.send("end", now_ns())
        stream.close()
        markers = receiver.markers()
    assert [(marker["event"], marker.get("number")) for marker in markers] == [
        *(("shown", n) for n in range(3)),
        ("end", None),
    ]
    assert told["type"] == "Markers"
    assert "<study>none</study>" in told["xml"] and f"<clock_error_s>{first_error_s:.1e}</clock_error_s>" in told["xml"]
    assert f"within {first_error_s * 1e6:.1f} us" in said
    for marker, at_ns in zip(markers, instants_ns, strict=False):
        assert abs(marker["stamp"] - (at_ns - AHEAD_NS) * 1e-9) <= stream.error_s + ROUNDING_S
