"""hmdwarp plan: the passes that would run, each with its reason, and those left out with theirs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
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
    frames = pipeline.source_of(options)
    options = frames.fitted(options)
    slow, noted = list(scenes.slow_in(frames.scene)), [*frames.notes, *frames.scene.notes]
    about = (_auto if options.warp == AUTO else _passes)(options, frames, told)
    eyes = headset_facts(frames.headset)
    if said["json"]:
        names = ("scene", "indirect", "warp", *(() if options.warp == AUTO else ("fill",)), "lens", "headset")
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


def _auto(options: PipelineOptions, source: pipeline.Source, told: dict[str, Any]) -> _About:
    """Return what warp auto would choose from, as far as that is known without running anything."""
    from ..run.short_bench import INSTANTS, candidates

    if options.bench is not None:
        return _auto_from_file(options.bench, options, source, told)
    pairs = [(c.warp, c.fill if c.plan.fills else "none") for c in candidates(options, source)]

    def show() -> None:
        names = ", ".join(warp if fill == "none" else f"{warp} + {fill}" for warp, fill in pairs)
        paragraph(f"Warp auto would first try these {len(pairs)} at {INSTANTS} instants of the run: {names}.")
        paragraph(
            f"It would begin with the most accurate that takes at most {options.budget_ms:g} ms for one eye, and "
            "keep to that time."
        )

    tried = [{"warp": warp, "fill": fill} for warp, fill in pairs]
    return _About({"budget_ms": options.budget_ms, "instants": INSTANTS, "tries": tried}, show)


def _auto_from_file(bench: Path, options: PipelineOptions, source: pipeline.Source, told: dict[str, Any]) -> _About:
    from ..pipeline.levels import best_within
    from ..pipeline.planning import plans_for
    from ..run import levels_from_file

    found = levels_from_file(bench, options, None)
    first = best_within(found.levels, options.budget_ms)
    chosen = attrs.evolve(options, levels=found.levels)
    frame = pipeline.frame_weight(options, source.headset, plans_for(chosen, source.headset, source.scene, **told))

    def show() -> None:
        typer.echo("Warp auto would choose from these, each slower and more accurate than the one before:")
        marks = ["; it would begin here" if number == first else "" for number in range(len(found.levels))]
        in_columns(
            (
                (str(r), f"{r.total_ms:.2f} ms per eye, mean FLIP {r.error:.4f}{mark}")
                for r, mark in zip(found.levels, marks, strict=True)
            ),
            indent=2,
        )
        for note in found.notes:
            paragraph(f"note: {note}")
        in_columns(_weights(frame))

    levels = [
        {"warp": r.warp, "fill": r.fill, "total_ms": r.total_ms, "flip": r.error, "psnr_db": r.psnr_db}
        for r in found.levels
    ]
    data = {"budget_ms": options.budget_ms, "levels": levels, "begins_with": first, "frame": frame}
    return _About(data, show, list(found.notes))


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
