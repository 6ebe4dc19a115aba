"""Coding of frames for the network: colour by a video codec, depth by a code of its own."""

from .codecs import Codec, check_codec, codecs
from .coder import Decoder, Encoder, Packet, Picture
from .coding import Coding
from .depth import STEP, DepthDecoder, DepthEncoder
from .errors import Undecodable
from .layers import packed_bytes

__all__ = [
    "STEP",
    "Codec",
    "Coding",
    "Decoder",
    "DepthDecoder",
    "DepthEncoder",
    "Encoder",
    "Packet",
    "Picture",
    "Undecodable",
    "check_codec",
    "codecs",
    "packed_bytes",
]
