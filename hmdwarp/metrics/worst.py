"""Keeping the worst pictures of a long run, in bounded memory and in an order that does not depend on timing."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import attrs

from .job import QualityJob, QualityResult


@attrs.frozen(eq=False)
class Kept:
    """A job that was kept with its result, and the key it was submitted under."""

    key: Any
    job: QualityJob
    result: QualityResult

    @property
    def rank(self) -> tuple[float, Any]:
        """Larger is worse; of two equally bad pictures the one with the larger key counts as worse, so no tie is left."""
        return self.result.values["flip"] or 0.0, self.key


class WorstKeeper:
    """The `count` pictures with the largest FLIP error, at most one from each bucket (a second of the trace, say).

    Whatever the order in which pictures are offered, the same ones are kept: a bucket's worst is only ever dropped for
    `count` buckets that are worse still, and those can only get worse. What has no bucket (None) is never kept.
    """

    def __init__(self, count: int, bucket: Callable[[Any], Hashable]) -> None:
        self.count, self._bucket = count, bucket
        self._best: dict[Hashable, Kept] = {}

    def offer(self, kept: Kept) -> None:
        """Keep it if it is among the worst so far."""
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
        """The worst first."""
        return sorted(self._best.values(), key=lambda k: k.rank, reverse=True)
