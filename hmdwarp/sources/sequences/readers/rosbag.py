"""Bags of ROS: colour, registered depth, its camera, and transforms, odometry or poses."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ....errors import InputError, TraceError
from ....poses.assumptions import Assumption, By
from ....poses.reading.pose_messages import Bag, bag_at, part_of, stamp_ns
from ..camera import Camera, refuse_distortion
from ..picture_files import fitted_depth
from ..recorded import POSE, Pictures, RecordedFrame, as_pictures, in_metres
from ..ros_pictures import COLOURS, DEPTHS, Matrix, Motion, Transforms, encoding_of, pixels_of
from ._base import Folder, layout, pose_of_square

_OPTICAL_FROM_BODY = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
_IMAGES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
_INFO, _TF = "sensor_msgs/CameraInfo", ("tf2_msgs/TFMessage", "tf/tfMessage")
_POSES = ("nav_msgs/Odometry", "geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped")
_PARTS = ("colour", "depth", "info", "pose")
_NAMING = ",".join(f"{part}=TOPIC" for part in _PARTS)
_WITHIN_NS = 20_000_000  # of colour and depth of one frame, as for TUM RGB-D


@layout(
    "rosbag",
    "bag of ROS 1 or 2 (.bag, .db3, .mcap): colour, registered depth, CameraInfo, and TF, odometry or poses",
    lambda path: 0 if (place := bag_at(path)) is None else 75 if place == path else 25,
    takes=("frames_topics",), intrinsics=("K of CameraInfo, or P of a rectified topic", By.FILE),
    scale="0.001 m per unit of 16UC1, 1 of 32FC1", no_depth="0 or NaN",
    pose=("root of TF from the picture's frame, else odometry or poses", By.FILE),
    clock=("header.stamp of colour", By.FILE),
    axes="world=-y,z,x head=x,-y,z",  # the world is x forward, y left, z up; the frame of a picture is optical
)  # fmt: skip
def rosbag(at: Folder) -> None:
    """Bags of ROS 1 and ROS 2.

    Source: ROS REP 103 and 105 (axes, frames), REP 118 (depth: millimetres or floats of metres),
    sensor_msgs/CameraInfo (K, D, P; frame_id is the optical frame).
    """
    place = bag_at(at.path)
    if place is None:
        raise InputError(f"{at.path}: no bag, or several; expected {at.layout.summary}")
    try:
        _read(at, Bag(place))
    except TraceError as error:
        raise InputError(str(error)) from error


def _read(at: Folder, bag: Bag) -> None:
    moving: list[Any] = []
    still: list[Any] = []
    for topic, _, message in bag.messages([name for name, kind in bag.topics.items() if kind in _TF]):
        (still if topic.endswith("tf_static") else moving).extend(message.transforms)
    tree, by = Transforms(moving, still), By.USER if at.options.frames_topics else By.DEFAULT
    topics = _topics(at.path, bag, tree, at.options.frames_topics)
    colours, depths = (_stamped(bag, topics[part]) for part in ("colour", "depth"))
    scale = DEPTHS[encoding_of(bag.message(topics["depth"], depths[0].logged_ns, depths[0].number))][1]
    at.state(unit=scale, own=_camera(at.path, bag, topics))
    high, wide = _pixels(bag, topics["colour"], colours[0]).shape[:2]
    fov = at.camera.fov((wide, high), f"{at.path}, {topics['info']}")
    pose_at, said, spans = _poses(bag, tree, topics["pose"], colours[0].frame)
    pictured = {topics[part]: (at[0].time_ns, at[-1].time_ns) for part, at in (("colour", colours), ("depth", depths))}
    at.clocks = {**pictured, **spans}
    late = np.array([picture.time_ns for picture in depths])
    for number, colour in enumerate(colours):
        depth = depths[int(np.abs(late - colour.time_ns).argmin())]
        matrix = pose_at(colour.time_ns) if abs(depth.time_ns - colour.time_ns) <= _WITHIN_NS else None
        if matrix is not None:
            pose = pose_of_square(at.axes, f"{at.path}, pose at {colour.time_ns} ns", matrix)
            raw = partial(_pixels, bag, topics["depth"], depth)
            read = partial(_pictures, partial(_pixels, bag, topics["colour"], colour), raw, topics["depth"], at.scale)
            name, time_ns = f"{topics['colour']} {number}", at.instant_ns(number, colour.time_ns)
            at.frames.append(RecordedFrame(name, time_ns, pose, fov, (wide, high), read, raw))
    named = ", ".join(f"{part} {topic}" for part, topic in topics.items() if topic)
    at.facts += [Assumption("topics", named, by, "--frames-topics"), said]
    at.left_out(len(colours), "no depth within 20 ms, or no pose at their instants")
    at.notes += [f"{part}: the others are not read."] if (part := part_of(bag.path)) else []


@attrs.frozen
class _Stamped:
    time_ns: int
    logged_ns: int
    number: int  # of those that were logged at the same instant
    frame: str


def _stamped(bag: Bag, topic: str) -> list[_Stamped]:
    found: list[_Stamped] = []
    for _, logged_ns, message in bag.messages([topic]):
        number = found[-1].number + 1 if found and found[-1].logged_ns == logged_ns else 0
        found.append(_Stamped(stamp_ns(message.header.stamp), logged_ns, number, message.header.frame_id.strip("/")))
    if not found:
        raise InputError(f"{bag.path}: no message of {topic}; expected pictures")
    return sorted({picture.time_ns: picture for picture in found}.values(), key=lambda picture: picture.time_ns)


def _topics(path: Path, bag: Bag, tree: Transforms, stated: str | None) -> dict[str, str]:
    """Return the topics that the user names, else the only fitting ones; pose is "" for TF."""
    parts = [part.partition("=") for part in (stated or "").split(",") if part]
    named = {key.strip(): topic.strip() for key, _, topic in parts}
    if not named.keys() <= set(_PARTS):
        raise InputError(f"--frames-topics '{stated}': expected {', '.join(_NAMING.split(','))}")
    absent = next((topic for topic in named.values() if topic not in bag.topics), None)
    if absent is not None:
        raise InputError(f"{path}: no topic '{absent}'; it holds {_held(bag.topics)}")
    first = {topic: _first(bag, topic) for topic, kind in bag.topics.items() if kind in _IMAGES}
    pictures = {topic: "" if message is None else encoding_of(message) for topic, message in first.items()}
    frames = {topic: "" if one is None else one.header.frame_id.strip("/") for topic, one in first.items()}
    colour = named.get("colour") or _one(
        path, "colour", [name for name in pictures if pictures[name] in COLOURS], pictures
    )
    fitting = [name for name in pictures if pictures[name] in DEPTHS]
    registered = [name for name in fitting if frames[name] == frames[colour]]
    depth = named.get("depth") or _one(path, "depth", registered or fitting, pictures)
    if frames[colour] != frames[depth]:
        raise InputError(
            f"{path}: {depth} is in frame '{frames[depth]}', {colour} in '{frames[colour]}'; expected depth that is "
            "registered to the colour (aligned_depth_to_color, depth_registered)"
        )
    infos = [name for name, kind in bag.topics.items() if kind == _INFO]
    beside = colour.removesuffix("/compressed").rpartition("/")[0] + "/camera_info"
    info = named.get("info") or (beside if beside in infos else infos[0] if len(infos) == 1 else "")
    poses = [name for name, kind in bag.topics.items() if kind in _POSES]
    by_tree = "pose" not in named and tree.moves(frames[colour])
    pose = named.get("pose") or ("" if by_tree else _one(path, "pose", poses, bag.topics))
    return {"colour": colour, "depth": depth, "info": info, "pose": pose}


def _first(bag: Bag, topic: str) -> Any:
    return next((message for _, _, message in bag.messages([topic])), None) if topic else None


def _one(path: Path, what: str, fitting: list[str], held: dict[str, str]) -> str:
    raw = [topic for topic in fitting if topic.rpartition("/")[0] not in fitting]
    if len(raw) == 1:
        return raw[0]
    found = f"several topics of {what} ({', '.join(raw)})" if raw else f"no topic of {what}; it holds {_held(held)}"
    raise InputError(f"{path}: {found}: name them by --frames-topics {_NAMING}")


def _held(topics: dict[str, str]) -> str:
    return ", ".join([f"{name} ({kind or 'unknown'})" for name, kind in topics.items()][:8]) or "nothing"


def _camera(path: Path, bag: Bag, topics: dict[str, str]) -> Camera | None:
    if (info := _first(bag, topics["info"])) is None:
        return None
    where, size = f"{path}, {topics['info']}", (int(info.width), int(info.height))
    # Their names are small in ROS 2.
    k, d, p = (np.asarray(getattr(info, name, getattr(info, name.upper(), ())), float) for name in "kdp")
    if "rect" in topics["colour"].rpartition("/")[2]:
        return Camera(p[0], p[5], p[2], p[6], size)
    refuse_distortion(where, {"distortion": d.tolist()})
    if not k[0] > 0:
        raise InputError(f"{where}: fx is {k[0]:g}, as of a camera that is not calibrated: give --intrinsics")
    return Camera(k[0], k[4], k[2], k[5], size)


def _poses(
    bag: Bag, tree: Transforms, topic: str, frame: str
) -> tuple[Callable[[int], Matrix | None], Assumption, dict[str, tuple[int, int]]]:
    """Return what gives world_from_optical at an instant, its entry, and when it is known."""
    if not topic:
        root = tree.chain(frame)[-1]
        said = Assumption(POSE, f"'{root}' from '{frame}', by TF", By.FILE)
        return partial(tree.up_to, frame, root), said, tree.spans(frame)
    samples, body = [], ""
    for _, _, message in bag.messages([topic]):
        pose = message.pose if hasattr(message.pose, "orientation") else message.pose.pose
        samples.append((stamp_ns(message.header.stamp), pose.position, pose.orientation))
        body = getattr(message, "child_frame_id", "").strip("/")  # "" where it is not stated
    if not samples:
        raise InputError(f"{bag.path}: no message of {topic}; expected poses")
    motion, instants, fixed = Motion(samples), [sample[0] for sample in samples], None
    if body in tree.chain(frame):
        fixed = tree.up_to(frame, body, 0) if not tree.moves(frame) else None
        said = Assumption(POSE, f"{topic} of '{body}', and TF from there to '{frame}'", By.FILE)
    elif body in ("", frame) or body.endswith("optical_frame"):
        fixed, said = np.eye(4), Assumption(POSE, f"{topic}, of the picture's own frame", By.DEFAULT)
    else:
        fixed = _OPTICAL_FROM_BODY
        said = Assumption(POSE, f"{topic} of '{body}', which looks along x, at the camera's place", By.DEFAULT)

    def at(time_ns: int) -> Matrix | None:
        moved, then = motion.at(time_ns), tree.up_to(frame, body, time_ns) if fixed is None else fixed
        return None if moved is None or then is None else moved @ then

    return at, said, {topic: (min(instants), max(instants))}


def _pixels(bag: Bag, topic: str, picture: _Stamped) -> Any:
    where = f"{bag.path}, {topic} at {picture.time_ns} ns"
    return pixels_of(where, bag.message(topic, picture.logged_ns, picture.number))


def _pictures(colour: Callable[[], Any], depth: Callable[[], Any], where: str, scale: float) -> Pictures:
    picture = np.ascontiguousarray(colour())
    return as_pictures(picture, in_metres(fitted_depth(depth(), picture, where), scale))
