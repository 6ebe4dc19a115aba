"""Frames with motion vectors and depth, as an engine gives them to a headset's runtime.

Names are those of XrFrameSynthesisInfoEXT (XR_EXT_frame_synthesis 1), which has all of
XrCompositionLayerSpaceWarpInfoFB (XR_FB_space_warp 2). docs/motion.md has every key.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..colour import linear_from_srgb, srgb8_from_linear
from ..errors import InputError
from ..geometry import DepthLayer, Fov, Pose, View
from ..options.named_files import PICTURE_FILE, named_in, opened
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
# Pixels of colour: what is finer differs by sampling alone, what is coarser is light and shadow.
_BLUR_PX = (1.0, 6.0)
_TWO = "XR_FRAME_SYNTHESIS_INFO_USE_2D_MOTION_VECTOR_BIT_EXT"
_VECTORS = ("motion", "vector", "velocity", "flow")  # layers of an EXR file that may hold them
_PLANES, _FAR = ("minDepth", "maxDepth", "nearZ", "farZ"), "Infinity"


@attrs.frozen
class Convention:
    """What the numbers of motion vectors mean; the default is that of XR_EXT_frame_synthesis."""

    unit: str = NDC  # NDC: -1 to 1; UV: 0 to 1; PIXELS of colour; METRES along the eye's axes
    y: str = DOWN
    sign: str = FORWARD
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

    @cached_property
    def nearest_around(self) -> Array:
        """(h, w) the largest inverse depth within a pixel."""
        return np.asarray(ndimage.maximum_filter(np.nan_to_num(self.inverse_depth), 3))

    @cached_property
    def brightness(self) -> Array:
        """(H, W) brightness without its finest detail and its shade."""
        root = np.sqrt(linear_from_srgb(self.colour).mean(axis=2).astype(np.float64))
        return np.asarray(np.subtract(*(ndimage.gaussian_filter(root, blur) for blur in _BLUR_PX)))

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
            raise InputError(f"{len(times)} frames: expected two or more with depth, with motion from the second on")
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
    data = read_json(where, "an object with frames, as docs/motion.md has it")
    rows, stated = data.pop("frames", None), data.pop("convention", {})
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{where}: frames: expected a list of objects, one for each frame")
    if not isinstance(stated, dict) or not stated.keys() <= PROPERTIES.keys():
        raise InputError(f"{where}: convention is {stated}: expected an object of {', '.join(PROPERTIES)}")
    folder = where.parent
    found = [_frame(f"{where}: frame {k}", folder, {**_USUAL, **data, **row}) for k, row in enumerate(rows)]
    return MotionFrames(found, Convention(**stated))


_KEYS = ("colour", "depth", "motion", "pose", "fov", "displayTime", "subImage", "motionVectorSubImage", "depthSubImage")
# What a frame is without its key; None: there must be one, or there is none.
_USUAL: dict[str, Any] = {
    **dict.fromkeys(_KEYS),
    "jitter": (0, 0),
    "layerFlags": (),
    "motionVectorScale": (1, 1, 1, 0),
    "motionVectorOffset": (0, 0, 0, 0),
    "appSpaceDeltaPose": {"position": (0, 0, 0), "orientation": (0, 0, 0, 1)},
    **dict(zip(_PLANES, (0.0, 1.0, 0.1, _FAR), strict=True)),
    "depthUnit": "buffer",
}


def _frame(at: str, folder: Path, row: Mapping[str, Any]) -> MotionFrame:
    if unknown := row.keys() - _USUAL.keys():
        raise InputError(f"{at}: {', '.join(sorted(unknown))}: expected the keys of docs/motion.md")

    def picture(key: str, image: str, read: Callable[[Path], NDArray[Any]]) -> NDArray[Any] | None:
        if row[key] is None and key != "colour":
            return None
        if not isinstance(row[key], str):
            raise InputError(f"{at}: {key} is {row[key]!r}: expected the name of a file")
        return _cut(at, read(named_in(folder, row[key])), row[image])

    colour, vectors = picture("colour", "subImage", _colour), picture("motion", "motionVectorSubImage", _vectors)
    assert colour is not None, "refused above"
    planes = [math.inf if row[key] == _FAR else number_of(at, key, row[key]) for key in _PLANES]
    return MotionFrame(
        row["colour"],
        colour,
        View(_pose(at, "pose", row["pose"]), Fov(*_numbers(at, "fov", row["fov"], _ANGLES))),
        int(number_of(at, "displayTime", row["displayTime"], "nanoseconds")),
        picture("depth", "depthSubImage", _depth),
        vectors[..., :2] if vectors is not None and _TWO in str(row["layerFlags"]) else vectors,
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


def _cut(at: str, picture: NDArray[Any], image: Any) -> NDArray[Any]:
    """Return the rectangle of an XrSwapchainSubImage, counted from the top left pixel."""
    if image is None:
        return picture
    rect = image.get("imageRect") if isinstance(image, dict) else None
    if not isinstance(rect, dict):
        raise InputError(f"{at}: sub-image {image!r}: expected an imageRect of offset and extent")
    x, y = map(int, _numbers(at, "offset", rect.get("offset"), "xy"))
    wide, high = map(int, _numbers(at, "extent", rect.get("extent"), ("width", "height")))
    found = picture[max(y, 0) : y + high, max(x, 0) : x + wide]
    if min(x, y) < 0 or not found.size or found.shape[:2] != (high, wide):
        raise InputError(f"{at}: sub-image of {wide}x{high} at {x}, {y}: the file has {picture.shape[1::-1]}")
    return found


def _colour(path: Path) -> NDArray[np.uint8]:
    found = _array(path) if path.suffix.lower() == NPY else read_colour(path)
    return found[..., :3] if found.dtype == np.uint8 else srgb8_from_linear(found[..., :3])


def _depth(path: Path) -> Array:
    """Return what a depth buffer holds: integers of their whole range."""
    found = read_depth(path)
    return found / np.iinfo(found.dtype).max if found.dtype.kind in "iu" else found.astype(np.float64)


def _vectors(path: Path) -> Array:
    """Return (h, w, 2 to 4): of EXR the layer that is named so, else red, green and blue."""
    if path.suffix.lower() == NPY:
        return _array(path).astype(np.float64)
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
