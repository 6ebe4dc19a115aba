"""Warp one RGB-D frame of the caller's own in one call, without scene or headset.

Names are in __init__.pyi; each loads its module at first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
