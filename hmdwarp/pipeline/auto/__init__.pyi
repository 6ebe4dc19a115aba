from .governor import Governor as Governor
from .levels import QualityLevel as QualityLevel
from .levels import choose as choose
from .levels import levels_from as levels_from
from .levels import settings_of as settings_of
