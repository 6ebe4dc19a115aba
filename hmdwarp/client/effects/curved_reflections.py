"""Curved mirrors: a chrome ball."""

from ...frames import Mirrored, Needs
from ..effect_passes import Reflections
from . import Effect, effects

effects.register(
    Effect(
        name="curved_reflections",
        order=12,
        summary="what a curved mirror shows is warped at the depth of its image by the mirror formula: half the "
        "radius for far things",
        applies=lambda _, mesh: mesh.material.curved,
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.CURVED),
        without="reflections stick to the ball, as if painted on it",
        source="Coddington 1829 (oblique pencils), see hmdwarp/geometry/view.py; Lochmann et al. 2014",
    )
)
