"""Mirrors: plane, uneven and curved ones, and what pictures alone tell of them."""

from ...frames import Mirrored, Needs, Others
from ..effect_passes import MirroredPass, Reflections
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

effects.register(
    Effect(
        name="reflections_from_pictures",
        order=15,
        summary="the other eye's picture and two older ones tell what mirrors show, and how far behind them; "
        "no data on mirrors are needed",
        applies=lambda scene, mesh: True,
        by_name_only=True,
        instead_of=("planar_reflections", "glossy_reflections", "curved_reflections"),
        made_by=MirroredPass,
        needs=Needs(others=Others(past=2, spacing_ns=300_000_000, other_eye=True)),
        without="reflections stick to the mirrors, as if painted on them",
        source="Sinha et al. 2012, Image-Based Rendering for Scenes with Reflections; Weiss 2001, Deriving Intrinsic "
        "Images from Image Sequences; Szeliski et al. 2000, Layer Extraction from Multiple Images Containing "
        "Reflections and Transparency",
    )
)
