"""Which refreshes are measured: one of every n, at a place of its own in each n."""

from __future__ import annotations

_GOLDEN = (5**0.5 - 1) / 2


def is_measured(number: int, every: int) -> bool:
    """Return whether refresh `number` is the measured one of its n = `every`.

    Its place among them is spread by the golden ratio, which is in step with no period: of misses,
    of a server's frames, of a head that nods. The first refresh is measured, and each run measures
    the same ones.
    """
    block, place = divmod(number, every)
    return place == int(every * (block * _GOLDEN % 1))
