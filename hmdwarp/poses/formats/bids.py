"""Motion of the Brain Imaging Data Structure: a table described by files next to it."""

from ..assumptions import By
from . import TraceFormat, formats


class Bids(TraceFormat):
    """Source: BIDS specification 1.9, "Motion"."""

    name = "bids"
    kind = "bids"
    summary = "BIDS motion.tsv, described by its channels.tsv; seconds, units and axes as stated"
    order = "quaternion by its components, or RotationOrder"
    facts = {"unit": "s", "direction_by": By.FORMAT}


formats.register(Bids())
