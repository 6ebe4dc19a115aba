"""The statistics of paired ratings: pure functions over arrays."""

from .bca import RESAMPLES, SEED, Interval, bca, is_degenerate
from .several import Friedman, friedman, holm, kendalls_w
from .shift import Shift, attained_level, hodges_lehmann
from .wilcoxon import MOST_PAIRS, Wilcoxon, rank_biserial, smallest_p, wilcoxon_exact

__all__ = [
    "MOST_PAIRS",
    "RESAMPLES",
    "SEED",
    "Friedman",
    "Interval",
    "Shift",
    "Wilcoxon",
    "attained_level",
    "bca",
    "friedman",
    "hodges_lehmann",
    "holm",
    "is_degenerate",
    "kendalls_w",
    "rank_biserial",
    "smallest_p",
    "wilcoxon_exact",
]
