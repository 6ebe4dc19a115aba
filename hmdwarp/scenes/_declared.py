"""What a scene calls for, read off its meshes: nobody sets it by hand."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import TYPE_CHECKING

from .effects import SceneEffect

if TYPE_CHECKING:
    from ._model import Mesh, Scene


def effects_of(scene: Scene) -> SceneEffect:
    """All that any of its meshes calls for."""
    return reduce(or_, map(_effects_of_mesh, scene.meshes), SceneEffect.NONE)


def _effects_of_mesh(mesh: Mesh) -> SceneEffect:
    material, found = mesh.material, SceneEffect.NONE
    calls = (
        (SceneEffect.PLANAR_REFLECTIONS, material.reflectivity > 0 and not material.curved),
        (SceneEffect.GLOSSY_REFLECTIONS, material.normal_map >= 0),
        (SceneEffect.CURVED_REFLECTIONS, material.curved),
        (SceneEffect.RIGID_MOTION, mesh.body > 0),
        (SceneEffect.SOFT_MOTION, mesh.deformation is not None),
        (SceneEffect.TRANSPARENCY, material.see_through),
        (SceneEffect.OVERLAY, material.head_locked),
    )
    for effect, called_for in calls:
        if called_for:
            found |= effect
    return found
