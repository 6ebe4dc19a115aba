"""A recorded sequence: frames with depth, where each was taken, and the head's own motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from collections.abc import Sequence as Several
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, srgb8_from_linear
from ...geometry import Fov, Hidden, Pose, View
from ...gpu import flip_rows
from ...poses import PoseTrack
from ...poses.assumptions import Assumption, By
from ..repairs import RepairChain
from .options import FAR
from .picture_files import read_colour

_JPEG = 8  # of 255: as far as a JPEG is off in a plain area next to an edge
# Facts that every recording has, as its assumptions name them.
INTRINSICS, DEPTH_SCALE, NO_DEPTH = "intrinsics", "depth scale", "no depth"
AXES, POSE, CLOCK = "camera axes", "camera pose", "frame clock"
FACTS = (INTRINSICS, DEPTH_SCALE, NO_DEPTH, AXES, POSE, CLOCK)
_OF_16_BITS = 65535
Pictures = tuple[NDArray[np.uint8], NDArray[np.float32]]


@attrs.frozen(eq=False)
class RecordedFrame:
    """A picture with depth, its instant and view. Pixels are read at each access, and not kept."""

    name: str  # of its file, for messages
    time_ns: int  # since the first frame of its sequence
    pose: Pose  # world_from_eye in the axes of OpenXR
    fov: Fov
    size: tuple[int, int]  # (w, h) in pixels
    read: Callable[[], Pictures] = attrs.field(repr=False)  # colour and depth_m, from the file; raises InputError
    # Reads depth as its file has it, in its own unit; None where nothing else does than `read`.
    raw_depth: Callable[[], NDArray[Any]] | None = attrs.field(default=None, repr=False)
    hidden: Hidden | None = None  # what a lens hides of it, None for nothing

    @property
    def view(self) -> View:
        return View(self.pose, self.fov, hidden=self.hidden)

    def rim(self) -> int:
        """Return how many outermost pixels hold one colour, as rectification leaves; 0 for none."""
        colour = self.colour.astype(np.int16)
        same = np.abs(colour - colour[0, 0]).max(axis=2) <= _JPEG
        lines = same.all(axis=1), same.all(axis=0)
        sides = [int(np.argmin(side)) for line in lines for side in (line, line[::-1])]  # up to the first that differs
        return max(sides) if min(sides) else 0

    def cropped(self, pixels: int) -> RecordedFrame:
        """Return the frame without its outermost pixels. Errors: InputError where none is left."""
        size = (self.size[0] - 2 * pixels, self.size[1] - 2 * pixels)
        if min(size) < 1:
            found = "x".join(map(str, self.size))
            raise InputError(f"--crop {pixels}: {self.name} has {found} pixels; expected to leave one or more")
        left, right, down, up = self.fov.tangents
        x, y = pixels * (right - left) / self.size[0], pixels * (up - down) / self.size[1]
        inner = np.s_[pixels : pixels + size[1], pixels : pixels + size[0]]

        def read() -> Pictures:
            colour, depth_m = self.read()
            return np.ascontiguousarray(colour[inner]), np.ascontiguousarray(depth_m[inner])

        fov = Fov.from_tangents((left + x, right - x, down + y, up - y))
        return attrs.evolve(self, fov=fov, size=size, read=read)

    def far_without_depth(self) -> RecordedFrame:
        def read() -> Pictures:
            colour, depth_m = self.read()
            return colour, np.where(depth_m <= 0, np.float32(np.inf), depth_m)

        return attrs.evolve(self, read=read)

    @property
    def colour(self) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 sRGB, row 0 at the top; read at each access."""
        return self.read()[0]

    @property
    def depth_m(self) -> NDArray[np.float32]:
        """(h, w) metres along -z; 0 or NaN is no depth, inf infinitely far; read at each access."""
        return self.read()[1]


