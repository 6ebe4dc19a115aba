"""What recorded frames in place of a scene set by themselves, and what they leave no choice in."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from ..errors import InputError

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
    "warp": "its benchmark draws a scene; name a warp",
}
_ONLY_SAID = ("scene", "headset", "rendered_size", "wide")


def with_frames(said: Mapping[str, Any], usual: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return what was said, with the defaults of recorded frames where there are any.

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


def refuse_set(asked: Mapping[str, tuple[str, bool]]) -> None:
    """Raise InputError for the first option that recorded frames leave no choice in.

    asked: by option, what was said and whether it is anything but what frames set.
    """
    for name, (said, is_asked) in asked.items():
        if is_asked:
            raise InputError(f"{said} with --frames: {_WHY_NOT[name]}; leave it out")


def refuse_change(name: str, names: Collection[str] = ("scene", "guard", "lens", "effects")) -> None:
    """Raise InputError for what a run over recorded frames cannot change while it runs."""
    if name in names:
        raise InputError(f"{name}: recorded frames set it; begin again with other options")
