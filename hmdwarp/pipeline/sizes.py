"""Plans of a run, sizes of its pictures, how old its frames are, and their memory."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from ..base import AUTO, Choice, InputError, MachineError, PlanError, memory_bytes
from ..client import Plan, build_plan, needs_of, parse_indirect
from ..client.capability import check_client
from ..client.classes import load_client
from ..client.effects import effects
from ..client.warps import Warp
from ..frames import EyeSizes, Needs, frame_bytes
from ..geometry import Eyes, Guard, GuardBand, Pose, guarded_eyes, wide_size
from ..gpu import Gpu, check_size
from ..headsets import Headset
from ..scenes import CONVERGED, Scene
from .options import PROXY, RECORDING, PipelineOptions

Size = tuple[int, int]


def guarded_size(guard: Guard, eyes: Eyes, size: Size) -> Size:
    """Return (w, h) of the picture that the server draws for one eye.

    Errors: InputError for a guard that leaves the half-space in front of the eye, and for a
    rendered size that does not hold the shown picture.
    """
    band = GuardBand.of(guard)
    band.check(size)
    try:
        return guarded_eyes(eyes.views(Pose()), band, size)[1]
    except InputError as error:
        of = f"headset '{name}'" if (name := getattr(eyes, "name", "")) else "these eyes"
        raise InputError(f"{band} on {of}: {error}; use a smaller one") from error


def eye_sizes(guard: Guard, eyes: Eyes, size: Size) -> EyeSizes:
    """Return the sizes that every layer is derived from.

    size: of the shown picture. Errors: as guarded_size.
    """
    return EyeSizes(guarded_size(guard, eyes, size), size, tuple(view.fov for view in eyes.views(Pose())))


def rendered_entry(guard: Guard, sizes: EyeSizes, needs: Needs) -> dict[str, Any]:
    """Return the `rendered` of summary.json: what the server draws for one eye.

    size: [w, h]. pixels: how many times those of the shown picture are drawn, with those of a wide
    view that is needed. fov_deg: [across, down], of the left eye, on the whole.
    """
    (width, height), (shown_width, shown_height) = sizes.rendered, sizes.shown
    fov, size = sizes.fovs[0], sizes.shown
    left, right, down, up = fov.guarded(guard, size, sizes.rendered)[0].tangents.tolist()
    pixels = width * height + (math.prod(wide_size(fov, size)) if "wide" in needs else 0)
    degrees = [math.degrees(math.atan(high) - math.atan(low)) for low, high in ((left, right), (down, up))]
    return {
        "size": [width, height],
        "pixels": round(pixels / (shown_width * shown_height), 4),
        "fov_deg": [round(angle, 2) for angle in degrees],
    }


def rendered_text(entry: Mapping[str, Any]) -> str:
    """Return the entry in words: '1600x900, 1.41 times the pixels, 102.7 x 93.4 degrees'."""
    width, height = entry["size"]
    across, down = entry["fov_deg"]
    return f"{width}x{height}, {entry['pixels']:.2f} times the pixels, {across:.1f} x {down:.1f} degrees"


# A latency within this of a whole number of refreshes counts as that number: 16.67 ms is one
# refresh at 60 Hz, not a little more.
_SAME_REFRESH = 1e-3


def latency_ns(options: PipelineOptions) -> int:
    """Return the motion-to-photon latency that the options set."""
    return round(options.latency_ms * 1e6)


def refreshes_of(latency_ms: float, rate_hz: float) -> int:
    """Return how many refreshes after drawing a frame is shown: the first one after it arrives."""
    return math.ceil(latency_ms * 1e-3 * rate_hz - _SAME_REFRESH)


def frames_held(options: PipelineOptions, rate_hz: float, needs: Needs) -> int:
    """Return the largest number of frames alive at once.

    Counts frames in transit, the one shown, the one being drawn, and the older ones that warps
    read.
    """
    link, latency_ms = options.client_link, options.latency_ms
    sends_hz, kept = link.server_rate_hz or rate_hz, needs.others.past + needs.others.recent
    if link.is_plain:
        # Those sent since the refresh before, less the latency.
        return refreshes_of(latency_ms + 1e3 / rate_hz, sends_hz) + 1 + kept
    return link.most_under_way(latency_ns(options), sends_hz) + 2 + kept


def expected_age_ns(options: PipelineOptions, plain_ns: int, rate_hz: float) -> int:
    """Return the mean age of a frame when it is seen.

    plain_ns: the age over a link that only delays, of a frame drawn at a refresh.
    """
    link = options.client_link
    stays_ns = max(0.0, 1e9 / (link.server_rate_hz or rate_hz) - 1e9 / rate_hz)
    newest_ns = plain_ns if link.is_plain else link.delay.typical_ns(latency_ns(options))
    return newest_ns + round(stays_ns / 2)


def check_held(gpu: Gpu, options: PipelineOptions, needs: Needs, sizes: EyeSizes, rate_hz: float) -> None:
    """Check the GL size limit, and that the largest number of frames alive at once fits.

    Errors: InputError beyond the GL limit; MachineError where the frames alone would fill the
    machine's memory.
    """
    check_size(gpu.gl, sizes.shown)
    wide, high = sizes.rendered
    if max(sizes.rendered) > gpu.max_texture_size:
        found = f"{options.guard_band} makes frames of {wide}x{high} pixels"
        raise InputError(f"{found}: expected at most {gpu.max_texture_size} on each side (this GPU's limit)")
    count = frames_held(options, rate_hz, needs)
    needed = count * sum(frame_bytes(needs, sizes).values())
    if gpu.is_software and needed > memory_bytes():
        raise MachineError(
            f"--latency {options.latency_ms:g} ms keeps {count} frames of 2x{wide}x{high} pixels, "
            f"{needed / 1e9:.1f} GB, and this machine has {memory_bytes() / 1e9:.1f} GB: "
            "use a smaller --size, a shorter --latency or a lower --rate"
        )


def smaller_size(gpu: Gpu, options: PipelineOptions, size: tuple[int, int]) -> str:
    """Return what a smaller --size saves where a processor draws the default headset, "" elsewhere.

    options: as they were set. size: (w, h) of one eye, where they set none.
    """
    if not gpu.is_software or options.size or options.headset != attrs.fields(PipelineOptions).headset.default:
        return ""
    (w, h), third = size, "x".join(str(round(side / 3)) for side in size)
    return f"without a GPU {w}x{h} pixels an eye ({options.headset}) are slow: --size {third} is about 7 times as fast"


def frame_weight(options: PipelineOptions, headset: Headset, plans: Sequence[Plan]) -> dict[str, Any]:
    """Return eyes, sizes, bytes of each layer and of a frame, and how many frames there are."""
    rate_hz = options.rate_hz or headset.refresh_hz
    needs, sizes = needs_of(plans), eye_sizes(options.guard_band, headset, options.size or headset.eye_size_px)
    pictures = options.source_kind.eyes
    layers = frame_bytes(needs, sizes, {name for plan in plans for name in plan.layers}, eyes=pictures)
    return {
        "eyes": pictures,
        **rendered_entry(options.guard_band, sizes, needs),
        "layers": layers,
        "bytes": sum(layers.values()),
        "at_once": frames_held(options, rate_hz, needs),
        "latency_ms": options.latency_ms,
        "rate_hz": rate_hz,
    }


def plans_for(options: PipelineOptions, headset: Headset | None, scene: Scene | None, **beyond: Any) -> list[Plan]:
    """Return the plans of a run: one, or one for each level that it chooses from.

    beyond, errors: as build_plan_for.
    """
    if options.warp != AUTO:
        return [build_plan_for(options, headset, scene, **beyond)]
    chosen = [options.with_pair(level.warp, level.fill) for level in options.levels]
    return [build_plan_for(run, headset, scene, in_turns=True, **beyond) for run in chosen]


def build_plan_for(
    options: PipelineOptions, headset: Headset | None, scene: Scene | None, *, in_turns: bool = False, **beyond: str
) -> Plan:
    """Return the plan of a run. Without a scene, only the names are checked.

    headset: the one whose lens is corrected, or None. in_turns: other warps take turns on the
    same frames, which therefore have no whole picture for an imposter: it compensates what they do.
    beyond: distorts, takes_depth, takes_panels of build_plan.
    Errors: as build_plan; PlanError for a plan that the client cannot run, and for a warp that is
    not for the scene; InputError for a lens correction on a headset without a lens.
    """
    if options.lens != "none" and headset is not None and headset.lens is None:
        raise InputError(f"headset '{headset.name}' has no lens for --lens {options.lens}: use --lens none")
    kind = options.source_kind
    how: dict[str, Any] = {"brings": kind.layers, "fused": options.fused}
    how["scanout"] = options.scanout_ms > 0 and options.follow_scanout
    selected: tuple[str, ...] = ()
    if kind is PROXY:  # its picture is finished
        limits = "; a proxy sends the finished picture alone: show it by --warp none or rotation"
        how |= {"client_geometry": False, "distorts": beyond.get("distorts", "")}
    else:
        called_for, limits = effects.of(scene) if scene is not None else (), kind.limits
        # What recorded frames show is not known, so that what is forced is never without content.
        selected = effects.selected(options.effects, called_for, scene if kind is not RECORDING else None)
        how |= {
            "client_geometry": kind.has_geometry,
            "named": selected if in_turns else effects.forced(options.effects),
            "forced": {*selected} - {*called_for},
            "forbidden": {*called_for} - {*selected},
            "indirect": options.indirect,
            "fovea": options.fovea,
            **beyond,
        }
    try:
        plan = build_plan(selected, options.warp, options.fill, options.lens, **how)
    except PlanError as error:
        raise PlanError(f"{error}{limits}") from error
    if kind is PROXY:
        compensated = proxy_plan_for(options, scene).effects
        done = f"the proxy compensates it, as far as its warp '{options.proxy.warp}' can"
        left_out = ((name, done if name in compensated else why) for name, why in plan.left_out)
        plan = attrs.evolve(plan, left_out=tuple(left_out))
    for planned in plan.effect_passes:
        if kind.eyes < 2 and planned.needs.others.other_eye:
            name = planned.effects[0].name
            raise PlanError(f"--effects {name} looks into the other eye's picture{kind.limits}: leave it out")
    check_suited(scene, plan.choice, options.indirect)
    if options.client_name:
        check_client(plan, load_client(options.client_name))
    return plan


def proxy_plan_for(options: PipelineOptions, scene: Scene | None) -> Plan:
    """Return the plan of the proxy: it compensates all, and leaves the lens to the client.

    Errors: as build_plan_for.
    """
    return build_plan_for(options.to_proxy(), None, scene)


def check_suited(scene: Scene | None, warp: Choice[Warp], indirect: str) -> None:
    """Check that a scene calls for them. Errors: PlanError."""
    for what, choice in ((f"warp '{warp}'", warp), (f"indirect light '{indirect}'", parse_indirect(indirect))):
        if scene is not None and choice is not None and (why := choice.entry.unsuited(scene)):
            raise PlanError(f"{what} is not for scene '{scene.name}': {why}")


def plan_against(options: PipelineOptions, warp: str, fill: str) -> Plan:
    """Return the plan of a comparison on the same frames: without effects and lens.

    Errors: as build_plan.
    """
    kind = options.source_kind
    light, fovea = (CONVERGED, None) if kind is PROXY else (options.indirect, options.fovea)
    known: dict[str, Any] = {"client_geometry": kind.has_geometry, "brings": kind.layers, "indirect": light}
    return build_plan((), warp, fill, "none", fovea=fovea, **known)
