"""Folders of colour and depth with a head trace in any format that is read."""

from __future__ import annotations

from decimal import Decimal, InvalidOperation
from pathlib import Path

import attrs

from ....errors import InputError, TraceError
from ....poses import Origin, TraceOptions, load_trace
from ....poses.assumptions import Assumption, By
from ....poses.load import find_format
from ....poses.reading.cleaning import LoadedTrace
from ....poses.reading.file_head import read_head
from ..camera import Camera, camera_of, read_json
from ..options import RATE_HZ, SequenceOptions
from ..picture_files import read_depth
from ..recorded import AXES, CLOCK, DEPTH_SCALE, INTRINSICS, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import CAMERA, OPTICAL, Pair, SequenceReader, at_rate, facts_of, folder_named, paired, rows_of
from ._dataset import clock_of, left_out

_COLOURS = ("color", "colour", "rgb", "images", "image")
_DEPTHS = ("depth", "depths", "depth_maps")
_TRACES = (".csv", ".txt", ".tum", ".tsv", ".json", ".jsonl", ".log", ".mcap", ".bag", ".db3")
_NAMES = ("trajectory", "traj", "trace", "groundtruth", "odometry", "poses", "pose", "camera_poses", "images")
_INTRINSICS = (
    "intrinsics.json",
    "camera_intrinsic.json",
    "camera_intrinsics.json",
    "camera_info.json",
    "intrinsic.json",
)
_MATRICES = ("intrinsics.txt", "intrinsic.txt", "camera_matrix.txt", "camera_matrix.csv", "K.txt")
_WHOLE = {"ns": 1, "us": 10**3, "ms": 10**6}
_UNITS = {"s": 10**9, **_WHOLE}
_COVERED = 0.05  # of the trace, at least
_AXES_OPTION = "--frames-axes"


@readers.register
class TracedReader(SequenceReader):
    """Pictures whose names are instants on the clock of a trace, or that have a pose each."""

    name = "traced"
    summary = "color/, depth/ and one head trace of any format; pictures named by its clock, or a pose for each"
    takes = ("frames_axes",)
    assumes = (
        Assumption(INTRINSICS, f"{_INTRINSICS[0]}, {_MATRICES[0]} or {CAMERA}", By.FILE, "--intrinsics"),
        Assumption(DEPTH_SCALE, "to be stated; floats are metres", By.NOBODY, "--depth-scale"),
        Assumption(NO_DEPTH, "0", By.NOBODY, "--no-depth"),
        Assumption(AXES, "those of the trace, else x right, y down, z forward", By.NOBODY, _AXES_OPTION),
        Assumption(POSE, "world from camera", By.NOBODY),
        Assumption(CLOCK, "names of pictures on the trace's clock, else a pose for each", By.FILE),
    )

    def fits(self, path: Path) -> int:
        folders = all(folder_named(path, *names).is_dir() for names in (_COLOURS, _DEPTHS))
        return 30 if folders and _traces(path) else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        files = paired(folder_named(path, *_COLOURS), folder_named(path, *_DEPTHS))
        floats = read_depth(files[0][1]).dtype.kind == "f"
        facts = facts_of(path, options, None, 1.0 if floats else None, own=_camera(path), by=By.NOBODY)
        try:
            trace, axes = _trace(_only(path), options)
        except TraceError as error:
            raise InputError(str(error)) from error
        track, epoch_ns = trace.track, trace.track.epoch_ns
        instants, clock = _instants(path, files, trace)
        pairs, stated = [], options.frames_rate_hz is not None
        for at, ((colour, depth), time_ns) in enumerate(zip(files, instants, strict=True)):
            sample = track.at(time_ns - epoch_ns)
            if sample.origin is not Origin.HELD:
                pairs.append(Pair(colour, depth, at_rate(options, at) if stated else sample.time_ns, sample.pose))
        notes = [
            *map(str, trace.defects),
            *left_out(len(files) - len(pairs), "the trace has no pose at their instants"),
        ]
        direction = next((fact for fact in trace.assumptions if fact.what == "pose"), None)
        by = By.FILE if "named" in clock else By.NOBODY
        more = [axes, clock_of(options, by) if stated else Assumption(CLOCK, clock, by)]
        more += [] if direction is None else [attrs.evolve(direction, what=POSE)]
        return self.sequence_of(path, pairs, facts, track=None if stated else track, notes=notes, more=more)


