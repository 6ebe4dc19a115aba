"""What frames weigh on the network, and what is left of them: colour through a video codec, depth through a code of its own."""

from .codecs import Codec, check_codec, codecs
from .coder import Decoder, Encoder, Packet, Picture
from .coding import Coding
from .depth import STEP, DepthDecoder, DepthEncoder
from .errors import Undecodable
from .layers import packed_bytes

__all__ = [
    "codecs", "STEP", "Codec", "Coding", "Decoder", "DepthDecoder", "DepthEncoder", "Encoder", "Packet", "Picture", "Undecodable",
    "check_codec", "packed_bytes",
]  # fmt: skip
