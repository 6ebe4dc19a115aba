"""What mirrors show, found in pictures alone: for frames without data of their mirrors."""

from ...frames import Needs, Others
from ..effect_passes import MirroredPass
from . import Effect, effects

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
