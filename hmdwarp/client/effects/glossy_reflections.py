"""Plane mirrors with a normal map: a floor that is polished but not even."""

from __future__ import annotations

from ...frames import Mirrored, Needs
from ...scenes.effects import SceneEffect
from . import Effect, effects
from ._reflection import Reflections

effects.register(
    Effect(
        flag=SceneEffect.GLOSSY_REFLECTIONS,
        summary="the normal map disturbs where the warped reflection is looked into, from where the head is now",
        made_by=Reflections,
        needs=Needs(reflection=Mirrored.PLANE),
        without="uneven mirrors show an even reflection",
        source="the 2014 thesis's order of steps (warp the even reflection, then disturb it); hmdwarp/reference/reflection.py",
        refines="planar_reflections",
    )
)
