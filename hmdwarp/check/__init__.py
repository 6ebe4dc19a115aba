"""Which conventions make the frames of somebody else agree with each other."""

from .decide import Decision, decide, differences
from .reading import Reading
from .search import Search
from .stated import LEFT, RIGHT, Stated, StatedFrame

__all__ = ["LEFT", "RIGHT", "Decision", "Reading", "Search", "Stated", "StatedFrame", "decide", "differences"]
