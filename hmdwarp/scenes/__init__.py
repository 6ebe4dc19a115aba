"""Scenes: triangles, textures and baked light in plain arrays, and the effects they call for.

Every table of `library` is one scene; a new scene is a table there, and a model.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
