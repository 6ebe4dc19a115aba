"""The real head traces used in development.

What each is known to hold, and conventions proved on gestures and a twin file.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.base import resources
from hmdwarp.poses import KINDS, analyse, load_trace

from .traces import kinds

# file: format, rows kept, rate, whole seconds, defects
EYES = "eye-position devices-interleaved "
KNOWN = {
    "eyenavgs_rutgers/user102_london.csv": (
        *("eyenavgs", 5414, 71, 75),
        EYES + "clock-restart repeated-pose gaze-lost",
    ),
    "eyenavgs_rutgers/user119_train.csv": ("eyenavgs", 4891, 71, 68, EYES + "repeated-pose"),
    "eyenavgs_nthu/user19_drjohnson.csv": ("eyenavgs", 2005, 36, 59, EYES + "tilt"),
    "multiviewpoint_mmsys18/user1_quaternion.txt": (
        *("multiviewpoint", 16053, 59, 272),
        "no-position sign-flip repeated-pose gap",
    ),
    "questset_sample/sample_movement_data.csv": ("questset", 7942, 60, 132, "repeated-pose"),
}


@pytest.mark.parametrize("name", KNOWN)
def test_each_real_file_reads_as_known(real_traces, name):
    format_name, count, rate, seconds, defects = KNOWN[name]
    loaded = load_trace(real_traces / name)
    assert loaded.format == format_name
    assert len(loaded.track) == count
    assert round(loaded.track.rate_hz) == rate
    assert loaded.track.duration_ns // 10**9 == seconds
    assert kinds(loaded) == set(defects.split())


# Seconds and where the extremum of each gesture lies, from the data set's own description of its
# known gestures.
GESTURES = {
    "step back": (11, "z", 1), "step forward": (15, "z", -1), "step left": (25, "x", -1), "step right": (36, "x", 1),
    "crouch": (51, "y", -1), "look down": (67, "pitch", -49), "look up": (76, "pitch", 62),
    "look left": (86, "yaw", 67), "look right": (98, "yaw", -75), "tilt left": (104, "roll", 56),
    "tilt right": (115, "roll", -57),
}  # fmt: skip


@pytest.mark.parametrize("gesture", GESTURES)
def test_known_gestures_prove_the_axes(real_traces, gesture):
    second, what, wanted = GESTURES[gesture]
    track = load_trace(real_traces / "questset_sample" / "sample_movement_data.csv").track
    near = np.abs(track.time_ns / 1e9 - second) < 2
    if what in "xyz":
        moved = track.position_m[near, "xyz".index(what)] - np.median(track.position_m[:, "xyz".index(what)])
        assert max(moved * wanted) > 0.2
        return
    angles = Rotation.from_quat(track.orientation_xyzw).as_euler("YXZ", degrees=True)[
        :, ["yaw", "pitch", "roll"].index(what)
    ]
    # The published angles count from how the head was held between gestures: nose 8 degrees down.
    moved = (angles - np.median(angles))[near]
    assert abs(moved[np.argmax(moved * np.sign(wanted))] - wanted) < 2


def test_shipped_people_are_described_level_and_licensed():
    """Each is 20 to 40 s long and small, says where it comes from, and looks ahead first."""
    folder = resources.folder("recordings")
    people = [name for name in resources.recording_names() if name not in KINDS]
    assert len(people) >= 6
    page, licences = ((folder / name).read_text(encoding="utf-8") for name in ("README.md", "LICENCES.md"))
    for name in people:
        path, loaded = folder / f"{name}.csv", load_trace(name)
        track, figures = loaded.track, analyse(loaded.track, latencies_ms=())
        turning = " / ".join(f"{speed:.1f}" for speed in [*figures["angular_speed_deg_s"].values()][:3])
        moving = " / ".join(f"{figures['linear_speed_m_s'][place]:.2f}" for place in ("p50", "p99"))
        what = track.origin.rpartition("; ")[2]
        assert f"| `{name}` | " in page and f"| {what} | {loaded.track.rate_hz:.0f} | {turning} | {moving} |" in page
        assert 20 <= track.duration_ns * 1e-9 <= 40.1 and path.stat().st_size < 300_000
        head = path.read_text(encoding="utf-8").split("time_ns")[0]
        assert all(f"# {fact}: " in head for fact in ("origin", "axes", "device", "licence", "changed"))
        assert f"`{name}`" in licences or f"`-{name.rpartition('-')[2]}`" in licences
        assert {defect.kind for defect in loaded.defects} <= {"repeated-pose"}
        turned = Rotation.from_quat(track.orientation_xyzw)
        ahead = turned[0].apply([0, 0, -1])
        assert abs(ahead[0]) < 1e-3 and ahead[2] < 0
        assert turned.apply([0, 1, 0])[:, 1].mean() > 0.8, "upright"
        assert np.abs(track.position_m.mean(axis=0)[1] - 1.6) < 1e-3
