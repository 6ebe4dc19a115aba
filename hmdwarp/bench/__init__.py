"""What accuracy costs in time: every method on the same late frames, error against time."""

from .options import BenchOptions
from .run import BenchResult, bench

__all__ = ["BenchOptions", "BenchResult", "bench"]
