"""Which codec a run uses, and how well."""

from __future__ import annotations

import attrs

from ..errors import InputError


@attrs.frozen
class Coding:
    """codec: a name of CODECS. crf: constant quality; or bitrate_mbit: Mbit/s of one eye's colour; neither: the codec's own quality.

    Errors: InputError for a quality or a rate without a codec.
    """

    codec: str = "none"
    crf: int | None = None
    bitrate_mbit: float | None = None

    def __attrs_post_init__(self) -> None:
        if self.codec == "none" and (self.crf, self.bitrate_mbit) != (None, None):
            told = f"crf {self.crf}" if self.crf is not None else f"bitrate {self.bitrate_mbit:g} Mbit/s"
            raise InputError(f"{told} without a codec: nothing is encoded; choose one with --codec, or leave it out")
