"""hmdwarp warp: somebody's own RGB-D frame, to another pose."""

from __future__ import annotations

from pathlib import Path

import typer

from ..options import FORCE, Option, names_in
from ._options import Said, takes

# What reads more than a picture with depth: left out of the help, which does not load the others.
NEEDS_A_SERVER = ("backward", "environment", "layered", "multi", "model", "relight", "wide")
_DECLARED = (
    Option(
        "FRAME.npz: colour, depth_m, fov, position_m, orientation_xyzw; depth_scale for integer depth.",
        Path,
        required=True,
        name="frame",
        metavar="FRAME",
        positional=True,
    ),
    Option("POSE.json: fov, position_m, orientation_xyzw.", Path, required=True, name="to"),
    Option("OUT.npz: colour, coverage, time_ms; or OUT.png, sRGB, holes transparent.", Path, required=True, name="out"),
    Option(f"{names_in('client/warps', without=NEEDS_A_SERVER)}.", default="forward", name="warp"),
    Option(f"{names_in('client/fills', without=NEEDS_A_SERVER)}, or several with +.", default="none", name="fill"),
    Option("Pixels of the result; by default the frame's.", name="size", metavar="WxH"),
    Option("Metres per unit of depth: 0.001 for millimetres, 1 for metres.", float, name="depth_scale"),
    FORCE,
)


@takes(*_DECLARED)
def warp(said: Said) -> None:
    """Warp an RGB-D frame to the pose it should be seen from."""
    from ..image import read_frame, read_view
    from ..image.warping import warp_image
    from ..pipeline.options import parse_size
    from ..report import refuse_existing, write_image_result

    out, size = said["out"], said["size"]
    refuse_existing(out, force=said["force"])
    frame = read_frame(said["frame"])
    result = warp_image(
        frame.colour,
        frame.depth_m,
        frame.view,
        read_view(said["to"]),
        said["warp"],
        said["fill"],
        None if size is None else parse_size(size),
        depth_scale=frame.depth_scale if said["depth_scale"] is None else said["depth_scale"],
    )
    write_image_result(out, result.colour, result.coverage, result.time_ms)
    stages = ", ".join(f"{name} {ms:.2f} ms" for name, ms in result.time_ms.items())
    typer.echo(f"{out}: {stages}; {100 * result.hole_share:.2f} % holes before the fill")