def _traces(path: Path) -> list[Path]:
    """Return the files that may be the trace, those of the usual names first."""
    lists = {*_INTRINSICS, *_MATRICES, CAMERA, "rgb.txt", "depth.txt", "associations.txt", "readme.txt"}
    found = [file for file in path.iterdir() if file.suffix.lower() in _TRACES and file.name not in lists]
    named = [file for file in found if file.stem.lower() in _NAMES]
    return sorted(named or found)


def _only(path: Path) -> Path:
    found = _traces(path) if path.is_dir() else []
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "no file of poses"
        raise InputError(
            f"{path}: {names}; expected one head trace, called {_NAMES[0]}.csv, .txt or as its format has it"
        )
    return found[0]


def _trace(file: Path, options: SequenceOptions) -> tuple[LoadedTrace, Assumption]:
    """Return the trace in the axes that it or the user states, else in those of a camera."""
    reading, head = TraceOptions(axes=options.frames_axes), read_head(file)
    if find_format(head, reading).layout(head, reading).time is None:
        reading = attrs.evolve(reading, rate=options.frames_rate_hz or RATE_HZ)
    trace = load_trace(file, reading)
    said = next((fact for fact in trace.assumptions if fact.what == "axes"), Assumption("axes", trace.axes, By.NOBODY))
    if said.by is By.NOBODY:
        trace = load_trace(file, attrs.evolve(reading, axes=OPTICAL))
        said = Assumption(AXES, "x right, y down, z forward, of world and camera", By.NOBODY)
    return trace, attrs.evolve(said, what=AXES, option=_AXES_OPTION)


def _instants(path: Path, files: list[tuple[Path, Path]], trace: LoadedTrace) -> tuple[list[int], str]:
    """Return the instant of each picture on the trace's clock, and how that is known.

    Errors: InputError where names are no instants of the trace, and there is not a pose for each.
    """
    track, stems = trace.track, [_number(colour) for colour, _ in files]
    first, last = (track.epoch_ns + time_ns for time_ns in (track.start_ns, track.end_ns))
    whole = [stem for stem in stems if stem is not None]
    counted = len(whole) == len(stems) and all(b - a == 1 for a, b in zip(whole, whole[1:], strict=False))
    if len(whole) == len(stems) and not counted:
        # Whole numbers are seconds of no clock but a count, and a count covers little of a trace.
        units = _UNITS if any("." in colour.name.removesuffix(colour.suffix) for colour, _ in files) else _WHOLE
        for unit, size in units.items():
            instants = [int(stem * size) for stem in whole]
            inside = sum(first <= instant <= last for instant in instants)
            if 2 * inside > len(instants) and max(instants) - min(instants) > _COVERED * (last - first):
                return instants, f"pictures are named by the trace's clock, in {unit}"
    if len(track) == len(files):
        return (track.time_ns + track.epoch_ns).tolist(), "the trace's, a pose for each picture in order"
    raise InputError(
        f"{path}: {len(track)} poses in {trace.path.name} for {len(files)} pictures, whose names are no instants of "
        f"it ({files[0][0].stem}, and {first / 1e9:.6f} to {last / 1e9:.6f} s); expected a pose for each, or such names"
    )


def _number(picture: Path) -> Decimal | None:
    try:
        return Decimal(picture.stem)
    except InvalidOperation:
        return None


def _camera(path: Path) -> Camera | None:
    """Return the camera of a file next to it, None where there is none. Errors: InputError."""
    file = next((path / name for name in _INTRINSICS if (path / name).exists()), None)
    if file is not None:
        return camera_of(file, read_json(file))
    file = next((path / name for name in _MATRICES if (path / name).exists()), None)
    if file is None:
        return None
    rows = rows_of(file)
    numbers = [number for row in rows for number in row.floats(len(row.words))]
    if len(numbers) == 4:
        fx, fy, cx, cy = numbers
        return Camera(fx, fy, cx, cy)
    names = {9: 3, 12: 4, 16: 4}
    if len(numbers) not in names:
        raise InputError(f"{file}: {len(numbers)} numbers; expected fx fy cx cy, or a matrix of 3 rows")
    nested = [
        numbers[at : at + names[len(numbers)]][:3] for at in range(0, 3 * names[len(numbers)], names[len(numbers)])
    ]
    return camera_of(file, {"intrinsic_matrix": nested})
