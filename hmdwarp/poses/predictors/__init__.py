"""Predictors of the head pose from known motion: one file each."""

from __future__ import annotations

from ...registry import Registry
from ._base import Predictor, hold

predictors: Registry[Predictor] = Registry("predictor", __name__)

__all__ = ["Predictor", "hold", "predictors"]
