"""Plane mirrors with a normal map: a floor that is polished but not even."""

from ...frames import Mirrored, Needs
from ..effect_passes import Reflections
from . import Effect, effects

effects.register(
    Effect(
        name="glossy_reflections",
        order=11,
        summary="the normal map disturbs where the warped reflection is sampled, for the head pose now",
        applies=lambda _, mesh: mesh.material.normal_map >= 0,
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.PLANE),
        without="uneven mirrors show an even reflection",
        source="the 2014 thesis's order of steps (warp the even reflection, then disturb it); "
        "tests/reference/reflection.py",
        refines="planar_reflections",
    )
)
