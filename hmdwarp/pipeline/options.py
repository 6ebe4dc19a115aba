"""Options of every run, checked before anything is started; and what kinds of sources there are."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Self

import attrs

from .. import client, geometry, headsets, poses
from ..base import (
    AUTO,
    DEFAULT_GUARD,
    DISPLAY,
    PICTURE,
    Declared,
    Guard,
    InputError,
    Number,
    as_path,
    group,
    guard_field,
    in_brief,
    names_in,
    one_of,
    option,
    options_of,
    parse_size,
)
from ..client.classes import PICTURE_CLIENT, load_client
from ..client.strategies import options_of_strategy, with_strategy
from ..link import CHANGES, SUM, Bandwidth, LinkOptions
from ..link.codec import Coding
from ..poses.options import DEFAULT_PREDICTOR, PREDICTORS
from ..scenes.options import EXTRAPOLATED, FORESEEN, HELD, SceneOptions
from ..sources.feed.options import FeedOptions
from ..sources.sequences.options import SequenceOptions, repair_field
from .governor import QualityLevel

# frames.layers.PICTURE, which loads NumPy: this file is read for every --help.
_PICTURE = ("rendered.colour", "rendered.inverse_depth")


def guard_band(guard: Guard | str) -> geometry.GuardBand:
    """Return the guard band of the option. Errors: InputError while it is "auto"."""
    if isinstance(guard, str):
        raise InputError("--guard auto looks at a whole trace first: give a number, or replay a recording")
    return geometry.GuardBand.of(guard)


@attrs.frozen
class SourceKind:
    """What is known of a source of frames by its options, before anything is loaded."""

    layers: tuple[str, ...] | None = None  # layers that its frames can have; None for any
    has_geometry: bool = True  # whether the client can have the scene's geometry
    has_head: bool = False  # whether it comes with a head's motion and a display of its own
    eyes: int = 2  # eyes that it has pictures of, and the truth
    sets: tuple[str, ...] = ()  # controls of a live run that it sets by itself
    limits: str = ""  # appended to the reason why a plan cannot run on its frames
    is_timed: bool = False  # whether its latency is only known once it is measured

    def refuse_change(self, name: str) -> None:
        """Raise InputError for a control that cannot change while it runs."""
        if name in self.sets:
            raise InputError(f"{name}: recorded frames set it; begin again with other options")


SCENE = SourceKind()
RECORDING = SourceKind(
    (*_PICTURE, "rendered.others"),
    has_geometry=False,
    has_head=True,
    eyes=1,
    sets=("scene", "guard", "lens", "effects"),
    limits="; recorded frames hold colour and depth of one eye, and no scene",
)
# The scene's name where a server elsewhere shows its own, whatever it is.
SERVER_SCENE = "server"
# A server elsewhere: with a scene that the options name, and with one that it has alone.
REMOTE = SourceKind(is_timed=True)
SERVED = SourceKind(
    has_geometry=False, is_timed=True, limits="; the scene is at the server: use another warp, or name it by --scene"
)
# A machine near the client that warps for it, and sends the finished picture.
PROXY = SourceKind(_PICTURE[:1])

# Options that recorded frames set, with their values; those that are refused wherever they are set;
# and why.
_OF_FRAMES = {"guard": "1", "predict": "none", "lens": "none"}
_ONLY_SAID = ("scene", "headset", "samples")
_SET_BY_FRAMES = "recorded frames are one eye's, as its camera took them; leave it out"


def with_frames(said: Mapping[str, Any], usual: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the options as set, with the defaults of recorded frames where there are any.

    usual: the default of each option. Errors: InputError for what frames leave no choice in.
    """
    if said.get("frames") is None:
        if (apart_mm := said.get("eye_distance")) is not None:
            raise InputError(f"--eye-distance {apart_mm:g} without --frames: a headset has both; leave it out")
        return said
    for name in _ONLY_SAID:
        if said.get(name) not in (None, usual.get(name)):
            raise InputError(f"--{name.replace('_', '-')} with --frames: {_SET_BY_FRAMES}")
    return {**said, **{name: value for name, value in _OF_FRAMES.items() if name in usual and said.get(name) is None}}


# Of what colour and depth allow, the most accurate in docs/results.md for its time.
DEFAULT_WARP, DEFAULT_FILL = "iterative", "memory+pyramid"
# Of frames of a caller, which need not follow each other: memory would show one in another's holes.
SINGLE_FILL = "pyramid"


