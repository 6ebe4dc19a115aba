"""What a codec is to this program."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from ....errors import MachineError


@attrs.frozen
class Codec:
    """encoder, decoder: FFmpeg's names of them, "" for a codec that does nothing. crf: the constant-quality setting if none is asked for.
    options: of the encoder, besides quality. threads: a fixed number, because the slices, and so the bytes, depend on it.
    """

    name: str
    summary: str
    encoder: str = ""
    decoder: str = ""
    crf: int = 0
    threads: int = 1
    options: Mapping[str, str] = attrs.field(factory=dict)

    @property
    def is_none(self) -> bool:
        """Whether nothing is run: frames arrive as they were drawn."""
        return not self.encoder

    def check(self) -> None:
        """Errors: MachineError if this PyAV was built without the encoder or the decoder."""
        if not self.is_none:
            require(f"codec '{self.name}'", self.encoder, "w")
            require(f"codec '{self.name}'", self.decoder, "r")


def require(what: str, name: str, mode: str) -> None:
    """mode: "w" for FFmpeg's encoder `name`, "r" for the decoder, which `what` needs. Errors: MachineError if this PyAV has none."""
    import av

    try:
        av.Codec(name, mode)
    except (ValueError, av.FFmpegError) as error:
        raise MachineError(
            f"PyAV {av.__version__} was built without the {'encoder' if mode == 'w' else 'decoder'} '{name}', which {what} needs: "
            "install PyAV from its wheel (pip install av), or use codec 'none'"
        ) from error
