"""Readers of recorded sequences: a function for each layout, recognised by its files.

A layout is a declaration and a function that adds the frames of a folder:

    @layout("mine", "color/N.png, depth/N.png, poses.txt", (80, "poses.txt", "depth"), unit=1e-3)
    def mine(at: Folder) -> None:
        at.state()
        for number, row in enumerate(at.rows("poses.txt")):
            colour, depth = at.path / f"color/{number}.png", at.path / f"depth/{number}.png"
            at.add(colour, depth, number, row.pose(at.axes))
"""

from __future__ import annotations

import itertools
import math
import os
import re
import reprlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from collections.abc import Sequence as Rows
from decimal import Decimal, InvalidOperation
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ....base import InputError, Registry, are_digits, as_path
from ....base.named_files import LIST, enter, text_in
from ....geometry import Pose
from ....poses import PoseTrack
from ....poses.assumptions import Assumption, By, first_stated
from ....poses.reading.axes import Axes, parse_axes
from .. import recorded
from ..frame_files import Camera, Size, camera_of, floats_in, read_json, scale_of
from ..options import LAYOUTS, MASK, RATE_HZ, SequenceOptions
from ..picture_files import EXR, NPY, PICTURES, fitted_depth, read_colour, read_depth, size_of
from ..recorded import Pictures, RecordedFrame, Sequence

OPTICAL = "x,-y,z"  # right, up and forward of a camera that looks along +z, with y down
VGA: Size = (640, 480)
CAMERA = "camera.json"  # may state what a layout does not: intrinsics, depth_scale
DEPTHS = (*PICTURES, EXR, NPY)
COLOURS = ("color", "colour", "rgb", "image", "images")
# The usual forms of poses.
XYZW, MATRICES = "world from camera, x y z qx qy qz qw", "world from camera, matrices by rows"
_STATED_BY = ("--intrinsics", "--depth-scale", "--no-depth", "", "", "--frames-rate")  # of each of FACTS
_STATES = {recorded.INTRINSICS: "--intrinsics FX,FY,CX,CY", recorded.DEPTH_SCALE: "--depth-scale METRES"}
# Beyond the first, an instant is in another unit than its file says; beyond the second it may be.
_APART_S, _USUAL_S = (0.9e-4, 1.1e4), (0.9e-3, 10.0)
Said = str | tuple[str, By] | Assumption


class SequenceReader:
    """One layout of recorded frames; other packages register theirs."""

    name = ""  # for --layout
    summary = ""  # its files, in one line
    takes: tuple[str, ...] = ()  # of the options that few layouts take, such as frames_axes, those that this one does
    # What is taken for each of FACTS where files and options do not say it, and who says that.
    assumes: tuple[Assumption, ...] = ()

    def fits(self, path: Path) -> int:
        """Return how likely `path` is of this layout: 0 not at all, 100 certainly."""
        raise NotImplementedError

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        """Return the sequence. Errors: InputError naming the file and its fault."""
        raise NotImplementedError


@attrs.frozen(eq=False)
class Layout(SequenceReader):
    name: str
    summary: str
    add_frames: Callable[[Folder], None]
    fits: Callable[[Path], int]  # type: ignore[assignment]
    assumes: tuple[Assumption, ...]
    camera: Camera | None = None
    unit: float | None = None
    by: By = By.FORMAT  # who says camera and unit
    only_for: Size | None = None  # (w, h) of the pictures that both are for
    axes: str = ""
    y_up: bool = False  # whether the camera may have y up
    takes: tuple[str, ...] = ()

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        folder = Folder(self, path, options)
        self.add_frames(folder)
        return folder.sequence()


readers: Registry[SequenceReader] = Registry("layout", __package__, holds_objects=True, modules=LAYOUTS)


