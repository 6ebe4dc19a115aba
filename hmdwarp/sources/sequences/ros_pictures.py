"""Pictures in messages of ROS: colour and depth, raw or compressed."""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...poses import Origin, PoseTrack
from ...poses.reading.pose_messages import stamp_ns

# Bytes a pixel, and which of its channels are red, green and blue.
COLOURS = {
    "rgb8": (3, (0, 1, 2)),
    "bgr8": (3, (2, 1, 0)),
    "8UC3": (3, (2, 1, 0)),
    "rgba8": (4, (0, 1, 2)),
    "bgra8": (4, (2, 1, 0)),
    "8UC4": (4, (2, 1, 0)),
    "mono8": (1, (0, 0, 0)),
    "8UC1": (1, (0, 0, 0)),
}
# Type and metres per unit.
DEPTHS = {"16UC1": ("u2", 0.001), "mono16": ("u2", 0.001), "32FC1": ("f4", 1.0)}
_COMPRESSED_DEPTH = "compressedDepth"
_HEADER = 12  # bytes before the PNG of a compressed depth


def encoding_of(message: Any) -> str:
    """Return a name of COLOURS or DEPTHS ("rgb8" for compressed colour), "" for others."""
    if hasattr(message, "encoding"):
        return str(message.encoding) if message.encoding in {*COLOURS, *DEPTHS} else ""
    encoding = str(message.format).partition(";")[0].strip()
    if encoding in DEPTHS:
        return encoding
    if _COMPRESSED_DEPTH in message.format:
        return "16UC1"
    return "rgb8" if any(word in message.format for word in ("jpeg", "jpg", "png")) else ""


def pixels_of(where: str, message: Any) -> NDArray[Any]:
    """Return (h, w, 3) uint8 sRGB, or (h, w) depth in its own unit. Errors: InputError."""
    encoding = encoding_of(message)
    if not encoding:
        found = getattr(message, "encoding", None) or message.format
        raise InputError(f"{where}: pictures of {found}; expected {', '.join([*COLOURS, *DEPTHS])}, JPEG or PNG")
    if not hasattr(message, "encoding"):
        return _decompressed(where, message, encoding)
    count, channels = COLOURS.get(encoding, (0, ()))
    kind = np.dtype("u1" if count else DEPTHS[encoding][0]).newbyteorder(">" if message.is_bigendian else "<")
    width = message.width * max(count, 1) * kind.itemsize
    data = np.asarray(message.data, np.uint8)
    if message.step < width or len(data) < message.step * message.height:
        raise InputError(
            f"{where}: {len(data)} bytes in rows of {message.step}; expected {message.width}x{message.height} pixels "
            f"of {encoding}"
        )
    rows = data[: message.step * message.height].reshape(message.height, message.step)[:, :width]
    values = np.ascontiguousarray(rows).view(kind)
    if not count:
        return values.astype(kind.newbyteorder("="))
    return values.reshape(message.height, message.width, count)[..., list(channels)]


def _decompressed(where: str, message: Any, encoding: str) -> NDArray[Any]:
    from PIL import Image

    data = bytes(np.asarray(message.data, np.uint8))
    if encoding in DEPTHS and _COMPRESSED_DEPTH in message.format:
        data = data[_HEADER:]
        if DEPTHS[encoding][0] != "u2":
            raise InputError(f"{where}: compressed depth of {encoding}; expected 16UC1, which is not quantised")
    try:
        with Image.open(io.BytesIO(data)) as picture:
            return np.asarray(picture if encoding in DEPTHS else picture.convert("RGB"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputError(f"{where}: a picture that cannot be read ({error}); expected JPEG or PNG") from error


Matrix = NDArray[np.float64]  # (4, 4)


def matrix_of(position: Any, orientation: Any) -> Matrix:
    from scipy.spatial.transform import Rotation

    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat([orientation.x, orientation.y, orientation.z, orientation.w]).as_matrix()
    matrix[:3, 3] = position.x, position.y, position.z
    return matrix


class Motion:
    """Samples of one frame in another, in the axes of ROS."""

    def __init__(self, samples: Iterable[tuple[int, Any, Any]]) -> None:
        """Take time_ns, position and quaternion; of several at one instant the last holds."""
        of_instants = {time_ns: (position, turn) for time_ns, position, turn in samples}
        self.times_ns = np.array(sorted(of_instants), np.int64)
        self._matrices = [matrix_of(*of_instants[int(time_ns)]) for time_ns in self.times_ns]
        self._track: PoseTrack | None = None

    def at(self, time_ns: int) -> Matrix | None:
        """Return parent_from_child; None outside of the samples or in a gap."""
        from scipy.spatial.transform import Rotation

        if self._track is None:
            turns = Rotation.from_matrix([matrix[:3, :3] for matrix in self._matrices]).as_quat()
            positions = np.array([matrix[:3, 3] for matrix in self._matrices])
            self._track = PoseTrack(self.times_ns - self.times_ns[0], positions, turns)
        sample = self._track.at(time_ns - int(self.times_ns[0]))
        if sample.origin is Origin.HELD:
            return None
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = sample.pose.rotation_matrix, sample.pose.position_m
        return matrix


class Transforms:
    """The tree of /tf and /tf_static."""

    def __init__(self, moving: Iterable[Any], still: Iterable[Any]) -> None:
        samples: dict[tuple[str, str], list[tuple[int, Any, Any]]] = {}
        self._still: dict[str, tuple[str, Matrix]] = {}
        for transform in still:
            parent, child = (name.strip("/") for name in (transform.header.frame_id, transform.child_frame_id))
            self._still[child] = parent, matrix_of(transform.transform.translation, transform.transform.rotation)
        for transform in moving:
            parent, child = (name.strip("/") for name in (transform.header.frame_id, transform.child_frame_id))
            sample = stamp_ns(transform.header.stamp), transform.transform.translation, transform.transform.rotation
            samples.setdefault((child, parent), []).append(sample)
        self._moving = {child: (parent, Motion(found)) for (child, parent), found in samples.items()}

    def chain(self, frame: str) -> list[str]:
        """Return a frame and those that it is in, up to the root."""
        names = [frame]
        while (edge := self._moving.get(names[-1]) or self._still.get(names[-1])) and edge[0] not in names:
            names.append(edge[0])
        return names

    def moves(self, frame: str) -> bool:
        """Return whether a transform that moves is above the frame."""
        return any(name in self._moving for name in self.chain(frame))

    def spans(self, frame: str) -> dict[str, tuple[int, int]]:
        """Return when the transforms that move are known, of those above the frame."""
        moving = {name: self._moving[name][1].times_ns for name in self.chain(frame) if name in self._moving}
        return {f"/tf of {name}": (int(times[0]), int(times[-1])) for name, times in moving.items()}

    def up_to(self, frame: str, ancestor: str, time_ns: int) -> Matrix | None:
        """Return ancestor_from_frame; None where a transform is missing, or has no sample then."""
        names, matrix = self.chain(frame), np.eye(4)
        if ancestor not in names:
            return None
        for name in names[: names.index(ancestor)]:
            found = self._moving[name][1].at(time_ns) if name in self._moving else self._still[name][1]
            if found is None:
                return None
            matrix = found @ matrix
        return matrix
