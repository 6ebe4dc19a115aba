"""Effects: content that a plain warp gets wrong. One file each, registered by name.

An effect's file says which meshes call for it, which layers frames carry for it, and which pass
compensates it.
"""

from ._base import Effect, EffectPass, EffectRegistry, RenderedPass, ShownPass, Tools

effects = EffectRegistry("effect", __name__, columns="pass=made_by.name without source")

__all__ = ["Effect", "EffectPass", "EffectRegistry", "RenderedPass", "ShownPass", "Tools", "effects"]
