"""hmdwarp synthesise: frames from motion vectors, as a headset's runtime makes them."""

from __future__ import annotations

import typer

from ..check.options import SynthesisOptions
from ._options import Said, takes


@takes(SynthesisOptions)
def synthesise(said: Said) -> None:
    """Make the frame between two or after them from motion vectors and depth, with its error.

    FRAMES as an engine gives them to XR_EXT_frame_synthesis or XR_FB_space_warp. `hmdwarp check
    --motion` says whether they are in its convention.
    """
    from ..check import read_motion
    from ..check import synthesise as made
    from ..report import OutputFolder

    options = SynthesisOptions.of(said)
    frames = read_motion(options.frames)
    rows = []
    with OutputFolder(options.out, owned=("[0-9]*.png",), last="synthesis.json", force=options.force) as out:
        for one in made(frames, options.at):
            out.write_png(f"{one.name}.png", one.colour)
            rows.append(one.row())
            error = "no true frame of that instant"
            if one.truth is not None:
                error = (
                    f"PSNR {one.psnr_db:.2f} dB to {one.truth}; {one.without_vectors_db:.2f} by head and depth alone, "
                    f"{one.as_it_was_db:.2f} as it was"
                )
            typer.echo(f"{one.name}.png at {one.time_ns} ns: {error}")
        out.write_json("synthesis.json", {"at": options.at, "frames": rows})
