"""Bags of ROS, and the table of all poses in their messages."""

from __future__ import annotations

import bz2
import operator
import os
import re
import threading
import weakref
from collections.abc import Collection, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO

from ...base import HmdwarpError, TraceError, import_extra
from ...base.named_files import BAG, TABLE, most_unpacked, opened, text_in, unpacked
from ..assumptions import Defect
from .columns import Made

COLUMNS = ("stamp_ns", "topic", "x", "y", "z", "qx", "qy", "qz", "qw")
# Where messages have position and orientation.
_POSES = {
    "geometry_msgs/PoseStamped": ("pose.position", "pose.orientation"),
    "geometry_msgs/PoseWithCovarianceStamped": ("pose.pose.position", "pose.pose.orientation"),
    "geometry_msgs/TransformStamped": ("transform.translation", "transform.rotation"),
    "nav_msgs/Odometry": ("pose.pose.position", "pose.pose.orientation"),
}
_LISTS = ("tf2_msgs/TFMessage", "tf/tfMessage")  # of transforms; the latter of the first tf
_STATIC = "tf_static"  # topic of transforms that never change: no head
_DATA = re.compile(r"^\s*- (\S+\.(?:db3|mcap))\s*$", re.MULTILINE)  # of a recording, in its metadata
_XYZ, _XYZW = operator.attrgetter("x", "y", "z"), operator.attrgetter("x", "y", "z", "w")


def part_of(path: Path) -> str:
    """Return that a file is one of several of a recording, as its metadata.yaml says; else ""."""
    metadata = path.with_name("metadata.yaml")
    files = set(_DATA.findall(metadata.read_text("utf-8", "replace"))) if metadata.is_file() else set()
    if len(files) < 2 or path.name not in files:
        return ""
    return f"{path.name} is one of the {len(files)} files of its recording, as metadata.yaml says"


_BAGS_EXTRA = "bags"
MAGICS = (b"#ROSBAG V2.0", b"SQLite format 3\x00", b"\x89MCAP0\r\n")
ENDINGS = (".bag", ".db3", ".mcap")
_METADATA = "metadata.yaml"


def bag_at(path: Path) -> Path | None:
    """Return the bag that a path is, or the only one in a folder; None for no bag."""
    if path.exists() and not path.is_dir():
        return path if path.suffix in ENDINGS else None
    if (path / _METADATA).exists():
        return path
    found = [place for place in path.glob("*") if place.suffix in ENDINGS or (place / _METADATA).exists()]
    return found[0] if len(found) == 1 else None


