"""Options of `hmdwarp check`."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..base import Declared, InputError, Number, force_field, group, option, out_field
from ..sources.sequences.options import SequenceOptions


@attrs.frozen
class CheckOptions(Declared):
    """Frames, and what to write."""

    frames: tuple[Path, ...] = option(
        attrs.NOTHING,
        "A folder of recorded frames, or two: of the left and the right eye.",
        kind=list,
        metavar="FRAMES",
        positional=True,
        names_files=True,
        parse=lambda texts: tuple(map(Path, texts)),
    )
    motion: bool = option(
        False, "Check the motion vectors of FRAMES, a folder with motion.json: unit, y axis, direction, jitter."
    )
    reading: SequenceOptions = group(SequenceOptions)

    def __attrs_post_init__(self) -> None:
        if self.motion and len(self.frames) != 1:
            raise InputError(f"--motion: {len(self.frames)} names: expected one folder with motion.json")


@attrs.frozen
class SynthesisOptions(Declared):
    """Frames with motion vectors, and which frame to make of each."""

    frames: Path = option(
        attrs.NOTHING, "A folder with motion.json, as docs/motion.md has it.", positional=True, names_files=True
    )
    out: Path = out_field(attrs.NOTHING, "Folder for a PNG of each frame, and synthesis.json.")
    at: float = option(
        1.0,
        "Where, in intervals after each frame: 1 the next frame, 0.5 half way to it, -0.5 half way back.",
        valid=Number(least=-1, most=2),
    )
    force: bool = force_field()
