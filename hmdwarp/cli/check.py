"""hmdwarp check: which conventions make somebody's frames agree with each other."""

from __future__ import annotations

import typer

from .. import check as conventions
from ..check.options import CheckOptions
from ._options import JSON, Said, as_json, takes


@takes(CheckOptions, JSON)
def check(said: Said) -> None:
    """Find the conventions under which frames of the same things agree, by depth and by colour.

    Quaternion order, pose or its inverse, axes, rows, eyes, depth and its planes and scale, half
    a pixel, time. It says what cannot be told, and prints the code that reads the frames right.
    """
    from ..check import Stated, check, read_stated
    from ..report import refuse_existing, write_png

    options = CheckOptions.of(said)
    if options.out is not None:
        refuse_existing(options.out, force=options.force)
    answer = check(Stated(read_stated(options.frames, options.reading)))
    if options.out is not None:
        from ..check import mismatch

        write_png(options.out, mismatch(answer))
    if said["json"]:
        typer.echo(as_json(answer.as_json()))
        return
    _print(answer)
    if options.out is not None:
        typer.echo(f"picture: {options.out}")


def _print(answer: conventions.Answer) -> None:
    from ._show import paragraph

    paragraph(answer.headline())
    if not answer.agree:
        return
    width = max(len(one.label) for one in answer.findings)
    for one in (one for one in answer.findings if one.told):
        mark = "" if one.as_stated else "  <- not as stated"
        sure = f"  ({one.margin:.0f} standard errors ahead)" if one.margin is not None else ""
        typer.echo(f"  {one.label:<{width}}  {one.value}{sure}{mark}")
    for one in (one for one in answer.findings if not one.told):
        paragraph(f"{one.label} cannot be told from these frames: {one.why}")
    for other in answer.as_good:
        paragraph(f"These frames agree as well with {other}")
    if answer.code:
        typer.echo("Read them so:")
        for line in answer.code:
            typer.echo(f"    {line}")
