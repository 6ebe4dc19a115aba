"""hmdwarp plan: the passes that would run, each with its reason, and those left out with theirs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import typer

from .. import client, headsets, pipeline, scenes
from ..errors import InputError, counted
from ..options import AUTO, Option
from ..pipeline.options import PipelineOptions
from ..pipeline.proxy_options import PROXY
from ..run.options import DESKTOP, OPENXR, LiveOptions
from ._options import JSON, Said, as_json, takes
from ._show import in_columns, paragraph
from .catalogue import headset_facts

REPLAY = "replay"
_SOURCE = Option("Display to plan for: replay, or in a live run openxr or desktop.", default=REPLAY, name="source")


@takes(PipelineOptions, _SOURCE, JSON)
def plan(said: Said) -> None:
    """Print the passes that would run, with reasons, and the bytes of a frame. Runs nothing.

    With --proxy those of the proxy too. Says what makes the scene slow to draw, and what to do.
    """
    source = said["source"]
    headsets.load_headset(said["headset"])
    kind, told = _driver(source)
    if said["lens"] is None and told:
        said["lens"] = "none"
    options = kind.of(said)
    if options.warp == AUTO:
        raise InputError("plan --warp auto: 'hmdwarp choose' with the same options names warp and fill; plan those")
    frames = pipeline.source_of(options)
    options = frames.fitted(options)
    slow, noted = list(scenes.slow_in(frames.scene)), [*frames.notes, *frames.scene.notes]
    about = _passes(options, frames, told)
    eyes = headset_facts(frames.headset)
    if said["json"]:
        names = ("scene", "indirect", "warp", "fill", "lens", "headset")
        chosen = {name: getattr(options, name) for name in names}
        notes = [*about.notes, *noted]
        typer.echo(as_json({"source": source, **chosen, "eyes": eyes, **about.data, "slow": slow, "notes": notes}))
        return
    about.show()
    light = [("Light", options.light_note)] if options.light_note else []
    typer.echo(f"Eyes of {frames.headset.name}:")
    in_columns(((key.replace("_", " "), text) for key, text in eyes.items()), indent=2)
    in_columns([*_assumed(source, options.headset), *light, *(("Slow", line) for line in slow)])
    for note in noted:
        paragraph(f"note: {note}")


@attrs.frozen
class _About:
    """What there is to tell: for programs, and as what prints it for people."""

    data: dict[str, Any]
    show: Callable[[], None]
    notes: list[str] = attrs.field(factory=list)


def _passes(options: PipelineOptions, source: pipeline.Source, told: dict[str, Any]) -> _About:
    from ..pipeline.planning import build_plan_for, proxy_plan_for
    from ..pipeline.source import motion_notes

    built = build_plan_for(options, source.headset, source.scene, **told)
    proxy = proxy_plan_for(options, source.scene) if options.source_kind is PROXY else None
    frame = pipeline.frame_weight(options, source.headset, [built])
    notes = [*pipeline.guard_notes(options, frame), *motion_notes(options, source.scene, built)]

    def show() -> None:
        if proxy is not None:
            typer.echo("Passes of the proxy, in order:")
            in_columns(((step.name, _told(step)) for step in proxy.steps), indent=2)
        typer.echo("Passes, in order:")
        in_columns(((step.name, _told(step)) for step in built.steps), indent=2)
        typer.echo("Left out; nothing is compiled or allocated for them:")
        in_columns(built.left_out, indent=2)
        in_columns(_weights(frame))
        for note in notes:
            paragraph(f"note: {note}")

    passes = [attrs.asdict(step) for step in built.steps]
    left_out = [{"name": name, "reason": reason} for name, reason in built.left_out]
    of_proxy = {} if proxy is None else {"proxy": {"passes": [attrs.asdict(step) for step in proxy.steps]}}
    return _About({"passes": passes, "left_out": left_out, "frame": frame, **of_proxy}, show, notes)


def _driver(source: str) -> tuple[type[PipelineOptions], dict[str, str]]:
    """Return the driver's options, and what it tells the plan.

    Errors: InputError for an unknown source.
    """
    from ..display.openxr import RUNTIME_LABEL

    if source not in (REPLAY, OPENXR, DESKTOP):
        raise InputError(f"--source '{source}': expected {REPLAY}, {OPENXR} or {DESKTOP}")
    kind = PipelineOptions if source == REPLAY else LiveOptions
    return kind, dict.fromkeys(("distorts", "takes_depth", "takes_panels"), RUNTIME_LABEL) if source == OPENXR else {}


def _assumed(source: str, headset: str) -> list[tuple[str, str]]:
    """Return what only the runtime knows, when it runs."""
    if source != "openxr":
        return []
    return [
        (
            "Not known",
            f"the runtime's own eyes, size and rate: those of '{headset}' were taken; and whether it takes depth at "
            "all",
        )
    ]


def _weights(frame: dict[str, Any]) -> list[tuple[str, str]]:
    layers = ", ".join(f"{name} {_megabytes(count)}" for name, count in frame["layers"].items())
    from ..pipeline.sizes import rendered_text

    at_once = f"at most {frame['at_once']} of them at {frame['latency_ms']:g} ms and {frame['rate_hz']:g} Hz"
    return [
        ("A frame", f"{counted(frame['eyes'], 'eye')}, {_megabytes(frame['bytes'])} uncompressed: {layers}"),
        ("An eye", f"{rendered_text(frame)}"),
        ("At a time", f"{at_once}: under way, being drawn, shown or kept"),
    ]


def _megabytes(count: int) -> str:
    return "under 0.1 MB" if 0 < count < 50_000 else f"{count / 1e6:.1f} MB"


def _told(step: client.Step) -> str:
    reads = f"reads {', '.join(step.reads)}; " if step.reads else ""
    return f"{step.reason}\n{reads}writes {', '.join(step.writes)}"
