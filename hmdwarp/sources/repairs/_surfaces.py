"""Which depths belong to one surface."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ._base import Pixels


def _check_limit(_: object, field: attrs.Attribute[float], value: float) -> None:
    if not 0 <= value < float("inf"):
        raise ValueError(f"{field.name} is {value:g}: expected 0 or more")


@attrs.frozen
class SurfaceSettings:
    """When two inverse depths belong to one surface.

    They do if they differ by at most tolerance * (the smaller one + floor).
    """

    tolerance: float = attrs.field(default=0.15, validator=_check_limit)
    floor: float = attrs.field(default=0.05, validator=_check_limit)  # 1/m

    def nearest_beside(self, inverse: Pixels) -> Pixels:
        """Return the largest inverse depth that belongs to one surface with each of these."""
        return inverse + np.float32(self.tolerance) * (inverse + np.float32(self.floor))

    def apart(self, one: Pixels, other: Pixels) -> NDArray[np.bool_]:
        """Return where two known depths are of different surfaces; False where one is NaN."""
        return np.maximum(one, other) > self.nearest_beside(np.minimum(one, other))
