"""Motion vectors and depth, as an engine gives them to a headset's runtime, and their verdict.

Names are those of XrFrameSynthesisInfoEXT (XR_EXT_frame_synthesis 1), which has all of
XrCompositionLayerSpaceWarpInfoFB (XR_FB_space_warp 2). docs/motion.md has every key.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..base import InputError, linear_from_srgb, listed, srgb8_from_linear
from ..base.named_files import named_in
from ..geometry import DepthLayer, Fov, Pose, View, inverse_depth_from_metres
from ..sources.sequences import read_colour, read_depth
from ..sources.sequences.frame_files import number_of, numbers_of, read_json
from ..sources.sequences.picture_files import EXR, NPY, read_exr, read_npy
from .conventions import Answer, Finding
from .search import SURE

Array = NDArray[np.float64]
Size = tuple[int, int]
FILE = "motion.json"
NDC, UV, PIXELS, METRES = "ndc", "uv", "pixels", "metres"
DOWN, UP = "down", "up"
_FORWARD, BACKWARD = "current - previous", "previous - current"
OUT, IN = "out", "in"
# Each property of a convention, what it may be, and its name in text; the first is the extension's.
PROPERTIES = {
    "unit": ((NDC, UV, PIXELS, METRES), "unit"),
    "y": ((DOWN, UP), "y axis"),
    "sign": ((_FORWARD, BACKWARD), "direction"),
    "jitter": ((OUT, IN), "jitter"),
}
_ANGLES = ("angleLeft", "angleRight", "angleDown", "angleUp")
# Pixels of colour: what is finer differs by sampling alone, what is coarser is light and shadow.
_BLUR_PX = (1.0, 6.0)
_TWO = "XR_FRAME_SYNTHESIS_INFO_USE_2D_MOTION_VECTOR_BIT_EXT"
_VECTORS = ("motion", "vector", "velocity", "flow")  # layers of an EXR file that may hold them
_PLANES, _INFINITE = ("minDepth", "maxDepth", "nearZ", "farZ"), "Infinity"


@attrs.frozen
class Convention:
    """What the numbers of motion vectors mean; the default is that of XR_EXT_frame_synthesis."""

    unit: str = NDC  # NDC: -1 to 1; UV: 0 to 1; PIXELS of colour; METRES along the eye's axes
    y: str = DOWN
    sign: str = _FORWARD
    jitter: str = OUT  # whether the sub-pixel jitter of the projections is in the vectors

    def __attrs_post_init__(self) -> None:
        for name, (values, _) in PROPERTIES.items():
            if getattr(self, name) not in values:
                raise InputError(f"{name} of motion vectors is {getattr(self, name)!r}: expected {', '.join(values)}")


@attrs.frozen(eq=False)
class MotionFrame:
    """One frame of one eye; pictures have the top row first."""

    name: str
    colour: NDArray[np.uint8]  # (H, W, 3) sRGB
    view: View  # without jitter
    time_ns: int
    # (h, w) of a depth buffer, as `planes` says; metres along -z without. None where it lacks.
    depth: Array | None = None
    # (h, w, 2 or 3) as stored, then times `scale` plus `offset`. None: the frame is a truth alone.
    vectors: Array | None = None
    planes: DepthLayer | None = DepthLayer()
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)
    jitter: tuple[float, ...] = (0.0, 0.0)  # pixels of colour by which the projection moves everything right and down
    app_space_delta: Pose = attrs.field(factory=Pose)  # of this frame's space in that of the frame before

    def __attrs_post_init__(self) -> None:
        for name, array, shapes in (("depth", self.depth, ((),)), ("motion", self.vectors, ((2,), (3,), (4,)))):
            if array is not None and (array.ndim < 2 or array.shape[2:] not in shapes or not array.size):
                raise InputError(f"{self.name}: {name} has shape {array.shape}: expected (h, w), and 2 to 4 for motion")
        if self.vectors is not None and self.depth is None:
            raise InputError(f"{self.name}: motion vectors without depth: expected both, of any resolution")

    @property
    def size(self) -> Size:
        """(w, h) of colour."""
        return self.colour.shape[1], self.colour.shape[0]

    @cached_property
    def motion(self) -> Array:
        """(h, w, 2 or 3) vectors with scale and offset."""
        vectors: Any = self.vectors  # callers look for frames with vectors, which have depth
        count = min(vectors.shape[2], 3)
        return np.asarray(vectors[..., :count] * self.scale[:count] + self.offset[:count])

    @cached_property
    def inverse_depth(self) -> Array:
        """(h, w) 1/m, NaN where there is none."""
        depth: Any = self.depth
        return inverse_depth_from_metres(depth) if self.planes is None else self.planes.inverse_depth(depth)

    @cached_property
    def nearest_around(self) -> Array:
        """(h, w) the largest inverse depth within a pixel."""
        return np.asarray(ndimage.maximum_filter(np.nan_to_num(self.inverse_depth), 3))

    @cached_property
    def brightness(self) -> Array:
        """(H, W) brightness without its finest detail and its shade."""
        root = np.sqrt(linear_from_srgb(self.colour).mean(axis=2).astype(np.float64))
        return np.asarray(np.subtract(*(ndimage.gaussian_filter(root, blur) for blur in _BLUR_PX)))


@attrs.frozen(eq=False)
class MotionFrames:
    """Frames in the order of time. Errors: InputError for too few, and for what does not fit."""

    frames: Sequence[MotionFrame]
    stated: Convention = Convention()

    def __attrs_post_init__(self) -> None:
        times = [frame.time_ns for frame in self.frames]
        if any(later <= one for one, later in zip(times, times[1:], strict=False)):
            raise InputError("frames: displayTime does not rise: expected the frames in the order of time")
        if not self.pairs:
            raise InputError(f"{len(times)} frames: expected two or more with depth, with motion from the second on")
        if len({frame.size for frame in self.frames}) > 1:
            raise InputError(f"frames have colour of {sorted({f.size for f in self.frames})} pixels: expected one size")

    @cached_property
    def pairs(self) -> list[tuple[MotionFrame, MotionFrame]]:
        """Each frame with vectors, and the one that they lead to: the last before with depth."""
        rendered = [frame for frame in self.frames if frame.depth is not None]
        return [(one, before) for before, one in zip(rendered, rendered[1:], strict=False) if one.vectors is not None]


def read_motion(path: Path) -> MotionFrames:
    """Return frames with motion vectors.

    Parameters
    ----------
    path : Path
        A folder with motion.json, or that file; docs/motion.md has every key.

    Raises
    ------
    InputError
        For what cannot be read, or does not fit together.
    """
    where = path / FILE if path.is_dir() else path
    data = read_json(where, "an object with frames, as docs/motion.md has it")
    rows, stated = data.pop("frames", None), data.pop("convention", {})
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{where}: frames: expected a list of objects, one for each frame")
    if not isinstance(stated, dict) or not stated.keys() <= PROPERTIES.keys():
        raise InputError(f"{where}: convention is {stated}: expected an object of {', '.join(PROPERTIES)}")
    folder = where.parent
    found = [_frame(f"{where}: frame {k}", folder, {**_USUAL, **data, **row}) for k, row in enumerate(rows)]
    return MotionFrames(found, Convention(**stated))


# What a frame is without its key; None: there must be one, or there is none.
_USUAL: dict[str, Any] = {
    **dict.fromkeys(("colour", "depth", "motion", "pose", "fov", "displayTime")),
    **dict.fromkeys(("subImage", "motionVectorSubImage", "depthSubImage")),
    "jitter": (0, 0),
    "layerFlags": (),
    "motionVectorScale": (1, 1, 1, 0),
    "motionVectorOffset": (0, 0, 0, 0),
    "appSpaceDeltaPose": {"position": (0, 0, 0), "orientation": (0, 0, 0, 1)},
    **dict(zip(_PLANES, (0.0, 1.0, 0.1, _INFINITE), strict=True)),
    "depthUnit": "buffer",
}


def _frame(at: str, folder: Path, row: Mapping[str, Any]) -> MotionFrame:
    if unknown := row.keys() - _USUAL.keys():
        raise InputError(f"{at}: {', '.join(sorted(unknown))}: expected the keys of docs/motion.md")

    def picture(key: str, image: str, read: Callable[[Path], NDArray[Any]]) -> Any:
        """Return the rectangle of an XrSwapchainSubImage, counted from the top left pixel."""
        if row[key] is None and key != "colour":
            return None
        if not isinstance(row[key], str):
            raise InputError(f"{at}: {key} is {row[key]!r}: expected the name of a file")
        path = named_in(folder, row[key])
        whole = read_npy(path, channels=True) if path.suffix.lower() == NPY and key != "depth" else read(path)
        if row[image] is None:
            return whole
        rect = row[image].get("imageRect") if isinstance(row[image], dict) else None
        if not isinstance(rect, dict):
            raise InputError(f"{at}: {image} is {row[image]!r}: expected an imageRect of offset and extent")
        x, y = map(int, _numbers(at, "offset", rect.get("offset"), "xy"))
        wide, high = map(int, _numbers(at, "extent", rect.get("extent"), ("width", "height")))
        found = whole[max(y, 0) : y + high, max(x, 0) : x + wide]
        if min(x, y) < 0 or not found.size or found.shape[:2] != (high, wide):
            raise InputError(f"{at}: {image} of {wide}x{high} at {x}, {y}: the file has {whole.shape[1::-1]}")
        return found

    colour = picture("colour", "subImage", read_colour)
    colour = colour[..., :3] if colour.dtype == np.uint8 else srgb8_from_linear(colour[..., :3])
    depth = picture("depth", "depthSubImage", read_depth)
    if depth is not None:  # of a buffer: integers are of their whole range
        depth = depth / np.iinfo(depth.dtype).max if depth.dtype.kind in "iu" else depth.astype(np.float64)
    if (vectors := picture("motion", "motionVectorSubImage", _vectors)) is not None:
        vectors = vectors.astype(np.float64)[..., : 2 if _TWO in str(row["layerFlags"]) else None]
    if row["depthUnit"] not in ("buffer", METRES):
        raise InputError(f"{at}: depthUnit is {row['depthUnit']!r}: expected buffer or {METRES}")
    planes = [math.inf if row[key] == _INFINITE else number_of(at, key, row[key]) for key in _PLANES]
    return MotionFrame(
        row["colour"],
        colour,
        View(_pose(at, "pose", row["pose"]), Fov(*_numbers(at, "fov", row["fov"], _ANGLES))),
        int(number_of(at, "displayTime", row["displayTime"], "nanoseconds")),
        depth,
        vectors,
        DepthLayer(*planes) if row["depthUnit"] == "buffer" else None,
        _numbers(at, "motionVectorScale", row["motionVectorScale"], "xyzw")[:3],
        _numbers(at, "motionVectorOffset", row["motionVectorOffset"], "xyzw")[:3],
        _numbers(at, "jitter", row["jitter"], "xy"),
        _pose(at, "appSpaceDeltaPose", row["appSpaceDeltaPose"]),
    )


def _numbers(at: str, key: str, value: Any, names: Sequence[str]) -> tuple[float, ...]:
    """Return numbers of a list, or of an object with these names."""
    return numbers_of(at, key, [value.get(name) for name in names] if isinstance(value, dict) else value, len(names))


def _pose(at: str, key: str, value: Any) -> Pose:
    if not isinstance(value, dict):
        raise InputError(f"{at}: {key} is {value!r}: expected an XrPosef: position and orientation")
    parts = (("position", "xyz"), ("orientation", "xyzw"))
    return Pose(*(_numbers(at, f"{key}.{part}", value.get(part), names) for part, names in parts))


def _vectors(path: Path) -> NDArray[Any]:
    """Return (h, w, 2 to 4): of EXR the layer that is named so, else red, green and blue."""
    if path.suffix.lower() != EXR:
        return read_colour(path) / 255.0
    layers: dict[str, dict[str, NDArray[np.float32]]] = {}
    for name, pixels in read_exr(path).channels.items():
        layers.setdefault(name.rpartition(".")[0], {})[name.rpartition(".")[2].upper()] = pixels
    named = [one for name, one in layers.items() if name.rpartition(".")[2].lower().startswith(_VECTORS)]
    found = named[0] if named else layers.get("", {})
    axes = "XYZ" if {*"XY"} <= found.keys() else "RGB"
    # X, Y, Z and W are Blender's: to the frame before, and to the one after.
    parts = [found[axis] for axis in (axes[:2] if "W" in found else axes) if axis in found]
    if len(parts) < 2:
        raise InputError(f"{path}: layers {', '.join(layers)}; expected R and G, or X and Y of a layer of vectors")
    return np.stack(parts, axis=-1)


_ACROSS, _DOWN = 20, 15  # blocks of a picture
BLOCKS = _ACROSS * _DOWN
_SCORED = 5000  # pixels of each frame by which candidates are told apart
_EDGE_PX, _EDGE = 3, 1.15  # pixels around, and ratio of distances: another surface is near
_MISSED = 0.02  # of the brightness, beside what 0.75 pixels make: something else was there
_FAR = 1e-3  # 1/m: what differs by less is equally far
_SURFACE = 0.06  # share of the depth: what differs by less may be one surface that came nearer by itself

_CANDIDATES = tuple(Convention(*values) for values in itertools.product(*(values for values, _ in PROPERTIES.values())))


class Pair:
    """A frame with vectors, and the one before, sampled at the centres of the vectors' pixels.

    step: every so many of them, in both directions.
    """

    def __init__(self, now: MotionFrame, before: MotionFrame, step: int = 1) -> None:
        self.now, self.before, first = now, before, step // 2
        self.vectors = now.motion[first::step, first::step]  # (h, w, 2 or 3)
        # (h, w, 2) places in the picture, 0 to 1, y down, and the number of the block of each.
        self.uv = grid(now.motion.shape[1::-1])[first::step, first::step]
        across, down = (self.uv * (_ACROSS, _DOWN)).astype(np.intp).transpose(2, 0, 1)
        self.block = down * _ACROSS + across
        self.bright = sampled(now.brightness, self.uv)  # of the frame itself; all conventions compare with it
        # (h, w) 1/m of the frame's own depth there, NaN for none; whether no other surface is near.
        self.inverse = nearest_at(now.inverse_depth, self.uv)
        depth, wide = np.nan_to_num(self.inverse), 2 * _EDGE_PX + 1
        nearest, farthest = ndimage.maximum_filter(depth, wide), ndimage.minimum_filter(depth, wide)
        self.one_surface = nearest < farthest * _EDGE + 10 * _FAR
        # The view of the frame before, in the space of this one. What stands still was in that eye
        # at these places, (h, w, 3), times 1/m, and at this inverse depth.
        self.then_view = before.view.at(now.app_space_delta.inverse() @ before.view.pose)
        turn = self.then_view.pose.inverse() @ now.view.pose
        along = _along_of(now.view, self.uv - now.jitter / np.array(now.size))
        self.still = along @ turn.rotation_matrix.T + turn.position_m * depth[..., None]
        self.expected = self.inverse / np.maximum(-self.still[..., 2], 1e-6)

    def places(self, convention: Convention) -> Array:
        """Return (h, w, 2) where each pixel was in the picture before, 0 to 1, y down."""
        now, before = (np.array(frame.jitter) / frame.size for frame in (self.now, self.before))
        off = convention.jitter == OUT
        here = self.uv - now if off else self.uv
        way = self.vectors * (1 if convention.sign == _FORWARD else -1)
        way = way * np.array((1, 1 if convention.y == DOWN else -1, 1))[: way.shape[2]]
        with np.errstate(all="ignore"):
            if convention.unit == METRES:
                place = _along_of(self.now.view, here) / self.inverse[..., None]
                place[..., :2] -= way[..., :2] * (1, -1)
                depth = place[..., 2] - way[..., 2] if way.shape[2] > 2 else self.still[..., 2] / self.inverse
                left, right, down, up = self.then_view.fov.tangents
                x, y = (place[..., k] / np.where(depth < 0, -depth, np.nan) for k in (0, 1))  # NaN behind the eye
                then = np.stack([(x - left) / (right - left), (up - y) / (up - down)], axis=-1)
            else:
                then = here - way[..., :2] * {NDC: 0.5, UV: 1.0, PIXELS: 1 / np.array(self.now.size)}[convention.unit]
        return then + before if off else then


def grid(size: Size) -> Array:
    """Return (h, w, 2) centres of a picture's pixels, 0 to 1, y down."""
    return np.stack(np.meshgrid(*((np.arange(count) + 0.5) / count for count in size)), axis=-1)


