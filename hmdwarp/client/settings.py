"""Settings of warps and fills without any."""

from __future__ import annotations

import attrs


@attrs.frozen
class NoSettings:
    """No settings."""
