"""Settings of warps and fills that have none."""

from __future__ import annotations

import attrs


@attrs.frozen
class NoSettings:
    """Nothing to set."""
