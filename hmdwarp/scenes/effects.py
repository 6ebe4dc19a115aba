"""Effects beyond static, opaque, matt geometry: those of a scene, and those a run compensates."""

from __future__ import annotations

import enum

from ..errors import InputError
from ..registry import unknown_name


class SceneEffect(enum.Flag):
    """Effects that follow from a scene's content; the frame carries them, only the plan reads them.

    Each has an entry of its name, in lower case, in client/effects.
    """

    NONE = 0
    PLANAR_REFLECTIONS = enum.auto()
    GLOSSY_REFLECTIONS = enum.auto()
    CURVED_REFLECTIONS = enum.auto()
    RIGID_MOTION = enum.auto()
    SOFT_MOTION = enum.auto()
    TRANSPARENCY = enum.auto()
    OVERLAY = enum.auto()


EVERY_EFFECT = ~SceneEffect.NONE
_BY_NAME = {str(effect.name).lower(): effect for effect in EVERY_EFFECT}
AUTO, NONE, FORBID = "auto", "none", "no-"


def effect_names(effects: SceneEffect) -> list[str]:
    """Return their names as on the command line and in summary.json."""
    return [str(effect.name).lower() for effect in effects]


def asked_effects(text: str, declared: SceneEffect) -> SceneEffect:
    """Return the effects that a run compensates: those the scene declares, changed by `text`.

    text: "auto" changes nothing, "none" forbids all. Else names separated by commas, each forced,
    or forbidden by "no-" before it. Forcing an effect without content costs its pass and changes no
    picture.
    Errors: UnknownNameError for a name; InputError for one that is both forced and forbidden.
    """
    forced = forbidden = SceneEffect.NONE
    for word in filter(None, (part.strip() for part in text.split(","))):
        if word == AUTO:
            continue
        if word == NONE:
            forbidden |= EVERY_EFFECT
        elif word.startswith(FORBID):
            forbidden |= _effect(word.removeprefix(FORBID))
        else:
            forced |= _effect(word)
    if both := forced & forbidden:
        raise InputError(
            f"effects '{text}': {', '.join(effect_names(both))} both forced and forbidden; choose one of the two"
        )
    return (declared | forced) & ~forbidden


def _effect(name: str) -> SceneEffect:
    if name not in _BY_NAME:
        raise unknown_name("effect", name, [*_BY_NAME, *(f"{FORBID}{known}" for known in _BY_NAME), AUTO, NONE])
    return _BY_NAME[name]