def _along_of(view: View, uv: Array) -> Array:
    """Return (.., 3) directions in the eye through places of the picture, z = -1."""
    left, right, down, up = view.fov.tangents
    x, y = left + uv[..., 0] * (right - left), up - uv[..., 1] * (up - down)
    return np.stack([x, y, -np.ones_like(x)], axis=-1)


def sampled(picture: Array, uv: Array) -> Array:
    """Return a picture's values at places, bilinear; NaN outside."""
    (high, wide), within = picture.shape, inside(uv)
    where = np.stack([uv[..., 1] * high - 0.5, uv[..., 0] * wide - 0.5])
    found = ndimage.map_coordinates(picture, np.where(within, where, 0.0), order=1, mode="nearest")
    return np.where(within, found, np.nan)


def nearest_at(picture: NDArray[Any], uv: Array) -> NDArray[Any]:
    """Return a picture's values of the nearest pixels, those at the border outside."""
    high, wide = picture.shape[:2]
    column, row = (np.fmin(np.fmax(uv[..., k] * n, 0), n - 1).astype(np.intp) for k, n in enumerate((wide, high)))
    return np.asarray(picture[row, column])


def inside(uv: Array) -> NDArray[np.bool_]:
    """Return which places lie in the picture."""
    x, y = uv[..., 0], uv[..., 1]
    with np.errstate(invalid="ignore"):
        return np.asarray((x > 0) & (x < 1) & (y > 0) & (y < 1))