@attrs.frozen(eq=False)
class Sequence:
    """Recorded frames in the order of their instants; all of one size."""

    name: str
    path: Path
    layout: str  # name of the reader
    frames: tuple[RecordedFrame, ...]
    # The recorded motion of the camera, world_from_head, from the first frame to the last: their
    # poses, and those between that the files have.
    track: PoseTrack
    notes: tuple[str, ...] = ()  # what a user must know, one sentence each
    repair: RepairChain = RepairChain()  # what mends the depth of a frame before it is warped
    assumptions: tuple[Assumption, ...] = ()  # facts that all frames share, with who says them
    noise_floor_db: float | None = None  # PSNR of two renders of one frame that differ by noise; None if unknown

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, at: int) -> RecordedFrame:
        return self.frames[at]

    def __repr__(self) -> str:
        (wide, high), seconds = self.frames[0].size, (self.frames[-1].time_ns - self.frames[0].time_ns) * 1e-9
        return f"<Sequence '{self.name}', {self.layout}: {len(self)} frames of {wide}x{high} in {seconds:.2f} s>"

    def with_no_depth(self, meaning: str) -> Sequence:
        if meaning != FAR:
            return self
        fact = Assumption(NO_DEPTH, "infinitely far", By.USER, "--no-depth")
        frames = tuple(frame.far_without_depth() for frame in self.frames)
        return attrs.evolve(self, frames=frames, assumptions=replaced(self.assumptions, fact))

    def repaired(self, repair: RepairChain) -> Sequence:
        if not repair.steps:
            return self
        note = f"The depth of late frames is mended by {repair.text}; the truth is what was recorded."
        return attrs.evolve(self, repair=repair, notes=(*self.notes, note))

    def masked(self, mask: Path) -> Sequence:
        """Return the sequence without what a mask of its size has black. Errors: InputError."""
        seen = flip_rows(read_colour(mask)[..., :3].max(axis=2) > 0)
        wide, high = self.frames[0].size
        if seen.shape != (high, wide) or not seen.any():
            found = "all black" if seen.shape == (high, wide) else f"{seen.shape[1]}x{seen.shape[0]} pixels"
            raise InputError(f"{mask}: {found}; expected {wide}x{high}, as the frames, black where a lens hides them")
        ends = np.stack([seen.argmax(axis=0), high - flip_rows(seen).argmax(axis=0)], axis=1)
        rows = np.where(np.asarray(seen.any(axis=0))[:, None], ends, 0) / high
        hidden = Hidden.of_rows(rows, self.frames[0].fov)
        frames = tuple(attrs.evolve(frame, hidden=hidden) for frame in self.frames)
        return attrs.evolve(self, frames=frames)

    def cropped(self, pixels: int) -> Sequence:
        if not pixels:
            return self
        note = f"The {pixels} outermost pixels of each picture are left out."
        frames = tuple(frame.cropped(pixels) for frame in self.frames)
        return attrs.evolve(self, frames=frames, notes=(*self.notes, note))

    @property
    def rate_hz(self) -> float:
        """Frames per second: one over the median step; 0 for a single frame."""
        steps = np.diff([frame.time_ns for frame in self.frames])
        return 1e9 / float(np.median(steps)) if len(steps) else 0.0


def replaced(facts: Iterable[Assumption], *by: Assumption) -> tuple[Assumption, ...]:
    return tuple({fact.what: fact for fact in (*facts, *by)}.values())


def is_largest(depth: NDArray[Any]) -> NDArray[np.bool_]:
    """Return where integers are the largest of their type or of 16 bits, as none is measured."""
    if depth.dtype.kind not in "iu" or not depth.size:
        return np.zeros(depth.shape, bool)
    most = int(depth.max())
    return np.asarray((depth == most) & (most in {np.iinfo(depth.dtype).max, _OF_16_BITS}))


def in_metres(depth: NDArray[Any], scale: float) -> NDArray[np.float32]:
    """Return depth in metres as float32; 0 where there is none, as in the largest of integers."""
    metres = depth.astype(np.float32) if scale == 1 else (depth * np.float64(scale)).astype(np.float32)
    return np.where(is_largest(depth) | np.isnan(metres), np.float32(0), metres)


