"""CSV exports of OptiTrack's Motive: rigid bodies under seven lines of header."""

from ..assumptions import By
from . import TraceFormat, formats


class Motive(TraceFormat):
    """Source: OptiTrack documentation, Data Export: CSV."""

    name = "motive"
    kind = "motive"
    summary = "CSV of OptiTrack's Motive, seven lines of header; rigid bodies, seconds, unit of length stated"
    order = "quaternion by the names of its columns"
    facts = {"unit": "s", "direction_by": By.FORMAT}


formats.register(Motive())
