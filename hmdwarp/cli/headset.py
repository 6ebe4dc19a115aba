"""`hmdwarp headset`: a picture of one, and files from what other programs know."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import typer

from .. import display, headsets, report
from ..base import FORCE, InputError, Option
from ._options import Group, Said, takes

app = typer.Typer(cls=Group, help="Show a headset as a picture, or write one from an export.", no_args_is_help=True)

_NAME = Option("A shipped headset, or a file.", required=True, name="headset", metavar="HEADSET", positional=True)
_PNG = Option("The picture to write, a PNG.", Path, required=True, name="out")
_EXPORT = Option("What hmdq exported, a .json file.", Path, required=True, name="file", metavar="FILE", positional=True)
_TOML = Option("The headset's file to write, a .toml.", Path, required=True, name="out")


@app.command()
@takes(_NAME, _PNG, FORCE)
def show(said: Said) -> None:
    """Draw both views in one projection, with overlap, hidden area and the lens's grid."""
    report.refuse_existing(said["out"], force=said["force"])
    if said["out"].suffix != ".png":
        raise InputError(f"--out {said['out']}: expected a .png file")
    report.write_bytes(said["out"], report.headset_plot_png(headsets.load_headset(said["headset"])))


@app.command("from-hmdq")
@takes(_EXPORT, _TOML, FORCE)
def from_hmdq(said: Said) -> None:
    """Write a headset's file from an export of hmdq: views, size and hidden area."""
    report.refuse_existing(said["out"], force=said["force"])
    if said["file"].suffix != ".json" or said["out"].suffix != ".toml":
        raise InputError(f"{said['file']} to {said['out']}: expected a .json file and --out with a .toml file")
    report.write_text(said["out"], headsets.headset_toml(headsets.load_headset(str(said["file"]))))


@app.command("from-openxr")
@takes(_TOML, FORCE)
def from_openxr(said: Said) -> None:
    """Write a headset's file from the connected OpenXR runtime: views, size, rate, hidden area."""
    out = said["out"]
    report.refuse_existing(out, force=said["force"])
    if out.suffix != ".toml":
        raise InputError(f"--out {out}: expected a .toml file")
    from ..display import openxr

    with closing(openxr.OpenXrDisplay(display.DisplayOptions())) as shown:
        about = f"{shown.about['headset']} by {shown.about['runtime']}"
        found = headsets.reported_headset(out.stem, about, shown.size, shown.rate_hz, shown.eyes)
    report.write_text(out, headsets.headset_toml(found))
