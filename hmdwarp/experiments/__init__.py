"""Experiments over many cases: bench, compare and the sweep engine."""
