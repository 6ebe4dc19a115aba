"""Options of every run, checked before anything is started."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

import attrs

from .. import geometry, headsets, poses
from ..client.classes import PICTURE_CLIENT, load_client
from ..client.strategies import options_of_strategy, with_strategy
from ..errors import InputError, in_brief
from ..link import CHANGES, RESOLUTION, Bandwidth, LinkOptions
from ..link.codec import Coding
from ..link.options import DROP
from ..options import (
    AUTO,
    DEFAULT_GUARD,
    DISPLAY,
    PICTURE,
    Declared,
    Guard,
    Number,
    Option,
    as_path,
    check_one_guard,
    group,
    guard_band,
    guard_field,
    names_in,
    one_of,
    option,
    options_of,
    parse_size,
    rendered_size_field,
)
from ..poses.options import DEFAULT_PREDICTOR, PREDICTORS
from ..scenes.options import EXTRAPOLATED, FORESEEN, HELD, SceneOptions
from ..sources.sequences.options import SequenceOptions, repair_field
from .levels import QualityLevel
from .proxy_options import (
    DEFAULT_FILL,
    DEFAULT_WARP,
    PROXY,
    RECORDING,
    REMOTE,
    SCENE,
    ProxyOptions,
    SourceKind,
    default_fill,
    default_guard,
    default_predictor,
    refuse_with_frames,
    with_frames,
)

# What tells one scene from another.
SceneKey = tuple[Hashable, ...]


def _warp_name(value: str) -> str:
    """Return the name, which the defaults of other fields read. Errors: InputError."""
    if not isinstance(value, str):
        raise InputError(f"--warp {in_brief(value)}: expected a name")
    return value


def _fill_for(warp: str, fill: str | None, *, fused: bool, wide: bool) -> str:
    """Return the chosen fill, or the default one: none for a warp fused with the lens.

    wide: run that fill first. Errors: InputError for a fill with warp auto, which chooses its own.
    """
    if warp == AUTO and (fill is not None or wide):
        asked = "--wide" if fill is None else f"--fill {fill}"
        raise InputError(f"{asked}: --warp auto chooses the fill too; leave one of the two out")
    chosen = fill if fill is not None else "none" if fused else default_fill(warp)
    if not wide:
        return chosen
    return "wide" if chosen == "none" else f"wide+{chosen}"


HELD_GAZE, PREDICTED_GAZE = "held", "predicted"
# Headings of options in help.
AUTOMATIC, RENDERING, DISPLAYED = "Choosing warp and fill", "Rendering", "Display"
RECORDED = SequenceOptions.heading
# Depth of a pixel of several samples.
MOST_SAMPLES = 16
_IPD = Option(
    "Millimetres between the pupils, within the headset's range; by default the headset's own.",
    float,
    name="ipd",
    unit="mm",
    study=DISPLAY,
)
_WIDE = Option(
    "A second, wide and coarse view with every frame: fill wide before the others.",
    bool,
    False,
    name="wide",
    heading=RENDERING,
)


@attrs.frozen
class PipelineOptions(Declared):
    """Options of the path from the server to the eye.

    Errors: InputError for a value out of range.
    """

    # Where recorded frames are shown.
    usual_eye_distance_mm: ClassVar[float] = 0.0
    # Whether pictures are compared with the truth, which a server elsewhere may draw.
    draws_truth: ClassVar[bool] = False

    scene: str = option(
        "room",
        f"Scene: {names_in('scenes/library')}, or a .glb, .gltf, .obj, .ply or Mitsuba .xml file.",
        study=PICTURE,
        names_files=True,
    )
    # Where the scene is a file.
    scene_options: SceneOptions = group(SceneOptions)
    frames: Path | None = option(
        None,
        "Recorded RGB-D folder used instead of a scene, shown as its camera saw it; see hmdwarp list layouts.",
        names_files=True,
        convert=attrs.converters.optional(as_path),
        study=DISPLAY,
    )
    sequence_options: SequenceOptions = group(SequenceOptions)
    # Of late frames; the truth is what was recorded.
    repair: str = repair_field()
    # 0 for the camera's eye alone.
    eye_distance_mm: float = option(
        attrs.Factory(lambda self: self.usual_eye_distance_mm, takes_self=True),
        "Show recorded frames to a second eye too, this many millimetres to the right of the camera. [default: 0, one "
        "eye; 63 in live]",
        default=None,
        kind=float,
        valid=Number(most=500.0),
        study=DISPLAY,
        heading=RECORDED,
    )
    # From drawing a frame to showing it.
    latency_ms: float = option(
        200.0,
        "Milliseconds from drawing a frame to showing it; with a proxy, from the proxy's picture on.",
        valid=Number(),
    )
    # "" for a client that can run everything; warp "auto" takes the client "picture".
    client: str = option(
        "",
        f"What the client can do: {names_in('client/classes', '*.toml')}, or a .toml file; what it lacks is refused, "
        "and never chosen. By default all, and picture where --warp auto chooses.",
        heading=AUTOMATIC,
    )
    # With settings after a colon; "" for none by name. It sets other options, see values_of.
    strategy: str = option(
        "",
        f"What crosses the link, and what the client does with it: {names_in('client/strategies')}. Sets the warp and "
        "what else it takes.",
    )
    warp: str = option(
        DEFAULT_WARP,
        f"Warp: {names_in('client/warps')}; or auto, which chooses warp and fill. [default: {DEFAULT_WARP}, or the "
        "strategy's]",
        default=None,
        convert=_warp_name,
    )
    # Per eye; for warp "auto" only, which takes the most accurate warp and fill within it.
    budget_ms: float | None = option(
        None, "Milliseconds for one eye that --warp auto keeps to.", valid=Number(above=True), heading=AUTOMATIC
    )
    # The bench.json that warp "auto" chooses from; None measures all warps on the run's own frames
    # first.
    bench: Path | None = option(
        None,
        "bench.json that --warp auto chooses from; by default it tries all on this run first.",
        convert=attrs.converters.optional(as_path),
        heading=AUTOMATIC,
    )
    # Ignored by warp "auto", which chooses its own.
    fill: str = option(
        attrs.Factory(lambda self: default_fill(self.warp), takes_self=True),
        f"Fill (inpainting): {names_in('client/fills')}, or several with +. [default: {DEFAULT_FILL}; none where "
        "the warp reads colour alone; auto's own]",
        kind=str,
        default=None,
    )
    # In the syntax of client.effects.EffectRegistry.selected.
    effects: str = option(
        "auto",
        f"auto (what the scene calls for), none, or of {names_in('client/effects')}: NAME forces, no-NAME forbids.",
        study=PICTURE,
        heading=RENDERING,
    )
    # How the server draws plane mirrors, see server.Server.
    mirrors: str = option(
        "geometry",
        "Draw plane mirrors by geometry, or from what is on the screen (misses stay empty).",
        study=PICTURE,
        heading=RENDERING,
    )
    samples: int = option(
        4,
        "Samples of each pixel of a scene's surfaces, in pictures and truth: colour is their mean in linear light. 4 "
        "is what engines send, 1 draws jagged edges.",
        valid=Number(least=1, most=MOST_SAMPLES),
        study=PICTURE,
        heading=RENDERING,
    )
    # In the syntax of client.parse_indirect; only where the scene's lamps move.
    indirect: str = option(
        "converged",
        "Light between surfaces under lamps that move: converged, or voxels[:size=64,cones=6,bounces=4,updates=10], "
        "a grid that all views share.",
        heading=RENDERING,
    )
    # Where scenes move; what is drawn on the server knows all of it.
    client_motion: str = option(
        FORESEEN,
        "What a client that draws knows of bodies, lamps and vertices that move: all of it beforehand, the last state "
        "that arrived and its speed, or that state alone.",
        valid=one_of(FORESEEN, EXTRAPOLATED, HELD),
        limits=f"{FORESEEN}, {EXTRAPOLATED} or {HELD}",
        study=PICTURE,
        heading=RENDERING,
    )
    headset: str = option(
        "quest-3",
        f"Headset that is emulated: {names_in('headsets', '*.toml')}, a .toml file, or SteamVR's .json.",
        study=DISPLAY,
        beside=(_IPD,),
    )
    lens: str = option(
        attrs.Factory(lambda self: getattr(headsets.load_headset(self.headset).lens, "model", "none"), takes_self=True),
        f"Lens correction: {names_in('client/lens')}; by default the headset's own.",
        kind=str,
        default=None,
        study=PICTURE,
    )
    # (w, h) of one eye.
    size: tuple[int, int] | None = option(
        None, "Pixels of one eye; by default the display's.", metavar="WxH", parse=parse_size, study=DISPLAY
    )
    # None for the display's own rate.
    rate_hz: float | None = option(
        None,
        "Refreshes per second; by default the display's.",
        valid=Number(above=True, most=1000),
        study=DISPLAY,
        heading=DISPLAYED,
    )
    # "auto" is replaced by a number before a run is built, see run.choose.
    guard: Guard | str = guard_field(
        attrs.Factory(lambda self: default_guard(self.warp), takes_self=True),
        f" auto: as the trace needs. [default: {DEFAULT_GUARD:g}; 1 with warp none]",
        beside=(_WIDE,),  # the other way to fill beyond the border
        heading=RENDERING,
    )
    rendered_size: tuple[int, int] | None = rendered_size_field(RENDERING)
    # None for frames that are as sharp everywhere.
    fovea_deg: float | None = option(
        None,
        "Degrees across that are sharp in frames, where the eye looks, or straight ahead if the trace has no gaze; the "
        "rest is coarser. By default all is sharp.",
        name="fovea",
        valid=Number(above=True, most=179),
        heading=RENDERING,
    )
    rim: int = option(
        4,
        "Display pixels that one pixel covers on each axis beyond --fovea.",
        valid=Number(least=2, most=16),  # as Fovea has it; geometry brings NumPy
        heading=RENDERING,
    )
    gaze: str = option(
        HELD_GAZE,
        "Where --fovea is: at the gaze that the server knows when it draws, or at the one predicted for display.",
        valid=one_of(HELD_GAZE, PREDICTED_GAZE),
        limits=f"{HELD_GAZE} or {PREDICTED_GAZE}",
        heading=RENDERING,
    )
    fused: bool = option(
        False, "Warp and apply the lens in one resample; for gather warps, without fill.", heading=DISPLAYED
    )
    # From the display's first row to its last; 0 for a global display.
    scanout_ms: float = option(
        0.0,
        "Milliseconds that the display takes from its first row to its last.",
        valid=Number(most=100),
        heading=DISPLAYED,
    )
    # Warps that cannot follow show all rows as in the middle of the scan-out.
    follow_scanout: bool = option(
        True,
        "Warp each row for its own instant, where the warp can, or all for the middle one.",
        off="--no-follow-scanout",
        heading=DISPLAYED,
    )
    # Delay variation, loss and queueing, on top of the latency.
    network: LinkOptions = group(LinkOptions)
    # Encoding and decoding on the link.
    coding: Coding = group(Coding)
    # What stands between the server and that link.
    proxy: ProxyOptions = group(ProxyOptions)
    predict: str = option(
        attrs.Factory(lambda self: default_predictor(self.warp), takes_self=True),
        f"Head pose that the server draws for, by predictor: {', '.join(PREDICTORS)}; on is cautious, "
        f"and cav constant_velocity. [default: {DEFAULT_PREDICTOR}; none with warp none]",
        valid=lambda *given: given[-1] in PREDICTORS or poses.predictors.get(given[-1]),
        kind=str,
        default=None,
        heading=RENDERING,
    )
    horizon_ms: float | None = option(
        None,
        "Milliseconds to predict ahead at most; by default the predictor's own.",
        valid=Number(),
        heading=RENDERING,
    )
    # What warp "auto" chooses from: of a live run, by the benchmark.
    levels: tuple[QualityLevel, ...] = ()

    def __attrs_post_init__(self) -> None:
        if self.source_kind is REMOTE:
            self._check_remote()
        if self.source_kind is RECORDING:
            self._check_recorded()
        else:
            refuse_without_frames(self.sequence_options, self.repair)
        fields = attrs.fields(type(self))
        for name in ("rim", "gaze"):
            if self.fovea_deg is None and (found := getattr(self, name)) != getattr(fields, name).default:
                raise InputError(f"--{name} {found}: frames are as sharp everywhere; it is for --fovea")
        if self.fovea_deg is not None and self.network.send == CHANGES:
            raise InputError(
                f"--fovea with --send {CHANGES}: the eyes move where nothing else does; leave one of the two out"
            )
        self._check_strategy()
        if self.proxy.on:
            self._check_proxy()
        if self.warp == AUTO:
            self._check_auto()
        elif self.budget_ms is not None:
            raise InputError(
                f"--budget {float(self.budget_ms):g} ms: only --warp auto keeps to a budget; '{self.warp}' takes what "
                "it takes"
            )
        elif self.bench is not None:
            raise InputError(
                f"--bench {self.bench}: only --warp auto chooses from a benchmark; '{self.warp}' is chosen already"
            )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError."""
        usual = {option.name: option.default for option in options_of(cls)}
        said = with_strategy(with_frames(with_headset(said, usual["headset"]), usual), usual)
        values = _with_limits_of_client(super().values_of(said), said)
        check_one_guard(said)
        fused, wide = bool(said.get("fused")), bool(said.get("wide"))
        values["fill"] = _fill_for(said.get("warp") or DEFAULT_WARP, said.get("fill"), fused=fused, wide=wide)
        return values

    @property
    def fovea(self) -> geometry.Fovea | None:
        """What frames have sharp, None for all of them."""
        return None if self.fovea_deg is None else geometry.Fovea(self.fovea_deg, self.rim)

    @property
    def scene_key(self) -> SceneKey:
        """What tells the scene, or the recorded frames in its place, from others."""
        return self.scene, self.scene_options, self.frames, self.sequence_options, self.repair

    @property
    def source_kind(self) -> SourceKind:
        """What gives the frames, as far as it is known before it is opened."""
        return RECORDING if self.frames is not None else PROXY if self.proxy.on else SCENE

    @property
    def client_name(self) -> str:
        """The client whose abilities count; "" where anything goes."""
        return self.client or (PICTURE_CLIENT if self.warp == AUTO else "")

    @property
    def client_link(self) -> LinkOptions:
        """The link to the client: the network, less what belongs to the one before a proxy."""
        return self.proxy.links(self.network)[1] if self.proxy.on else self.network

    @property
    def total_latency_ms(self) -> float:
        """From drawing a frame to showing it, over both links where there is a proxy."""
        return self.latency_ms + (self.proxy.latency_ms if self.proxy.on else 0.0)

    @property
    def horizon_ns(self) -> int | None:
        """How far to predict ahead at most; None for the predictor's own."""
        return None if self.horizon_ms is None else round(self.horizon_ms * 1e6)

    @property
    def guard_band(self) -> geometry.GuardBand:
        """The guard band. Errors: InputError while it is "auto"."""
        return guard_band(self)

    @property
    def guard_factors(self) -> geometry.GuardBand:
        """The guard band in factors, whatever pixels are drawn. Errors: as guard_band."""
        return guard_band(attrs.evolve(self, rendered_size=None))

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the results must know of the options, one sentence each."""
        told, found = f"The latency of {self.latency_ms:g} ms is", []
        if self.proxy.on:
            found.append(
                f"{told} that from the proxy to the client: {self.total_latency_ms:g} ms from the server. {self.proxy}."
            )
        if self.light_note:
            found.append(self.light_note)
        if self.fovea is not None:
            found.append(
                f"Frames are coarser away from the gaze that is {self.gaze} when they are drawn: {self.fovea}; it is "
                "straight ahead where the head's motion has no gaze."
            )
        if self.network.response is not None:
            found.append(
                f"{told} the network's alone: rendering, encoding, queue, size over bandwidth and decoding come on top "
                "(response sum)."
            )
        return tuple(found)

    @property
    def light_note(self) -> str:
        """Say how pictures are lit, if other than the truth; "" if alike."""
        if self.indirect == attrs.fields(type(self)).indirect.default:
            return ""
        return f"Pictures have indirect light by {self.indirect}, the truth has converged light."

    def with_pair(self, warp: str, fill: str) -> Self:
        """Return the options with this warp and fill, in place of an automatic choice."""
        return attrs.evolve(self, warp=warp, fill=fill, client=self.client_name, budget_ms=None, bench=None, levels=())

    def over(self, latency_ms: float, network: LinkOptions, coding: Coding) -> Self:
        """Return the options over a link that others share; what they set of it themselves stays.

        latency_ms: of the whole way, on which a proxy stands where there is one.
        """
        proxy = self.proxy.within(latency_ms) if self.proxy.on else self.proxy
        return attrs.evolve(
            self,
            latency_ms=latency_ms - (proxy.latency_ms if proxy.on else 0.0),
            proxy=proxy,
            network=_beside(network, self.network),
            coding=_beside(coding, self.coding),
        )

    def _check_recorded(self) -> None:
        asked = {
            "guard": (f"--guard {self.guard}", self.guard == AUTO),
            "predict": (f"--predict {self.predict}", self.predict != "none"),
            "lens": (f"--lens {self.lens}", self.lens not in ("none", AUTO)),
            "proxy": ("--proxy", self.proxy.on),
            "scanout": (f"--scanout {self.scanout_ms:g} ms", self.scanout_ms > 0),
            "warp": (f"--warp {self.warp}", self.warp == AUTO),
            "fovea": (f"--fovea {self.fovea_deg or 0:g}", self.fovea_deg is not None),
        }
        refuse_with_frames(asked)

    def _check_remote(self) -> None:
        if self.frames is not None:
            raise InputError(
                "--connect with --frames: frames come from the server or the folder; leave one of them out"
            )
        if self.network.response is not None or self.network.overload != DROP:
            raise InputError(
                "--connect with --response or --overload: the server's times are the real ones; leave them out"
            )
        if self.proxy.on or self.warp == AUTO:
            raise InputError("--connect with --proxy or --warp auto: not supported, leave them out")

    def _check_strategy(self) -> None:
        sets = options_of_strategy(self.strategy) if self.strategy else {}
        values = {"warp": self.warp, "fill": self.fill, "effects": self.effects, "proxy": self.proxy.on}
        values["indirect"] = self.indirect
        for name in sorted(sets.keys() & values.keys()):
            found = values[name]
            if found != sets[name]:
                raise InputError(
                    f"strategy '{self.strategy}' with {name} '{found}': it sets {name} to '{sets[name]}'; "
                    f"{type(self).__name__}.of({{'strategy': ..}}) does so"
                )

    def _check_proxy(self) -> None:
        if self.warp == AUTO:
            raise InputError(
                f"--proxy with --warp {AUTO}: the proxy warps; name what the client does, none or rotation"
            )
        if self.network.send == CHANGES:
            raise InputError(
                f"--proxy with --send {CHANGES}: the proxy's picture changes with every frame that it gets; leave one "
                "of the two out"
            )
        if self.network.overload == RESOLUTION:
            raise InputError(
                f"--proxy with --overload {RESOLUTION}: the proxy makes pictures of one size; leave one out"
            )

    def _check_auto(self) -> None:
        if self.budget_ms is None:
            raise InputError(
                "--warp auto chooses what fits into a budget: say how many milliseconds there are for one eye "
                "(--budget MS)"
            )
        if self.fused:
            raise InputError(
                "--fused with --warp auto: its warps must have the picture between warp and lens, to be measured; "
                "leave one out"
            )


def refuse_without_frames(facts: SequenceOptions, repair: str) -> None:
    """Raise InputError for what is stated of recorded frames, where there are none."""
    facts.refuse_unused()
    if repair != "none":
        raise InputError(f"--repair {repair}: a rendered scene lacks no depth; it is for --frames")


def _beside(shared: Any, own: Any) -> Any:
    """Return the shared group of options, with those of the own one that are not as usual."""
    usual = type(own)()
    names = [field.name for field in attrs.fields(type(own))]
    sets = {name: value for name in names if (value := getattr(own, name)) != getattr(usual, name)}
    return attrs.evolve(shared, **sets)


def _with_limits_of_client(values: dict[str, Any], said: Mapping[str, Any]) -> dict[str, Any]:
    """Add the client's budget for warp auto and, for frames that are coded, its download.

    Options that were set take precedence.
    """
    if not said.get("client"):
        return values
    client = load_client(said["client"])
    if said.get("warp") == AUTO and said.get("budget") is None and math.isfinite(client.budget_ms):
        values["budget_ms"] = client.budget_ms
    coded = values["coding"].codec != "none" if "coding" in values else False
    if coded and not said.get("bandwidth") and math.isfinite(client.download_mbit_s):
        values["network"] = attrs.evolve(values["network"], bandwidth=Bandwidth(client.download_mbit_s))
    return values


def with_headset(said: Mapping[str, Any], headset: str) -> Mapping[str, Any]:
    """Return the options with --ipd as part of the headset; headset: where none is named."""
    if said.get("ipd") is None:
        return said
    return {**said, "headset": f"{said.get('headset') or headset}:ipd={said['ipd']:g}"}
