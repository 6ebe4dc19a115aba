"""TUM RGB-D: colour and depth with clocks of their own, and a denser trajectory."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from ....errors import InputError, TraceError
from ....options.named_files import named_in
from ....poses import Origin, TraceOptions, load_trace
from ....poses.assumptions import AXES_BY, Assumption, By
from ..camera import Camera
from ..options import SequenceOptions
from ..recorded import AXES, CLOCK, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import VGA, Pair, SequenceReader, facts_of, for_size, intrinsics_fact, rows_of, scale_fact

COLOUR, DEPTH, TRAJECTORY, CALIBRATION = "rgb.txt", "depth.txt", "groundtruth.txt", "calibration.txt"
# What the authors advise for all sequences, whose depth is registered with it; those of freiburg3
# are undistorted already and have a camera of their own.
ADVISED = Camera(525.0, 525.0, 319.5, 239.5, VGA)
FREIBURG3 = Camera(535.4, 539.2, 320.1, 247.6, VGA)
_UNIT = 1 / 5000
_WITHIN_NS = 20_000_000  # of colour and depth of one frame, as the data set's own script has it
_WORLD = "x,z,y"


@readers.register
class TumReader(SequenceReader):
    """TUM RGB-D sequences, and those of ETH3D SLAM, which state their camera.

    Source: Sturm et al. 2012, A benchmark for the evaluation of RGB-D SLAM systems (the data set's
    file formats page: depth / 5000, cameras, associations within 20 ms); Schöps et al. 2019, BAD
    SLAM (its documentation: calibration.txt, depth / 5000).
    """

    name = "tum"
    summary = f"TUM RGB-D: {COLOUR}, {DEPTH}, {TRAJECTORY} and the pictures that they name"
    assumes = (
        intrinsics_fact(ADVISED, By.NOBODY),
        for_size(scale_fact(_UNIT, By.NOBODY), VGA),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        Assumption(AXES, "x right, y down, z forward, in a world of z up", By.FORMAT),
        Assumption(POSE, "world from camera, x y z qx qy qz qw", By.FORMAT),
        Assumption(CLOCK, "seconds in the lists of pictures", By.FILE),
    )

    def fits(self, path: Path) -> int:
        return 95 if all((path / name).exists() for name in (COLOUR, DEPTH, TRAJECTORY)) else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        name, own = path.resolve().name, _calibration(path)
        advised = FREIBURG3 if "freiburg3" in name else ADVISED
        by = By.FORMAT if own or "freiburg" in name else By.NOBODY
        only_for = None if own else VGA
        facts = facts_of(path, options, advised, _UNIT, own=own, by=by, only_for=only_for)
        axes = facts.axes(_WORLD)
        try:
            trace = load_trace(path / TRAJECTORY, TraceOptions(format="tum", axes=axes.words()))
        except TraceError as error:
            raise InputError(str(error)) from error
        track, pairs, lost = trace.track, [], 0
        for time_ns, colour, depth in _associated(_listed(path / COLOUR), _listed(path / DEPTH)):
            sample = track.at(time_ns - track.epoch_ns)
            if sample.origin is Origin.HELD:
                lost += 1
            else:
                pairs.append(Pair(named_in(path, colour), named_in(path, depth), sample.time_ns, sample.pose))
        # Axes are the layout's, and no option changes them.
        by_layout = (str(defect).replace(AXES_BY[By.USER], AXES_BY[By.FORMAT]) for defect in trace.defects)
        notes = [note.replace("--axes '", "axes '") for note in by_layout]
        if facts.camera is ADVISED and re.search("freiburg[12]", name):
            notes.append(
                "The lens of this camera distorts a little; the intrinsics that its authors advise leave it in."
            )
        if lost:
            notes.append(f"{lost} frames were left out: {TRAJECTORY} has no pose at their instants.")
        return self.sequence_of(path, pairs, facts, track=track, notes=notes)


def _calibration(path: Path) -> Camera | None:
    """Return the camera of ETH3D's file of fx fy cx cy; None without one. Errors: InputError."""
    file = path / CALIBRATION
    if not file.exists():
        return None
    rows = rows_of(file)
    if len(rows) != 1:
        raise InputError(f"{file}: {len(rows)} lines; expected one of fx fy cx cy")
    fx, fy, cx, cy = rows[0].floats(4)
    return Camera(fx, fy, cx, cy)


def _listed(path: Path) -> list[tuple[int, str]]:
    """Return instant and file of each line, by instant. Errors: InputError."""
    found = []
    for row in rows_of(path):
        try:
            time_ns = int(Decimal(row.words[0]) * 10**9)
        except (InvalidOperation, ValueError, OverflowError):
            time_ns = None
        if time_ns is None or len(row.words) != 2:
            raise row.wrong("seconds and the name of a file")
        found.append((time_ns, row.words[1]))
    return sorted(found)


def _associated(colours: list[tuple[int, str]], depths: list[tuple[int, str]]) -> list[tuple[int, str, str]]:
    """Return the instant of each colour picture, its file, and that of the depth nearest to it."""
    if not depths:
        return []
    times = np.array([time_ns for time_ns, _ in depths])
    found = []
    for time_ns, colour in colours:
        nearest = int(np.abs(times - time_ns).argmin())
        if abs(int(times[nearest]) - time_ns) <= _WITHIN_NS:
            found.append((time_ns, colour, depths[nearest][1]))
    return found
