"""The guard band: what the server draws beyond the display's field of view."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs

from ..errors import InputError

Size = tuple[int, int]


@attrs.frozen
class GuardBand:
    """Two factors of the field of view in tangents, or the pixels of the picture that is drawn.

    Pixels per tangent stay those of the shown picture, so factors of 1.25 and 1.125 make 1600x900
    of 1280x800 pixels, and 1.41 times as many.
    Errors: InputError for a factor below 1.
    """

    x: float = 1.0
    y: float = 1.0
    # (w, h) of the rendered picture; decides instead of the factors.
    size: Size | None = None

    def __attrs_post_init__(self) -> None:
        if not all(factor >= 1 and math.isfinite(factor) for factor in (self.x, self.y)):
            raise InputError(f"{self} is no enlargement: expected factors of 1 or more")

    @classmethod
    def of(cls, value: float | tuple[float, float] | GuardBand) -> GuardBand:
        """Return the guard band of one factor or of two."""
        if isinstance(value, GuardBand):
            return value
        return cls(*value) if isinstance(value, tuple) else cls(value, value)

    @property
    def text(self) -> str:
        """Return the factors: '1.5', or '1.25x1.125' where they differ."""
        return f"{self.x:g}" if self.x == self.y else f"{self.x:g}x{self.y:g}"

    @property
    def entry(self) -> float | str:
        """Return what summary.json has: a number, or the text of two."""
        return self.x if self.x == self.y else self.text

    def __str__(self) -> str:
        return f"guard {self.text}" if self.size is None else f"rendered size {self.size[0]}x{self.size[1]}"

    def factors(self, shown: Size) -> GuardBand:
        """Return the guard band in factors, for a shown picture of that size. Errors: as check."""
        self.check(shown)
        return self if self.size is None else GuardBand(self.size[0] / shown[0], self.size[1] / shown[1])

    def check(self, shown: Size) -> None:
        """Raise InputError if a rendered size does not hold the shown picture."""
        if self.size is not None and (self.size[0] < shown[0] or self.size[1] < shown[1]):
            raise InputError(
                f"{self} is smaller than the shown picture's {shown[0]}x{shown[1]}: expected at least that on each "
                "side, or a smaller --size"
            )

    def pads(self, tangents: Sequence[float], shown: Size) -> list[int]:
        """Return the whole pixels to add: left, right, below, above. Errors: as check.

        tangents: left, right, down, up of the shown view.
        """
        self.check(shown)
        pads = []
        for axis, factor in enumerate((self.x, self.y)):
            sides = [abs(tangent) for tangent in tangents[2 * axis : 2 * axis + 2]]
            if self.size is not None:
                added = self.size[axis] - shown[axis]
                first = round(added * sides[0] / sum(sides))
                pads += [first, added - first]
                continue
            per_tangent = shown[axis] / (tangents[2 * axis + 1] - tangents[2 * axis])
            # 1e-9: a guard of exactly whole pixels must not gain one by rounding.
            pads += [math.ceil(side * per_tangent * (factor - 1) - 1e-9) for side in sides]
        return pads
