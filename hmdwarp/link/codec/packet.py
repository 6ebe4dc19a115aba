"""What one picture is on the network."""

from __future__ import annotations

import attrs


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