def as_pictures(colour: NDArray[Any], depth_m: NDArray[np.float32]) -> Pictures:
    """Return the colour as bytes without alpha, and NaN for the depth where alpha is 0."""
    if colour.shape[2] == 4:
        depth_m = np.where(colour[..., 3] == 0, np.float32(np.nan), depth_m)
        colour = colour[..., :3]
    if colour.dtype != np.uint8:
        colour = srgb8_from_linear(colour)
    return np.ascontiguousarray(colour), depth_m


LOOKED_AT = 3  # frames of a sequence: decoding one takes milliseconds
# A region of sky: its share of the picture, and of the picture's edge that it reaches.
_LEAST_AREA, _LEAST_TOP, _LEAST_SIDE = 0.04, 0.15, 0.3
_FINEST = 160  # narrower than one over this of the picture's width, a region is no sky
# What lies within a share below 2^n - 1 is as frequent, unless a sensor of n bits saturates there.
_BELOW, _LEAST_MOST, _LEAST_SHARE = 64, 511, 0.005
# Metres to the nearest surface: beyond, a head that moves by a tenth of it at most is rarely meant.
# Beyond the farthest it is sky, written as a large number.
_FAR_M, _FARTHEST_M, _MOVED = 40.0, 2e4, 0.1
_FAR_AXIS = 0.2  # of a side from the middle: no camera or headset is built so
_UNITS = {"centimetres": 0.01, "millimetres": 0.001}
# Of a depth buffer at most 1 half the values are above the first or below the second: a near plane
# of 0.1 m puts all beyond 1 m there, and nobody's eye is 5 cm from half of what it sees.
_STANDARD, _REVERSED = 0.9, 0.05


def depth_notes(sequence: Sequence) -> list[str]:
    """Return what some frames suggest: no depth, wrong values, unit or intrinsics, sky as none."""
    last = len(sequence.frames) - 1
    looked = [sequence.frames[at] for at in sorted({round(last * k / (LOOKED_AT - 1)) for k in range(LOOKED_AT)})]
    depths = [frame.depth_m for frame in looked]
    raw = [frame.raw_depth() for frame in looked if frame.raw_depth is not None]
    first = np.array([frame.pose.position_m for frame in sequence.frames])
    moved_m = float(np.linalg.norm(first - first[0], axis=1).max())
    is_far = any(
        assumption.what == NO_DEPTH and assumption.value.startswith("infinitely") for assumption in sequence.assumptions
    )
    notes = []
    if empty := [depth for depth in depths if not (depth > 0).any()]:
        below = any((depth < 0).any() for depth in empty)
        why = " It is below 0: expected metres along -z, which are above." if below else ""
        looked_at = f"{len(empty)} of {len(depths)} frames looked at"
        notes.append(f"{looked_at} have no depth at all: warps by depth show nothing of them.{why}")
    notes += about_largest(raw) + ([] if is_far else about_sky(depths))
    notes += about_unit(depths, moved_m, "--depth-scale {:g}", raw)
    left, right, down, up = sequence.frames[0].fov.tangents.tolist()
    across, below = -left / (right - left), up / (up - down)
    if max(abs(across - 0.5), abs(below - 0.5)) > _FAR_AXIS:
        notes.append(
            f"The optical axis is at {100 * across:.0f} % of the width and {100 * below:.0f} % of the height, which is "
            "where intrinsics for another picture size put it. 'hmdwarp check' finds those under which the frames "
            "agree; --intrinsics states them."
        )
    return notes


