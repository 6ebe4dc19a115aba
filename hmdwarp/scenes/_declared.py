"""What a scene calls for, read off its meshes: nobody sets it by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .effects import SceneEffect

if TYPE_CHECKING:
    from ._model import Mesh, Scene


# Of a texture's 8-bit alpha: what is as good as 0, or as 1; and the share of texels between that edges make up at most.
ALPHA_OF_NOTHING, MOST_EDGES = 12, 0.08


def effects_of(scene: Scene) -> SceneEffect:
    """All that any of its meshes calls for."""
    found = SceneEffect.NONE
    for mesh in scene.meshes:
        found |= _effects_of_mesh(scene, mesh)
    return found


def is_cutout(scene: Scene, mesh: Mesh) -> bool:
    """Whether a sheet lets all light pass or none, but for its edges: then it has a depth of its own in the picture."""
    if not mesh.material.see_through or mesh.texture < 0 or mesh.material.opacity < 1:
        return False
    alpha = scene.textures[mesh.texture].image[..., 3:]
    between = (alpha > ALPHA_OF_NOTHING) & (alpha < 255 - ALPHA_OF_NOTHING)
    return alpha.size > 0 and float(between.mean()) < MOST_EDGES


def _effects_of_mesh(scene: Scene, mesh: Mesh) -> SceneEffect:
    material, found = mesh.material, SceneEffect.NONE
    calls = (
        (SceneEffect.PLANAR_REFLECTIONS, material.reflectivity > 0 and not material.curved),
        (SceneEffect.GLOSSY_REFLECTIONS, material.normal_map >= 0),
        (SceneEffect.CURVED_REFLECTIONS, material.curved),
        (SceneEffect.RIGID_MOTION, mesh.body > 0),
        (SceneEffect.SOFT_MOTION, mesh.deformation is not None),
        (
            SceneEffect.TRANSPARENCY,
            material.see_through and not is_cutout(scene, mesh),
        ),  # a fence has a depth of its own
        (SceneEffect.OVERLAY, material.head_locked),
    )
    for effect, called_for in calls:
        if called_for:
            found |= effect
    return found