class Found:
    """What a convention finds in the frame before: differences of what should be the same."""

    def __init__(self, pair: Pair, convention: Convention) -> None:
        self.pair, self.uv, expected = pair, pair.places(convention), pair.expected
        nearest, within = nearest_at(pair.before.nearest_around, self.uv), inside(self.uv) & np.isfinite(expected)
        # In the picture before, and nothing nearer was there; all that was there was farther.
        self.seen = within & (nearest <= expected * (1 + _SURFACE) + _FAR)
        self.elsewhere = within & (nearest < expected * (1 - _SURFACE) - _FAR)
        # Brightness now less before; inverse depth before less that expected, as a share of it.
        self.bright = pair.bright - sampled(pair.before.brightness, self.uv)
        self.deep = (nearest_at(pair.before.inverse_depth, self.uv) - expected) / (expected + 1e-2)

    def costs(self) -> Array:
        """Return, by block, 0 for what is there as it should be, to 1 for what is not there."""
        squared = (self.bright / _SCORE_NOISE) ** 2 + (np.clip(self.deep, -1, 1) / _DEPTH_NOISE) ** 2
        return _by_block(self.pair, np.where(self.seen, np.nan_to_num(squared / (1 + squared), nan=1.0), 1.0))

    @cached_property
    def gradient(self) -> Array:
        """(h, w, 2) change of the brightness before, per pixel of colour to the right and down."""
        other = self.pair.before.brightness
        steps = np.diag(1 / np.array(self.pair.now.size))
        return np.stack(
            [np.nan_to_num(sampled(other, self.uv + s) - sampled(other, self.uv - s)) / 2 for s in steps], axis=-1
        )


