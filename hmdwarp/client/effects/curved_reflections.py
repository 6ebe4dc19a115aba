"""Curved mirrors: a chrome ball."""

from __future__ import annotations

from ...frames import Mirrored, Needs
from ...scenes.effects import SceneEffect
from . import Effect, effects
from ._reflection import Reflections

effects.register(
    Effect(
        flag=SceneEffect.CURVED_REFLECTIONS,
        summary="what a curved mirror shows is warped at the depth of its image by the mirror formula: half the radius for far things",
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.CURVED),
        without="reflections stick to the ball, as if painted on it",
        source="Coddington 1829 (oblique pencils), see hmdwarp/geometry/mirror.py; Lochmann et al. 2014",
    )
)
