"""Respondents: simulated participants, who answer in rehearsals and in tests.

Names are in __init__.pyi; each loads its module at first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