_NOISE = 0.004  # of the brightness: sampling and 8 bits leave half of it on the library's scenes
# What costs half of what nothing does: of the brightness, of the depth as a share of it.
_SCORE_NOISE, _DEPTH_NOISE = 0.01, 0.03
_SHARED = 9.0  # pixels of a blurred picture that count as one
# How well a block tells a shift, and a shift that contradicts the vectors, beyond 5 deviations.
_KNOWN_PX, _OFF_PX, _SURELY = 0.1, 0.3, 25
_LEAST_BLOCKS = 15  # that must tell a shift
# The most that a right convention leaves. Exact vectors of matt scenes leave half of the first two
# at most, without antialiasing, nothing of the third, and half of the last: moving shadows.
_MOST = {
    "blocks": (0.04, "{:.1%} of the picture moved otherwise"),
    "drift_px": (0.15, "one picture as a whole by {:.2f} pixels"),
    "elsewhere": (5e-4, "{:.2%} of it came from where the depth before was farther"),
    "missed": (0.015, "{:.1%} of it came from where the colour was another"),
}


def text_of(convention: Convention) -> str:
    """Return a convention in words."""
    return f"{convention.unit}, y {convention.y}, {convention.sign}, jitter {convention.jitter}"


def check_motion(frames: MotionFrames) -> Answer:
    """Return which convention explains each next frame, by colour and by depth.

    Parameters
    ----------
    frames : MotionFrames
        As `read_motion` reads them.

    Returns
    -------
    Answer
        `reading` is the best Convention of all, `as_good` are those that fit as well. `figures` has
        what contradicts it, by what factors the vectors fit best, and their standard errors.
    """
    full = [Pair(now, before) for now, before in frames.pairs]
    pairs = [Pair(one.now, one.before, max(1, round(math.sqrt(one.vectors[..., 0].size / _SCORED)))) for one in full]
    costs = {one: np.concatenate([Found(pair, one).costs() for pair in pairs]) for one in _CANDIDATES}
    least = min(costs, key=lambda one: float(costs[one].sum()))
    alike = [one for one in _CANDIDATES if _margin(costs[least], costs[one]) < SURE]
    stated, count = attrs.asdict(frames.stated), f"{len(full)} pairs of frames"
    order = {
        one: (sum(map(operator.ne, attrs.astuple(one), stated.values())), float(costs[one].sum())) for one in alike
    }
    best = min(alike, key=order.__getitem__)
    figures = _contradictions([Found(pair, best) for pair in full])
    about: dict[str, Any] = {"frames": len(frames.frames), "figures": figures}
    why = [text.format(figures[name]) for name, (most, text) in _MOST.items() if figures[name] > most]
    if (judged := figures["judged"]) < _LEAST_BLOCKS:
        why = [f"only {judged} blocks of the picture have detail that three frames show"]
    if why:
        headline = f"cannot be told: no convention explains the next frame. With the nearest ({text_of(best)}), "
        return Answer("cannot be told", f"{headline}{listed(why)} ({count})", best, **about)
    findings = []
    for name, value in attrs.asdict(best).items():
        margins = {one: _margin(costs[best], costs[one]) for one in costs if getattr(one, name) != value}
        other = min(margins, key=margins.__getitem__)
        apart = np.linalg.norm((full[0].places(other) - full[0].places(best)) * full[0].now.size, axis=-1)
        told = margins[other] >= SURE
        untold = "" if told else f"{text_of(other)} moves pixels by {np.nanmedian(apart):.2g}"
        label, as_stated = PROPERTIES[name][1], value == stated[name]
        findings.append(Finding(name, label, value, as_stated, told, margins[other], untold))
    across, down = (f"{figures[way]:.3f} +- {1.96 * figures[f'{way}_error']:.3f} {way}" for way in ("across", "down"))
    about |= {"findings": findings, "notes": [f"The vectors fit best times {across} and {down} (95 %)."]}
    rivals = [text_of(one) for one in alike if one != best and order[one][0] == order[best][0]]
    if rivals:
        several = " or ".join([text_of(best), *rivals])
        headline = f"cannot be told: {several} explain it as well ({count})"
        return Answer("cannot be told", headline, best, as_good=rivals, **about)
    wrong = listed([one.label for one in findings if not one.as_stated])
    headline = f"{f'wrong: {wrong}' if wrong else 'right'}. The vectors explain the next frame as {text_of(best)}"
    code = _code(best, frames.pairs[0][0]) if wrong else []
    return Answer("wrong" if wrong else "right", f"{headline} ({count})", best, is_told=True, code=code, **about)


