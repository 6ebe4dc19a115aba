"""The conventions that frames may break: how each is named, told apart, and put right in code."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

import attrs
import numpy as np

from ..poses.assumptions import Assumption, assumption_rows
from .stated_frames import BUFFER, METRES, Reading, Stated, eye_axes

_SAME_UNIT = 0.06  # difference of the logarithms within which a scale is that of a unit
# Metres per unit that are common: of depth, and of positions.
_SCALES = {
    1e-3: "millimetres",
    1 / 5000: "1/5000 m, as TUM RGB-D",
    1e-2: "centimetres",
    1e-1: "decimetres",
    1 / 256: "1/256 m, as KITTI",
    0.3048: "feet",
    0.0254: "inches",
    1e3: "metres, where positions are in millimetres",
    1e2: "metres, where positions are in centimetres",
}


@attrs.frozen
class Convention:
    """One convention."""

    label: str
    needs: str  # the frames that show it
    fields: tuple[str, ...]  # the parts of a reading that state it
    # What is fitted for it, the least difference with a name, and the standard error beyond which
    # it is unknown: of a factor's logarithm; of the way along the ray; in pixels; in frames; of the
    # offset, in what is farthest, and in the median.
    numbers: tuple[str, ...] = ()
    least: float = 0.0
    vague: float = math.inf
    plain: str = "as stated"  # its value in words, where a reading does not differ


@attrs.frozen
class Finding:
    """What the frames say about one convention."""

    name: str
    label: str
    value: str  # what was found, or what is stated where it cannot be told
    as_stated: bool
    told: bool
    margin: float | None = None  # standard errors by which the nearest other reading is worse; None for numbers
    why: str = ""  # why it cannot be told; "" where it can


@attrs.frozen(eq=False, repr=False)
class Answer:
    """What is wrong, or that it cannot be told: headline, findings and code are one decision."""

    verdict: str  # "right", "wrong" (of what, the headline may tell), "no agreement" or "cannot be told"
    headline: str  # the verdict in one sentence
    reading: Any  # the Reading under which the frames agree best; of motion vectors the Convention
    findings: Sequence[Finding] = ()  # one for each convention; none without agreement
    is_told: bool = False  # whether the best reading is the only one that explains the frames, and nearly all
    as_good: Sequence[str] = ()  # what it may be, where frames do not tell: each explains them as well
    code: Sequence[str] = ()  # the lines that read such frames right; none where the cause is not known
    frames: int = 0
    figures: Mapping[str, float] = attrs.field(factory=dict)  # how well they agree, by name
    assumptions: Sequence[Assumption] = ()  # how a folder was read
    notes: Sequence[str] = ()  # what its depth suggests

    def __repr__(self) -> str:
        return f"<Answer {self.headline}>"

    def as_json(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {
            "verdict": self.verdict,
            "told": self.is_told,
            "frames": self.frames,
            **self.figures,
            "conventions": [attrs.asdict(finding) for finding in self.findings],
            "as_good": list(self.as_good),
            "code": list(self.code),
            "assumptions": assumption_rows(self.assumptions),
            "notes": list(self.notes),
        }


@lru_cache(256)
def differences(reading: Reading) -> tuple[str, ...]:
    """Return the names of the conventions in which a reading differs from what is stated.

    Parameters
    ----------
    reading : Reading
        Such as `Answer.reading`.
    """
    is_encoded = reading.kind == BUFFER or reading.factor < 0
    depth = "encoding" if is_encoded else "planes" if reading.offset else "scale"
    centre = "pixel" if reading.is_half_a_pixel else "centre"
    without = {"encoding", "planes", "scale", "pixel", "centre"} - {depth, centre}
    return tuple(name for name in CONVENTIONS if name not in without and restored(reading, name) != reading)


def restored(reading: Reading, name: str) -> Reading:
    """Return the reading with one convention as stated."""
    plain = Reading()
    return attrs.evolve(reading, **{field: getattr(plain, field) for field in CONVENTIONS[name].fields})


def value(reading: Reading, stated: Stated, name: str) -> str:
    """Return what a reading takes one convention for, in words."""
    if CONVENTIONS[name].plain and name not in differences(reading):
        return CONVENTIONS[name].plain
    if name == "scale":
        return " of what is stated".join(_scale_of(reading.factor))
    if name == "encoding" and reading.kind == METRES:
        return "reversed depth, converted as if it were not"
    if name == "encoding":
        low, near, far, is_reversed = _planes(reading, stated)
        planes = f"near {near:.3g} m, far {'infinite' if math.isinf(far) else f'{far:.3g} m'}"
        return f"{'reversed ' if is_reversed else ''}depth buffer of {low:g} to 1, {planes}"
    colour_up, late_s, (height, width) = reading.colour_rows_up, reading.late_s, stated.frames[0].depth.shape
    rows = "bottom row first" if colour_up or reading.depth_rows_up else "top row first"
    which = ("colour " if colour_up else "depth ") if colour_up != reading.depth_rows_up else ""
    frames, when = abs(late_s) / (stated.interval_s or math.inf), "before" if late_s > 0 else "after"
    x_px, y_px = stated.frames[0].view.fov.intrinsics((width, height))[:2]
    right_down = "pixels to the right and down"
    true_px = f"{x_px / reading.wide_x:.4g}, {y_px / reading.wide_y:.4g}"
    return {
        "order": " ".join(reading.order),
        "direction": "eye from world",
        "axes": f"{reading.axes}, {'left' if np.linalg.det(eye_axes(reading.axes)) < 0 else 'right'}-handed",
        "rows": which + rows,
        "eyes": "left and right swapped",
        "ray": "the ray",
        "planes": f"inverse depth off by {reading.offset:+.3g} /m: another near or far plane",
        "focal": f"focal lengths {true_px} pixels, in place of {x_px:.4g}, {y_px:.4g}",
        "centre": f"{-reading.pixel_x:+.1f}, {-reading.pixel_y:+.1f} {right_down} of where it is stated",
        "pixel": f"{reading.pixel_x:+.2f}, {reading.pixel_y:+.2f} {right_down}",
        "time": f"{abs(late_s) * 1e3:.1f} ms ({frames:.2f} frames) {when} the picture",
    }[name]


def _scale_of(factor: float) -> tuple[str, str]:
    """Return the metres per unit, and ": " and the common unit that has as many, if any."""
    near = [(one, f": {words}") for one, words in _SCALES.items() if abs(math.log(one * factor)) < _SAME_UNIT]
    metres, words = near[0] if near else (1 / factor, "")
    return f"{metres:.4g}", words


def _planes(reading: Reading, stated: Stated) -> tuple[float, float, float, bool]:
    """Return the low end of a depth buffer, near, far, and whether it is reversed."""
    low = -1.0 if stated.signed else 0.0
    is_reversed = reading.factor > 0
    ends = [reading.offset + reading.factor * (end - reading.end) for end in (low, 1.0)]
    near, far = max(ends), min(ends)
    return low, 1 / near, 1 / far if far > 0.005 else math.inf, is_reversed


_POSES_DIFFER = "frames that are turned and moved against each other"
_APART = "frames from places farther apart"
_DEPTH = ("kind", "factor", "end", "offset")
_WIDE, _PIXELS = ("wide_x", "wide_y"), ("pixel_x", "pixel_y")
_ROWS = "frames that look up or down, roll or rise against each other"
_EYES = "pairs of eyes at several places of the head: give two folders, the left eye's first"
_TIME = "five or more frames with times, close together, while the head changes its speed"
CONVENTIONS = {
    "order": Convention("quaternion order", _POSES_DIFFER, ("order",), plain=""),
    "direction": Convention("pose", _POSES_DIFFER, ("inverse",), plain="world from eye"),
    "axes": Convention("axes", _POSES_DIFFER, ("axes",), plain=""),
    "rows": Convention("rows", _ROWS, ("colour_rows_up", "depth_rows_up"), plain=""),
    "eyes": Convention("eyes", _EYES, ("eyes_swapped",), plain="as named"),
    "ray": Convention("depth along", f"{_APART}, or a wider view", ("along",), ("along",), 0.5, 0.2, "-z"),
    "encoding": Convention("depth encoding", _APART, _DEPTH, plain="distance"),
    "planes": Convention(
        "near and far", f"{_APART}, with things near and far", ("offset",), ("factor", "offset"), 0.05, 0.1
    ),
    "scale": Convention("depth scale", _APART, _DEPTH, ("factor",), 0.05, 0.1),
    "focal": Convention(
        "field of view", "a head that turns far, both ways, and moves ahead or back", _WIDE, _WIDE, 0.015, 0.05
    ),
    "centre": Convention("principal point", "frames that roll, or approach something", _PIXELS, _PIXELS, 0.75, 5.0),
    "pixel": Convention("pixel centres", "frames that roll or approach", _PIXELS, _PIXELS, 0.25, 0.15),
    "time": Convention("time of the pose", _TIME, ("late_s",), ("late_s",), 0.1, 0.15, "that of the picture"),
}


def code(reading: Reading, stated: Stated) -> Iterator[str]:
    """Yield the lines that read such frames right, in the order in which they are to stand."""
    wrong = differences(reading)
    if "order" in wrong:
        yield "pose = Pose(pose.position_m, np.roll(pose.orientation_xyzw, -1))  # w came first"
    if "direction" in wrong:
        yield "pose = pose.inverse()  # it took points of the world to the eye"
    if "axes" in wrong:
        yield from _turned(reading.axes)
    if "eyes" in wrong:
        yield "left, right = right, left  # the pictures, or the poses"
    if "time" in wrong:
        yield f"pose = track.at(time_ns + {round(reading.late_s * 1e9)}).pose"
    if "rows" in wrong:
        both = [word for word, up in (("colour", reading.colour_rows_up), ("depth_m", reading.depth_rows_up)) if up]
        yield f"{', '.join(both)} = {', '.join(f'{array}[::-1]' for array in both)}  # the bottom row came first"
    if "encoding" in wrong and reading.kind == BUFFER:
        low, near, far, is_reversed = _planes(reading, stated)
        ends = (far, near) if is_reversed else (near, far)
        planes = ", ".join("np.inf" if math.isinf(distance) else f"{distance:.4g}" for distance in ends)
        yield f"depth_m = 1 / DepthLayer({low:g}, 1, {planes}).inverse_depth(depth_m)"
    elif "encoding" in wrong or "planes" in wrong:
        constant = reading.offset - reading.factor * reading.end
        yield f"depth_m = 1 / ({constant:.5g} + {reading.factor:.5g} / depth_m)  # better: the planes of the renderer"
    if "scale" in wrong:
        yield f"depth_m = depth_m * {_scale_of(reading.factor)[0]}  # or --depth-scale, times as much"
    if "focal" in wrong or "centre" in wrong:
        yield "fx, fy, cx, cy = fov.intrinsics((width, height))"
        x, y = ("" if wide == 1 else f" / {wide:.4g}" for wide in (reading.wide_x, reading.wide_y))
        right, down = (f" - {shift:.4g}" if "centre" in wrong else "" for shift in (reading.pixel_x, reading.pixel_y))
        centre = f"cx{right}, cy{down}".replace("- -", "+ ")
        yield f"fov = Fov.from_intrinsics(fx{x}, fy{y}, {centre}, width, height)"
    if "pixel" in wrong:
        was, now = (0, 0.5) if reading.pixel_x > 0 else (0.5, 0)
        yield f"fx, fy, cx, cy = fov.intrinsics((width, height), centre={was})  # half a pixel"
        yield f"fov = Fov.from_intrinsics(fx, fy, cx, cy, width, height, centre={now})"
    if "ray" in wrong:
        yield "rays = View(pose, fov).rays((width, height))[::-1]"
        yield "depth_m = depth_m / np.linalg.norm(rays, axis=-1)  # it was along them"


def _turned(axes: str) -> Iterator[str]:
    eye = eye_axes(axes)
    if np.linalg.det(eye) > 0:
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_matrix(eye.T).as_quat(canonical=True)
        numbers = ", ".join(f"{round(float(value), 6) + 0.0:g}" for value in turn)
        yield f"pose = pose @ Pose(orientation_xyzw=({numbers}))  # the eye's axes were those of {axes}"
        return
    yield f"eye = np.array({[[int(cell) for cell in row] for row in eye]})  # right, up and back in the axes of {axes}"
    yield "world = np.diag([1, 1, -1])  # the other hand"
    yield "turn = Rotation.from_matrix(world @ pose.rotation_matrix @ eye.T)  # of SciPy"
    yield "pose = Pose(world @ pose.position_m, turn.as_quat())"
