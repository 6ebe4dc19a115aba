"""Head motion as Motion-BIDS: samples as recorded, on a clock that begins with the first one.

Source: BIDS specification 1.9, "Motion"; Jeung et al. 2024, Motion-BIDS, Sci Data 11, 716.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from ...poses import PoseTrack
from ...run import DESKTOP, OPENXR

FRAME = "world"
# name, component, type, units: in the order of the columns of _motion.tsv.
CHANNELS = (
    ("latency", "n/a", "LATENCY", "s"),
    ("head_pos_x", "x", "POS", "m"),
    ("head_pos_y", "y", "POS", "m"),
    ("head_pos_z", "z", "POS", "m"),
    ("head_quat_x", "quat_x", "ORNT", "n/a"),
    ("head_quat_y", "quat_y", "ORNT", "n/a"),
    ("head_quat_z", "quat_z", "ORNT", "n/a"),
    ("head_quat_w", "quat_w", "ORNT", "n/a"),
)
_NO_CHANNELS = ("ACCEL", "ANGACCEL", "GYRO", "JNTANG", "MAGN", "MISC", "VEL")
_UNEVEN = 0.05  # of a median step: smaller deviations are the timer's


@attrs.frozen
class TrackingSystem:
    """What led the head of a showing."""

    label: str  # for tracksys-<label>
    name: str
    model: str = ""  # of the device, "" where there is none

    @classmethod
    def of(cls, facts: Mapping[str, Any]) -> TrackingSystem:
        """Read it from the facts of a session. The headset of a window is only emulated.

        A trace's file name stays private: it may name a person.
        """
        display = facts.get("display", {})
        if facts.get("trace"):
            axes = facts.get("trace_axes")
            return cls("trace", f"head trace, replayed{f'; its axes: {axes}' if axes else ''}")
        if facts.get("source") == OPENXR:
            model = display.get("headset", "")
            return cls("hmd", f"{model or 'headset'}, by OpenXR runtime {_runtime(display) or 'unknown'}", model)
        if facts.get("source") == DESKTOP:
            return cls("mouse", "mouse and keyboard of a desktop window")
        return cls("unknown", "not recorded")


@attrs.frozen
class Rates:
    """Sampling rates of a track."""

    nominal_hz: float  # one over the median step
    effective_hz: float  # steps over their duration
    uneven: float  # share of steps that differ from the median by more than a twentieth
    longest_s: float  # longest step

    @classmethod
    def of(cls, track: PoseTrack) -> Rates:
        """Compute the rates of a track of at least two samples."""
        steps = np.diff(track.time_ns)
        median = float(np.median(steps))
        off = np.abs(steps - median) > _UNEVEN * median
        return cls(1e9 / median, len(steps) * 1e9 / track.duration_ns, float(off.mean()), float(steps.max()) * 1e-9)

    def describe(self) -> str:
        """Describe how regular the samples are."""
        return (
            f"Samples are as recorded, not resampled: {self.uneven:.1%} of the steps differ by more than "
            f"{_UNEVEN:.0%} from the median, "
            f"the longest is {self.longest_s:.4f} s. The channel 'latency' holds the instant of each."
        )


def motion_text(track: PoseTrack) -> str:
    """Return the _motion.tsv: no header, a row for each sample, columns as CHANNELS.

    Seconds to the microsecond, as the specification writes them; positions and quaternions with
    every digit.
    """
    stream = io.StringIO()
    times = (track.time_ns - track.start_ns).tolist()
    for time_ns, position, orientation in zip(
        times, track.position_m.tolist(), track.orientation_xyzw.tolist(), strict=True
    ):
        whole, micro = divmod((time_ns + 500) // 1000, 1_000_000)
        stream.write("\t".join((f"{whole}.{micro:06d}", *map(repr, position), *map(repr, orientation))) + "\n")
    return stream.getvalue()


def motion_json(track: PoseTrack, task: Mapping[str, str], facts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sidecar.

    task: TaskName and other fields of the task. facts: of the session; only versions and what led
    the head are used.
    """
    rates, system = Rates.of(track), TrackingSystem.of(facts)
    return {
        **task,
        "SamplingFrequency": round(rates.nominal_hz, 6),
        "SamplingFrequencyEffective": round(rates.effective_hz, 6),
        "SamplingDescription": rates.describe(),
        "TrackingSystemName": system.name,
        "RecordingDuration": round(track.duration_ns * 1e-9, 6),
        "MotionChannelCount": len(CHANNELS),
        "LATENCYChannelCount": 1,
        "POSChannelCount": 3,
        "ORNTChannelCount": 4,
        **{f"{kind}ChannelCount": 0 for kind in _NO_CHANNELS},
        "TrackedPointsCount": 1,
        "MissingValues": "n/a",
        "SubjectArtefactDescription": "n/a",
        "Manufacturer": "n/a",
        "ManufacturersModelName": system.model or "n/a",
        "DeviceSerialNumber": "n/a",  # would identify the machine
        "SoftwareVersions": software(facts.get("hmdwarp", ""), facts.get("display", {})),
    }


def software(hmdwarp: str, display: Mapping[str, Any]) -> str:
    """Name the versions of hmdwarp and of the runtime, as far as known."""
    return ", ".join(filter(None, (f"hmdwarp {hmdwarp}".strip(), _runtime(display))))


def _runtime(display: Mapping[str, Any]) -> str:
    return " ".join(str(display[key]) for key in ("runtime", "runtime_version") if display.get(key))


def channels_text() -> str:
    """Return the _channels.tsv: one row for each column of _motion.tsv, in that order."""
    rows = ["name\tcomponent\ttype\ttracked_point\tunits\treference_frame"]
    rows += [
        f"{name}\t{component}\t{type_}\thead\t{units}\t{_frame(type_)}" for name, component, type_, units in CHANNELS
    ]
    return "\n".join(rows) + "\n"


def _frame(type_: str) -> str:
    return "n/a" if type_ == "LATENCY" else FRAME


def channels_json() -> dict[str, Any]:
    """Describe the reference frame."""
    text = (
        "world_from_head in the axes of OpenXR: +x right, +y up, +z backward, metres; the quaternion rotates from "
        "the head's axes to the world's. The origin is the display's own."
    )
    frame = {"SpatialAxes": "RSP", "RotationRule": "right-hand", "Description": text}
    return {"reference_frame": {"Description": "Axes of the channel", "Levels": {FRAME: frame}}}