def _code(found: Convention, now: MotionFrame) -> list[str]:
    """Return C and GLSL that make of vectors what XR_EXT_frame_synthesis expects."""
    back, down = -1.0 if found.sign == BACKWARD else 1.0, 1.0 if found.y == DOWN else -1.0
    if found.unit == METRES:
        return [
            f"motion.xyz *= vec3({back:g}, {-down * back:g}, {back:g});  // now the way in the eye, y up",
            "vec4 then = previousProjection * vec4(eyePosition - motion.xyz, 1.0);  // without jitter",
            "motion.xyz = ndcPosition - then.xyz / then.w;",
        ]
    lines, (wide, high) = [], now.size
    units = {NDC: (1.0, 1.0), UV: (2.0, 2.0), PIXELS: (2 / wide, 2 / high)}[found.unit]
    factors = (back * units[0], back * down * units[1], back)
    for name, stated in (("Scale", now.scale), ("Offset", now.offset)):
        numbers = ", ".join(f"{value * factor:.9g}" for value, factor in zip(stated, factors, strict=True))
        if name == "Scale" or any(stated):
            lines.append(f"info.motionVector{name} = {{{numbers}, 0}};  // XrFrameSynthesisInfoEXT")
    lines.append("// XR_FB_space_warp: motion.xyz *= vec3({:.9g}, {:.9g}, {:.9g});".format(*factors))
    if found.jitter == IN:
        where = f"vec2(2.0 / {wide}, 2.0 / {high});  // pixels, y down"
        lines.append(f"motion.xy -= (jitter - previousJitter) * {where}")
    return lines


