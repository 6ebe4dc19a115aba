"""The worst pictures of a long run, in bounded memory, independent of timing."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import attrs

from .job import QualityJob, QualityResult
from .metric import PRIMARY


@attrs.frozen(eq=False)
class Kept:
    """A picture to keep, with its figures."""

    key: Any  # the key it was submitted under
    job: QualityJob
    result: QualityResult

    @property
    def rank(self) -> tuple[float, Any]:
        """Sort key: larger is worse. Of two equals the one with the larger key counts as worse."""
        return self.result.values[PRIMARY] or 0.0, self.key


class WorstKeeper:
    """The `count` pictures with the largest FLIP error, at most one from each bucket.

    A bucket is a second of the trace, say.

    The order in which pictures are offered does not matter. A bucket's worst is dropped only when
    `count` other buckets are worse still, and those can only get worse. A picture whose bucket is
    None is never kept.
    """

    def __init__(self, count: int, bucket: Callable[[Any], Hashable]) -> None:
        self.count, self._bucket = count, bucket
        self._best: dict[Hashable, Kept] = {}

    def offer(self, kept: Kept) -> None:
        """Keep a picture if it is among the worst so far."""
        if self.count == 0:
            return
        bucket = self._bucket(kept.key)
        if bucket is None:
            return
        if bucket in self._best and self._best[bucket].rank >= kept.rank:
            return
        self._best[bucket] = kept
        if len(self._best) > self.count:
            del self._best[min(self._best, key=lambda b: self._best[b].rank)]

    def kept(self) -> list[Kept]:
        """Return the kept pictures, the worst first."""
        return sorted(self._best.values(), key=lambda k: k.rank, reverse=True)
