"""Options of `hmdwarp check`."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..errors import InputError
from ..options import Declared, force_field, group, option, out_field
from ..sources.sequences.options import SequenceOptions


@attrs.frozen
class CheckOptions(Declared):
    """Frames, and what to write."""

    frames: tuple[Path, ...] = option(
        attrs.NOTHING,
        "A folder of recorded frames, two of the left and the right eye, or two or more files of one frame.",
        kind=list,
        metavar="FRAMES",
        positional=True,
        names_files=True,
        parse=lambda texts: tuple(map(Path, texts)),
    )
    reading: SequenceOptions = group(SequenceOptions)
    out: Path | None = out_field(None, "OUT.png: two frames moved onto each other, as stated and as found.")
    force: bool = force_field()

    def __attrs_post_init__(self) -> None:
        if self.out is not None and self.out.suffix != ".png":
            raise InputError(f"--out {self.out}: expected a name that ends in .png")
