"""hmdwarp warp: your own RGB-D frame, to another pose."""

from __future__ import annotations

import warnings
from pathlib import Path

import attrs
import typer

from .. import geometry, report
from ..base import Declared, force_field, names_in, option, out_field, same_as
from ..pipeline.options import SINGLE_FILL, PipelineOptions
from ..sources import sequences
from ..sources.sequences.options import FAR, SequenceOptions, repair_field
from ._options import JSON, Said, as_json, takes

# What reads more than a picture with depth: left out of the help, which does not load the others,
# with all that comes with a layer of its own.
NEEDS_A_SERVER = (
    *("backward", "composite", "difference", "environment", "layered", "model", "multi", "relight", "wide"),
)
_PIPELINE = attrs.fields(PipelineOptions)


@attrs.frozen
class _WarpOptions(Declared):
    """A frame, and how to warp it."""

    frame: Path = option(
        attrs.NOTHING,
        "FRAME.npz: colour, depth_m, fov, position_m, orientation_xyzw; depth_scale for integer depth, "
        "encoding for float colour. Or the colour alone: a PNG, a JPEG, or an EXR file, which may have its own Z.",
        positional=True,
        names_files=True,
    )
    to: Path = option(attrs.NOTHING, "POSE.json: fov or intrinsics, position_m, orientation_xyzw.")
    out: Path = out_field(
        attrs.NOTHING,
        "OUT.png (sRGB, holes transparent), OUT.jpg, OUT.exr (light, coverage, depth) or OUT.npz (the same, and the "
        "view).",
    )
    force: bool = force_field()
    warp: str = same_as(_PIPELINE.warp, help=f"{names_in('client/warps', without=NEEDS_A_SERVER, added=False)}.")
    fill: str = same_as(
        _PIPELINE.fill, SINGLE_FILL, help=f"{names_in('client/fills', without=NEEDS_A_SERVER)}, or several with +."
    )
    repair: str = repair_field()
    no_depth: str = same_as(attrs.fields(SequenceOptions).no_depth)
    size: tuple[int, int] | None = same_as(_PIPELINE.size, help="Pixels of the result; by default the frame's.")
    depth: Path | None = option(
        None, "Depth of a picture: 16-bit PNG, EXR, PGM or NPY; by default NAME.depth.png beside it."
    )
    camera: Path | None = option(
        None,
        "View of a picture, a JSON: fov or intrinsics (fx, fy, cx, cy), position_m, orientation_xyzw, maybe "
        "depth_scale; by default NAME.json beside it.",
    )
    depth_scale: float | None = option(
        None, "Metres per unit of depth: 0.001 for millimetres, 1 for metres; by default the frame's."
    )
    encoding: str | None = option(
        None, "Of float colour: linear, or srgb (0 to 1); by default the frame's, or else linear."
    )


@takes(_WarpOptions, JSON)
def warp(said: Said) -> None:
    """Warp an RGB-D frame to the pose it should be seen from."""
    import numpy as np

    from ..frames.layers import PICTURE
    from ..image.image_files import has_depth, write_image
    from ..image.picture_arrays import about_holes
    from ..image.usable import plan_of
    from ..image.warper import warp_image
    from ..sources.repairs import parse_repairs
    from ..sources.sequences import read_frame, read_view
    from ..sources.sequences.frame_files import scale_of
    from ..sources.sequences.recorded import in_metres

    options = _WarpOptions.of(said)
    for source in filter(None, (options.frame, options.depth, options.camera, options.to)):
        report.refuse_source(options.out, source)
    report.refuse_existing(options.out, force=options.force)
    depth = has_depth(options.out)
    plan_of(options.warp, options.fill, available=PICTURE, depth=depth)
    parse_repairs(options.repair)
    frame = read_frame(options.frame, options.depth, options.camera)
    shown = read_view(options.to, options.size or frame.size)
    scale = frame.depth_scale if options.depth_scale is None else options.depth_scale
    depth_m = frame.depth_m
    if options.no_depth == FAR and (scale is not None or depth_m.dtype.kind == "f"):  # else its unit is not known
        metres = in_metres(depth_m, 1.0 if scale is None else scale_of(frame.where, scale))
        depth_m, scale = np.where(metres <= 0, np.float32(np.inf), metres), None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # notes say it
        result = warp_image(
            frame.colour, depth_m, frame.view, shown, options.warp, options.fill, options.size, repair=options.repair,
            depth_scale=scale, encoding=options.encoding or frame.encoding, result="linear", depth=depth,
        )  # fmt: skip
    write_image(options.out, result, shown)
    notes = [*_notes(frame, shown, options), *about_holes(result.hole_share, frame.view, shown)]
    if said["json"]:
        facts = {"time_ms": result.time_ms, "hole_share": result.hole_share, "notes": notes}
        typer.echo(as_json({"out": str(options.out), **facts}))
        return
    stages = ", ".join(f"{name} {ms:.2f} ms" for name, ms in result.time_ms.items())
    typer.echo(f"{options.out}: {stages}; {100 * result.hole_share:.2f} % holes before the fill")
    for note in notes:
        typer.echo(f"note: {note}")


def _notes(frame: sequences.FrameFile, shown: geometry.View, options: _WarpOptions) -> list[str]:
    """Return what is assumed of a frame, and what its depth suggests."""
    import numpy as np

    from ..poses.assumptions import unstated
    from ..sources.sequences import about_largest, about_sky, about_unit, assumptions_of
    from ..sources.sequences.recorded import in_metres

    raw, scale = frame.depth_m, options.depth_scale or frame.depth_scale or 1.0
    metres = in_metres(raw, scale)
    moved_m = float(np.linalg.norm(shown.pose.position_m - frame.view.pose.position_m))
    return [
        *unstated(assumptions_of(frame, scale=options.depth_scale, encoding=options.encoding)),
        *frame.notes,
        *about_largest([raw]),
        *(about_sky([metres]) if options.no_depth != FAR else []),
        *about_unit([metres], moved_m, "--depth-scale {:g}", [raw]),
    ]
