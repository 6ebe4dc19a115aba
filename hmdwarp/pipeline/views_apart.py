"""How far the views that a server draws are from those that it was asked for."""

from __future__ import annotations

import math

import attrs
import numpy as np

from ..geometry import Fov, View

# Degrees, metres and share of the field of view that equal views may differ by: a renderer's single
# floats leave 1e-5 degrees, 5e-7 m at 8 m, and 4e-7 of the field.
_SAME_DEG, _SAME_M, _SAME_SHARE = 1e-4, 1e-6, 1e-6


@attrs.define
class ViewsApart:
    """The most that drawn views differed from asked ones."""

    turned_deg: float = 0.0
    moved_m: float = 0.0
    # The least share of the asked field of view that was drawn, by area in tangents.
    field_share: float = 1.0

    def take(self, asked: View, drawn: View) -> None:
        """Count one view more."""
        self.turned_deg = max(self.turned_deg, math.degrees(drawn.pose.angle_to(asked.pose)))
        self.moved_m = max(self.moved_m, float(np.linalg.norm(drawn.pose.position_m - asked.pose.position_m)))
        self.field_share = min(self.field_share, _share(asked.fov, drawn.fov))

    def __bool__(self) -> bool:
        return self.turned_deg > _SAME_DEG or self.moved_m > _SAME_M or self.field_share < 1 - _SAME_SHARE

    def __str__(self) -> str:
        field = f", with {self.field_share:.0%} of the field of view" if self.field_share < 1 - _SAME_SHARE else ""
        return f"up to {self.turned_deg:.2f} degrees and {self.moved_m:.3f} m off{field}"


def _share(asked: Fov, drawn: Fov) -> float:
    left, right, down, up = asked.tangents
    low, high = np.maximum((left, down), drawn.tangents[[0, 2]]), np.minimum((right, up), drawn.tangents[[1, 3]])
    return float(np.prod((high - low).clip(min=0)) / ((right - left) * (up - down)))
