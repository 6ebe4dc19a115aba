"""Codec and quality of a run."""

from __future__ import annotations

import attrs

from ...errors import InputError
from ...options import Declared, names_in, one_of, option

_CRFS = (0, 51)
# Codes of depth: without loss at fixed steps, at steps of a sixteenth of a pixel, or as video.
EXACT, SIXTEENTH, AS_VIDEO = DEPTH_CODES = ("exact", "sixteenth", "video")


@attrs.frozen
class Coding(Declared):
    """Codec and quality. With neither crf nor bitrate_mbit, the codec's own quality.

    Errors: InputError for a quality, a rate or a code of depth without a codec, for quality and
    rate together, or for one out of bounds.
    """

    heading = "Coding"
    # A name of codecs.
    codec: str = option("none", f"Codec that encodes and decodes frames on the way: {names_in('link/codec/codecs')}.")
    crf: int | None = option(None, "The codec's quality, 0 (best) to 51; by default the codec's own.", kind=int)
    bitrate_mbit: float | None = option(
        None, "Bit rate of one eye's videos together, in place of a quality.", kind=float, name="bitrate", unit="Mbit/s"
    )

    depth: str = option(
        AS_VIDEO,
        "How depth is coded: video (lightest; slow to encode), sixteenth (no pixel moves by more than 1/16 for a "
        "walking head), exact (within 2^-11 per metre).",
        name="depth_code",
        valid=one_of(*DEPTH_CODES),
        limits=", ".join(DEPTH_CODES),
    )

    def __attrs_post_init__(self) -> None:
        if self.codec == "none" and (self.crf, self.bitrate_mbit) != (None, None):
            found = f"--crf {self.crf}" if self.crf is not None else f"--bitrate {self.bitrate_mbit:g} Mbit/s"
            raise InputError(f"{found} without a codec: nothing is encoded; choose one with --codec, or leave it out")
        if self.codec == "none" and self.depth != AS_VIDEO:
            raise InputError(
                f"--depth-code {self.depth} without a codec: nothing is encoded; choose one with --codec, or leave "
                "it out"
            )
        check_quality(self.crf, self.bitrate_mbit)


def check_quality(crf: int | None, bitrate_mbit: float | None) -> None:
    """Check the numbers. Errors: InputError for both together, or one out of bounds."""
    if crf is not None and bitrate_mbit is not None:
        raise InputError(
            f"--crf {crf} beside --bitrate {bitrate_mbit:g} Mbit/s: expected a quality or a rate, not both"
        )
    if crf is not None and not _CRFS[0] <= crf <= _CRFS[1]:
        raise InputError(f"--crf {crf}: expected {_CRFS[0]} (best) to {_CRFS[1]}")
    if bitrate_mbit is not None and not 0.01 <= bitrate_mbit <= 1000:
        raise InputError(f"--bitrate {bitrate_mbit:g} Mbit/s: expected 0.01 to 1000 for one eye")
