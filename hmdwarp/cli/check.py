"""hmdwarp check and synthesise: what frames are, and frames from their motion vectors."""

from __future__ import annotations

import typer

from .. import check as conventions
from .. import report
from ..check import CheckOptions, SynthesisOptions
from ._options import JSON, Said, as_json, takes


@takes(CheckOptions, JSON)
def check(said: Said) -> None:
    """Find the conventions under which frames of the same things agree, by depth and by colour.

    Quaternion order, pose or its inverse, axes, rows, eyes, depth and its planes and scale, field
    of view, principal point, half a pixel, time. It says what cannot be told, and prints the code
    that reads the frames right.
    """
    from ._show import paragraph

    options = CheckOptions.of(said)
    if options.motion:
        answer = conventions.check_motion(conventions.read_motion(options.frames[0]))
    else:
        answer = conventions.check(conventions.read_stated(options.frames, options.reading))
    if said["json"]:
        typer.echo(as_json(answer.as_json()))
        return
    paragraph(answer.headline)
    width = max((len(finding.label) for finding in answer.findings), default=0)
    for finding in (finding for finding in answer.findings if finding.told):
        mark = "" if finding.as_stated else "  <- not as stated"
        sure = f"  ({finding.margin:.0f} standard errors ahead)" if finding.margin is not None else ""
        typer.echo(f"  {finding.label:<{width}}  {finding.value}{sure}{mark}")
    for other in answer.as_good:
        paragraph(f"It may be {other}")
    for finding in (finding for finding in answer.findings if not finding.told):
        paragraph(f"{finding.label} cannot be told from these frames: {finding.why}")
    if answer.code:
        typer.echo("\n".join(["Read them so:", *(f"    {line}" for line in answer.code)]))
    if answer.assumptions:
        typer.echo("\n".join(["The folder was read with:", *(f"  {one}" for one in answer.assumptions)]))
    for note in answer.notes:
        paragraph(note)


@takes(SynthesisOptions, JSON)
def synthesise(said: Said) -> None:
    """Make the frame between two or after them from motion vectors and depth, with its error.

    FRAMES as an engine gives them to XR_EXT_frame_synthesis or XR_FB_space_warp. `hmdwarp check
    --motion` says whether they are in its convention.
    """
    options = SynthesisOptions.of(said)
    frames = conventions.read_motion(options.frames)
    rows = []
    with report.OutputFolder(options.out, owned=("[0-9]*.png",), last="synthesis.json", force=options.force) as out:
        for one in conventions.synthesise(frames, options.at):
            out.write_png(f"{one.name}.png", one.colour)
            rows.append(one.row())
            error = "no true frame of that instant"
            if one.truth is not None:
                error = (
                    f"PSNR {one.psnr_db:.2f} dB to {one.truth}; {one.without_vectors_db:.2f} by head and depth alone, "
                    f"{one.as_it_was_db:.2f} as it was"
                )
            if not said["json"]:
                typer.echo(f"{one.name}.png at {one.time_ns} ns: {error}")
        out.write_json("synthesis.json", entry := {"at": options.at, "frames": rows})
    if said["json"]:
        typer.echo(as_json(entry))
