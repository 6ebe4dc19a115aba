"""Effects: content that a plain warp gets wrong. By family, registered by name.

An entry says which meshes call for it, which layers frames carry for it, and which pass
compensates it.
"""

from ._base import EXPANDED, Effect, EffectPass, EffectRegistry, ExpandPass, RenderedPass, ShownPass, Tools

_MODULES = {
    **dict.fromkeys(
        ("planar_reflections", "glossy_reflections", "curved_reflections", "reflections_from_pictures"), "mirrors"
    ),
    **dict.fromkeys(("rigid_motion", "soft_motion"), "motion"),
    **dict.fromkeys(("panels", "occluded_panels"), "text"),
    **dict.fromkeys(("overlay", "transparency", "light_only"), "compositing"),
}
effects = EffectRegistry("effect", __name__, columns="pass=made_by.name without source", modules=_MODULES)

__all__ = [
    "EXPANDED",
    "ExpandPass",
    "Effect",
    "EffectPass",
    "EffectRegistry",
    "RenderedPass",
    "ShownPass",
    "Tools",
    "effects",
]