def _by_block(pair: Pair, values: Array) -> Array:
    """Return the sum of each block of the picture."""
    return np.asarray(np.bincount(pair.block.ravel(), np.nan_to_num(values).ravel(), BLOCKS), np.float64)


def _margin(better: Array, worse: Array) -> float:
    """Return by how many standard errors one is better, over blocks."""
    apart = worse - better
    error = float(apart.std()) / math.sqrt(len(apart))
    return float(apart.mean()) / error if error > 0 else 0.0


def _contradictions(found: list[Found]) -> dict[str, float]:
    """Return what pictures and depths say against a convention, and how the vectors fit."""
    shift, matrix, known, off, way = (np.stack(each) for each in zip(*map(_shifts, found), strict=True))
    # Edges without antialiasing seem to move by chance: each time elsewhere.
    length = np.maximum(np.linalg.norm(shift, axis=-1, keepdims=True), 1e-9)
    along = np.linalg.norm((off[..., None] * shift / length).sum(axis=0), axis=-1)
    counts = known.sum(axis=0)
    judged, wrong = int((counts > 1).sum()), int((along >= np.maximum(1.5, counts / 2)).sum())
    whole = np.linalg.solve(matrix.sum(axis=1) + 1e-5 * np.eye(2), np.einsum("nbij,nbj->ni", matrix, shift)[..., None])
    # Where the depth before was farther, and where something of another colour was.
    contrary = [
        (one.elsewhere, one.seen & (np.abs(np.nan_to_num(one.bright)) > _MISSED + 0.75 * steep))
        for one in found
        for steep in [np.linalg.norm(one.gradient, axis=-1)]
    ]
    elsewhere, missed = np.mean(
        [[ndimage.binary_opening(one, np.ones((2, 2))).mean() for one in each] for each in contrary], axis=0
    ).tolist()
    # The factors of x and y that fit best and their standard errors, over blocks.
    way, shift, weight = way[known], shift[known], matrix[known][:, (0, 1), (0, 1)]
    total = np.maximum((weight * way**2).sum(axis=0), 1e-12)
    slope = (weight * way * shift).sum(axis=0) / total
    error = np.sqrt(((weight * way * (shift - slope * way)) ** 2).sum(axis=0)) / total
    return {
        "judged": judged,  # blocks that tell a shift, in two frames or more
        "blocks": max(0, wrong - 1) / max(judged, 1),  # of them, those but one that show it in frame after frame
        "drift_px": float(np.linalg.norm(whole, axis=1).max()),  # the whole picture's shift in one of the frames
        "elsewhere": elsewhere,  # of the pixels: the surface was not there
        "missed": missed,  # of the pixels: something of another colour was there
        **dict(zip(("across", "down"), (1 + slope).tolist(), strict=True)),
        **dict(zip(("across_error", "down_error"), error.tolist(), strict=True)),
    }


