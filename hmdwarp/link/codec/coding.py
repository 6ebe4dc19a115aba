"""Codec and quality of a run: without NumPy, for --help."""

from __future__ import annotations

import attrs

from ...base import Declared, InputError, names_in, one_of, option

# m/s. Heads that walk: of 1000 instants of the recording `walk`, one is faster than 0.94.
_HEAD_M_S = 1.0
# Pixels by which parallax may be wrong, either way.
PARALLAX_PIXELS = 1 / 16
# 1/m. Coarser steps than the first would part planes that the warps join (0.03 of inverse depth and
# 0.02 per metre together); finer ones than the second would not reach 0.25 m in 16 bits.
COARSEST, FINEST = 2.0**-7, 2.0**-14


def depth_step(pixels_per_tangent: float, age_s: float) -> float:
    """Return the step of inverse depth, 1/m, at which rounding moves no pixel by more than 1/16.

    A wrong inverse depth moves a warped pixel by pixels per tangent * that error * the eye's way
    across the line of sight, the same for every pixel of the picture. The way is what a walking
    head covers while a frame ages; rounding is wrong by half a step. Within COARSEST and FINEST.
    """
    way_px = pixels_per_tangent * _HEAD_M_S * age_s
    return min(COARSEST, max(FINEST, 2 * PARALLAX_PIXELS / way_px if way_px > 0 else COARSEST))


# Codes of depth: without loss at fixed steps, at steps of a sixteenth of a pixel, or as video of 10
# or of 8 bits.
EXACT, _SIXTEENTH, AS_VIDEO, AS_VIDEO8 = DEPTH_CODES = ("exact", "sixteenth", "video", "video8")


# For browsers, the best first: by bytes at an equal quality, see docs/results-link.md.
VIDEOS = ("av1", "hevc", "vp9", "h264")


@attrs.frozen
class Coding(Declared):
    """Codec and quality. With neither crf nor bitrate_mbit, the codec's own quality.

    Errors: InputError for a quality, a rate or a code of depth without a codec, for quality and
    rate together, or for one out of bounds.
    """

    heading = "Coding"
    # A name of codecs.
    codec: str = option("none", f"Codec that encodes and decodes frames on the way: {names_in('link/codec/codecs')}.")
    crf: int | None = option(None, "The codec's quality, 0 (best) to 51; by default the codec's own.")
    bitrate_mbit: float | None = option(
        None, "Bit rate of one eye's videos together, in place of a quality.", name="bitrate", unit="Mbit/s"
    )

    depth: str = option(
        AS_VIDEO,
        "How depth is coded: video (lightest; slow to encode), video8 (of 8 bits, as headsets and browsers decode), "
        "sixteenth (no pixel moves by more than 1/16 for a walking head), exact (within 2^-11 per metre).",
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
        if self.crf is not None and self.bitrate_mbit is not None:
            found = f"--crf {self.crf} beside --bitrate {self.bitrate_mbit:g} Mbit/s"
            raise InputError(f"{found}: expected a quality or a rate, not both")
        if self.crf is not None and not 0 <= self.crf <= 51:
            raise InputError(f"--crf {self.crf}: expected 0 (best) to 51")
        if self.bitrate_mbit is not None and not 0.01 <= self.bitrate_mbit <= 1000:
            raise InputError(f"--bitrate {self.bitrate_mbit:g} Mbit/s: expected 0.01 to 1000 for one eye")
