"""The server: draw a scene for the eyes into a Frame. It knows no latency, warps or lenses."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
