"""A window on the desktop in place of the headset, and a head moved by mouse and keys.

Names are in __init__.pyi; each loads its module at first use, so that layout and pacing need no
glfw.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
