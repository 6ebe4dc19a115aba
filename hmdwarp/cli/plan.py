"""hmdwarp plan: the passes that would run, each with its reason, and those left out with theirs."""

from __future__ import annotations

from typing import Any

import attrs
import typer

from .. import client, headsets, pipeline, scenes
from ..base import AUTO, InputError, counted
from ..pipeline.options import PROXY, PipelineOptions
from ._options import JSON, Said, as_json, takes
from ._show import in_columns, paragraph
from .catalogue import headset_facts


@takes(PipelineOptions, JSON)
def plan(said: Said) -> None:
    """Print the passes that would run, with reasons, and the bytes of a frame. Runs nothing.

    With --proxy those of the proxy too. Says what makes the scene slow to draw, and what to do.
    """
    from ..pipeline.sizes import build_plan_for, proxy_plan_for, rendered_text
    from ..pipeline.source import motion_notes

    own = headsets.load_headset(said["headset"]).lens
    if said["lens"] is None:
        said["lens"] = "none" if said["frames"] or own is None else own.model
    options = PipelineOptions.of(said)
    if options.warp == AUTO:
        raise InputError("plan --warp auto: 'hmdwarp choose' with the same options names warp and fill; plan those")
    frames = pipeline.source_of(options)
    options = frames.fitted(options)
    scene, eyes = frames.scene, headset_facts(frames.headset)
    slow, noted = list(scenes.slow_in(scene)), [*frames.notes, *scene.notes]
    built = build_plan_for(options, frames.headset, scene)
    proxy = proxy_plan_for(options, scene) if options.source_kind is PROXY else None
    frame = pipeline.frame_weight(options, frames.headset, [built])
    notes = motion_notes(options, scene, built)
    if said["json"]:
        names = ("scene", "indirect", "warp", "fill", "lens", "headset")
        data: dict[str, Any] = {**{name: getattr(options, name) for name in names}, "eyes": eyes}
        data["passes"] = [attrs.asdict(step) for step in built.steps]
        data["left_out"] = [{"name": name, "reason": reason} for name, reason in built.left_out]
        data["frame"] = frame
        if proxy is not None:
            data["proxy"] = {"passes": [attrs.asdict(step) for step in proxy.steps]}
        typer.echo(as_json({**data, "slow": slow, "notes": [*notes, *noted]}))
        return
    if proxy is not None:
        typer.echo("Passes of the proxy, in order:")
        in_columns(((step.name, _told(step)) for step in proxy.steps), indent=2)
    typer.echo("Passes, in order:")
    in_columns(((step.name, _told(step)) for step in built.steps), indent=2)
    typer.echo("Left out; nothing is compiled or allocated for them:")
    in_columns(built.left_out, indent=2)
    in_columns(_weights(frame, rendered_text(frame)))
    for note in notes:
        paragraph(f"note: {note}")
    typer.echo(f"Eyes of {frames.headset.name}:")
    in_columns(((key.replace("_", " "), text) for key, text in eyes.items()), indent=2)
    rows = [("Light", options.light_note)] if options.light_note else []
    in_columns([*rows, *(("Slow", line) for line in slow)])
    for note in noted:
        paragraph(f"note: {note}")


def _weights(frame: dict[str, Any], rendered: str) -> list[tuple[str, str]]:
    layers = ", ".join(f"{name} {_megabytes(count)}" for name, count in frame["layers"].items())
    at_once = f"at most {frame['at_once']} of them at {frame['latency_ms']:g} ms and {frame['rate_hz']:g} Hz"
    return [
        ("A frame", f"{counted(frame['eyes'], 'eye')}, {_megabytes(frame['bytes'])} uncompressed: {layers}"),
        ("An eye", rendered),
        ("At a time", f"{at_once}: under way, being drawn, shown or kept"),
    ]


def _megabytes(count: int) -> str:
    return "under 0.1 MB" if 0 < count < 50_000 else f"{count / 1e6:.1f} MB"


def _told(step: client.Step) -> str:
    reads = f"reads {', '.join(step.reads)}; " if step.reads else ""
    return f"{step.reason}\n{reads}writes {', '.join(step.writes)}"
