"""Traces made for tests: a smooth head motion, and text files of it in any layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hmdwarp.base import InputError, UnknownNameError
from hmdwarp.poses import PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.formats import formats

WRITERS = [form.name for form in formats if form.writes]


def head(n: int = 200, rate_hz: float = 60.0) -> PoseTrack:
    """A head that turns, nods and moves smoothly; starts away from every default pose."""
    t = np.arange(n) / rate_hz
    angles = np.stack([0.5 + 0.8 * np.sin(t), 0.2 + 0.3 * np.sin(1.7 * t), 0.1 * np.sin(0.9 * t)], axis=1)
    place = np.stack([0.1 + 0.2 * np.sin(0.5 * t), 1.6 + 0.02 * np.sin(5 * t), -0.3 * np.cos(0.4 * t)], axis=1)
    return PoseTrack(
        np.rint(t * 1e9).astype(np.int64), place, Rotation.from_euler("YXZ", angles).as_quat(), name="test"
    )


def rows(track: PoseTrack, order: str = "xyzw", stamp=lambda ns: repr(ns / 1e9)) -> list[list[str]]:
    """Fields of each sample: time, position, quaternion in that order, every digit."""
    columns = ["xyzw".index(c) for c in order]
    return [
        [stamp(int(t)), *map(repr, p), *map(repr, q)]
        for t, p, q in zip(
            track.time_ns, track.position_m.tolist(), track.orientation_xyzw[:, columns].tolist(), strict=True
        )
    ]


def write(
    path: Path, table: list[list[str]], header: str = "time,x,y,z,qx,qy,qz,qw", separator: str = ",", end: str = "\n"
) -> Path:
    """A text file of that table."""
    lines = ([header] if header else []) + [separator.join(r) for r in table]
    path.write_bytes(("\n".join(lines) + end).encode())
    return path


def save(track: PoseTrack, path: Path, name: str) -> Path:
    """A file of that format."""
    target = formats.get(name)
    with path.open("w") as stream:
        target.write(track, stream)
    return path


def kinds(loaded) -> set[str]:
    """The kinds of defect that were found."""
    return {d.kind for d in loaded.defects}


def found(loaded, kind: str):
    """The one defect of that kind."""
    (defect,) = [d for d in loaded.defects if d.kind == kind]
    return defect


def refusal(path: Path | str, **options) -> str:
    """The one line with which a file is refused."""
    with pytest.raises(InputError) as error:
        load_trace(path, TraceOptions(**options))
    assert "\n" not in str(error.value)
    said = str(error.value)
    # A name that no registry holds, or an option whose text is wrong, is no fault of the file.
    assert str(path) in said or said.startswith("--") or isinstance(error.value, UnknownNameError)
    return said


def matrices(track: PoseTrack) -> np.ndarray:
    """World-from-head matrices, (n, 4, 4)."""
    out = np.tile(np.eye(4), (len(track), 1, 1))
    out[:, :3, :3] = Rotation.from_quat(track.orientation_xyzw).as_matrix()
    out[:, :3, 3] = track.position_m
    return out


def same_motion(a: PoseTrack, b: PoseTrack, atol: float = 1e-12) -> bool:
    """Same instants, same poses within atol (metres, radians), signs of quaternions aside."""
    if not np.array_equal(a.time_ns, b.time_ns):
        return False
    angle = (Rotation.from_quat(a.orientation_xyzw).inv() * Rotation.from_quat(b.orientation_xyzw)).magnitude()
    return bool(np.abs(a.position_m - b.position_m).max() <= atol and angle.max() <= atol)


unit_quaternions = (
    st.lists(st.floats(-1, 1), min_size=4, max_size=4)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: np.array(q) / np.linalg.norm(q))
)
