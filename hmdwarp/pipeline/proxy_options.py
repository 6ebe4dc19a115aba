"""Kinds of sources of frames, and the options of one: a proxy that warps for the client."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import attrs

from .. import client
from ..errors import InputError
from ..link import LinkOptions, StageTimes
from ..link.codec import Coding
from ..options import AUTO, DEFAULT_GUARD, Declared, Number, names_in, option, options_of
from ..poses.options import DEFAULT_PREDICTOR

# frames.layers.PICTURE, which loads NumPy: this file is read for every --help.
_PICTURE = ("rendered.colour", "rendered.inverse_depth")


@attrs.frozen
class SourceKind:
    """What is known of a source of frames by its options, before anything is loaded."""

    name: str
    # Layers that its frames can have; None for any.
    layers: tuple[str, ...] | None = None
    # Whether the client can have the scene's geometry.
    has_geometry: bool = True
    # Whether it comes with a head's motion and a display of its own.
    has_head: bool = False
    # Eyes that it has pictures of, and the truth.
    eyes: int = 2
    # Controls of a live run that it sets by itself.
    sets: tuple[str, ...] = ()
    # Appended to the reason why a plan cannot run on its frames.
    limits: str = ""
    # Whether its latency is only known once it is measured.
    is_timed: bool = False

    def refuse_change(self, name: str) -> None:
        """Raise InputError for a control that cannot change while it runs."""
        if name in self.sets:
            raise InputError(f"{name}: recorded frames set it; begin again with other options")


SCENE = SourceKind("scene")
RECORDING = SourceKind(
    "recording",
    (*_PICTURE, "rendered.others"),
    has_geometry=False,
    has_head=True,
    eyes=1,
    sets=("scene", "guard", "lens", "effects"),
    limits="; recorded frames hold colour and depth of one eye, and no scene",
)
# The scene's name where a server elsewhere shows its own, whatever it is.
SERVER_SCENE = "server"
# A server elsewhere.
REMOTE = SourceKind("remote", is_timed=True)
# A machine near the client that warps for it, and sends the finished picture.
PROXY = SourceKind("proxy", _PICTURE[:1])

_DEFAULTS = {"guard": "1", "predict": "none", "lens": "none"}
_WHY_NOT = {
    "scene": "recorded frames take the place of a scene",
    "headset": "the display is the camera, and --guard 1.5 shows the middle of what it saw",
    "rendered_size": "a recording has as many pixels as were taken; --guard says how much of it is shown",
    "wide": "a recording has no second view",
    "predict": "each frame was taken where the camera was",
    "lens": "the display is the camera, which has no lens to correct",
    "proxy": "a proxy draws for heads of its own",
    "scanout": "the truth of each row was not recorded",
    "guard": "a factor says how much of the recording is shown, such as 1.5",
    "samples": "its edges are as they were recorded",
    "fovea": "they came as sharp everywhere",
    "warp": "its benchmark draws a scene; name a warp",
}
_ONLY_SAID = ("scene", "headset", "rendered_size", "wide", "samples")


def with_frames(said: Mapping[str, Any], usual: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the options as set, with the defaults of recorded frames where there are any.

    usual: the default of each option. Errors: InputError for what frames leave no choice in.
    """
    if said.get("frames") is None:
        if said.get("eye_distance") is not None:
            raise InputError(
                f"--eye-distance {said['eye_distance']:g} without --frames: a scene is drawn for both eyes of the "
                "headset; leave it out"
            )
        return said
    for name in _ONLY_SAID:
        if said.get(name) not in (None, usual.get(name)):
            raise InputError(f"--{name.replace('_', '-')} with --frames: {_WHY_NOT[name]}; leave it out")
    return {**said, **{name: value for name, value in _DEFAULTS.items() if name in usual and said.get(name) is None}}


def refuse_with_frames(found: Mapping[str, tuple[str, bool]]) -> None:
    """Raise InputError for the first option that recorded frames leave no choice in.

    found: by option, its text and whether it is anything but what frames set.
    """
    for name, (text, is_set) in found.items():
        if is_set:
            raise InputError(f"{text} with --frames: {_WHY_NOT[name]}; leave it out")


# Of what colour and depth allow, the most accurate in docs/results.md for its time.
DEFAULT_WARP, DEFAULT_FILL = "iterative", "memory+pyramid"
# Of frames of a caller, which need not follow each other: memory would show one in another's holes.
SINGLE_FILL = "pyramid"
_DEPTH = "rendered.inverse_depth"


