"""Poses in messages of ROS and Foxglove, and the table of all poses of a recording."""

from __future__ import annotations

import bz2
import operator
import os
import re
import struct
import threading
import tomllib
import weakref
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any, BinaryIO

from ...errors import HmdwarpError, TraceError
from ...options.documents import parse_json
from ...options.named_files import BAG, TABLE, most_unpacked, opened, text_in, unpacked
from ...resources import import_extra
from ..assumptions import Defect
from .header import Made

COLUMNS = ("stamp_ns", "topic", "x", "y", "z", "qx", "qy", "qz", "qw")
_TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_FIELDS, _LISTS = {name: text.split() for name, text in _TABLE["fields"].items()}, _TABLE["lists"]
_WITH_POSES = {*_FIELDS, *_LISTS}  # types of messages
_FILES = {"mcap": ("an MCAP file", "as JSON, protobuf or ROS 2's CDR"), "rosbag": ("a bag", "of ROS 1 or ROS 2")}
_STATIC = "tf_static"  # topic of transforms that never change: no head
_DATA = re.compile(r"^\s*- (\S+\.(?:db3|mcap))\s*$", re.MULTILINE)  # of a recording, in its metadata
_XYZ, _XYZW = operator.attrgetter("x", "y", "z"), operator.attrgetter("x", "y", "z", "w")


# Of a message: nanoseconds (0 without a stamp), its frame and the one in it, position and xyzw.
_StampedPose = tuple[int, str, str, tuple[float, ...]]


def poses_in(name: str, message: Any) -> Iterator[_StampedPose]:
    if name in _LISTS:
        for transform in message.transforms:
            yield from poses_in(_LISTS[name], transform)
        return
    found = ("" if path == "-" else operator.attrgetter(path)(message) for path in _FIELDS[name])
    stamp, parent, child, position, orientation = found
    numbers = tuple(map(float, (*_XYZ(position), *_XYZW(orientation))))
    whole, rest = next(pair for pair in _TABLE["stamps"].values() if all(hasattr(stamp, part) for part in pair))
    stamp_ns = int(getattr(stamp, whole)) * 1_000_000_000 + int(getattr(stamp, rest))
    yield stamp_ns, parent, child, numbers


def part_of(path: Path) -> str:
    """Return that a file is one of several of a recording, as its metadata.yaml says; else ""."""
    metadata = path.with_name("metadata.yaml")
    files = set(_DATA.findall(metadata.read_text("utf-8", "replace"))) if metadata.is_file() else set()
    if len(files) < 2 or path.name not in files:
        return ""
    return f"{path.name} is one of the {len(files)} files of its recording, as metadata.yaml says"


def _table(
    path: Path, kind: str, poses: Iterable[tuple[str, int, _StampedPose]], held: Mapping[str, str],
    defects: list[Defect], comments: Iterable[str] = (),
) -> Made:  # fmt: skip
    """Return a row of COLUMNS for each pose. poses: topic, time of logging in ns and pose.

    held: what other topics hold. It, defects and comments are complete once the poses are read.
    """
    rows, children, frames = [], dict[str, str](), dict[str, str]()  # frame -> the one it is in; topic -> frame
    for topic, logged_ns, (stamped_ns, parent, child, numbers) in poses:
        if child:
            children.setdefault(child, parent)
        if topic.rpartition("/")[2] == _STATIC:
            continue
        name = " ".join(f"{topic} {child}".replace(",", " ").replace('"', " ").split())
        frames.setdefault(name, parent)
        rows.append((stamped_ns, logged_ns, ",".join((name, *map(repr, numbers)))))
    if not rows:
        others = ", ".join(f"{topic} ({what})" for topic, what in list(held.items())[:8])
        others = f" that can be read; it holds {others}" if others else ""
        what, coded = _FILES[kind]
        types = ", ".join([*_FIELDS, *_LISTS])
        raise TraceError(f"{path} is {what} without poses{others}: expected {types}, {coded}")
    if part := part_of(path):
        defects.append(Defect("part-alone", part, "the others are not read"))
    stamped = any(stamped_ns for stamped_ns, _, _ in rows)
    if not stamped:
        what = "its messages have no time stamps of their own"
        defects.append(Defect("stamp-missing", what, "the times at which they were logged taken"))
    lines = (f"{own_ns if stamped else logged_ns},{row}" for own_ns, logged_ns, row in rows)
    text = "\n".join([*comments, ",".join(COLUMNS), *lines, ""]).encode()
    nested = {}
    for name, parent in frames.items():
        if parent in children:
            what = f"its poses are in frame '{parent}', which is itself in frame '{children[parent]}'"
            nested[name] = Defect("frame-nested", what, "taken as they are; transforms are not chained")
    return Made(kind, text, defects=tuple(defects), nested=nested)


MAGIC = b"\x89MCAP0\r\n"
EXTRA = "mcap"
METADATA = "hmdwarp"  # name of the record that states the axes and the origin


