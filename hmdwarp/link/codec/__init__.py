"""Coding of frames for the network: light by a video codec, all else by codes of our own.

Names are in __init__.pyi; each loads its module at first use: declaring an option loads no codec.
"""

import lazy_loader

from .codecs import codecs as codecs  # imported at once: the module of the same name would take its place later

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