def default_fill(warp: str) -> str:
    """Return the default fill of a warp: none where it reads colour alone, to send no depth for it.

    A name that no warp has gets the usual fill; who takes it says what is wrong.
    """
    if warp in (AUTO, DEFAULT_WARP):
        return DEFAULT_FILL
    try:
        chosen = client.parse_warp(warp)
    except InputError:
        return DEFAULT_FILL
    return DEFAULT_FILL if _DEPTH in chosen.entry.reads_for(chosen.settings) else "none"


def default_guard(warp: str) -> float:
    """Return the default guard band of a warp: 1 for none, which shows pictures as drawn."""
    return 1.0 if warp == "none" else DEFAULT_GUARD


def default_predictor(warp: str) -> str:
    """Return the default predictor of a warp: none for none, which shows latency as it is."""
    return "none" if warp == "none" else DEFAULT_PREDICTOR


# Of the whole way, the part before the proxy, where only the whole is given.
_SHARE = 0.75


@attrs.frozen
class ProxyOptions(Declared):
    """A proxy between server and client. Options that are not named here are the client's.

    Errors: InputError for a value out of range.
    """

    heading = "Proxy"
    on: bool = option(
        False,
        "A proxy warps: it gets frames from the server, and sends the client the finished picture for the newest pose "
        "that it knows. --latency, codec, loss and bandwidth are then those of the link to the client.",
        name="proxy",
    )
    # Poses go the other way; as everywhere, the latency is that of both ways together.
    latency_ms: float = option(
        300.0,
        "Milliseconds from drawing a frame on the server to its arrival at the proxy.",
        name="proxy_latency",
        valid=Number(),
    )
    warp: str = option(DEFAULT_WARP, f"Warp on the proxy: {names_in('client/warps')}.", name="proxy_warp")
    fill: str = option(
        attrs.Factory(lambda self: default_fill(self.warp), takes_self=True),
        f"Fill on the proxy: {names_in('client/fills')}, or several with +. [default: {DEFAULT_FILL}; none where its "
        "warp reads colour alone]",
        kind=str,
        default=None,
        name="proxy_fill",
    )
    guard: float = option(
        DEFAULT_GUARD,
        "Guard band of the frames from the server, around the picture that the proxy sends.",
        name="proxy_guard",
        valid=Number(least=1.0),
    )
    codec: str = option(
        "none",
        f"Codec between server and proxy, at its own quality: {names_in('link/codec/codecs')}.",
        name="proxy_codec",
    )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError for one without a proxy."""
        for offered in options_of(cls):
            if said.get(offered.name) not in (None, offered.default) and not said.get("proxy"):
                raise InputError(
                    f"{offered.flag} {said[offered.name]}: there is no proxy; add --proxy, or leave it out"
                )
        return super().values_of(said)

    def within(self, total_ms: float) -> Self:
        """Return the same proxy on a way of that latency, which it divides as by default: 3 to 1.

        What remains of the total is that of the link to the client.
        """
        return attrs.evolve(self, latency_ms=_SHARE * total_ms)

    @property
    def coding(self) -> Coding:
        """How frames are coded on their way to the proxy."""
        return Coding(self.codec)

    def links(self, network: LinkOptions) -> tuple[LinkOptions, LinkOptions]:
        """Return the link from the server to the proxy, and the one from there to the client.

        The server's rate, and the time that it takes to render, belong to the first; the proxy
        sends a picture at each refresh, and takes the time that it needs. All else is the second's.
        """
        stages = network.response
        first = LinkOptions(
            server_rate_hz=network.server_rate_hz,
            response=None if stages is None else StageTimes(render=stages.render),
        )
        last = attrs.evolve(
            network, server_rate_hz=None, response=None if stages is None else attrs.evolve(stages, render=None)
        )
        return first, last

    def longest_ms(self, network: LinkOptions) -> float:
        """Return how long frames are under way to the proxy at most, 0 without a proxy."""
        first, _ = self.links(network)
        return first.longest_ns(round(self.latency_ms * 1e6)) / 1e6 if self.on else 0.0

    def __str__(self) -> str:
        passes = self.warp if self.fill == "none" else f"{self.warp} + {self.fill}"
        return f"The proxy gets frames {self.latency_ms:g} ms after they were drawn and runs {passes}"
