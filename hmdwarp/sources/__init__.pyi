from . import feed as feed
from . import sequences as sequences
