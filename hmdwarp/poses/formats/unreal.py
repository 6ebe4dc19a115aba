"""Vectors, rotators and quaternions as Unreal Engine's ToString prints them, one a cell."""

from ..assumptions import By
from . import TraceFormat, formats


class Unreal(TraceFormat):
    """Source: Unreal Engine API, FVector::ToString, FRotator::ToString, FQuat::ToString."""

    name = "unreal"
    kind = "unreal"
    summary = "cells of Unreal's ToString: X= Y= Z=, P= Y= R= or X= Y= Z= W=; cm, Unreal's axes"
    facts = {"axes": "unreal", "axes_by": By.FORMAT}


formats.register(Unreal())
