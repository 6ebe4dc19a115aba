"""Experiments over many cases: bench with compare, the thesis, and the sweep engine."""