def _default_fill(warp: str) -> str:
    """Return the default fill of a warp: none where it reads colour alone, to send no depth for it.

    A name that no warp has gets the usual fill; who takes it says what is wrong.
    """
    if warp in (AUTO, DEFAULT_WARP):
        return DEFAULT_FILL
    try:
        chosen = client.parse_warp(warp)
    except InputError:
        return DEFAULT_FILL
    return DEFAULT_FILL if _PICTURE[1] in chosen.entry.reads_for(chosen.settings) else "none"


@attrs.frozen
class ProxyOptions(Declared):
    """A proxy between server and client. Options that are not named here are the client's.

    Errors: InputError for a value out of range.
    """

    heading = "Proxy"
    on: bool = option(
        False,
        "Warp on a proxy, which sends finished pictures; --latency and codec are those of its link to the client.",
        name="proxy",
    )
    # Poses go the other way; as everywhere, the latency is that of both ways together.
    latency_ms: float = option(
        300.0, "Milliseconds from drawing a frame to its arrival at the proxy.", name="proxy_latency", valid=Number()
    )
    warp: str = option(DEFAULT_WARP, f"Warp on the proxy: {names_in('client/warps')}.", name="proxy_warp")
    fill: str = option(
        attrs.Factory(lambda self: _default_fill(self.warp), takes_self=True),
        f"Fill on the proxy, one or several with +. [default: {DEFAULT_FILL}; none where its warp reads colour alone]",
        kind=str,
        default=None,
        name="proxy_fill",
    )
    guard: float = option(
        DEFAULT_GUARD, "Guard band of the frames that the proxy gets.", name="proxy_guard", valid=Number(least=1.0)
    )
    codec: str = option(
        "none", f"Codec of frames to the proxy, at its quality: {names_in('link/codec/codecs')}.", name="proxy_codec"
    )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError for one without a proxy."""
        for offered in options_of(cls):
            if said.get(offered.name) not in (None, offered.default) and not said.get("proxy"):
                raise InputError(f"{offered.flag} {said[offered.name]}: there is no proxy; add --proxy")
        return super().values_of(said)

    def link(self, network: LinkOptions) -> LinkOptions:
        """Return the link from the server to the proxy.

        The server's rate belongs to it; the proxy sends a picture at each refresh. All else is the
        client's link's.
        """
        return LinkOptions(server_rate_hz=network.server_rate_hz, response=network.response)

    def longest_ms(self, network: LinkOptions) -> float:
        """Return how long frames are under way to the proxy at most, 0 without a proxy."""
        return self.link(network).longest_ns(round(self.latency_ms * 1e6)) / 1e6 if self.on else 0.0

    def __str__(self) -> str:
        passes = self.warp if self.fill == "none" else f"{self.warp} + {self.fill}"
        return f"The proxy gets frames {self.latency_ms:g} ms after they were drawn and runs {passes}"


# What tells one scene from another.
SceneKey = tuple[Hashable, ...]


def _warp_name(value: str) -> str:
    """Return the name, which the defaults of other fields read. Errors: InputError."""
    if not isinstance(value, str):
        raise InputError(f"--warp {in_brief(value)}: expected a name")
    return value


# Headings of options in help.
_RENDERING, DISPLAYED = "Rendering", "Display"
_choosing = partial(option, heading="Choosing warp and fill")
_rendering, _displayed = partial(option, heading=_RENDERING), partial(option, heading=DISPLAYED)
_NO_FEED = FeedOptions()  # of options without
# Depth of a pixel of several samples.
MOST_SAMPLES = 16


@attrs.frozen
class PipelineOptions(Declared):
    """Options of the path from the server to the eye.

    Errors: InputError for a value out of range.
    """

    usual_eye_distance_mm: ClassVar[float] = 0.0  # where recorded frames are shown
    # Whether pictures are compared with the truth, which a server elsewhere may draw.
    draws_truth: ClassVar[bool] = False

    scene: str = option(
        "room",
        f"Scene: {names_in('scenes/library')}, or a .glb, .gltf, .obj, .ply or Mitsuba .xml file.",
        study=PICTURE,
        names_files=True,
    )
    scene_options: SceneOptions = group(SceneOptions)
    frames: Path | None = option(
        None,
        "Recorded RGB-D folder used instead of a scene, shown as its camera saw it; see hmdwarp list layouts.",
        names_files=True,
        convert=attrs.converters.optional(as_path),
        study=DISPLAY,
    )
    sequence_options: SequenceOptions = group(SequenceOptions)
    repair: str = repair_field()  # of late frames; the truth is what was recorded
    # 0 for the camera's eye alone.
    eye_distance_mm: float = option(
        attrs.Factory(lambda self: self.usual_eye_distance_mm, takes_self=True),
        "Millimetres from the camera to a right eye that sees recorded frames too. [default: 0, one eye; 63 in live]",
        default=None,
        kind=float,
        valid=Number(most=500.0),
        study=DISPLAY,
        heading=SequenceOptions.heading,
    )
    latency_ms: float = option(
        200.0,
        "Milliseconds from drawing a frame to showing it; with a proxy, from the proxy's picture on.",
        valid=Number(),
    )
    # "" for a client that can run everything; warp "auto" takes the client "picture".
    client: str = _choosing(
        "",
        f"What the client can do, beyond which all is refused: {names_in('client/classes', '*.toml')}, or a .toml "
        "file. [default: everything; picture with --warp auto]",
    )
    # With settings after a colon; "" for none by name. It sets other options, see values_of.
    strategy: str = option(
        "",
        f"What crosses the link, and what the client does with it: {names_in('client/strategies')}; sets the warp.",
    )
    warp: str = option(
        DEFAULT_WARP,
        f"Warp: {names_in('client/warps')}; auto chooses warp and fill. [default: {DEFAULT_WARP}, or the strategy's]",
        default=None,
        convert=_warp_name,
    )
    budget_ms: float | None = _choosing(
        None, "Milliseconds for one eye that --warp auto keeps to.", valid=Number(above=True)
    )
    bench: Path | None = _choosing(
        None,
        "bench.json that --warp auto chooses from; by default it tries all on this run first.",
        convert=attrs.converters.optional(as_path),
    )
    fill: str = option(
        attrs.Factory(lambda self: _default_fill(self.warp), takes_self=True),
        f"Fill (inpainting): {names_in('client/fills')}, or several with +. [default: {DEFAULT_FILL}; none for a warp "
        "of colour alone]",
        kind=str,
        default=None,
    )
    # In the syntax of client.effects.EffectRegistry.selected.
    effects: str = _rendering(
        "auto",
        f"auto (what the scene calls for), none, or of {names_in('client/effects')}: NAME forces, no-NAME forbids.",
        study=PICTURE,
    )
    mirrors: str = _rendering(
        "geometry", "Draw plane mirrors by geometry, or from what is on the screen (misses stay empty).", study=PICTURE
    )
    samples: int = _rendering(
        4,
        "Samples per pixel of a scene's surfaces, in images and ground truth; 4 as engines do, 1 draws jagged edges.",
        valid=Number(least=1, most=MOST_SAMPLES),
        study=PICTURE,
    )
    # In the syntax of client.parse_indirect; only where the scene's lamps move.
    indirect: str = _rendering(
        "converged",
        "Indirect light under lamps that move: converged, or voxels[:size=64,cones=6,bounces=4,updates=10].",
    )
    client_motion: str = _rendering(
        FORESEEN,
        "What a client that draws knows of motion: all of it, the state that arrived and its speed, or it alone.",
        valid=one_of(FORESEEN, EXTRAPOLATED, HELD),
        limits=f"{FORESEEN}, {EXTRAPOLATED} or {HELD}",
        study=PICTURE,
    )
    headset: str = option(
        "quest-3",
        f"Headset to emulate: {names_in('headsets', '*.toml')}, a .toml or SteamVR's .json; NAME:ipd=63 sets its IPD.",
        study=DISPLAY,
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
    rate_hz: float | None = _displayed(
        None, "Refreshes per second; by default the display's.", valid=Number(above=True, most=1000), study=DISPLAY
    )
    # "auto" is replaced by a number before a run is built, see run.choose.
    guard: Guard | str = guard_field(
        # 1 shows pictures as drawn.
        attrs.Factory(lambda self: 1.0 if self.warp == "none" else DEFAULT_GUARD, takes_self=True),
        f" auto: as the trace needs. [default: {DEFAULT_GUARD:g}; 1 with warp none]",
        heading=_RENDERING,
    )
    rendered_size: tuple[int, int] | None = None  # in place of the guard: of recorded frames, see Source.fitted
    fovea_deg: float | None = _rendering(
        None,
        "Degrees that are sharp around the gaze (straight ahead in a trace without); by default all is sharp.",
        name="fovea",
        valid=Number(above=True, most=179),
    )
    rim: int = _rendering(
        4,
        "Display pixels that one pixel covers on each axis beyond --fovea.",
        valid=Number(least=2, most=16),  # as Fovea has it; geometry brings NumPy
    )
    fused: bool = _displayed(False, "Warp and apply the lens in one resample; for gather warps, without fill.")
    scanout_ms: float = _displayed(
        0.0, "Milliseconds that the display takes from its first row to its last.", valid=Number(most=100)
    )
    follow_scanout: bool = _displayed(
        True, "Warp each row for its own instant, where the warp can.", off="--no-follow-scanout"
    )
    network: LinkOptions = group(LinkOptions)
    coding: Coding = group(Coding)
    proxy: ProxyOptions = group(ProxyOptions)
    predict: str = _rendering(
        # None shows latency as it is.
        attrs.Factory(lambda self: "none" if self.warp == "none" else DEFAULT_PREDICTOR, takes_self=True),
        f"Head pose that the server draws for, by predictor: {', '.join(PREDICTORS)}. "
        f"[default: {DEFAULT_PREDICTOR}; none with warp none]",
        valid=lambda *given: given[-1] in PREDICTORS or poses.predictors.get(given[-1]),
        kind=str,
        default=None,
    )
    horizon_ms: float | None = _rendering(
        None, "Milliseconds to predict ahead at most; by default the predictor's own.", valid=Number()
    )
    # What warp "auto" chooses from: of a live run, by the benchmark.
    levels: tuple[QualityLevel, ...] = ()

    def __attrs_post_init__(self) -> None:
        if self.source_kind is not RECORDING:
            refuse_without_frames(self.sequence_options, self.repair)
        for is_so, text in self._conflicts():
            if is_so:
                raise InputError(text)

    def _conflicts(self) -> Iterator[tuple[bool, str]]:
        """Yield each thing that cannot be: whether it is so, and the message."""
        is_auto, is_foveated = self.warp == AUTO, self.fovea_deg is not None
        changes = self.network.send == CHANGES
        if self.source_kind.is_timed:
            yield self.frames is not None, "--connect with --frames: frames come from one of them; leave the other out"
            yield self.network.response == SUM, "--connect with --response: the server's times are real; leave it out"
            yield self.proxy.on or is_auto, "--connect with --proxy or --warp auto: not supported, leave them out"
        for text, is_set in {
            "guard auto": self.guard == AUTO,
            f"predict {self.predict}": self.predict != "none",
            f"lens {self.lens}": self.lens not in ("none", AUTO),
            "proxy": self.proxy.on,
            f"scanout {self.scanout_ms:g} ms": self.scanout_ms > 0,
            "warp auto": is_auto,
            f"fovea {self.fovea_deg or 0:g}": is_foveated,
        }.items():
            yield self.source_kind is RECORDING and is_set, f"--{text} with --frames: {_SET_BY_FRAMES}"
        is_said = self.rim != attrs.fields(type(self)).rim.default
        yield is_said and not is_foveated, f"--rim {self.rim}: frames are as sharp everywhere; it is for --fovea"
        yield is_foveated and changes, "--fovea with --send changes: eyes move where nothing else does; leave one out"
        sets = options_of_strategy(self.strategy) if self.strategy else {}
        for name in sorted(sets.keys() & {"warp", "fill", "effects", "indirect", "proxy"}):
            own = self.proxy.on if name == "proxy" else getattr(self, name)
            how = f"it sets {name} to '{sets[name]}'; {type(self).__name__}.of({{'strategy': ..}}) does so"
            yield own != sets[name], f"strategy '{self.strategy}' with {name} '{own}': {how}"
        yield self.proxy.on and is_auto, "--proxy with --warp auto: name what the client does, none or rotation"
        yield self.proxy.on and changes, "--proxy with --send changes: its picture always changes; leave one out"
        yield is_auto and self.budget_ms is None, "--warp auto chooses what fits into a budget: add --budget MS"
        yield is_auto and self.fused, "--fused with --warp auto: its warps are measured before the lens; leave one out"
        budget, name = self.budget_ms, f"'{self.warp}' is chosen already"
        yield not is_auto and budget is not None, f"--budget {budget} ms: only --warp auto keeps to a budget; {name}"
        yield not is_auto and self.bench is not None, f"--bench: only --warp auto chooses from a benchmark; {name}"

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError."""
        usual = {option.name: option.default for option in options_of(cls)}
        said = with_strategy(with_frames(said, usual))
        values = super().values_of(said)
        if said.get("client"):  # its limits are those of what was not set
            device = load_client(said["client"])
            if said.get("warp") == AUTO and said.get("budget") is None and math.isfinite(device.budget_ms):
                values["budget_ms"] = device.budget_ms
            coded = values["coding"].codec != "none" if "coding" in values else False
            if coded and not said.get("bandwidth") and math.isfinite(device.download_mbit_s):
                values["network"] = attrs.evolve(values["network"], bandwidth=Bandwidth(device.download_mbit_s))
        warp, fill = said.get("warp") or DEFAULT_WARP, said.get("fill")
        if warp == AUTO and fill is not None:
            raise InputError(f"--fill {fill}: --warp auto chooses the fill too; leave one of the two out")
        # A warp fused with the lens has none.
        return {**values, "fill": fill or ("none" if said.get("fused") else _default_fill(warp))}

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
        if address := getattr(self, "feed", _NO_FEED).connect:
            return SERVED if self.scene in (SERVER_SCENE, address) else REMOTE
        return RECORDING if self.frames is not None else PROXY if self.proxy.on else SCENE

    @property
    def client_name(self) -> str:
        """The client whose abilities count; "" where anything goes."""
        return self.client or (PICTURE_CLIENT if self.warp == AUTO else "")

    @property
    def client_link(self) -> LinkOptions:
        """The link to the client: the network, less what belongs to the one before a proxy."""
        return attrs.evolve(self.network, server_rate_hz=None) if self.proxy.on else self.network

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
        return self.guard_factors if self.rendered_size is None else geometry.GuardBand(size=self.rendered_size)

    @property
    def guard_factors(self) -> geometry.GuardBand:
        """The guard band in factors, whatever pixels are drawn. Errors: as guard_band."""
        return guard_band(self.guard)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the results must know of the options, one sentence each."""
        told = f"The latency of {self.latency_ms:g} ms is"
        total = f"{self.total_latency_ms:g} ms from the server. {self.proxy}."
        on_top = "rendering, encoding, queue, size over bandwidth and decoding come on top (response sum)."
        coarser = f"Frames are coarser away from the gaze, which is straight ahead in a trace without: {self.fovea}."
        known = {
            f"{told} that from the proxy to the client: {total}": self.proxy.on,
            self.light_note: bool(self.light_note),
            coarser: self.fovea is not None,
            f"{told} the network's alone: {on_top}": self.network.response == SUM,
        }
        return tuple(text for text, is_so in known.items() if is_so)

    @property
    def light_note(self) -> str:
        """Say how pictures are lit, if other than the truth; "" if alike."""
        if self.indirect == attrs.fields(type(self)).indirect.default:
            return ""
        return f"Pictures have indirect light by {self.indirect}, the truth has converged light."

    def with_pair(self, warp: str, fill: str) -> Self:
        """Return the options with this warp and fill, in place of an automatic choice."""
        return attrs.evolve(self, warp=warp, fill=fill, client=self.client_name, budget_ms=None, bench=None, levels=())

    def to_proxy(self) -> Self:
        """Return the options of the way to the proxy, where pictures end without a lens."""
        proxy = self.proxy
        own = {name: getattr(proxy, name) for name in ("warp", "fill", "guard", "latency_ms")}
        own |= {"network": proxy.link(self.network), "coding": Coding(proxy.codec), "proxy": ProxyOptions()}
        own |= {"strategy": "", "client": "", "rendered_size": None, "lens": "none", "fused": False, "scanout_ms": 0.0}
        return attrs.evolve(self, **own)

    def over(self, latency_ms: float, network: LinkOptions, coding: Coding) -> Self:
        """Return the options over a link that others share; what they set of it themselves stays.

        latency_ms: of the whole way, on which a proxy stands where there is one.
        """
        before_ms = 0.75 * latency_ms if self.proxy.on else 0.0  # the proxy's part, as by default
        return attrs.evolve(
            self,
            latency_ms=latency_ms - before_ms,
            proxy=attrs.evolve(self.proxy, latency_ms=before_ms) if self.proxy.on else self.proxy,
            network=_beside(network, self.network),
            coding=_beside(coding, self.coding),
        )


def refuse_without_frames(facts: SequenceOptions, repair: str) -> None:
    """Raise InputError for what is stated of recorded frames, where there are none."""
    facts.refuse_unused()
    if repair != "none":
        raise InputError(f"--repair {repair}: a rendered scene lacks no depth; it is for --frames")


def _beside(shared: Any, own: Any) -> Any:
    """Return the shared group of options, with those of the own one that are not as usual."""
    usual = attrs.asdict(type(own)(), recurse=False)
    sets = {name: value for name, value in attrs.asdict(own, recurse=False).items() if value != usual[name]}
    return attrs.evolve(shared, **sets)