def table_of_mcap(path: Path, stream: IO[bytes], size: int) -> Made:
    """Return the poses of an MCAP file. Errors: TraceError, MachineError without `mcap`."""
    _check_unpacked(path, stream, size)
    mcap, how = import_extra("mcap.reader", "mcap", EXTRA), {"validate_crcs": True, "record_size_limit": size}
    modules = (("mcap_ros2.decoder", "mcap-ros2-support"), ("mcap_protobuf.decoder", "mcap-protobuf-support"))
    factories = [import_extra(*name, EXTRA).DecoderFactory() for name in modules]
    decoders: dict[int, Callable[[bytes], Iterator[_StampedPose]] | None] = {}
    held: dict[str, str] = {}
    comments: list[str] = []
    defects: list[Defect] = []

    def decoder(schema: Any, channel: Any) -> Callable[[bytes], Iterator[_StampedPose]] | None:
        """Return what reads the poses of a channel's messages, None where they have none."""
        if channel.id not in decoders:
            name = "" if schema is None else schema.name.replace("/msg/", "/")
            coded, decode = channel.message_encoding, None
            if name in _WITH_POSES and coded == "json":
                decode = lambda data: _by_name(parse_json(data))  # noqa: E731
            elif name in _WITH_POSES:
                decode = next(filter(None, (f.decoder_for(coded, schema) for f in factories)), None)
            if decode is None:
                held[channel.topic] = f"{name or 'no schema'}, {coded}"
            decoders[channel.id] = decode and (lambda data: poses_in(name, decode(data)))
        return decoders[channel.id]

    reader: Any = None
    topics = None  # all; of a whole file only the parts with poses are read
    try:
        reader = mcap.SeekingReader(stream, **how)
        if (index := reader.get_summary()) is not None:
            stated: dict[str, str] = next((m.metadata for m in reader.iter_metadata() if m.name == METADATA), {})
            comments += [f"# {key}: {' '.join(value.split())}" for key, value in stated.items()]
            known = [(channel, index.schemas.get(channel.schema_id)) for channel in index.channels.values()]
            topics = [channel.topic for channel, schema in known if decoder(schema, channel) is not None]
    except Exception:  # as below: a file that was cut off has no index where it should be
        topics = None
    if topics is None:
        stream.seek(0)
        reader = mcap.NonSeekingReader(stream, **how)

    def poses() -> Iterator[tuple[str, int, _StampedPose]]:
        count = 0
        try:
            for schema, channel, message in reader.iter_messages(topics, log_time_order=topics is not None):
                decode = decoder(schema, channel)
                for pose in () if decode is None else decode(message.data):
                    count += 1
                    yield channel.topic, message.log_time, pose
        except HmdwarpError:
            raise
        except Exception as error:  # decoders and decompressors raise anything at damaged data
            why = f"{type(error).__name__}: {error}"
            if topics is not None or not count:
                raise TraceError(f"{path}: its MCAP data are damaged ({why}): copy or record it again") from None
            what = f"the file ends in the middle, after {count} poses ({why})"
            defects.append(Defect("file-cut", what, "read up to there"))

    return _table(path, "mcap", poses(), held, defects, comments)


def _check_unpacked(path: Path, stream: IO[bytes], size: int) -> None:
    """Check what the chunks say that they unpack to. Errors: TraceError."""
    left, at = most_unpacked(size), len(MAGIC)
    while at + _RECORD.size <= size:
        stream.seek(at)
        code, length = _RECORD.unpack(stream.read(_RECORD.size))
        at += _RECORD.size + length
        if code == _CHUNK:
            head = stream.read(_CHUNK_HEAD)
            end, stated = 32 + int.from_bytes(head[28:32], "little"), int.from_bytes(head[16:24], "little")
            if head[32:end] == b"zstd":
                zstandard = import_extra("zstandard", "zstandard", EXTRA)
                with suppress(zstandard.ZstdError):  # damaged, as its reader will say
                    stated = max(stated, int(zstandard.frame_content_size(head[end + 8 :])))
            left -= stated
        if left < 0:
            what = f"its chunks are more than {most_unpacked(size)} bytes, unpacked: expected a shorter recording"
            raise TraceError(f"{path}: {what}")
    stream.seek(0)


# Of the MCAP format: opcode and length of a record; a chunk, whose head has two instants, the size
# unpacked, a checksum, a word, and the size packed; the data begin with a frame's own head.
_RECORD, _CHUNK, _CHUNK_HEAD = struct.Struct("<BQ"), 6, 32 + 8 + 8 + 18


def _by_name(value: Any) -> Any:
    if isinstance(value, dict):
        return SimpleNamespace(**{key: _by_name(one) for key, one in value.items()})
    return [_by_name(one) for one in value] if isinstance(value, list) else value


_BAGS_EXTRA = "bags"
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
        highlevel = import_extra("rosbags.highlevel", "rosbags", _BAGS_EXTRA)
        types = import_extra("rosbags.typesys", "rosbags", _BAGS_EXTRA)
        _check_plain(path)
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


class _Bounded:
    """A packed file, open for reading. Errors: ValueError beyond most_unpacked."""

    def __init__(self, file: BinaryIO, unpacking: BinaryIO) -> None:
        self._unpacking, self._left = unpacking, most_unpacked(os.fstat(file.fileno()).st_size)

    def read(self, size: int) -> bytes:
        data = self._unpacking.read(size)
        if (left := self._left - len(data)) < 0:
            raise ValueError("too many bytes when it is unpacked")
        self._left = left
        return data

    def __enter__(self) -> _Bounded:
        return self

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


def _check_plain(path: Path) -> None:
    """Refuse what rosbags would wait for: SQLite opens a .db3 by its name."""
    if path.is_dir():
        opened(path / _METADATA, TABLE).close()
    for file in path.iterdir() if path.is_dir() else (path,):
        if file.suffix in ENDINGS or file == path:
            opened(file, BAG).close()


def stamp_ns(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def table_of_bag(path: Path) -> Made:
    """Return the poses of a bag. Errors: as of Bag."""
    bag = Bag(path)
    held = {topic: name for topic, name in bag.topics.items() if name not in _WITH_POSES}
    poses = (
        (topic, logged_ns, pose)
        for topic, logged_ns, message in bag.messages(bag.topics.keys() - held.keys())
        for pose in poses_in(bag.topics[topic], message)
    )
    return _table(path, "rosbag", poses, held, [])
