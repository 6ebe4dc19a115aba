"""Bags of ROS 1 (.bag) and ROS 2 (.db3, .mcap, or their folder), read by rosbags."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from ...errors import HmdwarpError, TraceError
from ...options.named_files import BAG, TABLE, opened, text_in
from ...resources import import_extra
from .made import Made
from .pose_messages import PoseMessages, StampedPose, has_poses, poses_in

EXTRA = "bags"
MAGICS = (b"#ROSBAG V2.0", b"SQLite format 3\x00")  # of files that only rosbags reads
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
        highlevel = import_extra("rosbags.highlevel", "rosbags", EXTRA)
        types = import_extra("rosbags.typesys", "rosbags", EXTRA)
        _check_plain(path)
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
        self.topics = {
            connection.topic: connection.msgtype.replace("/msg/", "/") for connection in self._reader.connections
        }

    def messages(
        self, topics: Collection[str], first_ns: int | None = None, last_ns: int | None = None
    ) -> Iterator[tuple[str, int, Any]]:
        """Yield topic, time of logging in ns and message, of the instants from first to last."""
        chosen = [connection for connection in self._reader.connections if connection.topic in topics]
        stop_ns = None if last_ns is None else last_ns + 1
        try:
            for connection, time_ns, raw in (
                self._reader.messages(chosen, start=first_ns, stop=stop_ns) if chosen else ()
            ):
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


def _check_plain(path: Path) -> None:
    """Refuse what rosbags would wait for: SQLite opens a .db3 by its name."""
    if path.is_dir():
        opened(path / _METADATA, TABLE).close()
    for file in path.iterdir() if path.is_dir() else (path,):
        if file.suffix in ENDINGS or file == path:
            opened(file, BAG).close()


def stamp_ns(stamp: Any) -> int:
    """Return the nanoseconds of a stamp."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def table_of_bag(path: Path) -> Made:
    """Return every pose of the messages that hold one, in the order they were logged.

    Errors: TraceError without any, or for damaged data; MachineError where rosbags is missing.
    """
    return _Reading(path).table()


class _Reading(PoseMessages):
    kind = "rosbag"
    file = "a bag"
    wanted = "of ROS 1 or ROS 2"

    def poses(self) -> Iterator[tuple[str, int, StampedPose]]:
        bag = Bag(self.path)
        self.held = {topic: name for topic, name in bag.topics.items() if not has_poses(name)}
        for topic, logged_ns, message in bag.messages(bag.topics.keys() - self.held.keys()):
            for pose in poses_in(bag.topics[topic], message):
                yield topic, logged_ns, pose
