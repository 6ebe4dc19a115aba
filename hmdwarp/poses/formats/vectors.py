"""Tables with a vector or a quaternion in one cell."""

from ..assumptions import By
from . import TraceFormat, formats


class Vectors(TraceFormat):
    """Source: Unity, Vector3.ToString and Quaternion.ToString (x, y, z, w)."""

    name = "vectors"
    kind = "vectors"
    order = "quaternion xyzw, unless labelled"
    order_by = By.NOBODY
    summary = "several numbers in a cell: (x, y, z), [x y z], x=1 y=2, as Unity, NumPy and Python print"


formats.register(Vectors())
