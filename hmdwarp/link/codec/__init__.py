"""Frames as bytes on the network: colour through a video codec, depth through a code of its own.

The coders are imported when they are first used: an option's declaration must load nothing heavy.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .codecs import Codec, check_codec, codecs
from .coding import Coding
from .errors import Undecodable

if TYPE_CHECKING:
    from .coder import Decoder, Encoder, Packet, Picture
    from .depth import STEP, DepthDecoder, DepthEncoder
    from .layers import packed_bytes

_HOME = {
    "Decoder": "coder",
    "DepthDecoder": "depth",
    "DepthEncoder": "depth",
    "Encoder": "coder",
    "Packet": "coder",
    "Picture": "coder",
    "STEP": "depth",
    "packed_bytes": "layers",
}

__all__ = [
    "codecs", "STEP", "Codec", "Coding", "Decoder", "DepthDecoder", "DepthEncoder", "Encoder", "Packet", "Picture", "Undecodable",
    "check_codec", "packed_bytes",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    return value
