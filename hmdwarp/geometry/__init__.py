"""Float64 geometry without a GPU: poses, views, the warp map between two views, depth conventions.

This package does not depend on the rest of the program. Conventions: docs/conventions.md.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
