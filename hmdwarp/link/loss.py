"""Frames that never arrive, in bursts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import attrs

from ..errors import InputError

if TYPE_CHECKING:
    import numpy as np  # help does not wait for it


@attrs.frozen
class GilbertElliott:
    """A network in a good or a bad state.

    Each frame is lost with the probability of the state; then the state may change. It starts in
    the good one. In the long run (r good + p bad) / (p + r) of all frames are lost. r = 1 - p with
    bad = 1 loses each frame independently with probability p. Errors: InputError.
    Source: Gilbert 1960, Capacity of a burst-noise channel; Elliott 1963, Estimates of error rates
    for codes on burst-noise channels.
    """

    # Probability of good to bad after a frame.
    p: float
    # Probability of bad to good after a frame: a bad state lasts 1/r frames on average.
    r: float
    # Share of frames lost in each state.
    good: float = 0.0
    bad: float = 1.0

    def __attrs_post_init__(self) -> None:
        for name, value in attrs.asdict(self).items():
            if not 0 <= value <= 1:  # NaN too
                raise InputError(f"loss with {name}={value:g}: expected a probability from 0 to 1")

    @classmethod
    def in_bursts(cls, mean: float, frames: float) -> GilbertElliott:
        """Return a network that loses the share `mean` of all frames, so many in a row on average.

        Errors: InputError for bursts that are shorter than a frame, or too short for that share.
        """
        if not 1 <= frames <= 1e6:
            raise InputError(f"--loss-burst {frames:g}: expected 1 to 1000000 frames")
        most = frames / (frames + 1)
        if mean > most:
            raise InputError(
                f"--loss {mean:g} with --loss-burst {frames:g}: expected a share of at most {most:.3g}, as a frame "
                "arrives between two bursts; use longer bursts or a smaller share"
            )
        return cls(mean / (frames * (1 - mean)), 1 / frames)

    @property
    def mean(self) -> float:
        """The share of frames lost in the long run."""
        return (self.r * self.good + self.p * self.bad) / (self.p + self.r) if self.p else self.good

    def samples(self, rng: np.random.Generator) -> Iterator[bool]:
        """Yield whether each frame is lost, endlessly."""
        is_bad = False
        while True:
            yield bool(rng.random() < (self.bad if is_bad else self.good))
            is_bad = bool(rng.random() < self.p) if not is_bad else not rng.random() < self.r
