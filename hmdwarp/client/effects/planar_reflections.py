"""Plane mirrors: a wall mirror, a polished floor."""

from ...frames import Mirrored, Needs
from ..effect_passes import Reflections
from . import Effect, effects

effects.register(
    Effect(
        name="planar_reflections",
        order=10,
        summary="what plane mirrors show is a layer with the depth of the whole path, and is warped as the world "
        "behind the mirror",
        applies=lambda _, mesh: mesh.material.reflectivity > 0 and not mesh.material.curved,
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.PLANE),
        without="reflections stick to the mirrors, as if painted on them",
        source="Akenine-Moeller et al. 2018, Real-Time Rendering, 11.6.2 (mirrored geometry); Lochmann et al. 2014, "
        "Real-time Reflective "
        "and Refractive Novel-view Synthesis (warping by the length of the path)",
    )
)
