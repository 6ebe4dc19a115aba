"""`hmdwarp trace`: inspect and convert head traces, or write synthetic ones."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import typer

from .. import poses, report
from ..base import FORCE, Declared, InputError, Option, counted, force_field, option, out_field, unknown_name
from ..poses.options import MOTIONS, TraceOptions
from ._options import JSON, Group, Said, as_json, takes

if TYPE_CHECKING:
    from rich.table import Table

app = typer.Typer(cls=Group, help="Inspect and convert head traces, or write synthetic ones.", no_args_is_help=True)

_TRACE = Option(
    "A file, or the bare name of a shipped recording.",
    required=True, name="trace", metavar="TRACE", positional=True, names_files=True,
)  # fmt: skip
_OUT = Option("The file to write.", Path, required=True, name="out", metavar="OUT", positional=True)
_TO = Option("Format to write: native, tum or euroc.", default="native", name="to")


@app.command()
@takes(_TRACE, TraceOptions, JSON)
def info(said: Said) -> None:
    """Show rate, duration, gaps, speeds, what latency costs, and every defect with its repair."""
    from rich.console import Console

    from ._show import in_columns

    loaded = poses.load_trace(said["trace"], TraceOptions.of(said))
    figures = poses.analyse(loaded.track)
    if said["json"]:
        typer.echo(as_json(poses.trace_as_json(loaded, figures)))
        return
    console = Console()
    if not console.is_terminal:
        console = Console(width=120, soft_wrap=True)
    in_columns(_facts(loaded, figures).items())
    for table in _tables(loaded, figures):
        console.print()
        console.print(table)
    console.print()
    _tell_defects(loaded)


@app.command()
@takes(_TRACE, _OUT, _TO, FORCE, TraceOptions)
def convert(said: Said) -> None:
    """Write a clean trace.

    One segment, unit quaternions without sign flips, rising time, metres; OpenXR axes.
    """
    from ..poses.formats import formats

    to, out = said["to"], said["out"]
    able = [format_.name for format_ in formats if format_.writes]
    if to not in formats.names():
        raise unknown_name("format to write", to, able)
    target = formats.get(to)
    if not target.writes:
        raise InputError(f"--to {to}: this format is read, not written: expected one of {', '.join(able)}")
    loaded = poses.load_trace(said["trace"], TraceOptions.of(said))
    if not (out.exists() and out.samefile(loaded.path)):  # refused by write_stream, forced or not
        report.refuse_existing(out, force=said["force"])
    report.write_stream(out, lambda stream: target.write(loaded.track, stream), source=loaded.path)
    _tell_defects(loaded, err=True)
    typer.echo(f"axes read: {loaded.axes}; written: openxr", err=True)
    typer.echo(f"{_written(out, loaded.track)}, format {to}", err=True)


def _written(out: Path, track: poses.PoseTrack) -> str:
    return f"{out}: {counted(len(track), 'sample')}, {track.duration_ns / 1e9:.3f} s"


@attrs.frozen
class _SynthOptions(Declared):
    """Synthetic head motion."""

    kind: str = option(attrs.NOTHING, f"{MOTIONS}.", positional=True, metavar="KIND")
    out: Path = out_field(attrs.NOTHING, "The file to write.")
    force: bool = force_field()
    seed: int | None = option(None, "The same seed gives the same bytes; by default the recording's.")
    seconds: float | None = option(None, "Length; by default the recording's.")
    speed: float | None = option(
        None, "Speed of forward, backward and sideways (m/s, by default 0.5), and of rotate (degrees per second, 60)."
    )
    amplitude: float | None = option(
        None, "How far these go before they come back (m, by default 0.8), and rotate (degrees, 180)."
    )
    rate_hz: float = option(90.0, "Samples per second.")


@app.command()
@takes(_SynthOptions)
def synth(said: Said) -> None:
    """Write synthetic head motion: of people, or there and back at one speed."""
    options = _SynthOptions.of(said)
    if options.out.suffix.lower() not in ("", ".csv", ".txt"):
        raise InputError(
            f"--out {options.out}: found '{options.out.suffix}'; the trace is text: expected a name in .csv"
        )
    report.refuse_existing(options.out, force=options.force)
    track = poses.synthesise(
        options.kind, options.seed, options.seconds, options.rate_hz, speed=options.speed, amplitude=options.amplitude
    )
    report.write_stream(options.out, lambda stream: poses.write_synthetic(track, stream))
    typer.echo(f"{_written(options.out, track)}, {track.origin}", err=True)


def _facts(loaded: poses.LoadedTrace, figures: dict[str, Any]) -> dict[str, str]:
    gaps = "none"
    if figures["gaps"]:
        longest = max(figures["gaps"], key=lambda gap: gap["length_s"])
        gaps = (
            f"{len(figures['gaps'])} longer than {loaded.track.max_gap_ns / 1e6:g} ms, the longest "
            f"{longest['length_s']:.3f} s from {longest['start_s']:.3f} s"
        )
    taken = ", ".join(str(segment.number) for segment in loaded.segments if segment.taken)
    several = f"{len(loaded.segments)} in the file, of which {taken} is read; --json has all"
    mean_hz = f"{figures['mean_rate_hz']:.2f} Hz on average"
    return {
        "trace": str(loaded.path),
        **({"recordings": several} if len(loaded.segments) > 1 else {}),
        "format": loaded.format,
        "origin": loaded.track.origin or "not stated in the file",
        "axes": loaded.axes,
        "columns": loaded.columns,
        "samples": f"{figures['samples']}, {100 * figures['repeated_share']:.3g} % of them repeated poses",
        "duration": f"{figures['duration_s']:.3f} s",
        "rate": f"{figures['rate_hz']:.2f} Hz (one over the median step), {mean_hz}",
        "clock": f"{loaded.time_unit}, starting at {loaded.track.epoch_ns / 1e9:.9g} s" if loaded.time_unit else "",
        "gaps": gaps,
        "jumps": str(figures["jumps"] or "none"),
        "gaze": f"known in {figures['gaze']['known']:.1%} of the samples" if figures["gaze"] else "none",
    }


def _tables(loaded: poses.LoadedTrace, figures: dict[str, Any]) -> Iterator[Table]:
    """Yield the tables of speeds, of what latency costs, and of what was assumed."""
    short, turning, moving = "trace too short", figures["angular_speed_deg_s"], figures["linear_speed_m_s"]
    lines = [
        ("turning, deg/s", *(f"{v:.1f}" if math.isfinite(v) else short for v in turning.values())),
        ("moving, m/s", *(f"{v:.3f}" if math.isfinite(v) else short for v in moving.values())),
    ]
    yield report.terminal_table(("", *turning), lines, title="Speed (200 Hz, central differences)")
    title = "What latency costs: angle between the head and its --predict, degrees, p50 / p95 / p99 (mean)"
    names = [name for name in figures["errors_deg"][0] if name not in ("latency_ms", "count")]
    lines = [
        (f"{row['latency_ms']} ms", *(_angles(row[name]) if row["count"] else short for name in names))
        for row in figures["errors_deg"]
    ]
    yield report.terminal_table(("latency", *names), lines, title=title)
    assumed = [(assumption.what, assumption.value, assumption.source) for assumption in loaded.assumptions]
    heads = ("fact", "taken as", "who says so")
    yield report.terminal_table(heads, assumed, words=3, title="What was assumed of the file")


def _angles(errors: dict[str, float]) -> str:
    texts = (f"{angle:.2f}" if angle < 10 else f"{angle:.1f}" for key, angle in errors.items() if key != "mean")
    return f"{' / '.join(texts)} ({errors['mean']:.2f})"


def _tell_defects(loaded: poses.LoadedTrace, *, err: bool = False) -> None:
    found = counted(len(loaded.defects), "defect") if loaded.defects else "no defects"
    for line in (typer.style(f"{found} found", bold=True), *(f"  {defect}" for defect in loaded.defects)):
        typer.echo(line, err=err)
