from . import sequences as sequences
