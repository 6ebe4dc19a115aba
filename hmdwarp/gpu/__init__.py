"""OpenGL basics, independent of headsets: context, shader loader, textures, timers."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
