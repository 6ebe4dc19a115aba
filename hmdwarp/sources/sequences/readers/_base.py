"""What readers share: tables of text, pairs of pictures, cameras, and axes turned to OpenXR's."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from collections.abc import Sequence as Rows
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....errors import InputError
from ....geometry import Pose
from ....options.named_files import LIST, text_in
from ....poses import PoseTrack
from ....poses.assumptions import Assumption, By, first_stated
from ....poses.reading.axes import Axes, parse_axes
from ..camera import LAST, Camera, Size, by_rows, camera_of, read_json, scale_of, shared_scale, square_of, turns
from ..options import MASK, RATE_HZ, SequenceOptions
from ..picture_files import EXR, NPY, PICTURES, fitted_depth, read_colour, read_depth, size_of
from ..recorded import (
    DEPTH_SCALE,
    INTRINSICS,
    Pictures,
    RecordedFrame,
    Sequence,
    as_pictures,
    in_metres,
    replaced,
)

# Cameras that look along +z, with y down or, as some renderers have it, up.
OPTICAL, OPTICAL_UP = "opencv", "unity"
VGA: Size = (640, 480)
# The file that may state what a layout does not: intrinsics, depth_scale.
CAMERA = "camera.json"
_STATES = {INTRINSICS: "--intrinsics FX,FY,CX,CY", DEPTH_SCALE: "--depth-scale METRES"}
DEPTHS = (*PICTURES, EXR, NPY)
Fit = Callable[[NDArray[Any], NDArray[Any], object], NDArray[Any]]
# Beyond, an instant is in another unit than its file says, such as nanoseconds in place of seconds.
_LEAST_APART_S, _MOST_APART_S = 0.9e-4, 1.1e4
# And beyond these it may be.
_LEAST_USUAL_S, _MOST_USUAL_S = 0.9e-3, 10.0


@attrs.frozen
class Facts:
    """Camera and depth scale of a folder whose frames share them."""

    camera: Camera
    depth_scale: float
    assumptions: tuple[Assumption, ...] = ()
    # Size (w, h) of the pictures that the numbers of a layout are for; None for any.
    only_for: Size | None = None

    def axes(self, world: str = "") -> Axes:
        """Return the axes of the camera, which looks along +z, and of its world.

        world: right, up and forward in the file, by default those of the camera. Where the camera's
        y points up, the camera and its world are left-handed, and the world is that of the camera.
        """
        if self.camera.is_y_up:
            return parse_axes(OPTICAL_UP)
        axes = parse_axes(OPTICAL)
        return axes if not world else parse_axes(f"world={world} head={axes.words().rpartition('head=')[2]}")


def facts_of(
    folder: Path,
    options: SequenceOptions,
    camera: Camera | None,
    depth_scale: float | None,
    *,
    own: Camera | None = None,
    own_scale: float | None = None,
    by: By = By.FORMAT,
    only_for: Size | None = None,
) -> Facts:
    """Return what the options say, else camera.json in the folder, its own files, or the layout.

    own, own_scale: as the layout's files state them. camera, depth_scale: as the layout has them,
    None where it says nothing. by: who says those: FORMAT for documents of a data set, NOBODY for
    numbers that are often right. only_for: (w, h) of the pictures that those numbers are for.
    Errors: InputError.
    """
    stated = read_json(folder / CAMERA) if (folder / CAMERA).exists() else {}
    camera, camera_by = first_stated(options.intrinsics, camera_of(folder / CAMERA, stated) or own, camera)
    named = stated.get("depth_scale")
    if named is not None and options.depth_scale is None:
        scale_of(folder / CAMERA, named)
    scale, scale_by = first_stated(options.depth_scale, named or own_scale, depth_scale)
    if camera is None:
        raise InputError(
            f"{folder}: nothing says what the camera's intrinsics are: give --intrinsics FX,FY,CX,CY, or write "
            f'{CAMERA} there: {{"intrinsics": [fx, fy, cx, cy], "depth_scale": 0.001}}'
        )
    if scale is None:
        raise InputError(
            f"{folder}: nothing says the unit of its depth: give --depth-scale, the metres per unit (0.001 for "
            "millimetres, 0.0002 for TUM RGB-D)"
        )
    camera_by, scale_by = (by if known is By.FORMAT else known for known in (camera_by, scale_by))
    return Facts(camera, float(scale), (intrinsics_fact(camera, camera_by), scale_fact(scale, scale_by)), only_for)


def intrinsics_fact(camera: Camera, by: By) -> Assumption:
    """Return the entry for the intrinsics of a camera."""
    return Assumption(INTRINSICS, camera.text, by, "--intrinsics")


def scale_fact(scale: float, by: By) -> Assumption:
    """Return the entry for the metres per unit of depth."""
    return Assumption(DEPTH_SCALE, f"{scale:.6g} m per unit", by, "--depth-scale")


def for_size(fact: Assumption, size: Size) -> Assumption:
    """Return the entry for a number that a layout has for pictures of that size."""
    return attrs.evolve(fact, value="{} for {}x{}".format(fact.value, *size))


@attrs.frozen(eq=False)
class Pair:
    """Files of one frame."""

    colour: Path
    depth: Path
    time_ns: int
    pose: Pose
    # Of its own; None for that of all.
    camera: Camera | None = None


class SequenceReader:
    """One layout of recorded frames. A new one is one file in this package."""

    name = ""  # for --layout
    summary = ""  # its files, in one line
    # Of the options that few layouts take (frames_axes, frames_topics), those that this one does.
    takes: tuple[str, ...] = ()
    # What is taken for each of FACTS where files and options do not say it, and who says that.
    assumes: tuple[Assumption, ...] = ()

    def fits(self, path: Path) -> int:
        """Return how likely `path` is of this layout: 0 not at all, 100 certainly."""
        raise NotImplementedError

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        """Return the sequence. Errors: InputError naming the file and its fault."""
        raise NotImplementedError

    def sequence_of(
        self,
        folder: Path,
        pairs: Iterable[Pair],
        facts: Facts,
        *,
        track: PoseTrack | None = None,
        notes: Rows[str] = (),
        more: Rows[Assumption] = (),
        depth_of: Callable[[Path], NDArray[Any]] = read_depth,
        fit: Fit = fitted_depth,
    ) -> Sequence:
        """Return the sequence of pairs of files that share one camera.

        track: a denser motion than the frames' own. more: facts beside those of the camera.
        depth_of, fit: as `reading` takes them. Errors: InputError without frames, and for pictures
        of another size than the layout's numbers are for.
        """
        pairs = sorted(pairs, key=lambda pair: pair.time_ns)
        if not pairs:
            raise InputError(f"{folder}: no frame with colour, depth and a pose; expected {self.summary}")
        size = size_of(pairs[0].colour)
        self._refuse_other_size(folder, facts, size)

        def frame(pair: Pair) -> RecordedFrame:
            return RecordedFrame(
                pair.colour.name,
                pair.time_ns,
                pair.pose,
                (pair.camera or facts.camera).fov(size, str(folder)),
                size,
                reading(pair.colour, pair.depth, facts.depth_scale, size, depth_of, fit),
                partial(depth_of, pair.depth),
            )

        frames = [frame(pair) for pair in pairs]
        return self.made(folder, frames, track=track, notes=notes, assumptions=(*facts.assumptions, *more))

    def _refuse_other_size(self, folder: Path, facts: Facts, size: Size) -> None:
        """Raise InputError where numbers of a layout are for pictures of another size."""
        open_facts = [assumption for assumption in facts.assumptions if assumption.by in (By.FORMAT, By.NOBODY)]
        if facts.only_for in (None, size) or not open_facts:
            return
        (wide, high), (found_wide, found_high) = facts.only_for, size
        taken = " and ".join(f"{fact.what} {fact.value}" for fact in open_facts)
        remedy = " ".join(_STATES[fact.what] for fact in open_facts)
        raise InputError(
            f"{folder}: pictures of {found_wide}x{found_high}, and what {self.name} takes where files do not say it "
            f"({taken}) is for {wide}x{high}: give {remedy}, or write {CAMERA} there"
        )

    def made(
        self,
        path: Path,
        frames: Rows[RecordedFrame],
        *,
        track: PoseTrack | None = None,
        notes: Rows[str] = (),
        assumptions: Rows[Assumption] = (),
    ) -> Sequence:
        """Return the sequence of these frames, whose clock begins with the first.

        track: a denser motion, on the frames' own clock. assumptions: those of this recording; the
        others are what this reader assumes.
        Errors: InputError for no frames, for two of one instant, and for several sizes.
        """
        if not frames:
            raise InputError(f"{path}: no frames; expected {self.summary}")
        frames = sorted(frames, key=lambda frame: frame.time_ns)
        for before, after in zip(frames, frames[1:], strict=False):
            if before.time_ns == after.time_ns:
                raise InputError(
                    f"{path}: {before.name} and {after.name} are of one instant; expected instants of their own"
                )
            if before.size != after.size:
                sizes = ", ".join(f"{frame.name} {frame.size[0]}x{frame.size[1]}" for frame in (before, after))
                raise InputError(f"{path}: pictures of several sizes ({sizes}); expected one size")
        apart_s = float(np.median(np.diff([frame.time_ns * 1e-9 for frame in frames]))) if len(frames) > 1 else 1.0
        if not _LEAST_APART_S <= apart_s <= _MOST_APART_S:
            raise InputError(
                f"{path}: frames are {apart_s:g} s apart: expected {_LEAST_APART_S:g} to {_MOST_APART_S:g} s; write "
                "instants in their unit, or give --frames-rate"
            )
        if not _LEAST_USUAL_S <= apart_s <= _MOST_USUAL_S:
            unit = f"Frames are {apart_s:.4g} s apart: if their instants are in another unit, state --frames-rate."
            notes = [*notes, unit]
        name = (path if path.is_dir() else path.parent).resolve().name
        begins_ns = frames[0].time_ns
        frames = [attrs.evolve(frame, time_ns=frame.time_ns - begins_ns) for frame in frames]
        origin, epoch_ns = f"recorded frames ({self.name})", begins_ns + (0 if track is None else track.epoch_ns)
        own = attrs.evolve(_track(frames, track, begins_ns), name=name, origin=origin, epoch_ns=epoch_ns)
        facts = replaced(self.assumes, *assumptions)
        return Sequence(name, path, self.name, tuple(frames), own, tuple(notes), assumptions=facts)


def _track(frames: Rows[RecordedFrame], denser: PoseTrack | None, begins_ns: int) -> PoseTrack:
    """Return the motion from the first frame to the last, with the frames' own poses in it."""
    times = np.array([frame.time_ns for frame in frames])
    positions = np.array([frame.pose.position_m for frame in frames])
    turns = np.array([frame.pose.orientation_xyzw for frame in frames])
    if denser is None:
        return PoseTrack(times, positions, turns)
    between = denser.time_ns - begins_ns
    kept = (between > times[0]) & (between < times[-1]) & ~np.isin(between, times)
    every = np.concatenate([times, between[kept]])
    order = np.argsort(every)
    positions = np.concatenate([positions, denser.position_m[kept]])
    turns = np.concatenate([turns, denser.orientation_xyzw[kept]])
    return PoseTrack(every[order], positions[order], turns[order], axes=denser.axes, max_gap_ns=denser.max_gap_ns)


