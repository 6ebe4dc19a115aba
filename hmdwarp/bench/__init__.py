"""The benchmark: error against time of every method on the same late frames."""

from .options import BenchOptions
from .run import BenchResult, bench

__all__ = ["BenchOptions", "BenchResult", "bench"]
