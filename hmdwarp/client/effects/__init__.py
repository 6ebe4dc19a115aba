"""Effects: one file each, registered by the name of its SceneEffect in small letters; each says by which pass it is compensated."""

from ...registry import Registry
from ._base import Effect, EffectPass, LatePass, ShownPass, Tools

effects: Registry[Effect] = Registry("effect", __name__)

__all__ = ["Effect", "EffectPass", "LatePass", "ShownPass", "Tools", "effects"]
