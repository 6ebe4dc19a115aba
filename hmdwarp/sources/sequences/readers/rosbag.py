"""Bags of ROS: colour, registered depth, its camera, and transforms, odometry or poses."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from scipy.spatial.transform import Rotation

from ....base import InputError
from ....poses import Origin, PoseTrack
from ....poses.assumptions import Assumption, By
from ....poses.reading.pose_messages import Bag, bag_at, part_of, stamp_ns
from ..frame_files import Camera, refuse_distortion
from ..picture_files import fitted_depth
from ..recorded import POSE, Pictures, RecordedFrame, as_pictures, in_metres
from . import Folder, Matrix, layout

_OPTICAL_FROM_BODY = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
_IMAGES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
_INFO, _TF = "sensor_msgs/CameraInfo", ("tf2_msgs/TFMessage", "tf/tfMessage")
_POSES = ("nav_msgs/Odometry", "geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped")
_PARTS = ("colour", "depth", "info", "pose")
_NAMING = ",".join(f"{part}=TOPIC" for part in _PARTS)
_WITHIN_NS = 20_000_000  # of colour and depth of one frame, as for TUM RGB-D
# Bytes a pixel, and which of its channels are red, green and blue.
_RGB, _BGR = (0, 1, 2), (2, 1, 0)
_COLOURS = {"rgb8": (3, _RGB), "bgr8": (3, _BGR), "8UC3": (3, _BGR), "mono8": (1, (0, 0, 0)), "8UC1": (1, (0, 0, 0))}
_COLOURS |= {"rgba8": (4, _RGB), "bgra8": (4, _BGR), "8UC4": (4, _BGR)}
_DEPTHS = {"16UC1": ("u2", 0.001), "mono16": ("u2", 0.001), "32FC1": ("f4", 1.0)}  # type and metres per unit
_COMPRESSED_DEPTH = "compressedDepth"
_HEADER = 12  # bytes before the PNG of a compressed depth


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
    """Source: ROS REP 103, 105 (axes, frames), 118 (depth); sensor_msgs/CameraInfo (K, D, P)."""
    place = bag_at(at.path)
    if place is None:
        raise InputError(f"{at.path}: no bag, or several; expected {at.layout.summary}")
    bag = Bag(place)
    tree, by = _Transforms(bag), By.USER if at.options.frames_topics else By.DEFAULT
    topics = _topics(at.path, bag, tree, at.options.frames_topics)
    colours, depths = (_stamped(bag, topics[part]) for part in ("colour", "depth"))
    scale = _DEPTHS[_encoding_of(bag.message(topics["depth"], depths[0].logged_ns, depths[0].number))][1]
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
            pose = at.pose_in(f"{at.path}, pose at {colour.time_ns} ns", matrix)
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


def _topics(path: Path, bag: Bag, tree: _Transforms, stated: str | None) -> dict[str, str]:
    """Return the topics that the user names, else the only fitting ones; pose is "" for TF."""
    parts = [part.partition("=") for part in (stated or "").split(",") if part]
    named = {key.strip(): topic.strip() for key, _, topic in parts}
    if not named.keys() <= set(_PARTS):
        raise InputError(f"--frames-topics '{stated}': expected {', '.join(_NAMING.split(','))}")
    absent = next((topic for topic in named.values() if topic not in bag.topics), None)
    if absent is not None:
        raise InputError(f"{path}: no topic '{absent}'; it holds {_held(bag.topics)}")
    first = {topic: _first(bag, topic) for topic, kind in bag.topics.items() if kind in _IMAGES}
    pictures = {topic: "" if message is None else _encoding_of(message) for topic, message in first.items()}
    frames = {topic: "" if one is None else one.header.frame_id.strip("/") for topic, one in first.items()}
    colour = named.get("colour") or _one(
        path, "colour", [name for name in pictures if pictures[name] in _COLOURS], pictures
    )
    fitting = [name for name in pictures if pictures[name] in _DEPTHS]
    registered = [name for name in fitting if frames[name] == frames[colour]]
    depth = named.get("depth") or _one(path, "depth", registered or fitting, pictures)
    if frames[colour] != frames[depth]:
        expected = "expected depth that is registered to the colour (aligned_depth_to_color, depth_registered)"
        raise InputError(f"{path}: {depth} is in frame '{frames[depth]}', {colour} in '{frames[colour]}'; {expected}")
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
    bag: Bag, tree: _Transforms, topic: str, frame: str
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
    motion, instants, fixed = _Motion(samples), [sample[0] for sample in samples], None
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


def _pictures(colour: Callable[[], Any], depth: Callable[[], Any], where: str, scale: float) -> Pictures:
    picture = np.ascontiguousarray(colour())
    return as_pictures(picture, in_metres(fitted_depth(depth(), picture, where), scale))


def _pixels(bag: Bag, topic: str, picture: _Stamped) -> Any:
    """Return (h, w, 3) uint8 sRGB, or (h, w) depth in its own unit. Errors: InputError."""
    where = f"{bag.path}, {topic} at {picture.time_ns} ns"
    message = bag.message(topic, picture.logged_ns, picture.number)
    encoding = _encoding_of(message)
    if not encoding:
        found = getattr(message, "encoding", None) or message.format
        raise InputError(f"{where}: pictures of {found}; expected {', '.join([*_COLOURS, *_DEPTHS])}, JPEG or PNG")
    data = np.asarray(message.data, np.uint8)
    if not hasattr(message, "encoding"):
        from PIL import Image

        if encoding in _DEPTHS and _COMPRESSED_DEPTH in message.format:
            data = data[_HEADER:]
            if _DEPTHS[encoding][0] != "u2":
                raise InputError(f"{where}: compressed depth of {encoding}; expected 16UC1, which is not quantised")
        try:
            with Image.open(io.BytesIO(data.tobytes())) as image:
                return np.asarray(image if encoding in _DEPTHS else image.convert("RGB"))
        except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
            raise InputError(f"{where}: a picture that cannot be read ({error}); expected JPEG or PNG") from error
    count, channels = _COLOURS.get(encoding, (0, ()))
    kind = np.dtype("u1" if count else _DEPTHS[encoding][0]).newbyteorder(">" if message.is_bigendian else "<")
    width = message.width * max(count, 1) * kind.itemsize
    if message.step < width or len(data) < message.step * message.height:
        expected = f"expected {message.width}x{message.height} pixels of {encoding}"
        raise InputError(f"{where}: {len(data)} bytes in rows of {message.step}; {expected}")
    rows = data[: message.step * message.height].reshape(message.height, message.step)[:, :width]
    values = np.ascontiguousarray(rows).view(kind)
    if not count:
        return values.astype(kind.newbyteorder("="))
    return values.reshape(message.height, message.width, count)[..., list(channels)]


def _encoding_of(message: Any) -> str:
    if hasattr(message, "encoding"):
        return str(message.encoding) if message.encoding in {*_COLOURS, *_DEPTHS} else ""
    encoding = str(message.format).partition(";")[0].strip()
    if encoding in _DEPTHS:
        return encoding
    if _COMPRESSED_DEPTH in message.format:
        return "16UC1"
    return "rgb8" if any(word in message.format for word in ("jpeg", "jpg", "png")) else ""


def _matrix_of(position: Any, orientation: Any) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat([orientation.x, orientation.y, orientation.z, orientation.w]).as_matrix()
    matrix[:3, 3] = position.x, position.y, position.z
    return matrix


class _Motion:
    def __init__(self, samples: Iterable[tuple[int, Any, Any]]) -> None:
        self._samples = dict(sorted({time_ns: _matrix_of(*pose) for time_ns, *pose in samples}.items()))
        self.times_ns = list(self._samples)

    @cached_property
    def _track(self) -> PoseTrack:
        matrices = np.array(list(self._samples.values()))
        turns = Rotation.from_matrix(matrices[:, :3, :3]).as_quat()
        return PoseTrack(np.array(self.times_ns) - self.times_ns[0], matrices[:, :3, 3], turns)

    def at(self, time_ns: int) -> Matrix | None:
        """Return parent_from_child; None outside of the samples or in a gap."""
        sample = self._track.at(time_ns - self.times_ns[0])
        return None if sample.origin is Origin.HELD else sample.pose.matrix()


class _Transforms:
    def __init__(self, bag: Bag) -> None:
        samples: dict[tuple[str, str], list[tuple[int, Any, Any]]] = {}
        self._still: dict[str, tuple[str, Matrix]] = {}
        messages = bag.messages([name for name, kind in bag.topics.items() if kind in _TF])
        for topic, transform in ((topic, one) for topic, _, message in messages for one in message.transforms):
            parent, child = (name.strip("/") for name in (transform.header.frame_id, transform.child_frame_id))
            pose = transform.transform.translation, transform.transform.rotation
            if topic.endswith("tf_static"):
                self._still[child] = parent, _matrix_of(*pose)
            else:
                samples.setdefault((child, parent), []).append((stamp_ns(transform.header.stamp), *pose))
        self._moving = {child: (parent, _Motion(found)) for (child, parent), found in samples.items()}

    def chain(self, frame: str) -> list[str]:
        names = [frame]
        while (edge := self._moving.get(names[-1]) or self._still.get(names[-1])) and edge[0] not in names:
            names.append(edge[0])
        return names

    def moves(self, frame: str) -> bool:
        return any(name in self._moving for name in self.chain(frame))

    def spans(self, frame: str) -> dict[str, tuple[int, int]]:
        moving = {name: self._moving[name][1].times_ns for name in self.chain(frame) if name in self._moving}
        return {f"/tf of {name}": (times[0], times[-1]) for name, times in moving.items()}

    def up_to(self, frame: str, ancestor: str, time_ns: int) -> Matrix | None:
        names, matrix = self.chain(frame), np.eye(4)
        if ancestor not in names:
            return None
        for name in names[: names.index(ancestor)]:
            found = self._moving[name][1].at(time_ns) if name in self._moving else self._still[name][1]
            if found is None:
                return None
            matrix = found @ matrix
        return matrix
