"""Video codecs by name, one file each: which encoder and decoder of FFmpeg, and the low-delay settings."""

from __future__ import annotations

from ....registry import Registry
from ._base import Codec, require

codecs: Registry[Codec] = Registry("codec", __name__)


def check_codec(name: str) -> Codec:
    """The codec, once it is known to run here. Errors: InputError for a name that is none, MachineError if this PyAV lacks it."""
    codec = codecs.get(name)
    codec.check()
    return codec


__all__ = ["codecs", "Codec", "check_codec", "require"]
