"""Scenes: triangles, textures and baked light in plain arrays, and the effects they call for.

Every public module of `library` is one scene; a new scene is one new file there.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
