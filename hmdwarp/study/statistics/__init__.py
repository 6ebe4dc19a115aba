"""The statistics of paired ratings: pure functions over arrays."""

from .bootstrap import RESAMPLES, SEED, Interval, bca, bca_shares, is_degenerate
from .multiple import Friedman, friedman, holm, kendalls_w
from .signed_rank import (
    MOST_PAIRS,
    Shift,
    Wilcoxon,
    attained_level,
    hodges_lehmann,
    rank_biserial,
    signed_rank_null,
    smallest_p,
    wilcoxon_exact,
)

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
    "bca_shares",
    "friedman",
    "hodges_lehmann",
    "holm",
    "is_degenerate",
    "kendalls_w",
    "rank_biserial",
    "signed_rank_null",
    "smallest_p",
    "wilcoxon_exact",
]
