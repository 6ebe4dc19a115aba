"""The client: warp the newest rendered frame to what the eye should see now.

Warps, fills, effects and lenses are registries in packages of their own. Names are in __init__.pyi;
each loads its module at first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
