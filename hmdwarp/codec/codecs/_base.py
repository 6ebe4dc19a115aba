"""What a codec is to this program."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from ...errors import MachineError


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
        if self.is_none:
            return
        import av

        for name, mode, what in ((self.encoder, "w", "encoder"), (self.decoder, "r", "decoder")):
            try:
                av.Codec(name, mode)
            except (ValueError, av.FFmpegError) as error:
                raise MachineError(
                    f"PyAV {av.__version__} was built without the {what} '{name}', which codec '{self.name}' needs: "
                    "install PyAV from its wheel (pip install av), or use codec 'none'"
                ) from error