def layout(
    name: str,
    summary: str,
    holds: tuple[Any, ...] | Callable[[Path], int],
    *,
    world: str = "x,-y,z",
    axes: str = "",
    intrinsics: Said = "",
    scale: Said = "",
    no_depth: Said = "0",
    looks: Said = "",
    pose: Said = XYZW,
    clock: Said = (f"{RATE_HZ:g} frames per second", By.DEFAULT),
    **more: Any,
) -> Callable[[Callable[[Folder], None]], Callable[[Folder], None]]:
    """Register a function as a layout.

    holds: a score, 0 to 100, and patterns of files that must all be there; or a function of a path.
    world: right, up and forward, for a camera that looks along +z with y down; axes: any other.
    intrinsics .. clock: each of FACTS unless a file or option states it, and who says so.
    """
    by, unit, camera = more.get("by", By.FORMAT), more.get("unit"), more.get("camera")
    placed = axes or f"world={world} head={OPTICAL}"
    said = [
        intrinsics or (camera.text if camera else "to be stated", by if camera else By.USER),
        scale or (_scale_text(unit, more.get("only_for")), by) if unit or scale else ("to be stated", By.USER),
        *(no_depth, looks or parse_axes(placed).words(), pose, clock),
    ]
    assumes = tuple(
        one
        if isinstance(one, Assumption)
        else Assumption(what, *((one, By.FORMAT) if isinstance(one, str) else one), option)
        for what, option, one in zip(recorded.FACTS, _STATED_BY, said, strict=True)
    )

    def fits(path: Path) -> int:
        if not isinstance(holds, tuple):
            return holds(path)
        return holds[0] if path.is_dir() and all(any(path.glob(each)) for each in holds[1:]) else 0

    def register(add_frames: Callable[[Folder], None]) -> Callable[[Folder], None]:
        readers.register(Layout(name, summary, add_frames, fits, assumes, axes=placed, y_up=not axes, **more))
        return add_frames

    return register


def _scale_text(unit: float | None, only_for: Size | None = None) -> str:
    return f"{unit:.6g} m per unit" + ("" if only_for is None else " for {}x{}".format(*only_for))


def _of_camera(where: Path, pictures: list[Path], wanted: str | None) -> list[Path]:
    """Return the pictures of the camera the user names, or the only one. Errors: InputError."""
    named: dict[str, dict[str, Path]] = defaultdict(dict)
    for path in pictures:
        if found := re.search(r"^(.*?)(\d+)(\D*)$", path.stem):
            named[f"{found[1]}N{found[3]}"][found[2]] = path
    fitting = [] if wanted is None else [name for name in named if wanted in name]
    if len(fitting) == 1:
        return list(named[fitting[0]].values())
    worded = [set(numbers) for name, numbers in named.items() if re.search("[A-Za-z]", name.replace("N", "", 1))]
    is_rig = len(worded) > 1 and 2 * len(set.intersection(*worded)) >= max(map(len, worded)) > 1
    if is_rig or wanted is not None:
        expected = f"expected what one of the cameras alone has in its names: {', '.join(sorted(named)[:6])}"
        raise InputError(f"{where}: --frames-camera is {wanted or 'not given'}; {expected}")
    return pictures


Matrix = NDArray[np.float64]
LAST = (0.0, 0.0, 0.0, 1.0)
_NOTHING = 1e-12
_WITHIN = 1e-3


