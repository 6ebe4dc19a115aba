"""Panels of text and menus, sampled once at the newest pose."""

from ...frames import Needs
from ...frames.layers.panels import PanelDelivery
from ..effect_passes import PanelsPass
from . import Effect, effects

effects.register(
    Effect(
        name="panels",
        order=85,
        summary="text and menus cross once, as pictures with a place and a size, and are sampled once at the newest "
        "pose",
        applies=lambda *_: False,
        in_scene=lambda scene: bool(scene.panels),
        made_by=PanelsPass,
        needs=Needs(panels=frozenset({PanelDelivery()})),
        without="text is resampled twice, blurred by the codec, and moves by the warp's errors",
        fuses=True,
        for_display=True,
        source="OpenXR 1.0, XrCompositionLayerQuad; Heckbert 1989, Fundamentals of Texture Mapping and Image Warping",
    )
)

effects.register(
    Effect(
        name="occluded_panels",
        order=86,
        summary="what is nearer in the shown picture hides those panels that ask for it",
        applies=lambda *_: False,
        in_scene=lambda scene: any(panel.occluded for panel in scene.panels),
        made_by=PanelsPass,
        needs=Needs(panels=frozenset({PanelDelivery()})),
        without="panels lie over what is nearer than they are",
        source="Porter and Duff 1984, Compositing Digital Images; Duff 1985, Compositing 3-D Rendered Images",
        refines="panels",
    )
)
