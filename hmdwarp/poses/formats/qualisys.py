"""TSV exports of Qualisys Track Manager: bodies with six degrees of freedom."""

from ..assumptions import By
from . import TraceFormat, formats


class Qualisys(TraceFormat):
    """Source: QTM documentation, 6DOF data (.tsv); millimetres, Rot[] by columns."""

    name = "qualisys"
    kind = "qualisys"
    summary = "TSV of Qualisys Track Manager with 6D data; seconds, mm, matrices by columns"
    order = "matrix by columns"
    facts = {
        **{"unit": "s", "scale": 0.001, "scale_by": By.FORMAT},
        **{"order_by": By.FORMAT, "direction_by": By.FORMAT},
    }


formats.register(Qualisys())