class Bag:
    """The topics and messages of a bag, which stays open as long as this is used.

    Errors: TraceError for a damaged one; MachineError where rosbags is missing.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, threading.Lock()
        highlevel = import_extra("rosbags.highlevel", "rosbags", _BAGS_EXTRA)
        types = import_extra("rosbags.typesys", "rosbags", _BAGS_EXTRA)
        if path.is_dir():
            opened(path / _METADATA, TABLE).close()
        for file in path.iterdir() if path.is_dir() else (path,):  # SQLite would wait for a pipe
            if file.suffix in ENDINGS or file == path:
                opened(file, BAG).close()
        _bound_unpacking()
        try:
            # Older bags of ROS 2 do not hold the definitions of their messages.
            defined = types.get_typestore(types.Stores.LATEST)
            self._reader = highlevel.AnyReader([_BagPath(path)], default_typestore=defined)
            self._reader.open()
        except HmdwarpError:
            raise
        except Exception as error:  # its parsers raise anything at damaged data
            raise self._damaged(error) from None
        weakref.finalize(self, self._reader.close)
        # Type by topic, as ROS 1 names it: sensor_msgs/Image.
        self.topics = {each.topic: each.msgtype.replace("/msg/", "/") for each in self._reader.connections}

    def messages(
        self, topics: Collection[str], first_ns: int | None = None, last_ns: int | None = None
    ) -> Iterator[tuple[str, int, Any]]:
        """Yield topic, time of logging in ns and message, of the instants from first to last."""
        chosen = [connection for connection in self._reader.connections if connection.topic in topics]
        stop_ns = None if last_ns is None else last_ns + 1
        try:
            found = self._reader.messages(chosen, start=first_ns, stop=stop_ns) if chosen else ()
            for connection, time_ns, raw in found:
                if not isinstance(time_ns, int):  # any column of SQLite may hold text
                    raise ValueError(f"a message at {time_ns!r}")  # noqa: TRY301 (said as the reader's own)
                yield connection.topic, time_ns, self._reader.deserialize(raw, connection.msgtype)
        except HmdwarpError:
            raise
        except Exception as error:  # as above
            raise self._damaged(error) from None

    def message(self, topic: str, time_ns: int, number: int = 0) -> Any:
        """Return a message by its time of logging. number: of those of one instant."""
        with self._lock:
            for at, (_, _, message) in enumerate(self.messages([topic], time_ns, time_ns)):
                if at == number:
                    return message
        raise TraceError(f"{self.path}: no message {number} of {topic} at {time_ns} ns; was the bag replaced?")

    def _damaged(self, error: Exception) -> TraceError:
        why = " ".join(f"{type(error).__name__}: {error}".split())
        return TraceError(f"{self.path}: cannot be read as a bag ({why}); expected one of {', '.join(ENDINGS)}")


class _BagPath(type(Path())):  # type: ignore[misc]
    """A path whose files rosbags opens as all others are opened, packed ones too."""

    def open(self, *_: Any, **__: Any) -> BinaryIO:
        return opened(self, BAG)

    def read_text(self, *_: Any, **__: Any) -> str:
        return text_in(self, TABLE)


class _Bounded(AbstractContextManager["_Bounded"]):
    """A packed file, open for reading. Errors: ValueError beyond most_unpacked."""

    def __init__(self, file: BinaryIO, unpacking: BinaryIO) -> None:
        self._unpacking, self._left = unpacking, most_unpacked(os.fstat(file.fileno()).st_size)

    def read(self, size: int) -> bytes:
        data = self._unpacking.read(size)
        if (left := self._left - len(data)) < 0:
            raise ValueError("too many bytes when it is unpacked")
        self._left = left
        return data

    def __exit__(self, *_: object) -> None:
        self._unpacking.close()


def _bound_unpacking() -> None:
    """Have rosbags unpack no more than most_unpacked; it would take what there is."""
    names = ("rosbag1.reader", "rosbag2.reader", "rosbag2.storage_mcap")
    first, second, mcap = (import_extra(f"rosbags.{name}", "rosbags", _BAGS_EXTRA) for name in names)
    lz4, zstd = import_extra("lz4.frame", "lz4", _BAGS_EXTRA), vars(second)["zstd"]
    if isinstance(zstd, SimpleNamespace):
        return
    makers = {"bz2": bz2.BZ2Decompressor, "lz4": lz4.LZ4FrameDecompressor, "zstd": zstd.ZstdDecompressor}
    bounded = {name: lambda data, *_, make=make: unpacked(make(), data) for name, make in makers.items()}
    first.decompressors.update({name: bounded[name] for name in ("bz2", "lz4")})
    mcap.DECOMPRESSORS.update({name: bounded[name] for name in ("lz4", "zstd")})
    vars(second)["zstd"] = SimpleNamespace(
        decompress=bounded["zstd"], open=lambda file, mode: _Bounded(file, zstd.open(file, mode))
    )


def stamp_ns(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def table_of_bag(path: Path) -> Made:
    """Return a row of COLUMNS for each pose of a bag. Errors: TraceError; as of Bag."""
    bag, defects = Bag(path), list[Defect]()
    rows, children, frames = [], dict[str, str](), dict[str, str]()  # frame -> the one it is in; topic -> frame
    held = {topic: name for topic, name in bag.topics.items() if name not in (*_POSES, *_LISTS)}

    def parts_of(kind: str, message: Any) -> Iterator[tuple[str, str, int, list[str]]]:
        """Yield parent, child, stamp in ns and numbers of each pose."""
        if kind in _LISTS:
            for one in message.transforms:
                yield from parts_of("geometry_msgs/TransformStamped", one)
            return
        position, orientation = (operator.attrgetter(place)(message) for place in _POSES[kind])
        numbers = map(float, (*_XYZ(position), *_XYZW(orientation)))
        child, head = str(getattr(message, "child_frame_id", "")), message.header
        yield str(head.frame_id), child, stamp_ns(head.stamp), [*map(repr, numbers)]

    for topic, logged_ns, whole in bag.messages(bag.topics.keys() - held.keys()):
        try:
            poses = list(parts_of(bag.topics[topic], whole))
        except (AttributeError, TypeError, ValueError) as error:  # a file defines its messages itself
            raise bag._damaged(error) from None
        for parent, child, stamped_ns, numbers in poses:
            if child:
                children.setdefault(child, parent)
            if topic.rpartition("/")[2] == _STATIC:
                continue
            name = f"{topic} {child}".strip()
            frames.setdefault(name, parent)
            rows.append((stamped_ns, logged_ns, [name, *numbers]))
    if not rows:
        others = ", ".join(f"{topic} ({what})" for topic, what in list(held.items())[:8])
        others = f" that can be read; it holds {others}" if others else ""
        raise TraceError(f"{path} is a bag without poses{others}: expected {', '.join([*_POSES, *_LISTS])}")
    if part := part_of(path):
        defects.append(Defect("part-alone", part, "the others are not read"))
    stamped = any(stamped_ns for stamped_ns, _, _ in rows)
    if not stamped:
        what = "its messages have no time stamps of their own"
        defects.append(Defect("stamp-missing", what, "the times at which they were logged taken"))
    made = [[str(own_ns if stamped else logged_ns), *row] for own_ns, logged_ns, row in rows]
    nested = {}
    for name, parent in frames.items():
        if parent in children:
            what = f"its poses are in frame '{parent}', which is itself in frame '{children[parent]}'"
            nested[name] = Defect("frame-nested", what, "taken as they are; transforms are not chained")
    return Made("rosbag", made, COLUMNS, tuple(defects), nested)
