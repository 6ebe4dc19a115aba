"""What a scene calls for beyond static, opaque, matt geometry, and how an experiment forces or forbids one of it."""

from __future__ import annotations

import enum

from ..errors import InputError
from ..registry import unknown_name


class SceneEffect(enum.Flag):
    """Effects a scene declares from its own content; the frame carries them and the plan alone looks at them.

    Each has an entry of its name, in small letters, in client/effects.
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
_BY_NAME = {effect.name.lower(): effect for effect in EVERY_EFFECT}
AUTO, NONE, FORBID = "auto", "none", "no-"


def effect_names(effects: SceneEffect) -> list[str]:
    """As they are written on the command line and in summary.json."""
    return [effect.name.lower() for effect in effects]


def asked_effects(text: str, declared: SceneEffect) -> SceneEffect:
    """What a run compensates: what the scene declares, changed by `text`.

    text: "auto" changes nothing, "none" forbids all; else names with commas between, each forced, or forbidden by "no-" before it.
    A forced effect that the scene has nothing of costs its pass and changes no picture.
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
            f"effects '{text}': {', '.join(effect_names(both))} both forced and forbidden; say one of the two"
        )
    return (declared | forced) & ~forbidden


def _effect(name: str) -> SceneEffect:
    if name not in _BY_NAME:
        raise unknown_name("effect", name, [*_BY_NAME, *(f"{FORBID}{known}" for known in _BY_NAME), AUTO, NONE])
    return _BY_NAME[name]
