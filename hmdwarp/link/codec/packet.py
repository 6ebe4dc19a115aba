"""What one picture is on the network."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import attrs

from .undecodable import Undecodable

_CHECKED_FROM = 4  # what comes before is the checksum


@attrs.frozen
class Packet:
    """One picture on the network."""

    # 0 for the first of its stream.
    number: int
    # Whether it can be decoded without those before it.
    key: bool
    data: bytes = attrs.field(repr=lambda data: f"<{len(data)} bytes>")

    @property
    def size_bytes(self) -> int:
        """The size of all of it."""
        return len(self.data)


def two_parts(header: struct.Struct, fields: tuple[Any, ...], first: bytes, second: bytes) -> bytes:
    """Return data of two parts after a header.

    header: CRC-32 of everything after it (a video decoder conceals what is damaged), the fields,
    and the bytes of the first part.
    """
    data = header.pack(0, *fields, len(first))[_CHECKED_FROM:] + first + second
    return zlib.crc32(data).to_bytes(_CHECKED_FROM, "little") + data


def from_two_parts(header: struct.Struct, data: bytes, what: str) -> tuple[list[Any], bytes, bytes]:
    """Return fields and parts of what `two_parts` made. Errors: Undecodable, naming what it is."""
    try:
        checksum, *fields, length = header.unpack_from(data)
    except struct.error as error:
        raise Undecodable(f"damaged {what} ({error})") from error
    if zlib.crc32(data[_CHECKED_FROM:]) != checksum:
        raise Undecodable(f"damaged {what} (its checksum is wrong)")
    start = header.size + length
    return fields, data[header.size : start], data[start:]
