"""No coding at all."""

from . import Codec, codecs

codecs.register(Codec("none", "frames arrive as they were drawn; nothing is encoded"))
