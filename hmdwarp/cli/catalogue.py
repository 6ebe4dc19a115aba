"""hmdwarp list and doctor: what there is to choose from, and what this machine has.

The rows of texts are for tables of docs/ and other programs too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Any

import attrs
import typer

from ..base import Declared, InputError, Option, Registry, Row, describe, option, unknown_name
from ._options import JSON, Said, as_json, takes


@attrs.frozen
class Kind:
    """What one list holds."""

    summary: str
    # "module:registry", or a function that returns the entries.
    entries: str | Callable[[], Iterable[Any]]
    # The columns of an entry besides those of its registry.
    more: Callable[[Any], Row] = lambda entry: {}

    def rows(self) -> list[Row]:
        """Return a row of texts for each entry, each with at least `name` and `summary`."""
        if isinstance(self.entries, str):
            module, _, name = self.entries.partition(":")
            registry: Registry[Any] = getattr(_of(module), name)
            return describe(registry, registry.columns, self.more)
        return describe(self.entries(), more=self.more)


def _of(module: str) -> Any:
    return import_module(f"hmdwarp.{module}")


def _each(module: str, names: str, load: str) -> Callable[[], Iterable[Any]]:
    """Return a function that loads what a module has names of."""
    return lambda: map(getattr(_of(module), load), getattr(_of(module), names)())


def entries(kind: str) -> list[Row]:
    """Return the rows of one kind, a key of KINDS.

    Of warps also those that do as another system does, and that library's own.
    """
    rows = KINDS[kind].rows()
    if kind != "warps":
        return rows
    from ..client import every_baseline, parse_warp
    from ..run.measuring import OUTSIDE, missing

    own = {row["name"]: row for row in rows}
    for text, system in every_baseline().items():
        choice = parse_warp(text)
        values = ", ".join(f"{name}={value}" for name, value in attrs.asdict(choice.settings).items())
        of = own[choice.entry.name]
        told = {"name": text, "summary": f"as {system}: {of['summary']}", "settings": values, "does_as": system}
        rows.append(of | told)
    for name, system in OUTSIDE.items():
        summary = f"as {system}: its own warp by depth, on the CPU, for 'hmdwarp bench' only"
        told = {"name": name, "summary": summary, "does_as": system, "source": system}
        told |= {"reads": "rendered.colour, rendered.inverse_depth", "fused_with_the_lens": "no"}
        if not missing(name):
            rows.append(dict.fromkeys(rows[0], "none") | told | {"follows_scanout": "no"})
    return rows


def _client(client: Any) -> Row:
    limits = {
        "budget": (client.budget_ms, "ms an eye"), "decoder": (client.decoder_mpx_s, "Mpx/s"),
        "download": (client.download_mbit_s, "Mbit/s"), "memory": (client.memory_gb_s, "GB/s"),
        "arithmetic": (client.compute_tflops, "TFLOPS"),
    }  # fmt: skip
    return {
        "scene": client.scene,
        "compute_shaders": "yes" if client.compute_shaders else "no",
        "layers": "all" if client.more_layers else "colour and depth",
        **{key: f"{most:g} {unit}" if math.isfinite(most) else "not stated" for key, (most, unit) in limits.items()},
        "source": client.source or "none",
    }


def _headset(headset: Any) -> Row:
    return {
        "eye_size": "x".join(map(str, headset.eye_size_px)),
        "refresh_hz": f"{headset.refresh_hz:g}",
        **headset_facts(headset),
        "lens": headset.lens.model if headset.lens is not None else "none",
        "emulated": headset.emulated or "all of it",
        "source": headset.source,
    }


def headset_facts(headset: Any) -> Row:
    """Return what the eyes of a headset see, in words."""
    sides = dict(zip(("left", "right"), headset.eyes, strict=False))
    least, most = (limit * 1e3 for limit in headset.ipd_range_m)
    return {
        **{f"{side}_fov_deg": _angles(eye.fov) for side, eye in sides.items()},
        "cant_deg": _both(headset.cants_deg, ".1f"),
        "across_deg": f"{headset.across_deg:.1f}",
        "overlap_deg": f"{headset.overlap_deg:.1f}",
        "pixels_per_degree": f"{headset.eyes[0].fov.pixels_per_degree(headset.eye_size_px):.1f}",
        "hidden_share": _both([eye.hidden_share for eye in headset.eyes], ".1%"),
        "ipd_mm": f"{headset.ipd_m * 1e3:.1f}, :ipd={least:g} to {most:g}",
    }


def _angles(fov: Any) -> str:
    angles = zip(("left", "right", "down", "up"), map(math.degrees, attrs.astuple(fov)), strict=True)
    return ", ".join(f"{side} {angle:.1f}" for side, angle in angles)


def _both(values: Sequence[float], form: str) -> str:
    """Return one value where both eyes have the same, else those of each."""
    return ", ".join(dict.fromkeys(format(value, form) for value in values))


def _stated(facts: Iterable[Any]) -> list[tuple[Any, str]]:
    """Return what a file format assumes, with who states it."""
    by = _of("poses.assumptions").By
    said = {by.USER: "stated by {0.option}", by.DEFAULT: "not stated"}
    return [
        (fact, f"{fact.value} ({said.get(fact.by, 'by the {0.by}').format(fact)}"
         f"{f': {fact.option}' if fact.by is by.DEFAULT and fact.option else ''})")
        for fact in facts
    ]  # fmt: skip


def _recording(loaded: Any) -> Row:
    track = loaded.track
    made_by, _, what = track.origin.rpartition("; ")  # as 'hmdwarp trace synth' writes it into the file
    about = {"seconds": f"{track.duration_ns * 1e-9:.1f}", "rate_hz": f"{track.rate_hz:.0f}"}
    return {"name": track.name, "summary": what, **about, "origin": made_by or track.origin}


def _scale(scale: Any) -> Row:
    items = [item.described for item in scale.items]
    answers = f"{scale.least:g} to {scale.most:g}, {scale.direction}"
    return {
        "summary": f"{scale.title}: {answers if scale.has_answers else 'each question has its own answers'}",
        "kind": scale.kind,
        "step": f"{scale.step:g}",
        "anchors": "; ".join(f"{value:g} = {words}" for value, words in scale.anchors.items())
        or "those of each question",
        "asks": items[0] if len(items) == 1 else f"{len(items)} items: {', '.join(items)}",
        "scores": ", ".join(score.name for score in scale.scores) or "the answer itself",
        "source": scale.source,
    }


def _study(study: Any) -> Row:
    parts = [f"{part.name}: {', '.join(condition.name for condition in part.conditions)}" for part in study.parts]
    scales = ", ".join(scale.name for scale in study.scales)
    return {"summary": study.title, "scales": scales, "conditions": "; ".join(parts), "order": study.order}


def _layer(layer: Any) -> Row:
    from ..pipeline import PipelineOptions, eye_sizes

    headset = _of("headsets").load_headset(PipelineOptions().headset)
    count = layer.bytes(layer.something, eye_sizes(1.0, headset, headset.eye_size_px))
    per, size = "frame" if layer.per_frame else "eye", layer.size_class
    return {
        "format": " + ".join(layer.formats) or "none: no picture",
        "size": ("its own" if size == "own" else f"of the {size} picture") if layer.formats else "none",
        "bytes": f"{count / 1e6:.1f} MB for each {per} of {headset.name}" if count else "none",
        "carried": f"once for each {per}, {'always' if layer.always else 'where a pass reads it'}",
        "drawn_by": layer.drawn_by or ("the scene's own passes" if layer.always else "nothing: the client has it"),
        "coded_as": " + ".join(layer.coded_as()) if count else "nothing",
    }


def _options() -> list[tuple[str, Option, list[str]]]:
    """Return every option with the commands that take it, and a name that no other has."""
    from ._app import options_of_commands

    takers: dict[Option, list[str]] = {}
    for command, options in options_of_commands().items():
        for one in options:
            takers.setdefault(one, []).append(command)
    first = {one.name: one for one in reversed(takers)}
    return [
        (one.name if first[one.name] is one else f"{commands[0]} {one.name}", one, commands)
        for one, commands in takers.items()
    ]


def _option(named: tuple[str, Option, list[str]]) -> Row:
    name, option, commands = named
    default = {False: "no", True: "yes"}.get(option.default) if option.kind is bool else str(option.default)
    if option.default is None and (said := re.search(r"\[default: (.*)\]", option.help)):
        default = said[1]
    kinds = {bool: "yes or no", int: "a whole number", float: "a number"}
    return {
        "name": name.replace("_", "-"),
        "summary": option.help,
        "flag": option.metavar or option.name.upper() if option.positional else option.flag,
        "value": option.limits or kinds.get(option.kind, "a text"),
        "unit": option.unit or "none",
        "default": "none" if default in (None, "", "None") else default,
        "commands": ", ".join(commands),
        "in_a_study": "no" if "live" not in commands else "yes" if option.in_study else f"no: {option.study}",
    }


KINDS = {
    "strategies": Kind(
        "What crosses the link, and what the client does with it.", "client.strategies:strategies",
        lambda s: {
            "sets": ", ".join(f"{name}={value}" for name, value in s.options("").items()) or "nothing",
            "classes": ", ".join(f"class-{number}" for number in s.classes), "source": s.source,
            "published": s.published or "none",
        },
    ),
    "warps": Kind(
        "Move a late picture to the newest head pose.", "client.warps:warps",
        lambda warp: {"does_as": "none", "source": warp.source},
    ),
    "fills": Kind("Close the holes that a warp leaves.", "client.fills:fills"),
    "repairs": Kind("Mend depth as cameras give it, before the warp.", "sources.repairs:repairs"),
    "metrics": Kind(
        "What is measured of each picture.", "metrics:metrics",
        lambda metric: {
            "unit": "%" if metric.percent_of else metric.unit or "none",
            "better": "more" if metric.higher_is_better else "less",
            "needs": ", ".join(sorted(str(need.name).lower().replace("_", " ") for need in metric.needs)) or "nothing",
        },
    ),
    "effects": Kind(
        "What a scene may call for beside plain surfaces: mirrors, moving bodies, glass, overlays.",
        "client.effects:effects",
    ),
    "lenses": Kind("Correct the lens of a headset.", "client.lens:lenses"),
    "scenes": Kind("What is rendered, beside files of your own.", "scenes:scenes"),
    "headsets": Kind(
        "Displays that can be emulated.", _each("headsets", "headset_names", "load_headset"), _headset
    ),
    "clients": Kind(
        "Devices that warp, with what each can do.", _each("client.classes", "client_names", "load_client"), _client
    ),
    "axes": Kind(
        "Axes of head traces, by the software that writes them.", "poses.reading.axes:presets",
        lambda axes: {"axes": axes.words(), "source": axes.source},
    ),
    "formats": Kind(
        "Formats of head traces.", "poses.formats:formats",
        lambda entry: {fact.what: stated for fact, stated in _stated(entry.assumes())},
    ),
    "layouts": Kind(
        "Layouts of recorded frames.", "sources.sequences:readers",
        lambda reader: {
            **{what.replace(" ", "_"): "" for what in _of("sources.sequences").FACTS},
            **{fact.what.replace(" ", "_"): stated for fact, stated in _stated(reader.assumes)},
        },
    ),
    "layers": Kind("What a frame holds beside its picture.", "frames.layers:layers", _layer),
    "predictors": Kind(
        "Predict the head pose.", "poses.predictors:predictors",
        lambda e: {"horizon": f"{e.horizon_ns / 1e6:g} ms", "source": e.source},
    ),
    "codecs": Kind(
        "Encode and decode what crosses the link.", "link.codec:codecs", lambda codec: {"crf": f"{codec.crf:g}"}
    ),
    "delays": Kind(
        "How the latency varies from frame to frame.", "link:delay_models",
        lambda model: {"summary": str(model.__doc__).split("\n\n", maxsplit=1)[0]},
    ),
    "recordings": Kind(
        "Head traces that are part of the package.",
        lambda: map(_of("poses").load_trace, _of("base.resources").recording_names()), _recording,
    ),
    "scales": Kind("What a study asks.", _each("study.scales", "scale_names", "load_scale"), _scale),
    "studies": Kind(
        "Plans of studies that are part of the package.",
        lambda: (_of("study.design").load_design(name, checked=False) for name in _of("study.design").study_names()),
        _study,
    ),
    "options": Kind(
        "Every option, with its limits, its default and the commands that take it.", _options, _option
    ),
}  # fmt: skip


# Of one entry, where that is not the list's name without its s.
_ONE = {"lenses": "lens", "studies": "study", "axes": "axes preset"}


@attrs.frozen
class _ListOptions(Declared):
    """What to list, and how."""

    kind: str | None = option(None, f"One of {', '.join(KINDS)}; by default these kinds are listed.", positional=True)
    name: str | None = option(None, "Show everything about this one; a headset may be a file.", positional=True)
    json: bool = option(False, "Everything, as a JSON array of objects.")
    markdown: bool = option(False, "Everything, as a Markdown table.")


@takes(_ListOptions)
def list_(said: Said) -> None:
    """List what there is to choose from: warps, fills, scenes, recordings, studies and more."""
    from ._show import in_columns, paragraph

    options = _ListOptions.of(said)
    if options.json and options.markdown:
        raise InputError("--json and --markdown: expected one of the two")
    rows = _rows(options.kind, options.name)
    columns = list(rows[0])  # the same in all
    if options.json:
        typer.echo(as_json(rows))
    elif options.markdown:
        lines = [columns, ["---"] * len(columns)]
        lines += [[f"`{row['name']}`", *(row[key].replace("|", "\\|") for key in columns[1:])] for row in rows]
        typer.echo("\n".join(f"| {' | '.join(line)} |" for line in lines))
    elif options.name is not None:
        typer.echo(rows[0]["name"])
        in_columns(((key.replace("_", " "), text) for key, text in rows[0].items() if key != "name"), indent=2)
    else:
        in_columns((row["name"], row["summary"]) for row in rows)
        if rest := ", ".join(key.replace("_", " ") for key in columns[2:]):
            typer.echo()
            paragraph(f"'hmdwarp list {options.kind} NAME' tells the rest of one: {rest}.")


def _rows(kind: str | None, name: str | None) -> list[Row]:
    """Return the rows of a list, or the one of a name; of what there are lists of for no kind."""
    if kind is None:
        return [{"name": each, "summary": of.summary} for each, of in KINDS.items()]
    if kind not in KINDS:
        raise unknown_name("list", kind, list(KINDS))
    if kind == "headsets" and name is not None:
        return describe([_of("headsets").load_headset(name)], more=_headset)  # files too
    rows = entries(kind)
    found = rows if name is None else [row for row in rows if row["name"] == name]
    if name is not None and not found:
        raise unknown_name(_ONE.get(kind, kind.removesuffix("s")), name, [row["name"] for row in rows])
    return found


COLOURS = {"ok": typer.colors.GREEN, "missing": typer.colors.RED, "optional": typer.colors.YELLOW}


@takes(JSON)
def doctor(said: Said) -> None:
    """Check what this machine has, what is missing, and how to get it.

    OpenGL and its timers, displays, and each extra.
    """
    from ._checks import MISSING, examine

    findings = examine()
    ready = all(finding.state != MISSING for finding in findings)
    if said["json"]:
        typer.echo(as_json({"replay": ready, "findings": list(map(attrs.asdict, findings))}))
    else:
        for finding in findings:
            mark = typer.style(f"{finding.state:<9}", fg=COLOURS[finding.state])
            typer.echo(f"{mark} {finding.name:<15} {finding.detail}")
            if finding.remedy:
                typer.echo(f"{'':<25} -> {finding.remedy}")
        typer.echo(f"'hmdwarp replay' {'can run here.' if ready else 'cannot run here: see the lines marked missing.'}")
    if not ready:
        raise typer.Exit(3)
