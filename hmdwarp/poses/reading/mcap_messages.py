"""Messages of MCAP files as the rows of a table, to be read like any other trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any

from ...errors import HmdwarpError, TraceError
from ...options.documents import parse_json
from ...resources import import_extra
from ..stated import Defect
from .made import Made
from .pose_messages import PoseMessages, StampedPose, has_poses, poses_in

MAGIC = b"\x89MCAP0\r\n"
EXTRA = "mcap"
METADATA = "hmdwarp"  # name of the record that states the axes and the origin


def table_of_mcap(path: Path, stream: IO[bytes], size: int) -> Made:
    """Return every pose of the messages that hold one, in the order they were logged.

    Errors: TraceError without any, or for damaged data; MachineError where `mcap` is missing.
    """
    return _Reading(path, stream, size).table()


class _Reading(PoseMessages):
    kind = "mcap"
    file = "an MCAP file"
    wanted = "as JSON, protobuf or ROS 2's CDR"

    def __init__(self, path: Path, stream: IO[bytes], size: int) -> None:
        super().__init__(path)
        self.stream = stream
        self._mcap = import_extra("mcap.reader", "mcap", EXTRA)
        self._how = {"validate_crcs": True, "record_size_limit": size}
        modules = (("mcap_ros2.decoder", "mcap-ros2-support"), ("mcap_protobuf.decoder", "mcap-protobuf-support"))
        self._factories = [import_extra(*name, EXTRA).DecoderFactory() for name in modules]
        self._decoders: dict[int, Callable[[bytes], Any] | None] = {}

    def poses(self) -> Iterator[tuple[str, int, StampedPose]]:
        count = 0
        reader, whole = self._reader()
        try:
            for schema, channel, message in reader.iter_messages(self._topics(whole), log_time_order=whole is not None):
                name = "" if schema is None else schema.name.replace("/msg/", "/")
                decode = self._decoder(name, schema, channel)
                if decode is not None:
                    for pose in poses_in(name, decode(message.data)):
                        count += 1
                        yield channel.topic, message.log_time, pose
        except HmdwarpError:
            raise
        except Exception as error:  # decoders and decompressors raise anything at damaged data
            why = f"{type(error).__name__}: {error}"
            if whole is not None or not count:
                raise TraceError(f"{self.path}: its MCAP data are damaged ({why}): copy or record it again") from None
            what = f"the file ends in the middle, after {count} poses ({why})"
            self.defects.append(Defect("file-cut", what, "read up to there"))

    def _reader(self) -> tuple[Any, Any]:
        """Return a reader, and the index of a file that was closed as it should be, else None."""
        try:
            reader = self._mcap.SeekingReader(self.stream, **self._how)
            index = reader.get_summary()
            if index is not None:
                self._state(reader)
                return reader, index
        except Exception:  # as above: a file that was cut off has no index where it should be
            pass
        self.stream.seek(0)
        return self._mcap.NonSeekingReader(self.stream, **self._how), None

    def _state(self, reader: Any) -> None:
        stated: dict[str, str] = next((m.metadata for m in reader.iter_metadata() if m.name == METADATA), {})
        self.comments = [f"# {key}: {' '.join(value.split())}" for key, value in stated.items()]

    def _topics(self, index: Any) -> list[str] | None:
        """Return the topics with poses; None for all. Only their parts of the file are read."""
        if index is None:
            return None
        topics = []
        for channel in index.channels.values():
            schema = index.schemas.get(channel.schema_id)
            if self._decoder("" if schema is None else schema.name.replace("/msg/", "/"), schema, channel) is not None:
                topics.append(channel.topic)
        return topics

    def _decoder(self, name: str, schema: Any, channel: Any) -> Callable[[bytes], Any] | None:
        if channel.id not in self._decoders:
            found = self._decoder_of(schema, channel.message_encoding) if has_poses(name) else None
            if found is None:
                self.held[channel.topic] = f"{name or 'no schema'}, {channel.message_encoding}"
            self._decoders[channel.id] = found
        return self._decoders[channel.id]

    def _decoder_of(self, schema: Any, encoding: str) -> Callable[[bytes], Any] | None:
        if encoding == "json":
            return lambda data: _by_name(parse_json(data))
        return next(filter(None, (f.decoder_for(encoding, schema) for f in self._factories)), None)


def _by_name(value: Any) -> Any:
    """Return JSON with attributes in place of keys."""
    if isinstance(value, dict):
        return SimpleNamespace(**{key: _by_name(one) for key, one in value.items()})
    return [_by_name(one) for one in value] if isinstance(value, list) else value
