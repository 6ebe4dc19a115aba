"""Video codecs, one table each: encoder and decoder of FFmpeg, and low-delay settings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import attrs

from ....base import MachineError, Registry, pyav

LARGE = 1 << 20


@attrs.frozen
class Codec:
    """A video codec."""

    name: str
    summary: str
    # FFmpeg's names, "" for a codec that does nothing.
    encoder: str = ""
    decoder: str = ""
    crf: int = 0  # the default constant-quality setting
    best: int = 0  # the best one that it takes
    threads: int = 1  # fixed, because the slices, and so the bytes, depend on it
    options: Mapping[str, str] = attrs.field(factory=dict)  # of the encoder, besides quality
    rates: tuple[str, ...] = ("b", "maxrate")  # options that a bit rate sets
    # What is otherwise for pictures of more than LARGE pixels.
    large: Mapping[str, str] = attrs.field(factory=dict)

    @property
    def is_none(self) -> bool:
        """Whether nothing is coded: frames arrive as they were drawn."""
        return not self.encoder

    def check(self) -> None:
        """Check that it runs here. Errors: MachineError if PyAV lacks its encoder or decoder."""
        if not self.is_none:
            require(f"codec '{self.name}'", self.encoder, "w")
            require(f"codec '{self.name}'", self.decoder, "r")


def require(what: str, name: str, mode: Literal["r", "w"]) -> None:
    """Check for FFmpeg's encoder ("w") or decoder ("r") `name`, which `what` needs.

    Errors: MachineError if this PyAV lacks it.
    """
    av = pyav()
    try:
        av.Codec(name, mode)
    except (ValueError, av.FFmpegError) as error:
        raise MachineError(
            f"PyAV {av.__version__} was built without the {'encoder' if mode == 'w' else 'decoder'} "
            f"'{name}', which {what} needs: "
            "install PyAV from its wheel (pip install av), or use codec 'none'"
        ) from error


codecs: Registry[Codec] = Registry(
    "codec", __name__, of_table=lambda name, table: Codec(name, **table), columns="encoder"
)

__all__ = ["codecs", "Codec", "require"]
