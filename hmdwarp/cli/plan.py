"""hmdwarp plan: the passes that would run, each with its reason, and those left out with theirs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from ..errors import InputError
from ..options import Option
from ..pipeline.options import PipelineOptions
from ..run.options import DESKTOP, OPENXR, LiveOptions
from ._options import Said, takes

if TYPE_CHECKING:
    from ..client.plan import Plan, Step
    from ..headsets import Headset
    from ..scenes import Scene

REPLAY = "replay"
_SOURCE = Option("Driver that shows the pictures: replay, or live: openxr or desktop.", default=REPLAY, name="source")


@takes(PipelineOptions, _SOURCE)
def plan(said: Said) -> None:
    """Print the passes that would run, with reasons, and the bytes of a frame. Starts nothing.

    Tells what makes the scene slow to draw, and what to do about it.
    """
    from ..headsets import load_headset
    from ..pipeline.planning import build_plan_for
    from ..scenes import load_scene, slow_in
    from ._show import in_columns

    source, headset = said["source"], load_headset(said["headset"])
    kind, told = _driver(source)
    if said["lens"] is None and told:
        said["lens"] = "none"
    options = kind.of(said)
    scene = load_scene(options.scene)
    slow = [("Slow", line) for line in slow_in(scene)]
    if options.chooses_warp:
        _auto(options, scene, told)
        in_columns(slow)
        return
    built = build_plan_for(options, headset, scene, **told)
    weights = _weights(options, headset, [built])
    typer.echo("Passes, in order:")
    in_columns(((step.name, _told(step)) for step in built.steps), indent=2)
    typer.echo("Left out; nothing is compiled or allocated for them:")
    in_columns(built.left_out, indent=2)
    in_columns([*weights, *_assumed(source, options.headset), *slow])


def _driver(source: str) -> tuple[type[PipelineOptions], dict[str, str]]:
    """Return the driver's options, and what it tells the plan.

    Errors: InputError for an unknown source.
    """
    from ..display.openxr import RUNTIME_LABEL

    if source not in (REPLAY, OPENXR, DESKTOP):
        raise InputError(f"source '{source}': expected {REPLAY}, {OPENXR} or {DESKTOP}")
    kind = PipelineOptions if source == REPLAY else LiveOptions
    return kind, {"distorts": RUNTIME_LABEL, "takes_depth": RUNTIME_LABEL} if source == OPENXR else {}


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


def _auto(options: PipelineOptions, scene: Scene, told: dict[str, str]) -> None:
    """Print what warp auto would choose from, as far as that is known without running anything."""
    from ..auto.levels import best_within
    from ..headsets import load_headset
    from ..pipeline.planning import plans_for
    from ..run import levels_from_file
    from ..run.short_bench import INSTANTS, candidates
    from ._show import in_columns, paragraph

    if options.bench is None:
        names = [f"{c.warp} + {c.fill}" if c.plan.fills else c.warp for c in candidates(options)]
        paragraph(
            f"Warp auto would first try these {len(names)} at {INSTANTS} instants of the run: {', '.join(names)}."
        )
        paragraph(
            f"It would begin with the most accurate that takes at most {options.budget_ms:g} ms for one eye, and "
            "keep to that time."
        )
        return
    found = levels_from_file(options.bench, options, None)
    first = best_within(found.levels, options.budget_ms)
    typer.echo("Warp auto would choose from these, each dearer and more accurate than the one before:")
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
    headset = load_headset(options.headset)
    in_columns(_weights(options, headset, plans_for(options, headset, scene, found.levels, **told)))


def _weights(options: PipelineOptions, headset: Headset, plans: list[Plan]) -> list[tuple[str, str]]:
    """Return the bytes of frames that carry what all the plans read, and how many there are."""
    from ..client.plan import needs_of
    from ..frames import frame_bytes
    from ..pipeline.build import frames_held
    from ..pipeline.sizes import eye_sizes

    rate_hz = options.rate_hz or headset.refresh_hz
    needs, sizes = needs_of(plans), eye_sizes(options.guard_factor, headset, options.size or headset.eye_size_px)
    parts = frame_bytes(needs, sizes, {name for plan in plans for name in plan.layers})
    told = ", ".join(f"{name} {count / 1e6:.1f} MB" for name, count in parts.items())
    at_once = f"at most {frames_held(options, rate_hz, needs)} of them at {options.latency_ms:g} ms and {rate_hz:g} Hz"
    return [
        (
            "A frame",
            f"2 eyes x {sizes.rendered[0]}x{sizes.rendered[1]} px, {sum(parts.values()) / 1e6:.1f} MB uncompressed: "
            f"{told}",
        ),
        ("At a time", f"{at_once}: under way, being drawn, shown or kept"),
    ]


def _told(step: Step) -> str:
    reads = f"reads {', '.join(step.reads)}; " if step.reads else ""
    return f"{step.reason}\n{reads}writes {', '.join(step.writes)}"