def _square_of(where: str, value: Any) -> Matrix:
    """Return 4x4 of 4x4, 3x4, 4x3 or 12 or 16 numbers, as written. Errors: InputError."""
    try:
        found = np.array(value, np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape == (12,):
        found = found.reshape(3, 4)
        if not turns(found[:, :3]) and turns(found.reshape(4, 3)[:3]):
            found = found.reshape(4, 3)
    found = found.reshape(4, 4) if found.shape == (16,) else found
    if found.shape not in ((4, 4), (3, 4), (4, 3)) or not np.isfinite(found).all():
        expected = "expected a matrix of 4 rows of 4 finite numbers, nested or flat"
        raise InputError(f"{where}: {reprlib.repr(value)}; {expected}")
    whole = np.diag(np.ones(4))
    whole[: found.shape[0], : found.shape[1]] = found
    return whole


def _by_rows(where: str, matrices: Rows[Matrix]) -> tuple[list[Matrix], Assumption]:
    """Return a file's matrices by rows, and who says they are: 0, 0, 0, 1. Errors: InputError."""
    below, beside = (
        np.array([np.abs(np.subtract(line, LAST)).max() <= _NOTHING for line in lines], bool)
        for lines in ([matrix[3] for matrix in matrices], [matrix[:, 3] for matrix in matrices])
    )
    rows, columns = np.flatnonzero(below & ~beside), np.flatnonzero(beside & ~below)
    if len(rows) and len(columns):
        why = f"matrix {rows[0]} is written by rows and matrix {columns[0]} by columns; expected one way for all"
        raise InputError(f"{where}: {why}")
    order = "by columns" if len(columns) else "by rows"
    by = By.FILE if len(rows) or len(columns) else By.FORMAT
    turned = [matrix.T for matrix in matrices] if len(columns) else list(matrices)
    return turned, Assumption(recorded.POSE, f"world from camera, matrices {order}", by)


def turns(matrix: Matrix) -> bool:
    """Return whether three rows are those of a rotation, within what a file rounds."""
    return bool(np.abs(matrix @ matrix.T - np.eye(3)).max() <= _WITHIN)


def _shared_scale(matrices: Rows[Matrix]) -> float:
    """Return the factor that all matrices have beside a rotation; 1 for none, or for several."""
    scales = np.cbrt([np.linalg.det(matrix[:3, :3]) for matrix in matrices])
    if not len(scales) or not np.isfinite(scales).all() or scales.min() <= 0:
        return 1.0
    scale = float(np.median(scales))
    is_shared = np.abs(scales / scale - 1).max() <= _WITHIN
    return scale if is_shared and abs(scale - 1) > _WITHIN / 2 else 1.0


@attrs.frozen(eq=False)
class Pair:
    colour: Path
    depth: Path
    time_ns: int
    pose: Pose
    camera: Camera | None = None  # None: the folder's
    picture: Callable[[], NDArray[Any]] | None = None  # reads colour that is no file of its own


class Folder:
    """A folder that is being read by a layout: what it states, and the frames found so far."""

    def __init__(self, layout: SequenceReader, path: Path, options: SequenceOptions) -> None:
        self.layout, self.path, self.options = layout, path, options
        self.pairs: list[Pair] = []
        self.frames: list[RecordedFrame] = []  # in place of pairs
        self.notes: list[str] = []
        self.clocks: dict[str, tuple[float, float]] = {}  # first and last ns of what is paired by instants
        self.facts: list[Assumption] = []
        self.track: PoseTrack | None = None  # a denser motion than the frames' own, on their clock
        self.size: Size | None = None  # by default that of the first picture
        self.depth_of: Callable[[Path], NDArray[Any]] = read_depth
        self.fit: Callable[[NDArray[Any], NDArray[Any], object], NDArray[Any]] = fitted_depth
        self.rate_hz = RATE_HZ
        self.only_for: Size | None = None  # size of the pictures that camera and scale are for
        self.camera = Camera(1, 1, 0, 0)
        self.scale = 1.0
        self.axes = parse_axes(getattr(layout, "axes", "") or "openxr")

    def state(
        self,
        camera: Camera | None = None,
        unit: float | None = None,
        *,
        own: Camera | None = None,
        own_scale: float | None = None,
        by: By | None = None,
    ) -> None:
        """Take camera and scale of options, camera.json, own files, layout. Errors: InputError."""
        known: Any = self.layout
        camera, unit, by = camera or known.camera, unit or known.unit, by or known.by
        folder = self.path if self.path.is_dir() else self.path.parent
        stated = read_json(folder / CAMERA) if (folder / CAMERA).exists() else {}
        named = stated.get("depth_scale")
        if named is not None and self.options.depth_scale is None:
            scale_of(folder / CAMERA, named)
        found, camera_by = first_stated(self.options.camera, camera_of(folder / CAMERA, stated) or own, camera)
        scale, scale_by = first_stated(self.options.depth_scale, named or own_scale, unit)
        if found is None:
            raise InputError(
                f"{folder}: nothing says what the camera's intrinsics are: give --intrinsics FX,FY,CX,CY, or write "
                f'{CAMERA} there: {{"intrinsics": [fx, fy, cx, cy], "depth_scale": 0.001}}'
            )
        if scale is None:
            hint = "give --depth-scale, the metres per unit (0.001 for millimetres, 0.0002 for TUM RGB-D)"
            raise InputError(f"{folder}: nothing says the unit of its depth: {hint}")
        self.camera, self.scale = found, float(scale)
        camera_by, scale_by = (by if one is By.FORMAT else one for one in (camera_by, scale_by))
        self.say(found, camera_by, scale_by)
        if found.is_y_up:
            if not known.y_up:
                raise InputError(f"{self.path}: fy is {found.fy:g}; expected above 0, as its layout has it")
            self.axes = parse_axes("unity")  # left-handed, and so is its world
        self.only_for = known.only_for

    def say(self, camera: Camera, camera_by: By, scale_by: By) -> None:
        self.facts.append(Assumption(recorded.INTRINSICS, camera.text, camera_by, "--intrinsics"))
        self.facts.append(Assumption(recorded.DEPTH_SCALE, _scale_text(self.scale), scale_by, "--depth-scale"))

    def instant_ns(self, number: int, stated_ns: int | None = None) -> int:
        """Return the instant of a frame: as stated unless there is a rate, else by its number."""
        if stated_ns is not None and self.options.frames_rate_hz is None:
            return stated_ns
        return round(number * 1e9 / (self.options.frames_rate_hz or self.rate_hz))

    def add(self, colour: Path, depth: Path, number: int, pose: Pose, time_ns: int | None = None, **more: Any) -> None:
        """Add a frame. number: of the frame, its instant where time_ns does not state one."""
        self.pairs.append(Pair(colour, depth, self.instant_ns(number, time_ns), pose, **more))

    def left_out(self, of: int, why: str) -> None:
        if count := of - len(self.pairs or self.frames):
            self.notes.append(f"{count} frames were left out: {why}.")

    def clock(self, value: str = "", by: By = By.DEFAULT) -> None:
        value = value or f"{self.rate_hz:g} frames per second"
        self.facts.append(Assumption(recorded.CLOCK, value, by, "--frames-rate"))

    def rows(self, name: str) -> list[Row]:
        return rows_of(self.path / name)

    def folder(self, *names: str) -> Path:
        return next((self.path / name for name in names if (self.path / name).is_dir()), self.path / names[0])

    def first(self, *names: str, above: bool = False) -> Path | None:
        """Return the first of these files that exists. above: look in the parent too."""
        places = (self.path, self.path.resolve().parent) if above else (self.path,)
        return next((place / name for place in places for name in names if (place / name).exists()), None)

    def numbered(self, pattern: str) -> dict[int, Path]:
        files = (path for path in sorted(self.path.glob(pattern)) if not path.name.startswith("."))
        numbers = [(int(found.group()), path) for path in files if (found := re.search(r"[0-9]+", path.name))]
        if doubled := next((pair for pair in itertools.pairwise(sorted(numbers)) if pair[0][0] == pair[1][0]), None):
            names = " and ".join(path.name for _, path in doubled)
            raise InputError(f"{self.path}: {names} have one number: put those of one camera in a folder of its own")
        return dict(numbers)

    def paired(self, depths: Path | None = None) -> list[tuple[Path, Path]]:
        """Return pictures with depth, by names, numbers, else instants. Errors: InputError."""
        colours, depths = self.folder(*COLOURS), depths or self.path / "depth"
        first, second = images_in(colours), images_in(depths, DEPTHS)
        first, wanted = _of_camera(colours, first, self.options.frames_camera), self.options.frames_camera or ""
        second = [path for path in second if wanted in path.stem] or second
        parts = [[[int(one) for one in re.findall(r"\d+", path.stem)] for path in side] for side in (first, second)]
        ways: list[list[list[Any]]] = [[[path.stem for path in side] for side in (first, second)]]
        if all(itertools.chain(*parts)):  # by all of their numbers, else the last of each
            ways += [[[tuple(one[-n:]) for one in side] for side in parts] for n in (9, 1)]
        for here, there in ways:
            if first and len({*here}) == len(here) and {*here} <= {*there} and len({*there}) == len(there):
                return [(path, second[there.index(one)]) for path, one in zip(first, here, strict=True)]
        try:
            instants = [[Decimal(path.stem) for path in side] for side in (first, second)]
            step = min(b - a for side in instants for a, b in itertools.pairwise(side))
            if all(2 * abs(a - b) < step for a, b in zip(*instants, strict=True)):
                return list(zip(first, second, strict=True))
        except (InvalidOperation, ValueError):  # names that are none, a single one, or more of one side
            pass
        without = sorted({*ways[-1][0]} - {*ways[-1][1]})
        raise InputError(
            f"{colours.parent}: {len(first)} pictures in {colours.name}, {len(second)} in {depths.name}"
            + "".join(f", without depth {' '.join(map(str, np.ravel(one)))}" for one in without[:1])
            + "; expected depth of the same name or number for each, or of an instant within half a frame"
        )

    def poses(self, matrices: Iterable[tuple[str, Any]], unit: float = 1.0, *, inverse: bool = False) -> list[Pose]:
        """Return world_from_eye of a file's matrices, a scale they share divided out."""
        given = list(matrices)
        turned, fact = _by_rows(given[0][0] if given else "", [_square_of(where, one) for where, one in given])
        if inverse:
            if flat := [where for (where, _), one in zip(given, turned, strict=True) if not np.linalg.det(one)]:
                raise InputError(f"{flat[0]}: the matrix has no inverse; expected a rotation and a position")
            turned = [np.asarray(np.linalg.inv(one), dtype=np.float64) for one in turned]
            fact = attrs.evolve(fact, value=fact.value.replace("world from camera", "camera from world, inverted"))
        if (scale := _shared_scale(turned)) != 1:
            turned = [np.vstack([one[:3] / scale, one[3:]]) for one in turned]
            said = f"{fact.value}, their scale of {1 / scale if inverse else scale:.6g} divided out"
            fact = attrs.evolve(fact, value=said, by=By.FILE)
        self.facts.append(fact)
        return [self.pose_in(where, one, unit) for (where, _), one in zip(given, turned, strict=True)]

    def pose_in(self, where: str, matrix: NDArray[np.float64], unit: float = 1.0) -> Pose:
        """Return world_from_eye of a (4, 4) matrix. Errors: InputError for more than that."""
        turn = matrix[:3, :3]
        if not turns(turn) or np.linalg.det(turn) < 0 or not np.allclose(matrix[3], LAST):
            expected = "expected a right-handed rotation, and a scale only where all have the same"
            raise InputError(f"{where}: the matrix does more than turn and move; {expected}")
        return pose_of(self.axes, matrix[:3, 3] * unit, turn)

    def poses_in(self, files: Mapping[int, Path]) -> dict[int, Pose]:
        whole = {at: matrix for at, path in files.items() if np.isfinite(matrix := matrix_in(path)).all()}
        return dict(zip(whole, self.poses((str(files[at]), one) for at, one in whole.items()), strict=True))

    def sequence(self) -> Sequence:
        frames = sorted(self.frames or self._frames(), key=lambda frame: frame.time_ns)
        if not frames:
            self.refuse_apart()
            raise InputError(f"{self.path}: no frame with colour, depth and a pose; expected {self.layout.summary}")
        for before, after in itertools.pairwise(frames):
            if before.time_ns == after.time_ns:
                raise InputError(f"{self.path}: {before.name} and {after.name} are of one instant; expected one each")
            if before.size != after.size:
                sizes = ", ".join(f"{frame.name} {frame.size[0]}x{frame.size[1]}" for frame in (before, after))
                raise InputError(f"{self.path}: pictures of several sizes ({sizes}); expected one size")
        begins_ns = frames[0].time_ns
        frames = [attrs.evolve(frame, time_ns=frame.time_ns - begins_ns) for frame in frames]
        times = np.array([frame.time_ns for frame in frames])
        apart_s = float(np.median(np.diff(times))) * 1e-9 if len(times) > 1 else 1.0
        if not _APART_S[0] <= apart_s <= _APART_S[1]:
            raise InputError(
                f"{self.path}: frames are {apart_s:g} s apart: expected {_APART_S[0]:g} to {_APART_S[1]:g} s; write "
                "instants in their unit, or give --frames-rate"
            )
        if not _USUAL_S[0] <= apart_s <= _USUAL_S[1]:
            why = "if their instants are in another unit, state --frames-rate."
            self.notes.append(f"Frames are {apart_s:.4g} s apart: {why}")
        # The motion from the first frame to the last, with the frames' own poses in it.
        positions = np.array([frame.pose.position_m for frame in frames])
        turned = np.array([frame.pose.orientation_xyzw for frame in frames])
        epoch_ns, more, every = begins_ns, {}, times  # type: int, dict[str, Any], NDArray[np.int64]
        if (denser := self.track) is not None:
            between = denser.time_ns - begins_ns
            kept = (between > times[0]) & (between < times[-1]) & ~np.isin(between, times)
            every = np.concatenate([times, between[kept]])
            positions = np.concatenate([positions, denser.position_m[kept]])
            turned = np.concatenate([turned, denser.orientation_xyzw[kept]])
            epoch_ns, more = epoch_ns + denser.epoch_ns, {"axes": denser.axes, "max_gap_ns": denser.max_gap_ns}
        name, order = (self.path if self.path.is_dir() else self.path.parent).resolve().name, np.argsort(every)
        more |= {"name": name, "origin": f"recorded frames ({name})", "epoch_ns": epoch_ns}
        track = PoseTrack(every[order], positions[order], turned[order], **more)
        facts = {fact.what: fact for fact in recorded.replaced(self.layout.assumes, *self.facts)}
        if (rate_hz := self.options.frames_rate_hz) is not None and (option := facts[recorded.CLOCK].option):
            facts[recorded.CLOCK] = Assumption(recorded.CLOCK, f"{rate_hz:g} frames per second", By.USER, option)
        notes, assumptions = tuple(self.notes), tuple(facts.values())
        return Sequence(name, self.path, self.layout.name, tuple(frames), track, notes, assumptions=assumptions)

    def refuse_apart(self) -> None:
        firsts, lasts = zip(*self.clocks.values(), strict=True) if self.clocks else ((0,), (0,))
        if (apart := max(firsts) - min(lasts)) > 0:
            spans = "; ".join(f"{name}: {a / 1e9:.6f} to {b / 1e9:.6f} s" for name, (a, b) in self.clocks.items())
            raise InputError(f"{self.path}: the clocks are {apart / 1e9:.6g} s apart ({spans}); expected one clock")

    def _frames(self) -> list[RecordedFrame]:
        pairs = sorted(self.pairs, key=lambda pair: pair.time_ns)
        if not pairs:
            return []
        size = self.size or size_of(pairs[0].colour)
        open_facts = [one for one in self.facts if one.what in _STATES and one.by in (By.FORMAT, By.DEFAULT)]
        if self.only_for not in (None, size) and open_facts:
            taken = " and ".join(f"{fact.what} {fact.value}" for fact in open_facts)
            raise InputError(
                f"{self.path}: pictures of {size[0]}x{size[1]}, and what {self.layout.name} takes where files do not "
                f"say it ({taken}) is for {self.only_for[0]}x{self.only_for[1]}: "
                f"give {' '.join(_STATES[fact.what] for fact in open_facts)}, or write {CAMERA} there"
            )
        return [self._frame(pair, size) for pair in pairs]

    def _frame(self, pair: Pair, size: Size) -> RecordedFrame:
        def read() -> Pictures:
            picture = None if pair.picture is None else pair.picture()
            w, h = size_of(pair.colour) if picture is None else picture.shape[1::-1]
            if (w, h) != size:
                raise InputError(f"{pair.colour}: {w}x{h} pixels; expected {size[0]}x{size[1]}, as the first frame has")
            picture = read_colour(pair.colour) if picture is None else picture
            return recorded.as_pictures(picture, recorded.in_metres(self.fit(depth(), picture, pair.depth), self.scale))

        depth = partial(self.depth_of, pair.depth)
        fov = (pair.camera or self.camera).fov(size, str(self.path))
        return RecordedFrame(pair.colour.name, pair.time_ns, pair.pose, fov, size, read, depth)


def pose_of(axes: Axes, position: ArrayLike, rotation: NDArray[np.float64]) -> Pose:
    """Return world_from_eye in OpenXR's axes of a position and a (3, 3) rotation of a file."""
    turned = axes.world @ rotation @ axes.head.T
    pose = Pose(axes.world @ np.asarray(position, np.float64), Rotation.from_matrix(turned).as_quat())
    pose.check_near("recorded frames")
    return pose


@attrs.frozen
class Row:
    where: str
    words: list[str]

    def floats(self, count: int, begin: int = 0, *, whole: bool = True) -> list[float]:
        values = floats_in(self.words if whole else self.words[: begin + count])
        if len(values) != begin + count or not np.isfinite(values).all():
            raise self.wrong(f"{begin + count} finite numbers")
        return values[begin:]

    def matrix(self, begin: int = 0, *, more: int = 0, whole: bool = True) -> NDArray[np.float64]:
        """Return the matrix of x y z qx qy qz qw. more: numbers after it. Errors: InputError."""
        numbers = self.floats(7 + more, begin, whole=whole)
        length = float(np.linalg.norm(numbers[3:7]))
        if not abs(length - 1) <= 1e-2:
            raise InputError(f"{self.where}: a quaternion of length {length:.4g}; expected 1 within 0.01, x y z w")
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(numbers[3:7]).as_matrix(), numbers[:3]
        return matrix

    def pose(self, axes: Axes, begin: int = 0, **more: Any) -> Pose:
        matrix = self.matrix(begin, **more)
        return pose_of(axes, matrix[:3, 3], matrix[:3, :3])

    def nanoseconds(self) -> int:
        """Return those of the seconds in its first word, to the last digit. Errors: InputError."""
        try:
            return int(Decimal(self.words[0]) * 10**9)
        except (InvalidOperation, ValueError, OverflowError):
            raise self.wrong("seconds") from None

    def wrong(self, expected: str) -> InputError:
        return InputError(f"{self.where}: '{' '.join(self.words)[:60]}'; expected {expected}")


def rows_of(path: Path) -> list[Row]:
    """Return the lines of a file; comments and empty lines are left out."""
    lines = (line.partition("#")[0].replace(",", " ").split() for line in text_in(path, LIST).splitlines())
    return [Row(f"{path}, line {number}", words) for number, words in enumerate(lines, 1) if words]


def matrix_in(path: Path, size: int = 4) -> NDArray[np.float64]:
    """Return the matrix of (size, size) numbers in a file, maybe inf. Errors: InputError."""
    found = []
    for row in rows_of(path):
        found.append(floats_in(row.words))
        if not found[-1]:
            raise row.wrong(f"{size} numbers")
    if [len(row) for row in found] != [size] * size:
        raise InputError(f"{path}: {len(found)} lines; expected a matrix, {size} lines of {size} numbers")
    return np.array(found)


def images_in(folder: Path, endings: Rows[str] = PICTURES) -> list[Path]:
    files = folder.iterdir() if folder.is_dir() else ()
    found = [
        one for one in files if one.suffix.lower() in endings and not one.name.startswith(".") and one.name != MASK
    ]
    words = {path: re.split(r"([0-9]+)", path.stem) for path in found}
    return sorted(found, key=lambda path: [(int(p), "") if are_digits(p) else (-1, p) for p in words[path]])


_NAMED = 6  # files of a folder that no reader knows


def open(path: str | os.PathLike[str], options: SequenceOptions | None = None) -> Sequence:
    """Return the recorded sequence of a folder; pixels are read later, frame by frame.

    Parameters
    ----------
    path : path
        Of the folder, or of a file in it (transforms.json, a bag).
    options : SequenceOptions, optional
        Overrides facts of the files, or adds missing ones.

    Raises
    ------
    InputError
        For what no reader knows, damaged or missing files, missing facts, and lens distortion.
    """
    options, place = SequenceOptions.checked(options, optional=True), as_path(path)
    if not place.exists():
        raise InputError(f"{place}: no such file or folder; expected a folder of recorded frames")
    if place.is_dir():
        enter(place)
    reader = _reader_of(place) if options.layout is None else readers.get(options.layout)
    for name in ("frames_axes", "frames_camera", "frames_topics"):
        if getattr(options, name) is not None and name not in reader.takes:
            known = ", ".join(known.name for known in readers if name in known.takes)
            raise InputError(f"--{name.replace('_', '-')}: layout {reader.name} does not take it; expected {known}")
    path = (place if place.is_dir() else place.parent) / CAMERA
    floor_db = read_json(path).get("noise_floor_db") if path.exists() else None
    if floor_db is not None and (type(floor_db) not in (int, float) or not 0 < floor_db < math.inf):
        raise InputError(f"{path}: noise_floor_db is {floor_db!r}; expected a positive number of dB")
    sequence = attrs.evolve(reader.read(place, options), noise_floor_db=floor_db)
    mask = options.hidden or place / MASK
    if options.hidden or mask.is_file():
        sequence = sequence.masked(mask)
    return sequence.cropped(options.crop).with_no_depth(options.no_depth)


def _reader_of(place: Path) -> SequenceReader:
    chances = {reader.name: reader.fits(place) for reader in readers}
    best = max(chances, key=lambda name: chances[name])
    if chances[best]:
        return readers.get(best)
    held = "a file"
    if place.is_dir():
        names = sorted(f"{path.name}/" if path.is_dir() else path.name for path in place.iterdir())
        more = " .." if len(names) > _NAMED else ""
        held = f"holds {', '.join(names[:_NAMED])}{more}" if names else "an empty folder"
    expected = f"expected one of {', '.join(readers.names())}; 'hmdwarp list layouts' says what each holds"
    raise InputError(f"{place} ({held}): no layout of recorded frames that is known: {expected}")
