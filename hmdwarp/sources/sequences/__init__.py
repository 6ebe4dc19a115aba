"""Recorded frames with depth: one file of them, or a sequence that a reader recognises.

sequence = sequences.open("folder")
for frame in sequence.frames:
frame.colour, frame.depth_m, frame.pose, frame.fov, frame.time_ns
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
