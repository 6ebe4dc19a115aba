"""Bags of ROS: colour, registered depth, its camera, and transforms, odometry or poses."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ....errors import InputError, TraceError
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ....poses.reading.pose_messages import Bag, bag_at, part_of, stamp_ns
from ..camera import Camera, refuse_distortion
from ..options import SequenceOptions
from ..picture_files import fitted_depth
from ..recorded import (
    CLOCK,
    DEPTH_SCALE,
    INTRINSICS,
    NO_DEPTH,
    POSE,
    Pictures,
    RecordedFrame,
    Sequence,
    as_pictures,
    in_metres,
)
from ..ros_pictures import COLOURS, DEPTHS, Matrix, Motion, Transforms, encoding_of, pixels_of
from . import readers
from ._base import SequenceReader, at_rate, facts_of, pose_of_matrix
from ._dataset import axes_of, clock_of, left_out, refuse_y_up

# The world is x forward, y left, z up; the frame of a picture is optical, x right, y down.
_AXES = "world=-y,z,x head=x,-y,z"
_OPTICAL_FROM_BODY = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
_IMAGES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
_INFO, _TF = "sensor_msgs/CameraInfo", ("tf2_msgs/TFMessage", "tf/tfMessage")
# Where messages have their pose.
_POSES = {
    "nav_msgs/Odometry": "pose.pose",
    "geometry_msgs/PoseStamped": "pose",
    "geometry_msgs/PoseWithCovarianceStamped": "pose.pose",
}
_PARTS = ("colour", "depth", "info", "pose")
_WITHIN_NS = 20_000_000  # of colour and depth of one frame, as for TUM RGB-D


@readers.register
class RosBagReader(SequenceReader):
    """Bags of ROS 1 and ROS 2.

    Source: ROS REP 103 and 105 (axes, frames), REP 118 (depth: millimetres or floats of metres),
    sensor_msgs/CameraInfo (K, D, P; frame_id is the optical frame).
    """

    name = "rosbag"
    summary = "bag of ROS 1 or 2 (.bag, .db3, .mcap): colour, registered depth, CameraInfo, and TF, odometry or poses"
    takes = ("frames_topics",)
    assumes = (
        Assumption(INTRINSICS, "K of CameraInfo, or P of a rectified topic", By.FILE, "--intrinsics"),
        Assumption(DEPTH_SCALE, "0.001 m per unit of 16UC1, 1 of 32FC1", By.FORMAT, "--depth-scale"),
        Assumption(NO_DEPTH, "0 or NaN", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(_AXES)),
        Assumption(POSE, "root of TF from the picture's frame, else odometry or poses", By.FILE),
        Assumption(CLOCK, "header.stamp of colour", By.FILE, "--frames-rate"),
    )

    def fits(self, path: Path) -> int:
        return 0 if (place := bag_at(path)) is None else 75 if place == path else 25

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        place = bag_at(path)
        if place is None:
            raise InputError(f"{path}: no bag, or several; expected {self.summary}")
        try:
            return self._read(path, Bag(place), options)
        except TraceError as error:
            raise InputError(str(error)) from error

    def _read(self, path: Path, bag: Bag, options: SequenceOptions) -> Sequence:
        tree = _transforms(bag)
        topics = _topics(path, bag, tree, options.frames_topics)
        colours, depths = (_stamped(bag, topic) for topic in (topics.colour, topics.depth))
        camera = _camera(path, bag, topics)
        scale = DEPTHS[encoding_of(bag.message(topics.depth, depths[0].logged_ns, depths[0].number))][1]
        facts = facts_of(path if path.is_dir() else path.parent, options, None, scale, own=camera)
        refuse_y_up(path, facts.camera)
        size = _size(pixels_of(topics.colour, bag.message(topics.colour, colours[0].logged_ns, colours[0].number)))
        fov, axes = facts.camera.fov(size, f"{path}, {topics.info}"), parse_axes(_AXES)
        pose_at, said = _poses(bag, tree, topics, colours[0].frame)
        late, frames = np.array([picture.time_ns for picture in depths]), []
        for at, colour in enumerate(colours):
            depth = depths[int(np.abs(late - colour.time_ns).argmin())]
            matrix = pose_at(colour.time_ns) if abs(depth.time_ns - colour.time_ns) <= _WITHIN_NS else None
            if matrix is not None:
                time_ns = colour.time_ns if options.frames_rate_hz is None else at_rate(options, at)
                pose = pose_of_matrix(axes, f"{path}, pose at {colour.time_ns} ns", matrix)
                raw = partial(_pixels, bag, topics.depth, depth)
                read = partial(_pictures, bag, topics, colour, raw, facts.depth_scale)
                frames.append(RecordedFrame(f"{topics.colour} {at}", time_ns, pose, fov, size, read, raw))
        named = ", ".join(f"{part} {getattr(topics, part)}" for part in _PARTS if getattr(topics, part))
        more = [Assumption("topics", named, topics.by, "--frames-topics"), said]
        more += [] if options.frames_rate_hz is None else [clock_of(options, By.USER)]
        notes = left_out(len(colours) - len(frames), "no depth within 20 ms, or no pose at their instants")
        notes += [f"{part}: the others are not read."] if (part := part_of(bag.path)) else []
        return self.made(path, frames, notes=notes, assumptions=(*facts.assumptions, *more))


@attrs.frozen
class _Stamped:
    """A picture in a bag, by where it is."""

    time_ns: int
    logged_ns: int
    # Of those that were logged at the same instant.
    number: int
    frame: str


def _stamped(bag: Bag, topic: str) -> list[_Stamped]:
    """Return the pictures of a topic by their stamps. Errors: InputError without any."""
    found: list[_Stamped] = []
    for _, logged_ns, message in bag.messages([topic]):
        number = found[-1].number + 1 if found and found[-1].logged_ns == logged_ns else 0
        frame = message.header.frame_id.strip("/")
        found.append(_Stamped(stamp_ns(message.header.stamp), logged_ns, number, frame))
    if not found:
        raise InputError(f"{bag.path}: no message of {topic}; expected pictures")
    return sorted({picture.time_ns: picture for picture in found}.values(), key=lambda picture: picture.time_ns)


@attrs.frozen
class _Topics:
    colour: str
    depth: str
    info: str
    # "" for TF.
    pose: str
    by: By


def _topics(path: Path, bag: Bag, tree: Transforms, stated: str | None) -> _Topics:
    """Return the topics that the user names, else the only fitting ones. Errors: InputError."""
    named = _named(path, bag, stated)
    pictures = _kinds(bag, [name for name, kind in bag.topics.items() if kind in _IMAGES])
    colour = named.get("colour") or _one(
        path, "colour", [name for name, kind in pictures.items() if kind in COLOURS], pictures
    )
    fitting = [name for name, kind in pictures.items() if kind in DEPTHS]
    depth = named.get("depth") or _one(path, "depth", _registered(bag, fitting, colour), pictures)
    frames = _frame(bag, colour), _frame(bag, depth)
    if frames[0] != frames[1]:
        raise InputError(
            f"{path}: {depth} is in frame '{frames[1]}', {colour} in '{frames[0]}'; expected depth that is registered "
            "to the colour (aligned_depth_to_color, depth_registered)"
        )
    infos = [name for name, kind in bag.topics.items() if kind == _INFO]
    beside = colour.removesuffix("/compressed").rpartition("/")[0] + "/camera_info"
    info = named.get("info") or (beside if beside in infos else infos[0] if len(infos) == 1 else "")
    poses = [name for name, kind in bag.topics.items() if kind in _POSES]
    moved = "pose" not in named and tree.moves(_frame(bag, colour))
    pose = named.get("pose") or ("" if moved else _one(path, "pose", poses, bag.topics))
    return _Topics(colour, depth, info, pose, By.USER if stated else By.NOBODY)


def _named(path: Path, bag: Bag, stated: str | None) -> dict[str, str]:
    """Return topic by part as --frames-topics states them. Errors: InputError."""
    parts = [part.partition("=") for part in (stated or "").split(",") if part]
    named = {key.strip(): topic.strip() for key, _, topic in parts}
    if not named.keys() <= set(_PARTS):
        raise InputError(f"--frames-topics '{stated}': expected {', '.join(f'{part}=TOPIC' for part in _PARTS)}")
    absent = next((topic for topic in named.values() if topic not in bag.topics), None)
    if absent is not None:
        raise InputError(f"{path}: no topic '{absent}'; it holds {_held(bag.topics)}")
    return named


def _kinds(bag: Bag, topics: Iterable[str]) -> dict[str, str]:
    """Return the encoding of the first picture of each topic."""
    first = ((topic, next((message for _, _, message in bag.messages([topic])), None)) for topic in topics)
    return {topic: "" if message is None else encoding_of(message) for topic, message in first}


def _one(path: Path, what: str, fitting: list[str], held: dict[str, str]) -> str:
    """Return the only topic, the raw one where it is compressed too. Errors: InputError."""
    raw = [topic for topic in fitting if topic.rpartition("/")[0] not in fitting]
    if len(raw) == 1:
        return raw[0]
    found = f"several topics of {what} ({', '.join(raw)})" if raw else f"no topic of {what}; it holds {_held(held)}"
    raise InputError(f"{path}: {found}: name them by --frames-topics {','.join(f'{part}=TOPIC' for part in _PARTS)}")


def _held(topics: dict[str, str]) -> str:
    names = [f"{name} ({kind or 'unknown'})" for name, kind in topics.items()]
    return ", ".join(names[:8]) or "nothing"


def _frame(bag: Bag, topic: str) -> str:
    return next((message.header.frame_id.strip("/") for _, _, message in bag.messages([topic])), "")


def _registered(bag: Bag, fitting: list[str], colour: str) -> list[str]:
    """Return the depths in the frame of the colour, if there are any."""
    same = [topic for topic in fitting if _frame(bag, topic) == _frame(bag, colour)]
    return same or fitting


def _camera(path: Path, bag: Bag, topics: _Topics) -> Camera | None:
    """Return the camera of the colour, None if none is stated. Errors: InputError: distortion."""
    info = next((message for _, _, message in bag.messages([topics.info])), None) if topics.info else None
    if info is None:
        return None
    where, size = f"{path}, {topics.info}", (int(info.width), int(info.height))
    if "rect" in topics.colour.rpartition("/")[2]:
        p = np.asarray(getattr(info, "p", getattr(info, "P", None)), float)
        return Camera(p[0], p[5], p[2], p[6], size)
    refuse_distortion(where, {"distortion": np.asarray(getattr(info, "d", getattr(info, "D", ()))).tolist()})
    k = np.asarray(getattr(info, "k", getattr(info, "K", None)), float)
    if not k[0] > 0:
        raise InputError(f"{where}: fx is {k[0]:g}, as of a camera that is not calibrated: give --intrinsics")
    return Camera(k[0], k[4], k[2], k[5], size)


def _transforms(bag: Bag) -> Transforms:
    moving: list[Any] = []
    still: list[Any] = []
    topics = [name for name, kind in bag.topics.items() if kind in _TF]
    for topic, _, message in bag.messages(topics):
        (still if topic.endswith("tf_static") else moving).extend(message.transforms)
    return Transforms(moving, still)


def _poses(
    bag: Bag, tree: Transforms, topics: _Topics, frame: str
) -> tuple[Callable[[int], Matrix | None], Assumption]:
    """Return what gives world_from_optical at an instant, and the entry for it."""
    if not topics.pose:
        root = tree.chain(frame)[-1]
        return partial(tree.up_to, frame, root), Assumption(POSE, f"'{root}' from '{frame}', by TF", By.FILE)
    motion, body = _motion(bag, topics.pose)
    if body in tree.chain(frame):
        fixed = tree.up_to(frame, body, 0) if not tree.moves(frame) else None
        said = Assumption(POSE, f"{topics.pose} of '{body}', and TF from there to '{frame}'", By.FILE)
    elif body in ("", frame) or body.endswith("optical_frame"):
        fixed, said = np.eye(4), Assumption(POSE, f"{topics.pose}, of the picture's own frame", By.NOBODY)
    else:
        fixed = _OPTICAL_FROM_BODY
        said = Assumption(POSE, f"{topics.pose} of '{body}', which looks along x, at the camera's place", By.NOBODY)

    def at(time_ns: int) -> Matrix | None:
        moved, then = motion.at(time_ns), tree.up_to(frame, body, time_ns) if fixed is None else fixed
        return None if moved is None or then is None else moved @ then

    return at, said


def _motion(bag: Bag, topic: str) -> tuple[Motion, str]:
    """Return the motion of a topic of poses, and its frame, "" where that is not stated."""
    samples, body = [], ""
    for _, _, message in bag.messages([topic]):
        pose = message.pose
        pose = pose if hasattr(pose, "orientation") else pose.pose
        samples.append((stamp_ns(message.header.stamp), pose.position, pose.orientation))
        body = getattr(message, "child_frame_id", "").strip("/")
    if not samples:
        raise InputError(f"{bag.path}: no message of {topic}; expected poses")
    return Motion(samples), body


def _pixels(bag: Bag, topic: str, picture: _Stamped) -> Any:
    return pixels_of(
        f"{bag.path}, {topic} at {picture.time_ns} ns", bag.message(topic, picture.logged_ns, picture.number)
    )


def _pictures(bag: Bag, topics: _Topics, colour: _Stamped, depth: Callable[[], Any], scale: float) -> Pictures:
    picture = np.ascontiguousarray(_pixels(bag, topics.colour, colour))
    return as_pictures(picture, in_metres(fitted_depth(depth(), picture, topics.depth), scale))


def _size(picture: Any) -> tuple[int, int]:
    return picture.shape[1], picture.shape[0]
