"""No coding at all."""

from . import CODECS, Codec

CODECS.register(Codec("none", "frames arrive as they were drawn; nothing is encoded"))
