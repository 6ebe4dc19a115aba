"""hmdwarp warp: somebody's own RGB-D frame, to another pose."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..options import names_in


def warp(
    frame: Annotated[Path, typer.Argument(help="FRAME.npz: colour, depth_m, fov, position_m, orientation_xyzw.")],
    to: Annotated[Path, typer.Option("--to", help="POSE.json: fov, position_m, orientation_xyzw.")],
    out: Annotated[
        Path, typer.Option("--out", help="OUT.npz: colour, coverage, time_ms; or OUT.png, sRGB, holes transparent.")
    ],
    warp: Annotated[str, typer.Option("--warp", help=f"{names_in('client/warps')}.")] = "forward",
    fill: Annotated[str, typer.Option("--fill", help=f"{names_in('client/fills')}.")] = "none",
    size: Annotated[
        str | None, typer.Option(help="WxH pixels of the result; by default the frame's.", show_default=False)
    ] = None,
) -> None:
    """Warp an RGB-D frame to the pose it should be seen from."""
    from ..image.files import read_frame, read_view
    from ..image.warping import warp_image
    from ..pipeline.options import parse_size
    from ..report import write_image_result

    colour, depth_m, rendered = read_frame(frame)
    result = warp_image(
        colour, depth_m, rendered, read_view(to), warp, fill, None if size is None else parse_size(size)
    )
    write_image_result(out, result.colour, result.coverage, result.time_ms)
    stages = ", ".join(f"{name} {ms:.2f} ms" for name, ms in result.time_ms.items())
    typer.echo(f"{out}: {stages}; {100 * result.hole_share:.2f} % holes before the fill")
