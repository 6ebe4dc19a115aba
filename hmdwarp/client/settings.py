"""What a warp or fill has that can be set, where there is nothing."""

from __future__ import annotations

import attrs


@attrs.frozen
class NoSettings:
    """For warps and fills that have nothing to set."""
