"""Which codec a run uses, and how well."""

from __future__ import annotations

import attrs


@attrs.frozen
class Coding:
    """codec: a name of CODECS. crf: constant quality; or bitrate_mbit: Mbit/s of one eye's colour; neither: the codec's own quality."""

    codec: str = "none"
    crf: int | None = None
    bitrate_mbit: float | None = None