def about_largest(depths: Several[NDArray[Any]]) -> list[str]:
    """Return a note on integers of files that are the largest of their type or sensor."""
    whole = [depth for depth in depths if depth.dtype.kind in "iu" and depth.size]
    if not whole:
        return []
    most, pixels = max(int(depth.max()) for depth in whole), sum(depth.size for depth in whole)
    at = [depth == most for depth in whole]
    count = sum(int(found.sum()) for found in at)
    pictures = "its depth" if len(whole) == 1 else f"the depth of {len(whole)} frames looked at"
    are = f"{count} pixels ({100 * count / pixels:.2g} %) of {pictures} are {most}, the largest value of"
    if any(is_largest(depth).any() for depth in whole):
        kind = str(whole[0].dtype) if most == np.iinfo(whole[0].dtype).max else "16 bits"
        return [f"{are} {kind} (or of a PGM's own bits): they are taken as no depth."]
    below = sum(int((depth > most - most // _BELOW).sum()) for depth in whole) - count
    if most & (most + 1) or most < _LEAST_MOST or count < max(below, _LEAST_SHARE * pixels):
        return []
    advice = "they are taken as depth. If the sensor saturates there, write 0 for them."
    return [f"{are} {most.bit_length()} bits, and hardly any is a little less: {advice}"]


def about_sky(depths: Several[NDArray[np.floating]]) -> list[str]:
    """Return a note where large regions without depth, in metres, reach the border as sky does."""
    share = max(map(_sky, depths), default=0.0)
    found = f"A region without depth of {100 * share:.0f} % of the picture reaches its border."
    hint = "state it by --no-depth far: it is a hole otherwise, which a fill covers with what is near."
    return [f"{found} If that is sky, written as no depth, {hint}"] if share else []


def about_unit(
    depths: Several[NDArray[np.floating]], moved_m: float, option: str, raw: Several[NDArray[Any]] = ()
) -> list[str]:
    """Return a note on depth (metres; raw as in files) that is hardly metres. option: a format."""
    known = np.concatenate([depth[np.isfinite(depth) & (depth > 0)].ravel()[::7] for depth in depths])
    if len(known) and moved_m and known.min() < known.max() <= 1:
        middle, spans = float(np.median(known)), f"Depth goes from {known.min():.3g} to {known.max():.3g}"
        floats = [one[np.isfinite(one)] for one in raw if one.dtype.kind == "f"]
        as_read = max((float(one.max(initial=0)) for one in floats), default=0.0)
        if middle < _REVERSED and as_read > 1:
            read = f"up to {as_read:.3g} in the file: if that is metres already, {option.format(1)} takes it so."
            return [f"{spans} m by the scale that is stated, and {read}"]
        if not _REVERSED <= middle <= _STANDARD:
            side, planes = ("above", "near, far") if middle > _STANDARD else ("below", "far, near")
            metres = f"If it is one, 1 / hmdwarp.DepthLayer(0, 1, {planes}).inverse_depth(depth) has metres"
            why = f"half of it {side} {middle:.3g}: so are the values of a depth buffer, not metres. {metres}"
            return [f"{spans}, {why}; 'hmdwarp check' finds near and far."]
    near = float(np.quantile(known, 0.01, method="lower")) if len(known) else 0.0
    if not _FAR_M < near <= _FARTHEST_M or not 0 < moved_m < _MOVED * near:
        return []
    readings = [f"{option.format(unit)} takes it as {name}: {near * unit:.3g} m" for name, unit in _UNITS.items()]
    moves = f"while the eye moves by {moved_m:.2g} m, so that hardly anything shifts against anything else."
    return [f"The nearest surface is {near:.4g} m away, {moves} If depth is in another unit, {'; '.join(readings)}."]


def _sky(depth: NDArray[np.floating]) -> float:
    """Return the share of the largest region without depth at the top or a side, rims apart."""
    from scipy.ndimage import binary_opening, label

    known = depth > 0
    if not known.any():
        return 0.0
    rows, columns = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    left, right = columns[0], columns[-1] + 1
    # What is empty above is a rim only where the sides have one too.
    top = rows[0] if rows[0] <= 2 * min(left, known.shape[1] - right) else 0
    inner = ~known[top:, left:right]
    regions, count = label(binary_opening(inner, iterations=max(1, known.shape[1] // _FINEST)))
    best = 0.0
    for number in range(1, count + 1):
        region = regions == number
        is_above = region[0].mean() >= _LEAST_TOP
        is_beside = max(region[:, 0].mean(), region[:, -1].mean()) >= _LEAST_SIDE
        if is_above or is_beside:
            best = max(best, region.sum() / known.size)
    return best if best >= _LEAST_AREA else 0.0