def reading(
    colour: Path,
    depth: Path,
    scale: float,
    size: tuple[int, int],
    depth_of: Callable[[Path], NDArray[Any]] = read_depth,
    fit: Fit = fitted_depth,
) -> Callable[[], Pictures]:
    """Return what reads a frame from two files.

    depth_of: reads depth in its own unit. fit: takes it to the pixels of its colour.
    """

    def read() -> Pictures:
        picture = read_colour(colour)
        if picture.shape[1::-1] != size:
            found = f"{picture.shape[1]}x{picture.shape[0]}"
            raise InputError(f"{colour}: {found} pixels; expected {size[0]}x{size[1]}, as the first frame has")
        return as_pictures(picture, in_metres(fit(depth_of(depth), picture, depth), scale))

    return read


def pose_of(axes: Axes, position: ArrayLike, rotation: NDArray[np.float64]) -> Pose:
    """Return world_from_eye in OpenXR's axes of a position and a (3, 3) rotation of a file."""
    from scipy.spatial.transform import Rotation

    turned = axes.world @ rotation @ axes.head.T
    return Pose(axes.world @ np.asarray(position, np.float64), Rotation.from_matrix(turned).as_quat())


def pose_of_numbers(axes: Axes, where: str, numbers: Rows[float]) -> Pose:
    """Return world_from_eye of x y z and a quaternion x y z w of a file. Errors: InputError."""
    from scipy.spatial.transform import Rotation

    position, xyzw = numbers[:3], numbers[3:]
    length = float(np.linalg.norm(xyzw))
    if not abs(length - 1) <= 1e-2:
        raise InputError(f"{where}: a quaternion of length {length:.4g}; expected 1 within 0.01, x y z w")
    return pose_of(axes, position, Rotation.from_quat(xyzw).as_matrix())


