"""Frames with motion vectors and depth, as an engine gives them to a headset's runtime.

Names are those of XrFrameSynthesisInfoEXT (XR_EXT_frame_synthesis 1), which has all of
XrCompositionLayerSpaceWarpInfoFB (XR_FB_space_warp 2). docs/motion.md has every key.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import srgb8_from_linear
from ..errors import InputError
from ..geometry import DepthLayer, Fov, Pose, View
from ..options.named_files import PICTURE_FILE, opened
from ..sources.sequences import read_colour, read_depth
from ..sources.sequences.camera import number_of, numbers_of, read_json
from ..sources.sequences.picture_files import EXR, NPY, read_exr

Array = NDArray[np.float64]
Size = tuple[int, int]
FILE = "motion.json"
NDC, UV, PIXELS, METRES = "ndc", "uv", "pixels", "metres"
DOWN, UP = "down", "up"
FORWARD, BACKWARD = "current - previous", "previous - current"
OUT, IN = "out", "in"
# Each property of a convention, what it may be, and its name in text; the first is the extension's.
PROPERTIES = {
    "unit": ((NDC, UV, PIXELS, METRES), "unit"),
    "y": ((DOWN, UP), "y axis"),
    "sign": ((FORWARD, BACKWARD), "direction"),
    "jitter": ((OUT, IN), "jitter"),
}
_ANGLES = ("angleLeft", "angleRight", "angleDown", "angleUp")
_TWO = "XR_FRAME_SYNTHESIS_INFO_USE_2D_MOTION_VECTOR_BIT_EXT"
_VECTORS = ("motion", "vector", "velocity", "flow")  # layers of an EXR file that may hold them
_LIGHT = ("R", "G", "B")


@attrs.frozen
class Convention:
    """What the numbers of motion vectors mean; the default is that of XR_EXT_frame_synthesis."""

    # NDC: -1 to 1; UV: 0 to 1; PIXELS of colour; METRES along the eye's axes.
    unit: str = NDC
    y: str = DOWN
    sign: str = FORWARD
    # Whether the sub-pixel jitter of the projections is in the vectors.
    jitter: str = OUT

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
    # Pixels of colour by which the projection moves everything right and down.
    jitter: tuple[float, ...] = (0.0, 0.0)
    # Of this frame's space in that of the frame before.
    app_space_delta: Pose = attrs.field(factory=Pose)

    def __attrs_post_init__(self) -> None:
        for name, array, shapes in (("depth", self.depth, ((),)), ("motion", self.vectors, ((2,), (3,), (4,)))):
            if array is not None and (array.ndim < 2 or array.shape[2:] not in shapes or not array.size):
                raise InputError(f"{self.name}: {name} has shape {array.shape}: expected (h, w), of vectors x and y, "
                                 "or x, y and z of each")  # fmt: skip
        if self.vectors is not None and self.depth is None:
            raise InputError(f"{self.name}: motion vectors without depth: expected both, of any resolution")

    @property
    def size(self) -> Size:
        """(w, h) of colour."""
        return self.colour.shape[1], self.colour.shape[0]

    @cached_property
    def motion(self) -> Array:
        """(h, w, 2 or 3) vectors with scale and offset."""
        assert self.vectors is not None, "callers look for frames with vectors"
        count = min(self.vectors.shape[2], 3)
        return self.vectors[..., :count] * self.scale[:count] + self.offset[:count]

    @cached_property
    def inverse_depth(self) -> Array:
        """(h, w) 1/m, NaN where there is none."""
        assert self.depth is not None, "frames with vectors have depth"
        if self.planes is not None:
            return self.planes.inverse_depth(self.depth)
        with np.errstate(divide="ignore"):
            return np.where(self.depth > 0, 1 / self.depth, np.nan)

    def view_before(self, before: MotionFrame) -> View:
        """Return the view of the frame before, in the space of this one."""
        return before.view.at(self.app_space_delta.inverse() @ before.view.pose)


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
            raise InputError(
                f"{len(times)} frames: expected two or more with depth, and with motion from the second on"
            )
        if len({frame.size for frame in self.frames}) > 1:
            raise InputError(f"frames have colour of {sorted({f.size for f in self.frames})} pixels: expected one size")

    @cached_property
    def pairs(self) -> list[tuple[MotionFrame, MotionFrame]]:
        """Each frame with vectors, and the one that they lead to: the last before with depth."""
        rendered = [frame for frame in self.frames if frame.depth is not None]
        return [(one, before) for before, one in zip(rendered, rendered[1:], strict=False) if one.vectors is not None]


def read_motion(path: Path) -> MotionFrames:
    """Return the frames of a folder with motion.json, or of that file. Errors: InputError."""
    where = path / FILE if path.is_dir() else path
    data = read_json(where, f"an object with frames, as docs/motion.md has it")
    rows = data.pop("frames", None)
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{where}: frames: expected a list of objects, one for each frame")
    stated = data.pop("convention", {})
    if not isinstance(stated, dict) or not stated.keys() <= PROPERTIES.keys():
        raise InputError(f"{where}: convention is {stated}: expected an object of {', '.join(PROPERTIES)}")
    return MotionFrames(
        [_frame(where, number, {**data, **row}) for number, row in enumerate(rows)], Convention(**stated)
    )


def _frame(where: Path, number: int, row: Mapping[str, Any]) -> MotionFrame:
    at = f"{where}: frame {number}"
    unknown = row.keys() - {
        "colour", "depth", "motion", "pose", "fov", "displayTime", "jitter", "layerFlags", "motionVectorScale",
        "motionVectorOffset", "motionVectorSubImage", "depthSubImage", "subImage", "appSpaceDeltaPose", "minDepth",
        "maxDepth", "nearZ", "farZ", "depthUnit",
    }  # fmt: skip
    if unknown or not isinstance(row.get("colour"), str):
        raise InputError(f"{at}: {', '.join(sorted(unknown)) or 'no colour'}: expected the keys of docs/motion.md")
    files = {key: where.parent / str(row[key]) for key in ("colour", "depth", "motion") if row.get(key) is not None}
    colour = _cut(at, _colour(files["colour"]), row.get("subImage"))
    depth, vectors = (
        read(files[key]) if key in files else None for key, read in (("depth", _depth), ("motion", _vectors))
    )
    if vectors is not None and _TWO in row.get("layerFlags", ()):
        vectors = vectors[..., :2]
    buffer = row.get("depthUnit", "buffer") == "buffer"
    planes = [_distance(at, key, row.get(key, usual)) for key, usual in
              (("minDepth", 0.0), ("maxDepth", 1.0), ("nearZ", 0.1), ("farZ", "Infinity"))]  # fmt: skip
    return MotionFrame(
        files["colour"].name,
        colour,
        View(_pose(at, "pose", row.get("pose")), Fov(*_numbers(at, "fov", row.get("fov"), _ANGLES))),
        int(number_of(at, "displayTime", row.get("displayTime"), "nanoseconds")),
        None if depth is None else _cut(at, depth, row.get("depthSubImage")),
        None if vectors is None else _cut(at, vectors, row.get("motionVectorSubImage")),
        DepthLayer(*planes) if buffer else None,
        _numbers(at, "motionVectorScale", row.get("motionVectorScale", (1, 1, 1, 0)), "xyzw")[:3],
        _numbers(at, "motionVectorOffset", row.get("motionVectorOffset", (0, 0, 0, 0)), "xyzw")[:3],
        _numbers(at, "jitter", row.get("jitter", (0, 0)), "xy"),
        _pose(
            at, "appSpaceDeltaPose", row.get("appSpaceDeltaPose", {"position": (0, 0, 0), "orientation": (0, 0, 0, 1)})
        ),
    )


def _distance(at: str, key: str, value: Any) -> float:
    return float("inf") if value in ("Infinity", float("inf")) else number_of(at, key, value)


def _numbers(at: str, key: str, value: Any, names: Sequence[str]) -> tuple[float, ...]:
    """Return numbers of a list, or of an object with these names."""
    if isinstance(value, dict):
        value = [value.get(name) for name in names]
    return numbers_of(at, key, value, len(names))


def _pose(at: str, key: str, value: Any) -> Pose:
    if not isinstance(value, dict):
        raise InputError(f"{at}: {key} is {value!r}: expected an XrPosef: position and orientation")
    return Pose(*(_numbers(at, f"{key}.{part}", value.get(part), names)
                  for part, names in (("position", "xyz"), ("orientation", "xyzw"))))  # fmt: skip


def _cut(at: str, picture: NDArray[Any], image: Any) -> NDArray[Any]:
    """Return the rectangle of an XrSwapchainSubImage, counted from the top left pixel."""
    if image is None:
        return picture
    rect = image.get("imageRect") if isinstance(image, dict) else None
    if not isinstance(rect, dict):
        raise InputError(f"{at}: sub-image {image!r}: expected an imageRect of offset and extent")
    x, y = map(int, _numbers(at, "offset", rect.get("offset"), "xy"))
    wide, high = map(int, _numbers(at, "extent", rect.get("extent"), ("width", "height")))
    if min(x, y) < 0 or min(wide, high) < 1 or y + high > picture.shape[0] or x + wide > picture.shape[1]:
        raise InputError(
            f"{at}: sub-image of {wide}x{high} at {x}, {y}: the file has {picture.shape[1]}x{picture.shape[0]}"
        )
    return picture[y : y + high, x : x + wide]


def _colour(path: Path) -> NDArray[np.uint8]:
    found = _array(path) if path.suffix.lower() == NPY else read_colour(path)
    return found[..., :3] if found.dtype == np.uint8 else srgb8_from_linear(found[..., :3])


def _depth(path: Path) -> Array:
    """Return what a depth buffer holds: integers of their whole range."""
    found = read_depth(path)
    return found / np.iinfo(found.dtype).max if found.dtype.kind in "iu" else found.astype(np.float64)


def _vectors(path: Path) -> Array:
    """Return (h, w, 2 to 4): of EXR the layer that is named so, else red, green and blue."""
    suffix = path.suffix.lower()
    if suffix == NPY:
        return _array(path).astype(np.float64)
    if suffix != EXR:
        return read_colour(path) / 255.0
    channels = read_exr(path).channels
    layers: dict[str, dict[str, NDArray[np.float32]]] = {}
    for name, pixels in channels.items():
        layers.setdefault(name.rpartition(".")[0], {})[name.rpartition(".")[2].upper()] = pixels
    named = [one for name, one in layers.items() if name.rpartition(".")[2].lower().startswith(_VECTORS)]
    found = (named or [layers.get("", {})])[0]
    axes = "XYZ" if {*"XY"} <= found.keys() else _LIGHT
    # X, Y, Z and W are Blender's: to the frame before, and to the one after.
    parts = [found[axis] for axis in (axes[:2] if "W" in found else axes) if axis in found]
    if len(parts) < 2:
        raise InputError(f"{path}: channels {', '.join(channels)}; expected R and G, or X and Y of a layer of vectors")
    return np.stack(parts, axis=-1).astype(np.float64)


def _array(path: Path) -> NDArray[Any]:
    try:
        with opened(path, PICTURE_FILE) as file:
            found = np.load(file, allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise InputError(f"{path}: not an .npy file of numbers ({error})") from error
    if not isinstance(found, np.ndarray) or found.ndim != 3 or found.dtype.kind not in "fiu":
        raise InputError(f"{path}: expected (h, w, channels) numbers")
    return found
