"""Export of a study: one long table, questionnaires, a BIDS data set with the motion of the heads.

Participants are random words, and no dates leave the machine.

Names are in __init__.pyi; each loads its module at first use.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
