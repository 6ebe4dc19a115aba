"""hmdwarp: latency compensation for head-mounted displays.

    out = hmdwarp.warp_image(colour, depth_m, rendered=View(...), shown=View(...), warp="forward")

Names are in __init__.pyi; each loads its module at first use, so this import costs nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
