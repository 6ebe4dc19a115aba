"""Errors of the shown picture against the truth: quality, holes, flicker; in worker processes.

A metric is one file in metrics/library. Pictures are sRGB-encoded, (h, w, 3), top row first; holes
are black pixels and count.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
