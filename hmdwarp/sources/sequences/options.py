"""Options of recorded frames: facts that the user states in place of what the files say."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import attrs

from ...base import DISPLAY, Declared, InputError, Number, names_in, one_of, option, option_of
from .. import sequences

HOLE, FAR = "hole", "far"  # what a pixel without depth is
MASK = "hidden.png"
# Names of the layouts, each with the module of sources/sequences/readers that declares it.
LAYOUTS = {
    **dict.fromkeys(("icl_nuim", "numbered", "redwood", "replica", "rtabmap", "stray_scanner"), "layouts"),
    **dict.fromkeys(("tartanair", "traced", "tum", "colmap", "folder", "nerfstudio", "open3d"), "layouts"),
    **{"scannet": "layouts", "seven_scenes": "layouts", "rosbag": "rosbag"},
}
RATE_HZ = 30.0  # of files without a clock, as nearly all depth cameras have it


HEADING = "Recorded frames"  # of these options in help
_fact = partial(option, study=DISPLAY)


def repair_field() -> Any:
    return _fact(
        "none",
        f"Mend missing and wrong depth before the warp: {names_in('sources/repairs')}, or several with +.",
        heading=HEADING,
    )


@attrs.frozen
class SequenceOptions(Declared):
    """Overrides for reading recorded frames; None leaves it to the files. Errors: InputError."""

    heading = HEADING
    layout: str | None = _fact(
        None, f"Layout of the recorded frames: {', '.join(sorted(LAYOUTS))}; by default it is detected."
    )
    intrinsics: sequences.Camera | None = _fact(
        None,
        "Intrinsics of the recorded frames, FX,FY,CX,CY in pixels; a negative FY where the camera's y points up.",
        metavar="FX,FY,CX,CY",
        parse=lambda text: sequences.parse_intrinsics(text=text),
    )
    projection: sequences.Camera | None = _fact(
        None,
        "In place of --intrinsics, the 4x4 projection matrix of Unity, WebXR, OpenGL or OpenVR: 16 numbers, by rows or "
        "columns.",
        metavar="M00,M01,..",
        parse=lambda text: sequences.parse_projection(text=text),
    )
    depth_scale: float | None = _fact(
        None,
        "Metres per unit of the recorded depth: 0.001 for millimetres, 0.0002 for TUM RGB-D.",
        valid=Number(most=1.0, above=True),
    )
    no_depth: str = _fact(
        HOLE,
        "What a pixel without depth is: a hole, or infinitely far, as sky of a renderer is.",
        valid=one_of(HOLE, FAR),
    )
    frames_rate_hz: float | None = _fact(
        None,
        f"Recorded frames per second, where the files have no clock; by default {RATE_HZ:g}.",
        name="frames_rate",
        valid=Number(least=1e-3, most=1e4),
    )
    frames_axes: str | None = _fact(
        None, "Axes of the poses of recorded frames: a preset (hmdwarp list axes), or world=right,up,forward head=.."
    )
    frames_camera: str | None = _fact(
        None,
        "Of several cameras of recorded frames, the one to read: its number in COLMAP, else part of its files' names.",
        metavar="NAME",
    )
    frames_topics: str | None = _fact(
        None,
        "Topics of a bag of recorded frames, where it holds several: colour=TOPIC,depth=TOPIC,info=TOPIC,pose=TOPIC.",
    )
    crop: int = _fact(
        0,
        "Leave out this many of the outermost pixels of recorded frames, where they hold no picture.",
        kind=int,
        unit="px",
        valid=Number(),
    )

    hidden: Path | None = _fact(
        None, f"Picture of what a lens hides of recorded frames: black there; by default {MASK} beside them."
    )

    def __attrs_post_init__(self) -> None:
        if self.intrinsics is not None and self.projection is not None:
            raise InputError("--intrinsics and --projection both state the camera: say one")

    @property
    def camera(self) -> sequences.Camera | None:
        return self.intrinsics or self.projection

    def refuse_unused(self) -> None:
        """Raise InputError for the first that is stated, where there are no recorded frames."""
        for field in attrs.fields(type(self)):
            if getattr(self, field.name) != field.default:
                flag = option_of(field).flag
                raise InputError(f"{flag}: it states how recorded frames are read; it is for --frames")
