"""How head traces of many layouts are read: files with known truth, a table for docs/traces.md.

Each layout is written from the recording `walk`: which way the person looked and which way was up
is known. `layouts.toml` has them.
"""

from __future__ import annotations

import tempfile
import textwrap
import tomllib
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from hmdwarp.base import HmdwarpError
from hmdwarp.poses import LoadedTrace, PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.reading.axes import parse_axes

EPOCH_NS = 1_700_000_000 * 10**9
RIGHT, OPTION, REFUSED, WRONG = "right by itself", "warned, with the option", "refused, with the option", "wrong"


@attrs.frozen(kw_only=True)
class Layout:
    """A kind of file: its axes, how a pose is written, and what a user has to state."""

    name: str
    row: str  # of one pose; see `written`
    axes: str = "openxr"
    header: str = ""
    join: str = "\n"
    end: str = ""
    stated: dict[str, Any] = attrs.field(factory=dict)  # fields of TraceOptions; most need one
    # What says so: documents of the data set or of its maker, and for the plain ones of OpenXR.
    proof: str = "OpenXR 1.1, 2.16"


_TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
LAYOUTS = [Layout(name=name, **said) for name, said in _TABLE.items()]


def written(layout: Layout, truth: PoseTrack, folder: Path) -> Path:
    """Write a file of the layout that holds `truth`."""
    axes, rows = parse_axes(layout.axes), []
    turned = axes.world.T @ Rotation.from_quat(truth.orientation_xyzw).as_matrix() @ axes.head
    turns, places = Rotation.from_matrix(turned), truth.position_m @ axes.world
    needed = "{angles" in layout.row  # some heads have none: gimbal lock
    angles = turns.as_euler("zxy", degrees=True).tolist() if needed else [()] * len(truth)
    numbers = (truth.time_ns, places, turns.as_quat(), turned.reshape(-1, 9))
    for (ns, p, q, m), zxy in zip(zip(*(each.tolist() for each in numbers), strict=True), angles, strict=True):
        stamps = {"s": f"{ns // 10**9}.{ns % 10**9:09d}", "ms": ns / 1e6, "ns": ns, "late_ns": ns + 90_000}
        stamps |= {"us": [(ns + late) // 1000 for late in (0, 90_000)], "unix_ns": EPOCH_NS + ns}
        stamps |= {"unix": divmod(EPOCH_NS + ns, 10**9), "m": m, "angles": zxy, "cm": [100 * metres for metres in p]}
        named = dict(zip(("x", "y", "z", "qx", "qy", "qz", "qw"), (*p, *q), strict=True))
        rows.append(layout.row.format(**stamps, **named))
    text = f"{layout.header}\n".lstrip("\n") + layout.join.join(rows) + f"{layout.end}\n"
    path = folder / "head.csv"
    path.write_text(text, encoding="utf-8")
    return path


def is_truth(loaded: LoadedTrace, truth: PoseTrack) -> bool:
    """Return whether the head is where it was and looks where it looked.

    Files hold every digit of a float64 (2e-16); a matrix, Euler angles in degrees or a change of
    axes cost a few of them, and the angle of a turn near zero has the square root of that, 1e-7.
    Aria's clock is in whole microseconds, so a stamp is off by up to 1000 ns, a difference by twice
    that.
    """
    track = loaded.track
    if len(track) != len(truth):
        return False
    turn = Rotation.from_quat(track.orientation_xyzw).inv() * Rotation.from_quat(truth.orientation_xyzw)
    apart = float(np.abs(track.position_m - truth.position_m).max())
    late = int(np.abs((track.time_ns - truth.time_ns) - (track.time_ns[0] - truth.time_ns[0])).max())
    return apart < 1e-6 and float(turn.magnitude().max()) < 1e-6 and late <= 2000


def verdict(layout: Layout, truth: PoseTrack, folder: Path) -> tuple[str, str]:
    """Return how a file of the layout is read, and the options that a user needs, in words."""
    path = written(layout, truth, folder)
    stated: dict[str, Any] = {}
    outcome = RIGHT
    for _ in range(1 + len(layout.stated)):
        try:
            loaded = load_trace(path, TraceOptions(**stated))
        except HmdwarpError as error:
            said, failed = str(error), REFUSED
        else:
            if is_truth(loaded, truth):
                return outcome, " ".join(f"`{_flag(name)} {value}`" for name, value in stated.items())
            said = " ".join(str(d) for d in loaded.defects if d.kind.endswith(("contradicted", "implausible", "tilt")))
            failed = OPTION
        named = next((name for name in layout.stated if name not in stated and _flag(name) in said), None)
        if named is None:
            return WRONG, ""
        outcome = REFUSED if REFUSED in (outcome, failed) else OPTION
        stated[named] = layout.stated[named]
    return WRONG, ""


def _flag(name: str) -> str:
    return "--trace-rate" if name == "rate" else "--" + name.replace("_", "-")


def layouts_table() -> str:
    """Return the list of docs/traces.md."""
    truth = load_trace("walk").track
    with tempfile.TemporaryDirectory() as folder:
        rows = [(layout, *verdict(layout, truth, Path(folder))) for layout in LAYOUTS]
    return "\n".join(line(*row) for row in rows)


def line(layout: Layout, outcome: str, options: str) -> str:
    return f"- {layout.name} ({layout.proof}): {outcome} {options}".rstrip()


def contradicted_text() -> str:
    """Return what is said of a TUM RGB-D file that is read as it comes, for docs/traces.md."""
    layout = next(layout for layout in LAYOUTS if layout.name.startswith("TUM RGB-D"))
    with tempfile.TemporaryDirectory() as folder:
        loaded = load_trace(written(layout, load_trace("walk").track, Path(folder)))
    said = next(str(defect) for defect in loaded.defects if defect.kind == "axes-contradicted")
    return "\n".join(["```text", *textwrap.wrap(said, 96), "```"])


if __name__ == "__main__":
    print(layouts_table())
