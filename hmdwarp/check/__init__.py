"""Which conventions make the frames of somebody else agree with each other."""

from .answer import Answer, Finding, check
from .decide import differences
from .reading import Reading
from .stated import LEFT, RIGHT, Stated, StatedFrame

__all__ = ["LEFT", "RIGHT", "Answer", "Finding", "Reading", "Stated", "StatedFrame", "check", "differences"]
