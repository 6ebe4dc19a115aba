"""Video codecs, one file each: encoder and decoder of FFmpeg, and low-delay settings."""

from __future__ import annotations

from ....registry import Registry
from ._base import Codec, require

codecs: Registry[Codec] = Registry("codec", __name__)


def check_codec(name: str) -> Codec:
    """Return the codec if it runs here.

    Errors: InputError for an unknown name, MachineError if this PyAV lacks it.
    """
    codec = codecs.get(name)
    codec.check()
    return codec


__all__ = ["codecs", "Codec", "check_codec", "require"]
