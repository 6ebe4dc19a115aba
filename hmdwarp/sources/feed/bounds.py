"""The numbers that messages may hold: decoding checks them, docs/feed.md prints them."""

from __future__ import annotations

import math

import attrs

from ...geometry import MOST_M
from ...scenes import ACTIONS, LEAST_WAY


class OutOfBounds(ValueError):
    """A number that no message may hold; the text says what was expected."""


@attrs.frozen
class Bound:
    what: str
    least: float
    most: float
    unit: str = ""
    or_none: bool = False  # whether 0 is allowed too, and stands for none

    def check(self, *numbers: float) -> None:
        """Check numbers of a message. Errors: OutOfBounds, for NaN too."""
        for number in numbers:
            if not (self.least <= number <= self.most or (self.or_none and number == 0)):
                raise OutOfBounds(f"{self.what} {number:.12g}: expected {self.text}")

    @property
    def text(self) -> str:
        """What is allowed, such as '1 to 1000 Hz'."""
        none = "0, or " if self.or_none else ""
        return f"{none}{_shown(self.least)} to {_shown(self.most)} {self.unit}".rstrip()


def _shown(number: float) -> str:
    mantissa, exponent = math.frexp(abs(number))
    if mantissa == 0.5 and abs(exponent) > 14:
        return f"{'-' if number < 0 else ''}2^{exponent - 1}"
    return f"{number:g}"


NUMBER = Bound("id", 1, 2**64)
SIDE = Bound("width or height of a picture, rendered or shown", 1, 8192, "pixels")
EYES = Bound("eyes", 1, 2)
COORDINATE = Bound("coordinate of a position", -MOST_M, MOST_M, "m")
LENGTH = Bound("length of a quaternion", 0.999, 1.001)
# The angles themselves: geometry.Fov.
EXTENT = Bound("field of view from left to right, or from down to up", 1e-4, 3.1242, "rad")
INSTANT = Bound("instant", -(2**62), 2**62, "ns")
DRAWING = Bound("time that drawing took", 0, 2**62, "ns")
RATE = Bound("frames a second", 1, 1000, "Hz")
QUALITY = Bound("quality of a video", 0, 52)
BITRATE = Bound("bit rate of an eye's video", 0, 1000, "Mbit/s")
STEP = Bound("step of coded depth", 2.0**-20, 1, "1/m", or_none=True)
CODE_STEP = Bound("step of depth in 16 bits", 0, 2.0**111, "1/m")
LAYERS = Bound("number of further layers", 0, 16)
AMOUNT = Bound("amount of a layer", 1, 16, or_none=True)
SETTINGS = Bound("rows, or columns, of a layer's settings", 1, 8)
GAZE = Bound("length of a gaze", 0.999, 1.001)
FATES = Bound("frames whose fate a request tells", 0, 512)
INPUTS = Bound("inputs of a request", 0, 512)
ACTION = Bound("action of an input", 1, len(ACTIONS))
WAY = Bound("length of the direction of an input", LEAST_WAY, 1 / LEAST_WAY)
# 45 minutes of four a second, or 3 of a hand that moves something at 90 Hz.
KEPT_INPUTS = Bound("inputs of a session that `hmdwarp serve` keeps", 0, 2**14)
MESSAGE = Bound("length of a message", 12, 2**29, "bytes")
UNPACKED = Bound("length of a frame, or of its layers, as numbers", 0, 2**29, "bytes")
# 1.5 s of a core, and four times the memory.
DRAWN_BY_CPU = Bound("length of a frame that `hmdwarp serve` draws without a GPU, as numbers", 0, 2**28, "bytes")
# 2 s of a core, for key frames; depth is coded with more care than colour.
_CODED = "pixels of a frame's videos that `hmdwarp serve` codes, H.265 counting 4 times, AV1 3, depth twice"
CODED = Bound(_CODED, 0, 1.75e7)
TEXT = Bound("length of a refusal's text", 0, 500, "bytes")

BOUNDS = [value for value in list(vars().values()) if isinstance(value, Bound)]


def most_beside(size: tuple[int, int]) -> int:
    """Return the bytes of a layer of another size, such as a cube, by its (w, h) picture."""
    return (1 << 24) + 64 * size[0] * size[1]
