"""Displays for live pictures: OpenXR, a desktop window, or offscreen.

The loop does not depend on them; hmdwarp.run depends only on the protocol.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
