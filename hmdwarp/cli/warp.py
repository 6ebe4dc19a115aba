"""hmdwarp warp: somebody's own RGB-D frame, to another pose."""

from __future__ import annotations

from pathlib import Path

import attrs
import typer

from ..options import Declared, names_in, option, same_as
from ..pipeline.options import PipelineOptions
from ._options import Said, takes

_PIPELINE = attrs.fields(PipelineOptions)


@attrs.frozen
class WarpOptions(Declared):
    """A frame, and how to warp it."""

    frame: Path = option(
        attrs.NOTHING, "FRAME.npz: colour, depth_m, fov, position_m, orientation_xyzw.", kind=Path, positional=True
    )
    to: Path = option(attrs.NOTHING, "POSE.json: fov, position_m, orientation_xyzw.", kind=Path)
    out: Path = option(
        attrs.NOTHING, "OUT.npz: colour, coverage, time_ms; or OUT.png, sRGB, holes transparent.", kind=Path
    )
    warp: str = same_as(_PIPELINE.warp, help=f"{names_in('client/warps')}.")
    fill: str = same_as(_PIPELINE.fill, "none", help=f"{names_in('client/fills')}.")
    size: tuple[int, int] | None = same_as(_PIPELINE.size, help="Pixels of the result; by default the frame's.")


@takes(WarpOptions)
def warp(said: Said) -> None:
    """Warp an RGB-D frame to the pose it should be seen from."""
    from ..image.frame_files import read_frame, read_view
    from ..image.warping import warp_image
    from ..report import write_image_result

    options = WarpOptions.of(said)
    colour, depth_m, rendered = read_frame(options.frame)
    result = warp_image(colour, depth_m, rendered, read_view(options.to), options.warp, options.fill, options.size)
    write_image_result(options.out, result.colour, result.coverage, result.time_ms)
    stages = ", ".join(f"{name} {ms:.2f} ms" for name, ms in result.time_ms.items())
    typer.echo(f"{options.out}: {stages}; {100 * result.hole_share:.2f} % holes before the fill")
