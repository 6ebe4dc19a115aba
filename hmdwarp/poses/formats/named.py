"""Any file whose header names its columns in one of the common ways."""

from __future__ import annotations

from ..options import TraceOptions
from ..reading.file_head import Head
from . import TraceFormat, formats


@formats.register
class Named(TraceFormat):
    """Common headers: qx..qw, QuaternionX..W, HeadOrientationW..Z, w x y z, head_rot_x..w."""

    name = "named"
    summary = "any header that names time, position and quaternion (qx.., QuaternionX.., head_rot_x.., ..)"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        return 10 if head.names is not None else 0