def pose_of_matrix(axes: Axes, where: str, matrix: Any, unit: float = 1.0) -> Pose:
    """Return world_from_eye of a 4x4 matrix of a file, whose positions have `unit` metres.

    matrix: as square_of takes it, by rows, or by columns where its zeros say so; poses_of looks at
    all matrices of a file. Errors: InputError for what is no rotation and translation.
    """
    return poses_of(axes, [(where, matrix)], unit)[0][0]


def poses_of(
    axes: Axes, matrices: Rows[tuple[str, Any]], unit: float = 1.0, *, inverse: bool = False
) -> tuple[list[Pose], Assumption]:
    """Return world_from_eye of all matrices of a file, with their places, and how they are written.

    As pose_of_matrix. inverse: the matrices are from world to camera. A scale that all of them have
    is that of the world over the camera, in whose unit depth is: positions are divided by it.
    Errors: InputError.
    """
    places = [where for where, _ in matrices]
    turned, fact = by_rows(places[0] if places else "", [square_of(where, one) for where, one in matrices])
    if inverse:
        turned = [_inverse_of(*pair) for pair in zip(places, turned, strict=True)]
        fact = attrs.evolve(fact, value=fact.value.replace("world from camera", "camera from world, inverted"))
    scale = shared_scale(turned)
    if scale != 1:
        turned = [np.vstack([one[:3] / scale, one[3:]]) for one in turned]
        stated = 1 / scale if inverse else scale
        fact = attrs.evolve(fact, value=f"{fact.value}, their scale of {stated:.6g} divided out", by=By.FILE)
    return [_pose_of_square(axes, where, one, unit) for where, one in zip(places, turned, strict=True)], fact