def _shifts(found: Found) -> tuple[NDArray[Any], ...]:
    """Return for each block by how many pixels the picture before lies elsewhere, and how sure.

    Source: Lucas and Kanade 1981, one step: what is left is below a pixel where vectors are right.
    """
    pair, gradient, bright = found.pair, found.gradient, np.nan_to_num(found.bright)
    steep = np.linalg.norm(gradient, axis=-1)
    weight = (found.seen & pair.one_surface) / (1 + (bright / (4 * _NOISE + steep)) ** 2)
    x, y = gradient[..., 0], gradient[..., 1]
    xx, xy, yy, xb, yb = (_by_block(pair, weight * one) for one in (x * x, x * y, y * y, x * bright, y * bright))
    matrix = np.stack([xx, xy, xy, yy], axis=-1).reshape(-1, 2, 2)
    shift = np.linalg.solve(matrix + 1e-5 * np.eye(2), np.stack([xb, yb], axis=-1)[..., None])[..., 0]
    variance = _SHARED * _NOISE**2
    sure = np.einsum("ni,nij,nj->n", shift, matrix, shift) / variance
    off = np.asarray((sure > _SURELY) & (np.linalg.norm(shift, axis=1) > _OFF_PX))
    known = off | (np.linalg.eigvalsh(matrix)[:, 1] > variance / _KNOWN_PX**2)
    way = np.where(weight[..., None] > 0, (found.uv - pair.uv) * pair.now.size, 0)
    count = np.maximum(_by_block(pair, weight > 0), 1)
    return shift, matrix, known, off, np.stack([_by_block(pair, way[..., k]) / count for k in (0, 1)], axis=-1)
