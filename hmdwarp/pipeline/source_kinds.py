"""Kinds of sources of frames: what each can give, and what it leaves no choice in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from ..errors import InputError

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
REMOTE = SourceKind("remote")
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
    "warp": "its benchmark draws a scene; name a warp",
}
_ONLY_SAID = ("scene", "headset", "rendered_size", "wide")


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