def _inverse_of(where: str, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inverse of a (4, 4) matrix. Errors: InputError where it has none."""
    try:
        return np.asarray(np.linalg.inv(matrix), np.float64)
    except np.linalg.LinAlgError:
        raise InputError(f"{where}: the matrix has no inverse; expected a rotation and a position") from None


def _pose_of_square(axes: Axes, where: str, matrix: NDArray[np.float64], unit: float) -> Pose:
    turn = matrix[:3, :3]
    if not turns(turn) or np.linalg.det(turn) < 0 or not np.allclose(matrix[3], LAST):
        raise InputError(
            f"{where}: the matrix does more than turn and move; expected a right-handed rotation, and a scale only "
            "where all have the same"
        )
    return pose_of(axes, matrix[:3, 3] * unit, turn)


@attrs.frozen
class Row:
    """A line of a text file, as words."""

    where: str
    words: list[str]

    def floats(self, count: int) -> list[float]:
        """Return its numbers. Errors: InputError naming the line."""
        try:
            values = [float(word) for word in self.words]
        except ValueError:
            values = []
        if len(values) != count or not np.isfinite(values).all():
            raise self.wrong(f"{count} finite numbers")
        return values

    def first(self, count: int) -> list[float]:
        """Return its first numbers, whatever follows. Errors: as floats."""
        return attrs.evolve(self, words=self.words[:count]).floats(count)

    def wrong(self, expected: str) -> InputError:
        """Return the error for another content than expected."""
        return InputError(f"{self.where}: '{' '.join(self.words)[:60]}'; expected {expected}")


def rows_of(path: Path) -> list[Row]:
    """Return the lines of a file; comments and empty lines are left out."""
    text = text_in(path, LIST)
    lines = (line.partition("#")[0].replace(",", " ").split() for line in text.splitlines())
    return [Row(f"{path}, line {number}", words) for number, words in enumerate(lines, 1) if words]


def pictures_in(folder: Path, endings: Rows[str] = PICTURES) -> list[Path]:
    """Return the pictures of a folder in the order of the numbers in their names."""
    if not folder.is_dir():
        return []
    found = [
        path
        for path in folder.iterdir()
        if path.suffix.lower() in endings and not path.name.startswith(".") and path.name != MASK
    ]
    return sorted(
        found,
        key=lambda path: [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.stem)],
    )


def folder_named(folder: Path, *names: str) -> Path:
    """Return the first of these folders that exists, else the first of them."""
    return next((folder / name for name in names if (folder / name).is_dir()), folder / names[0])


def at_rate(options: SequenceOptions, number: int, rate_hz: float | None = None) -> int:
    """Return the instant of a frame of files without a clock. rate_hz: of the layout."""
    return round(number * 1e9 / (options.frames_rate_hz or rate_hz or RATE_HZ))


def paired(colours: Path, depths: Path) -> list[tuple[Path, Path]]:
    """Return the pictures of both folders in order, by their names or their number.

    Errors: InputError where the two do not fit.
    """
    first, second = pictures_in(colours), pictures_in(depths, DEPTHS)
    by_name = {path.stem: path for path in second}
    if first and all(path.stem in by_name for path in first):
        return [(path, by_name[path.stem]) for path in first]
    if len(first) != len(second) or not first:
        raise InputError(
            f"{colours.parent}: {len(first)} pictures in {colours.name}, {len(second)} in {depths.name}; expected as "
            "many of both, or the same names"
        )
    return list(zip(first, second, strict=True))
