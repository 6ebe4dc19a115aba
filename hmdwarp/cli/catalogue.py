"""What every registry holds, as plain rows.

For `hmdwarp list`, the README's tables and other programs.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any

import attrs

from .. import geometry, headsets, poses
from ..options import Option
from ..poses.assumptions import Assumption, By
from ..study import design, scales

_SIZES = {"rendered": "of the rendered picture", "shown": "of the shown picture", "own": "its own"}


def entries(kind: str) -> list[dict[str, str]]:
    """Rows of one kind, each with at least `name` and `summary`.

    kind: a key of `listing.KINDS`.
    """
    return _MAKERS[kind]()


def _said(entry: object, *names: str) -> dict[str, str]:
    """Return the texts of an entry under their own names."""
    return {name: getattr(entry, name) for name in ("name", "summary", *names)}


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _settings(entry: Any) -> str:
    return ", ".join(f"{field.name}={field.default}" for field in attrs.fields(entry.Settings)) or "none"


def _strategies() -> list[dict[str, str]]:
    from ..client.strategies import strategies

    return [
        {
            **_said(strategy, "crosses", "client", "late"),
            "sets": ", ".join(f"{name}={value}" for name, value in strategy.options("").items()) or "nothing",
            "classes": ", ".join(f"class-{number}" for number in strategy.classes),
            "source": strategy.source,
        }
        for strategy in strategies
    ]


def _warps() -> list[dict[str, str]]:
    from ..client.variants import every_baseline, parse_warp
    from ..client.warps import warps
    from ..run.combinations import OUTSIDE, missing

    rows = [
        {
            **_said(warp, "kind"),
            "reads": ", ".join(warp.reads),
            "settings": _settings(warp),
            "fused_with_the_lens": _yes(warp.fuses),
            "follows_scanout": _yes(warp.scans_out),
            "exact_when": warp.exact_when,
            "gets_wrong": warp.gets_wrong,
            "does_as": "none",
            "source": warp.source,
        }
        for warp in warps
    ]
    own = {row["name"]: row for row in rows}
    for text, system in every_baseline().items():
        choice = parse_warp(text)
        values = ", ".join(f"{name}={value}" for name, value in attrs.asdict(choice.settings).items())
        of = own[choice.entry.name]
        rows.append(
            of | {"name": text, "summary": f"as {system}: {of['summary']}", "settings": values, "does_as": system}
        )
    there = [name for name in OUTSIDE if not missing(name)]
    return rows + [_outside_row(name, OUTSIDE[name], list(rows[0])) for name in there]


def _outside_row(name: str, system: str, keys: list[str]) -> dict[str, str]:
    said = {
        "name": name,
        "summary": f"as {system}: its own warp by depth, on the CPU, for 'hmdwarp bench' only",
        "reads": "rendered.colour, rendered.inverse_depth",
        "fused_with_the_lens": "no",
        "follows_scanout": "no",
        "does_as": system,
        "source": system,
    }
    return {key: said.get(key, "none") for key in keys}


def _fills() -> list[dict[str, str]]:
    from ..client.fills import fills

    return [
        {
            **_said(fill),
            "reads": ", ".join(fill.reads),
            "settings": _settings(fill),
            "leaves_no_hole": _yes(fill.complete),
            "source": fill.source,
        }
        for fill in fills
    ]


def _repairs() -> list[dict[str, str]]:
    from ..sources.repairs import repairs

    return [{**_said(repair, "needs"), "settings": _settings(repair), "source": repair.source} for repair in repairs]


def _metrics() -> list[dict[str, str]]:
    from ..metrics import metrics

    return [
        {
            "name": metric.name,
            "summary": metric.description,
            "unit": "%" if metric.percent_of else metric.unit or "none",
            "better": "more" if metric.higher_is_better else "less",
            "needs": ", ".join(sorted(str(need.name).lower().replace("_", " ") for need in metric.needs)) or "nothing",
        }
        for metric in metrics
    ]


def _predictors() -> list[dict[str, str]]:
    from ..poses.predictors import predictors

    return [
        {
            **_said(each),
            "horizon": f"{each.horizon_ns / 1e6:g} ms",
            "same_as": each.alias_of or "none",
            "source": each.source,
        }
        for each in predictors
    ]


def _codecs() -> list[dict[str, str]]:
    from ..link.codec import codecs

    return [{**_said(each), "encoder": each.encoder or "none", "crf": f"{each.crf:g}"} for each in codecs]


def _delays() -> list[dict[str, str]]:
    from ..link import delay_models

    return [{"name": each.name, "summary": str(each.__doc__).split("\n\n", maxsplit=1)[0]} for each in delay_models]


def _effects() -> list[dict[str, str]]:
    from ..client.effects import effects

    return [{**_said(e), "pass": e.made_by.name, "without": e.without, "source": e.source} for e in effects]


def _lenses() -> list[dict[str, str]]:
    from ..client.lens import lenses

    return [_said(lens, "source") for lens in lenses]


def _scenes() -> list[dict[str, str]]:
    from ..scenes import scenes

    return [{**_said(scene), "effects": ", ".join(scene.effects) or "none"} for scene in scenes]


def _headsets() -> list[dict[str, str]]:
    return [headset_row(name) for name in headsets.headset_names()]


def _axes() -> list[dict[str, str]]:
    from ..poses.reading.axes import load_preset, preset_names

    presets = map(load_preset, preset_names())
    return [{**_said(preset), "axes": preset.axes.words(), "source": preset.source} for preset in presets]


def _clients() -> list[dict[str, str]]:
    from ..client.classes import client_names, load_client

    return [
        {
            **_said(client, "scene"),
            "compute_shaders": _yes(client.compute_shaders),
            "layers": "all" if client.more_layers else "colour and depth",
            "budget": _limit(client.budget_ms, "ms an eye"),
            "decoder": _limit(client.decoder_mpx_s, "Mpx/s"),
            "download": _limit(client.download_mbit_s, "Mbit/s"),
            "source": client.source or "none",
        }
        for client in map(load_client, client_names())
    ]


def _limit(value: float, unit: str) -> str:
    return f"{value:g} {unit}" if math.isfinite(value) else "no limit"


def headset_row(name: str) -> dict[str, str]:
    """Return the row of one headset. name: as load_headset takes it. Errors: InputError."""
    headset = headsets.load_headset(name)
    return {
        **_said(headset),
        "eye_size": "x".join(map(str, headset.eye_size_px)),
        "refresh_hz": f"{headset.refresh_hz:g}",
        **headset_facts(headset),
        "lens": headset.lens.model if headset.lens is not None else "none",
        "emulated": headset.emulated or "all of it",
        "source": headset.source,
    }


def headset_facts(headset: headsets.Headset) -> dict[str, str]:
    """Return what the eyes of a headset see, in words."""
    sides = dict(zip(("left", "right"), headset.eyes, strict=False))
    least, most = (limit * 1e3 for limit in headset.ipd_range_m)
    return {
        **{f"{side}_fov_deg": _angles(eye.fov) for side, eye in sides.items()},
        "cant_deg": _both(headset.cants_deg, ".1f"),
        "across_deg": f"{headset.across_deg:.1f}",
        "overlap_deg": f"{headset.overlap_deg:.1f}",
        "pixels_per_degree": f"{headset.left_fov.pixels_per_degree(headset.eye_size_px):.1f}",
        "hidden_share": _both([eye.hidden_share for eye in headset.eyes], ".1%"),
        "ipd_mm": f"{headset.ipd_m * 1e3:.1f}, --ipd {least:g} to {most:g}",
    }


def _angles(fov: geometry.Fov) -> str:
    angles = zip(("left", "right", "down", "up"), map(math.degrees, attrs.astuple(fov)), strict=True)
    return ", ".join(f"{side} {angle:.1f}" for side, angle in angles)


def _both(values: Sequence[float], form: str) -> str:
    """Return one value where both eyes have the same, else those of each."""
    texts = [format(value, form) for value in values]
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts)


def _formats() -> list[dict[str, str]]:
    from ..poses.formats import formats

    rows = []
    for entry in formats:
        facts = {fact.what: f"{fact.value} ({_stated_by(fact)})" for fact in entry.assumes()}
        rows.append({**_said(entry), "can_write": _yes(entry.writes), **facts})
    return rows


def _layouts() -> list[dict[str, str]]:
    from ..sources.sequences import FACTS, readers

    rows = []
    for reader in readers:
        stated = {assume.what: f"{assume.value} ({_stated_by(assume)})" for assume in reader.assumes}
        facts = {what.replace(" ", "_"): stated.get(what, "") for what in FACTS}
        rows.append({**_said(reader), **facts})
    return rows


def _stated_by(fact: Assumption) -> str:
    if fact.by not in (By.USER, By.NOBODY):
        return f"by the {fact.by}"
    return f"stated by {fact.option}" if fact.by is By.USER else f"not stated{fact.option and f': {fact.option}'}"


def _recordings() -> list[dict[str, str]]:
    from ..resources import recording_names

    return [_recording_row(poses.load_trace(name).track) for name in recording_names()]


def _recording_row(track: poses.PoseTrack) -> dict[str, str]:
    # As 'hmdwarp trace synth' writes it into the file.
    made_by, _, what = track.origin.rpartition("; ")
    return {
        "name": track.name,
        "summary": what,
        "seconds": f"{track.duration_ns * 1e-9:.1f}",
        "rate_hz": f"{track.rate_hz:.0f}",
        "origin": made_by or track.origin,
    }


def _scales() -> list[dict[str, str]]:
    return [_scale_row(scales.load_scale(name)) for name in scales.scale_names()]


def _scale_row(scale: scales.Scale) -> dict[str, str]:
    items = [item.described for item in scale.items]
    return {
        "name": scale.name,
        "summary": f"{scale.title}: {scale.least:g} to {scale.most:g}, {scale.direction}"
        if scale.has_answers
        else f"{scale.title}: each question has its own answers",
        "kind": scale.kind,
        "step": f"{scale.step:g}",
        "anchors": "; ".join(f"{value:g} = {words}" for value, words in scale.anchors.items())
        or "those of each question",
        "asks": items[0] if len(items) == 1 else f"{len(items)} items: {', '.join(items)}",
        "scores": ", ".join(score.name for score in scale.scores) or "the answer itself",
        "source": scale.source,
    }


def _studies() -> list[dict[str, str]]:
    return [_study_row(design.load_design(name, checked=False)) for name in design.study_names()]


def _study_row(study: design.Design) -> dict[str, str]:
    parts = [f"{part.name}: {', '.join(condition.name for condition in part.conditions)}" for part in study.parts]
    return {
        "name": study.name,
        "summary": study.title,
        "scales": ", ".join(scale.name for scale in study.scales),
        "conditions": "; ".join(parts),
        "order": study.order,
    }


def _layers() -> list[dict[str, str]]:
    from ..frames.layers import layers
    from ..pipeline.options import PipelineOptions
    from ..pipeline.sizes import eye_sizes

    headset = headsets.load_headset(PipelineOptions().headset)
    sizes = eye_sizes(1.0, headset, headset.eye_size_px)
    rows = []
    for layer in layers:
        per, count = "frame" if layer.per_frame else "eye", layer.bytes(layer.something, sizes)
        row = {
            **_said(layer),
            "format": " + ".join(layer.formats) or "none: no picture",
            "size": _SIZES[layer.size_class] if layer.formats else "none",
            "bytes": f"{count / 1e6:.1f} MB for each {per} of {headset.name}" if count else "none",
            "carried": f"once for each {per}, {'always' if layer.always else 'where a pass reads it'}",
            "drawn_by": layer.drawn_by or ("the scene's own passes" if layer.always else "nothing: the client has it"),
            "coded_as": " + ".join(layer.coded_as()) if count else "nothing",
        }
        rows.append(row)
    return rows


def _options() -> list[dict[str, str]]:
    from ._app import options_of_commands

    takers: dict[Option, list[str]] = {}
    for command, options in options_of_commands().items():
        for option in options:
            takers.setdefault(option, []).append(command)
    first = {option.name: option for option in reversed(takers)}
    return [
        _option_row(option, option.name if first[option.name] is option else f"{names[0]} {option.name}", names)
        for option, names in takers.items()
    ]


def _option_row(option: Option, name: str, commands: list[str]) -> dict[str, str]:
    default = {False: "no", True: "yes"}.get(option.default) if option.kind is bool else str(option.default)
    if option.default is None and (said := re.search(r"\[default: (.*)\]", option.help)):
        default = said[1]
    return {
        "name": name.replace("_", "-"),
        "summary": option.help,
        "flag": option.metavar or option.name.upper() if option.positional else option.flag,
        "value": option.limits
        or {bool: "yes or no", int: "a whole number", float: "a number"}.get(option.kind, "a text"),
        "unit": option.unit or "none",
        "default": "none" if default in (None, "", "None") else default,
        "commands": ", ".join(commands),
        "in_a_study": "no" if "live" not in commands else "yes" if option.in_study else f"no: {option.study}",
    }


_MAKERS: dict[str, Callable[[], list[dict[str, str]]]] = {
    maker.__name__.removeprefix("_"): maker
    for maker in (
        *(_strategies, _warps, _fills, _repairs, _metrics, _effects, _lenses, _scenes, _headsets, _clients, _axes),
        *(_formats, _layers, _layouts, _predictors, _codecs, _delays, _recordings, _scales, _studies, _options),
    )
}
